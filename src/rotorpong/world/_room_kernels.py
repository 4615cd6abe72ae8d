"""The sports hall, compiled: walls with a row of windows, planks, a ceiling with lamps."""

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    CEILING,
    FLOOR,
    HALF,
    IY,
    LAMP,
    LINE,
    ONE,
    PITCH,
    SEAM,
    TWO,
    WAINSCOT,
    WALL,
    WALL_T,
    WALL_Z,
    WINDOW,
    ZERO,
    F,
    X,
    Y,
    any_within,
    follow,
    grain,
    lay_row,
    level_places,
    overlap,
    span,
    step,
    stripes,
)

GROUND, ROOF = F(court.FLOOR_HEIGHT), F(court.CEILING_HEIGHT)
BACK, FRONT, SIDE = F(court.ROOM_BACK), F(court.ROOM_FRONT), F(court.ROOM_HALF_WIDTH)
LENGTH, WIDTH = F(court.TABLE_HALF_LENGTH), F(court.TABLE_HALF_WIDTH)

WAINSCOT_TOP, RAIL_TOP, MARGIN = F(0.42), F(0.47), F(0.2)
WINDOW_LOW, WINDOW_HIGH, WINDOW_PERIOD, WINDOW_WIDTH = F(1.45), F(2.58), F(2.0), F(1.54)
SASH_PERIOD, SASH = F(0.5), F(0.04)
PLANK, INVERSE_PLANK, GAP = F(0.14), F(1 / 0.14), F(0.005)
ALONG, SHIFT = F(0.12), F(7.3)  # planks: grain stretched along x, shifted from plank to plank
LAMP_PERIOD, LAMP_WIDTH, LAMP_LENGTH = F(2.0), F(0.35), F(1.2)
SIDE_LIGHT, CORNER_LIGHT, CORNER_SLOPE = F(0.93), F(0.78), F(0.176)
RAMP_SLOPE, SHADE = F(1.43), F(0.35)


@kernel
def meet_walls(out, inverse_x, inverse_y, view):
    """Write the depth at which each ray meets the nearest wall."""
    front, back, left, right = FRONT - view.x, BACK - view.x, SIDE - view.y, -SIDE - view.y
    for i in range(out.shape[0]):
        tx = (front if inverse_x[i] > ZERO else back) * inverse_x[i]
        ty = (left if inverse_y[i] > ZERO else right) * inverse_y[i]
        out[i] = min(tx, ty)


@kernel
def room(row, view, paint):
    """Paint walls, floor and ceiling."""
    columns = (0, row.near.shape[0])
    height = row.ray[WALL_Z]
    if any_within(height, columns, GROUND - MARGIN, ROOF + MARGIN):
        walls(row, columns, view, paint)
    if any_within(height, columns, -F(1e9), GROUND + MARGIN):
        floor(row, columns, view, paint)
    if any_within(height, columns, ROOF - MARGIN, F(1e9)):
        ceiling(row, columns, view, paint)


@kernel
def walls(row, columns, view, paint):
    """Lay the four walls with wainscot, rail and windows; floor and ceiling cover the rest."""
    along, side, soft, light, cover = row.work[0], row.work[1], row.work[2], row.work[3], row.work[4]
    height, colours = row.ray[WALL_Z], paint.colours
    wall_places(along, side, soft, row.ray, view)
    wall_light(light, along, height, soft, side, paint.texture)
    cover[:] = ONE
    lay_row(row.colour, columns, colours[WAINSCOT], light, cover)
    if any_within(height, columns, WAINSCOT_TOP - MARGIN, ROOF + MARGIN):
        for i in range(cover.shape[0]):
            cover[i] = step(height[i] - WAINSCOT_TOP, soft[i])
        lay_row(row.colour, columns, colours[WALL], light, cover)
    if any_within(height, columns, WAINSCOT_TOP - MARGIN, RAIL_TOP + MARGIN):
        for i in range(cover.shape[0]):
            cover[i] = overlap(height[i], WAINSCOT_TOP, RAIL_TOP, soft[i])
        lay_row(row.colour, columns, colours[LINE], light, cover)
    if any_within(height, columns, WINDOW_LOW - MARGIN, WINDOW_HIGH + MARGIN):
        panes(cover, along, height, soft)
        lay_row(row.colour, columns, colours[WINDOW], side, cover)


@kernel
def wall_places(along, side, soft, ray, view):
    """Write how far along its wall each ray ends, that wall's light, and what a pixel spans."""
    follow(along, (0, along.shape[0]), ray[WALL_T], ray[X], view.x)
    follow(soft, (0, along.shape[0]), ray[WALL_T], ray[Y], view.y)
    for i in range(along.shape[0]):
        side[i] = SIDE_LIGHT if abs(soft[i]) > SIDE - F(1e-4) else ONE
    for i in range(along.shape[0]):
        along[i] = along[i] + HALF if side[i] < ONE else soft[i]
    x, y, iy, t, pitch = ray[X], ray[Y], ray[IY], ray[WALL_T], ray[PITCH]
    for i in range(along.shape[0]):
        wide = span(x[i] * iy[i], view.rx, view.dx, view.ry, view.dy, ONE)
        soft[i] = t[i] * pitch[i] * (max(wide, ONE) if side[i] < ONE else ONE)


@kernel
def wall_light(out, along, height, soft, side, texture):
    """Write the brightness of the walls: texture, and less light down where they meet the floor."""
    for i in range(out.shape[0]):
        out[i] = grain(texture, along[i], height[i], soft[i])
    for i in range(out.shape[0]):
        corner = min(CORNER_LIGHT + (height[i] - GROUND) * CORNER_SLOPE, ONE)
        out[i] = side[i] * corner * (ONE + out[i])


@kernel
def panes(out, along, height, soft):
    """Write the coverage by window panes."""
    for i in range(out.shape[0]):
        sash = stripes(along[i], SASH_PERIOD, SASH, soft[i])
        out[i] = stripes(along[i], WINDOW_PERIOD, WINDOW_WIDTH, soft[i]) * (ONE - sash)
    for i in range(out.shape[0]):
        sash = stripes(height[i] - WINDOW_LOW, SASH_PERIOD, SASH, soft[i])
        out[i] *= overlap(height[i], WINDOW_LOW, WINDOW_HIGH, soft[i]) * (ONE - sash)


@kernel
def floor(row, columns, view, paint):
    """Lay a floor of planks along x, darker under the table."""
    x, y, wide, light, cover = row.work[0], row.work[1], row.work[3], row.work[4], row.work[5]
    level_places(row, columns, view, GROUND)
    for i in range(x.shape[0]):
        plank = np.floor(y[i] * INVERSE_PLANK)
        light[i] = grain(paint.texture, ALONG * x[i] + SHIFT * plank, y[i], wide[i])
    for i in range(x.shape[0]):
        dark = ramp(LENGTH + SHADE - abs(x[i])) * ramp(WIDTH + SHADE - abs(y[i]))
        light[i] = (ONE + TWO * light[i]) * (ONE - HALF * dark)
    height, depth, pitch = row.ray[WALL_Z], row.ray[WALL_T], row.ray[PITCH]
    for i in range(x.shape[0]):
        cover[i] = step(GROUND - height[i], depth[i] * pitch[i])
    lay_row(row.colour, columns, paint.colours[FLOOR], light, cover)
    for i in range(x.shape[0]):
        cover[i] *= stripes(y[i], PLANK, GAP, wide[i])
    lay_row(row.colour, columns, paint.colours[SEAM], light, cover)


@kernel
def ceiling(row, columns, view, paint):
    """Lay a ceiling with rows of lamps."""
    x, y, long, wide, light, cover = (
        row.work[0], row.work[1], row.work[2], row.work[3], row.work[4], row.work[5],
    )  # fmt: skip
    level_places(row, columns, view, ROOF)
    for i in range(x.shape[0]):
        light[i] = ONE + grain(paint.texture, x[i], y[i], max(long[i], wide[i]))
    height, depth, pitch = row.ray[WALL_Z], row.ray[WALL_T], row.ray[PITCH]
    for i in range(x.shape[0]):
        cover[i] = step(height[i] - ROOF, depth[i] * pitch[i])
    lay_row(row.colour, columns, paint.colours[CEILING], light, cover)
    for i in range(x.shape[0]):
        cover[i] *= stripes(x[i], LAMP_PERIOD, LAMP_LENGTH, long[i])
        cover[i] *= stripes(y[i], LAMP_PERIOD, LAMP_WIDTH, wide[i])
    light[:] = ONE
    lay_row(row.colour, columns, paint.colours[LAMP], light, cover)


@kernel
def ramp(u):
    """Return a soft step from 0 at u = 0 to 1 at u = 0.7 m."""
    return min(max(u * RAMP_SLOPE, ZERO), ONE)
