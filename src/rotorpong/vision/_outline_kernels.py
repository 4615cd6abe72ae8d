"""Places about the outline of one ball, compiled: a circle, or a capsule while it moves.

The outline is the points within r of the segment from -u to u, in the ball's own frame
q = shape^-1 (pixel - centre). A state is x, y, r, ux, uy.
"""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel

SECTORS = 24  # around the outline
PLACES = 16  # pixels of a row that are placed at once
NEAR, SECTOR, RAMP = 2 * PLACES, 3 * PLACES, 4 * PLACES  # where these begin

F = np.float32
ZERO, HALF, ONE, TWO, TINY = F(0), F(0.5), F(1), F(2), F(1e-20)
PI, OCTANT, BEND = F(3.1415927), F(0.785398), F(0.273)  # arctan z to 0.004
PER_RADIAN, LAST = F(SECTORS / 6.283185307), F(SECTORS)


@kernel
def box_around(pixels, state, shape, reach):
    """Return x0, x1, y0, y1 (ends exclusive) of the pixels within `reach` of the segment."""
    ux = abs(shape[0, 0] * state[3] + shape[0, 1] * state[4])
    uy = abs(shape[1, 0] * state[3] + shape[1, 1] * state[4])
    half_x = reach * math.hypot(shape[0, 0], shape[0, 1]) + ux
    half_y = reach * math.hypot(shape[1, 0], shape[1, 1]) + uy
    x0, x1 = math.floor(state[0] - half_x), math.ceil(state[0] + half_x) + 1
    y0, y1 = math.floor(state[1] - half_y), math.ceil(state[1] + half_y) + 1
    return max(x0, 0), min(x1, pixels.shape[1]), max(y0, 0), min(y1, pixels.shape[0])


@kernel
def fits(pixels, state, shape, gap):
    """Tell whether outline and gap lie within the pixels."""
    reach = state[2] + gap
    half_x = reach * math.hypot(shape[0, 0], shape[0, 1])
    half_x += abs(shape[0, 0] * state[3] + shape[0, 1] * state[4])
    half_y = reach * math.hypot(shape[1, 0], shape[1, 1])
    half_y += abs(shape[1, 0] * state[3] + shape[1, 1] * state[4])
    x, y = state[0], state[1]
    inside_x = x - half_x >= -0.5 and x + half_x <= pixels.shape[1] - 0.5
    return inside_x and y - half_y >= -0.5 and y + half_y <= pixels.shape[0] - 0.5


@kernel
def deep_span(state, shape, inverse, row, reach):
    """Return the columns (from, to; to exclusive) of a row within `reach` of both ends.

    Those are the pixels whose farthest point of the segment is nearer than `reach`.
    """
    first, last = chord(state, shape, inverse, row, reach, 1.0)
    if state[3] != 0.0 or state[4] != 0.0:
        left, right = chord(state, shape, inverse, row, reach, -1.0)
        first, last = max(first, left), min(last, right)
    return first, max(first, last)


@kernel
def chord(state, shape, inverse, row, reach, end):
    """Return the columns (from, to; to exclusive) of a row within `reach` of one end, +-1 u."""
    x = state[0] + end * (shape[0, 0] * state[3] + shape[0, 1] * state[4])
    dy = row - state[1] - end * (shape[1, 0] * state[3] + shape[1, 1] * state[4])
    a = inverse[0, 0] * inverse[0, 0] + inverse[1, 0] * inverse[1, 0]
    b = (inverse[0, 0] * inverse[0, 1] + inverse[1, 0] * inverse[1, 1]) * dy
    c = (inverse[0, 1] * inverse[0, 1] + inverse[1, 1] * inverse[1, 1]) * dy * dy
    squared = b * b - a * (c - reach * reach)
    if reach <= 0.0 or squared <= 0.0:
        return 0, 0
    half = math.sqrt(squared) / a
    return math.ceil(x - b / a - half), math.floor(x - b / a + half) + 1


@kernel
def place_row(places, state, inverse, row, first, step):
    """Write where the pixels `first`, `first + step`, ... of a row lie about the outline.

    Args:
        places: (5 * PLACES,) float32: q, distance from the segment squared, sector as it is seen
            from a capsule that is squeezed to a circle; 0, 1, 2, ... that is only read.
        state: x, y, r, ux, uy.
        inverse: of the shape.
        row: of the picture.
        first: column.
        step: from one column to the next.
    """
    x, dy, apart = F(first - state[0]), F(row - state[1]), F(step)
    qx_row, qy_row = F(inverse[0, 1]) * dy, F(inverse[1, 1]) * dy
    a, b = F(inverse[0, 0]), F(inverse[1, 0])
    ux, uy = F(state[3]), F(state[4])
    uu = ux * ux + uy * uy
    length = math.sqrt(uu)
    share = ONE / uu if uu > ZERO else ZERO
    squeeze = length / (F(state[2]) + length)
    for k in range(PLACES):
        dx = x + apart * places[RAMP + k]
        qx, qy = a * dx + qx_row, b * dx + qy_row
        along = qx * ux + qy * uy
        t = along * share
        t_near = min(max(t, -ONE), ONE)
        near = qx * qx + qy * qy + t_near * (t_near * uu - TWO * along)
        places[k] = qx
        places[PLACES + k] = qy
        places[NEAR + k] = near if near > ZERO else ZERO
        places[SECTOR + k] = sector_of(qx - t * squeeze * ux, qy - t * squeeze * uy)


@inlined_kernel
def sector_of(x, y):
    """Return the angle of (x, y) in sectors, 0 <= s < SECTORS, good to 0.02 of one."""
    ax, ay = abs(x), abs(y)
    z = min(ax, ay) / (max(ax, ay) + TINY)
    angle = z * (OCTANT + BEND * (ONE - z))
    angle = HALF * PI - angle if ay > ax else angle
    angle = PI - angle if x < ZERO else angle
    angle = TWO * PI - angle if y < ZERO else angle
    s = angle * PER_RADIAN
    return s if s < LAST else ZERO
