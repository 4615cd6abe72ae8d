"""The sports hall, compiled: walls with a row of windows, planks, a ceiling with lamps."""

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    BLUE,
    CEILING,
    COVER,
    DOWN,
    EYE,
    FADE,
    FLOOR,
    GREEN,
    HALF,
    LAMP,
    LIGHT,
    LINE,
    ONE,
    PITCH,
    RED,
    RIGHT,
    SEAM,
    SEEN,
    SOFT,
    SPAN_U,
    SPAN_V,
    TEXEL,
    TEXELS_PER_METRE,
    TINY,
    TWO,
    UP,
    WAINSCOT,
    WALL,
    WALL_Z,
    WINDOW,
    ZERO,
    F,
    P,
    Q,
    T,
    U,
    V,
    X,
    Y,
    Z,
    cross,
    fill,
    grain,
    inverse,
    lay,
    overlap,
    span,
    step,
    stripes,
    texel,
)

GROUND, ROOF = F(court.FLOOR_HEIGHT), F(court.CEILING_HEIGHT)
BACK, FRONT, SIDE = F(court.ROOM_BACK), F(court.ROOM_FRONT), F(court.ROOM_HALF_WIDTH)
LENGTH, WIDTH = F(court.TABLE_HALF_LENGTH), F(court.TABLE_HALF_WIDTH)

WAINSCOT_TOP, RAIL_MIDDLE, RAIL_TOP = F(0.42), F(0.445), F(0.47)
WINDOW_LOW, WINDOW_HIGH, WINDOW_PERIOD, WINDOW_WIDTH = F(1.45), F(2.58), F(2.0), F(1.54)
SASH_PERIOD, SASH = F(0.5), F(0.04)
PLANK, INVERSE_PLANK, GAP = F(0.14), F(1 / 0.14), F(0.005)
ALONG, SHIFT = F(0.12), F(7.3)  # planks: grain stretched along x, shifted from plank to plank
LAMP_PERIOD, LAMP_WIDTH, LAMP_LENGTH = F(2.0), F(0.35), F(1.2)
SIDE_LIGHT, CORNER_LIGHT, CORNER_SLOPE, ALMOST = F(0.93), F(0.78), F(0.176), F(1e-4)
RAMP_SLOPE, SHADE = F(1.43), F(0.35)


@kernel
def room(tile, n, texels, view, paint):
    """Paint walls, floor and ceiling."""
    low, middle, high, panelled, glazed = wall_places(tile, n, texels, view)
    if middle:
        grain(tile, texels, paint.texture, n)
        walls(tile, n, paint.colours, panelled)
        if glazed:
            panes(tile, n)
            lay(tile, n, paint.colours[WINDOW])
    else:
        fill(tile[BLUE:], n, ZERO)
        fill(tile[GREEN:], n, ZERO)
        fill(tile[RED:], n, ZERO)
    if low:
        floor(tile, n, texels, view, paint)
    if high:
        ceiling(tile, n, texels, view, paint)


@kernel
def wall_places(tile, n, texels, view):
    """Write where each ray ends on its wall, what a pixel spans there, the wall's light.

    Return what a pixel may show: floor, wall, ceiling, the wall's panelling up to its rail, a
    window.
    """
    eye_x, eye_y, eye_z = view[EYE, 0], view[EYE, 1], view[EYE, 2]
    right_x, down_x, right_y, down_y = view[RIGHT, 0], view[DOWN, 0], view[RIGHT, 1], view[DOWN, 1]
    front, back, left, right = FRONT - eye_x, BACK - eye_x, SIDE - eye_y, -SIDE - eye_y
    low, middle, high, panelled, glazed = False, False, False, False, False
    for i in range(n):
        x, y, pitch = tile[X + i], tile[Y + i], tile[PITCH + i]
        ix, iy = inverse(x), inverse(y)
        depth = min((front if ix > ZERO else back) * ix, (left if iy > ZERO else right) * iy)
        height, soft = eye_z + depth * tile[Z + i], depth * pitch
        low |= height < GROUND + soft
        middle |= (height > GROUND - soft) & (height < ROOF + soft)
        high |= height > ROOF - soft
        tile[WALL_Z + i], tile[SOFT + i] = height, soft
        across = eye_y + depth * y
        is_side = abs(across) > SIDE - ALMOST
        along = (eye_x + depth * x) + HALF if is_side else across
        slanted = max(span(x * iy, right_x, down_x, right_y, down_y, ONE), ONE)
        soft = soft * (slanted if is_side else ONE)
        u, v = along * TEXELS_PER_METRE, height * TEXELS_PER_METRE
        tile[P + i], tile[Q + i] = u - np.floor(u), v - np.floor(v)
        texels[i] = texel(u, v)
        tile[FADE + i] = min(TEXEL / max(soft, TINY), ONE)
        tile[U + i], tile[SPAN_U + i] = along, soft
        tile[SEEN + i] = SIDE_LIGHT if is_side else ONE
        panelled |= height < RAIL_TOP + soft
        glazed |= (height > WINDOW_LOW - soft) & (height < WINDOW_HIGH + soft)
    return low, middle, high, panelled, glazed


@kernel
def walls(tile, n, colours, panelled):
    """Lay the four walls with wainscot and rail; floor and ceiling cover the rest."""
    if not panelled:
        blue, green, red = colours[WALL, 0], colours[WALL, 1], colours[WALL, 2]
        for i in range(n):
            light = wall_light(tile[WALL_Z + i], tile[SEEN + i], tile[LIGHT + i])
            tile[BLUE + i], tile[GREEN + i] = blue * light, green * light
            tile[RED + i] = red * light
        return
    for i in range(n):
        height, soft = tile[WALL_Z + i], tile[SPAN_U + i]
        tile[LIGHT + i] = wall_light(height, tile[SEEN + i], tile[LIGHT + i])
        tile[COVER + i] = step(height - RAIL_MIDDLE, soft)
        tile[T + i] = overlap(height, WAINSCOT_TOP, RAIL_TOP, soft)
    lay_panels(tile[BLUE:], tile, n, colours[:, 0])
    lay_panels(tile[GREEN:], tile, n, colours[:, 1])
    lay_panels(tile[RED:], tile, n, colours[:, 2])


@kernel
def wall_light(height, side, texture):
    """Return how bright a wall is at a height: darker on the sides and towards the floor."""
    corner = min(CORNER_LIGHT + (height - GROUND) * CORNER_SLOPE, ONE)
    return side * corner * (ONE + texture)


@kernel
def lay_panels(under, tile, n, colours):
    """Lay wainscot, wall and rail in one colour channel."""
    wainscot, wall, line = colours[WAINSCOT], colours[WALL], colours[LINE]
    for i in range(n):
        light, cover, rail = tile[LIGHT + i], tile[COVER + i], tile[T + i]
        colour = (ONE - cover) * (wainscot * light) + cover * (wall * light)
        under[i] = (ONE - rail) * colour + rail * (line * light)


@kernel
def panes(tile, n):
    """Write coverage and light of window panes."""
    for i in range(n):
        along, height, soft = tile[U + i], tile[WALL_Z + i], tile[SPAN_U + i]
        sash = stripes(along, SASH_PERIOD, SASH, soft)
        cover = stripes(along, WINDOW_PERIOD, WINDOW_WIDTH, soft) * (ONE - sash)
        sash = stripes(height - WINDOW_LOW, SASH_PERIOD, SASH, soft)
        cover *= overlap(height, WINDOW_LOW, WINDOW_HIGH, soft) * (ONE - sash)
        tile[COVER + i] = cover
        tile[LIGHT + i] = tile[SEEN + i]


@kernel
def floor(tile, n, texels, view, paint):
    """Lay a floor of planks along x, darker under the table."""
    cross(tile, n, view, UP, GROUND)
    for i in range(n):
        y = tile[V + i]
        u = (ALONG * tile[U + i] + SHIFT * np.floor(y * INVERSE_PLANK)) * TEXELS_PER_METRE
        v = y * TEXELS_PER_METRE
        tile[P + i], tile[Q + i] = u - np.floor(u), v - np.floor(v)
        texels[i] = texel(u, v)
        tile[FADE + i] = min(TEXEL / max(tile[SPAN_V + i], TINY), ONE)
    grain(tile, texels, paint.texture, n)
    for i in range(n):
        x, y = tile[U + i], tile[V + i]
        dark = ramp(LENGTH + SHADE - abs(x)) * ramp(WIDTH + SHADE - abs(y))
        tile[LIGHT + i] = (ONE + TWO * tile[LIGHT + i]) * (ONE - HALF * dark)
        tile[COVER + i] = step(-(tile[WALL_Z + i] - GROUND), tile[SOFT + i])
    lay(tile, n, paint.colours[FLOOR])
    for i in range(n):
        tile[COVER + i] *= stripes(tile[V + i], PLANK, GAP, tile[SPAN_V + i])
    lay(tile, n, paint.colours[SEAM])


@kernel
def ceiling(tile, n, texels, view, paint):
    """Lay a ceiling with rows of lamps."""
    cross(tile, n, view, UP, ROOF)
    for i in range(n):
        u, v = tile[U + i] * TEXELS_PER_METRE, tile[V + i] * TEXELS_PER_METRE
        tile[P + i], tile[Q + i] = u - np.floor(u), v - np.floor(v)
        texels[i] = texel(u, v)
        widest = max(tile[SPAN_U + i], tile[SPAN_V + i])
        tile[FADE + i] = min(TEXEL / max(widest, TINY), ONE)
    grain(tile, texels, paint.texture, n)
    for i in range(n):
        tile[LIGHT + i] = ONE + tile[LIGHT + i]
        tile[COVER + i] = step(tile[WALL_Z + i] - ROOF, tile[SOFT + i])
    lay(tile, n, paint.colours[CEILING])
    for i in range(n):
        lamp = stripes(tile[U + i], LAMP_PERIOD, LAMP_LENGTH, tile[SPAN_U + i])
        tile[COVER + i] *= lamp * stripes(tile[V + i], LAMP_PERIOD, LAMP_WIDTH, tile[SPAN_V + i])
    fill(tile[LIGHT:], n, ONE)
    lay(tile, n, paint.colours[LAMP])


@kernel
def ramp(u):
    """Return a soft step from 0 at u = 0 to 1 at u = 0.7 m."""
    return min(max(u * RAMP_SLOPE, ZERO), ONE)
