"""The sports hall, compiled: walls with a row of windows, planks, a ceiling with lamps."""

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    CEILING,
    COVER,
    DOWN,
    EYE,
    FAR,
    FLOOR,
    HALF,
    IX,
    IY,
    LAMP,
    LIGHT,
    LINE,
    ONE,
    PITCH,
    RIGHT,
    SEAM,
    SEEN,
    SPAN_U,
    SPAN_V,
    TWO,
    WAINSCOT,
    WALL,
    WALL_T,
    WALL_Z,
    WINDOW,
    ZERO,
    F,
    T,
    U,
    V,
    X,
    Y,
    Z,
    cross,
    fill,
    follow,
    grain,
    lay_row,
    overlap,
    span,
    spread,
    step,
    stripes,
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
def room(row, view, paint):
    """Paint walls, floor and ceiling."""
    soft, depth, pitch = row.work[SPAN_U], row.ray[WALL_T], row.ray[PITCH]
    for i in range(row.columns[0], row.columns[1]):
        soft[i] = depth[i] * pitch[i]
    low, high = any_near(row, -FAR, GROUND), any_near(row, ROOF, FAR)
    if any_near(row, GROUND, ROOF):
        walls(row, view, paint)
    if low:
        floor(row, view, paint)
    if high:
        ceiling(row, view, paint)


@kernel
def any_near(row, low, high):
    """Tell whether a pixel reaches into (low, high) on its wall."""
    height, soft, count = row.ray[WALL_Z], row.work[SPAN_U], 0
    for i in range(row.columns[0], row.columns[1]):
        count += 1 if (height[i] > low - soft[i]) & (height[i] < high + soft[i]) else 0
    return count > 0


@kernel
def meet_walls(row, view):
    """Write the depth at which each ray meets the nearest wall."""
    out, inverse_x, inverse_y = row.ray[WALL_T], row.ray[IX], row.ray[IY]
    front, back = FRONT - view[EYE, X], BACK - view[EYE, X]
    left, right = SIDE - view[EYE, Y], -SIDE - view[EYE, Y]
    for i in range(row.columns[0], row.columns[1]):
        tx = (front if inverse_x[i] > ZERO else back) * inverse_x[i]
        ty = (left if inverse_y[i] > ZERO else right) * inverse_y[i]
        out[i] = min(tx, ty)


@kernel
def walls(row, view, paint):
    """Lay the four walls with wainscot, rail and windows; floor and ceiling cover the rest."""
    along, soft, side, cover = row.work[U], row.work[SPAN_U], row.work[SEEN], row.work[COVER]
    height, colours = row.ray[WALL_Z], paint.colours
    wall_places(row, along, soft, view)
    wall_light(row, paint.texture)
    fill(row, cover, ONE)
    lay_row(row, colours[WAINSCOT])
    if any_near(row, RAIL_MIDDLE, ROOF):
        for i in range(row.columns[0], row.columns[1]):
            cover[i] = step(height[i] - RAIL_MIDDLE, soft[i])
        lay_row(row, colours[WALL])
    if any_near(row, WAINSCOT_TOP, RAIL_TOP):
        for i in range(row.columns[0], row.columns[1]):
            cover[i] = overlap(height[i], WAINSCOT_TOP, RAIL_TOP, soft[i])
        lay_row(row, colours[LINE])
    if any_near(row, WINDOW_LOW, WINDOW_HIGH):
        panes(row, along, height, soft)
        for i in range(row.columns[0], row.columns[1]):
            row.work[LIGHT, i] = side[i]
        lay_row(row, colours[WINDOW])


@kernel
def wall_places(row, along, soft, view):
    """Write how far along its wall each ray ends, what a pixel spans there, the wall's light."""
    ray, side = row.ray, row.work[SEEN]
    depth, pitch = ray[WALL_T], ray[PITCH]
    follow(row, along, depth, ray[X], view[EYE, X])
    follow(row, soft, depth, ray[Y], view[EYE, Y])
    for i in range(row.columns[0], row.columns[1]):
        side[i] = SIDE_LIGHT if abs(soft[i]) > SIDE - ALMOST else ONE
    for i in range(row.columns[0], row.columns[1]):
        along[i] = along[i] + HALF if side[i] < ONE else soft[i]
    x, iy, rx, dx = ray[X], ray[IY], view[RIGHT, X], view[DOWN, X]
    ry, dy = view[RIGHT, Y], view[DOWN, Y]
    for i in range(row.columns[0], row.columns[1]):
        slanted = max(span(x[i] * iy[i], rx, dx, ry, dy, ONE), ONE)
        soft[i] = depth[i] * pitch[i] * (slanted if side[i] < ONE else ONE)


@kernel
def wall_light(row, texture):
    """Write the brightness of the walls: texture, and less light down where they meet the floor."""
    along, soft, side = row.work[U], row.work[SPAN_U], row.work[SEEN]
    out, height = row.work[LIGHT], row.ray[WALL_Z]
    for i in range(row.columns[0], row.columns[1]):
        out[i] = grain(texture, along[i], height[i], soft[i])
    for i in range(row.columns[0], row.columns[1]):
        corner = min(CORNER_LIGHT + (height[i] - GROUND) * CORNER_SLOPE, ONE)
        out[i] = side[i] * corner * (ONE + out[i])


@kernel
def panes(row, along, height, soft):
    """Write the coverage by window panes."""
    out = row.work[COVER]
    for i in range(row.columns[0], row.columns[1]):
        sash = stripes(along[i], SASH_PERIOD, SASH, soft[i])
        out[i] = stripes(along[i], WINDOW_PERIOD, WINDOW_WIDTH, soft[i]) * (ONE - sash)
    for i in range(row.columns[0], row.columns[1]):
        sash = stripes(height[i] - WINDOW_LOW, SASH_PERIOD, SASH, soft[i])
        out[i] *= overlap(height[i], WINDOW_LOW, WINDOW_HIGH, soft[i]) * (ONE - sash)


@kernel
def floor(row, view, paint):
    """Lay a floor of planks along x, darker under the table."""
    cross(row, view, Z, GROUND)
    spread(row, view, Z, T, (ZERO, FAR))
    x, y, wide = row.work[U], row.work[V], row.work[SPAN_V]
    light, cover = row.work[LIGHT], row.work[COVER]
    for i in range(row.columns[0], row.columns[1]):
        plank = np.floor(y[i] * INVERSE_PLANK)
        light[i] = grain(paint.texture, ALONG * x[i] + SHIFT * plank, y[i], wide[i])
    for i in range(row.columns[0], row.columns[1]):
        dark = ramp(LENGTH + SHADE - abs(x[i])) * ramp(WIDTH + SHADE - abs(y[i]))
        light[i] = (ONE + TWO * light[i]) * (ONE - HALF * dark)
    beyond_wall(row, -ONE, GROUND)
    lay_row(row, paint.colours[FLOOR])
    for i in range(row.columns[0], row.columns[1]):
        cover[i] *= stripes(y[i], PLANK, GAP, wide[i])
    lay_row(row, paint.colours[SEAM])


@kernel
def ceiling(row, view, paint):
    """Lay a ceiling with rows of lamps."""
    cross(row, view, Z, ROOF)
    spread(row, view, Z, T, (ZERO, FAR))
    x, y, long, wide = row.work[U], row.work[V], row.work[SPAN_U], row.work[SPAN_V]
    light, cover = row.work[LIGHT], row.work[COVER]
    for i in range(row.columns[0], row.columns[1]):
        light[i] = ONE + grain(paint.texture, x[i], y[i], max(long[i], wide[i]))
    beyond_wall(row, ONE, ROOF)
    lay_row(row, paint.colours[CEILING])
    for i in range(row.columns[0], row.columns[1]):
        lamp = stripes(x[i], LAMP_PERIOD, LAMP_LENGTH, long[i])
        cover[i] *= lamp * stripes(y[i], LAMP_PERIOD, LAMP_WIDTH, wide[i])
    fill(row, light, ONE)
    lay_row(row, paint.colours[LAMP])


@kernel
def beyond_wall(row, sign, level):
    """Write to COVER the share of pixels whose ray meets a level plane before any wall."""
    cover, height, depth, pitch = row.work[COVER], row.ray[WALL_Z], row.ray[WALL_T], row.ray[PITCH]
    for i in range(row.columns[0], row.columns[1]):
        cover[i] = step(sign * (height[i] - level), depth[i] * pitch[i])


@kernel
def ramp(u):
    """Return a soft step from 0 at u = 0 to 1 at u = 0.7 m."""
    return min(max(u * RAMP_SLOPE, ZERO), ONE)
