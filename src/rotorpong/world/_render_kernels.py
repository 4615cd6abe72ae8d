"""The ray caster, compiled: tiles of pixels, and the ball between its far and near layers."""

import numpy as np

from rotorpong.kernels import kernel, spliced_kernel
from rotorpong.world._court_kernels import layers, see_table
from rotorpong.world._moment_kernels import BALL_POSITION, bound_row, look, look_for_ball
from rotorpong.world._pixel_kernels import (
    AHEAD,
    ASIDE,
    BALL,
    BALL_COVER,
    BALL_LIGHT,
    BEYOND,
    BLUE,
    COVER,
    FAR,
    GREEN,
    HALF,
    LIGHT,
    NEAR,
    PITCH,
    RED,
    UP,
    ZERO,
    F,
    X,
    Y,
    Z,
    fill,
    lay,
)
from rotorpong.world._room_kernels import room
from rotorpong.world._sphere_kernels import near_ball, sample_ball
from rotorpong.world._survey_kernels import (
    BALL_BOX,
    axis_of,
    find_ball,
    survey,
    toward,
    within,
)

WHITEST = F(255)


@spliced_kernel
def begin_row(scan, lens, row, columns, shutter, moment):
    """Find out what some columns of a row may show, and where the ball is if it is among that."""
    look(moment, shutter, row)
    survey(scan, lens, row, columns, moment.axes)
    bound_row(moment.box, shutter, row)
    if find_ball(scan, lens, row, columns, moment.box):
        look_for_ball(moment, shutter, row)


@spliced_kernel
def paint_tile(work, n, lens, place, moment, scan, paint):
    """Write the colours of n pixels from `place` on, linear and unbounded.

    Where the ball is seen the layers are laid twice: behind it, and before it.
    """
    tile, texels, sums = work
    start, view, ball, rays = place[0], moment.axes, moment.pose[BALL_POSITION:], lens.rays
    cast(tile, n, rays, place, view)
    first, last = within(scan.spans, BALL_BOX, start, n)
    if first < last:
        first, last = near_ball(rays, place, (first, last), moment.box)
        if first < last:
            sample_ball(tile, sums, rays, place, (first, last), moment)
    part, count = tile, n
    for passage in range(2):
        if passage == 1:
            if first >= last:
                break
            part, count, start = tile[first:], last - first, start + first
            lay_ball(part, count, paint.colours[BALL])
        top = see_table(part, count, start, view, ball, scan.spans)
        if passage == 0 and not top[1]:
            room(tile, n, texels, view, paint)
        layers(part, count, start, view, ball, paint, scan, top)
    if first < last:
        fill(part[BEYOND:], count, FAR)


@kernel
def lay_ball(tile, n, colour):
    """Lay the ball over the tile; what is laid next is nearer."""
    for i in range(n):
        tile[LIGHT + i], tile[COVER + i] = tile[BALL_LIGHT + i], tile[BALL_COVER + i]
        tile[BEYOND + i], tile[NEAR + i] = tile[NEAR + i], ZERO
    lay(tile, n, colour)


@kernel
def cast(tile, n, rays, place, view):
    """Start a tile: its rays in the world."""
    start, row = place
    across, down, pitch = rays[0, row, start:], rays[1, row, start:], rays[2, row, start:]
    x, y, z = axis_of(view, AHEAD), axis_of(view, ASIDE), axis_of(view, UP)
    for i in range(n):
        a, b = across[i], down[i]
        tile[X + i], tile[Y + i], tile[Z + i] = toward(a, b, x), toward(a, b, y), toward(a, b, z)
        tile[PITCH + i] = pitch[i]


@kernel
def expose(pixels, tile, n):
    """Round a tile to what the picture holds."""
    for i in range(n):
        pixels[3 * i] = np.uint8(min(max(tile[BLUE + i], ZERO), WHITEST) + HALF)
        pixels[3 * i + 1] = np.uint8(min(max(tile[GREEN + i], ZERO), WHITEST) + HALF)
        pixels[3 * i + 2] = np.uint8(min(max(tile[RED + i], ZERO), WHITEST) + HALF)
