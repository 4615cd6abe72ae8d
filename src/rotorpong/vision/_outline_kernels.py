"""Places about the outline of one ball, compiled: a circle, or a capsule while it moves.

The outline is the points within r of the segment from -u to u, in the ball's own frame
q = shape^-1 (pixel - centre). A state is x, y, r, ux, uy.
"""

import math

from rotorpong.kernels import kernel

SECTORS = 24  # around the outline


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
def capsule(qx, qy, ux, uy, uu):
    """Return distances from the segment -u .. u, and from the farther of its ends, squared."""
    squared = qx * qx + qy * qy
    if uu == 0.0:
        return squared, squared
    along = qx * ux + qy * uy
    t = min(max(along / uu, -1.0), 1.0)
    return max(squared + t * (t * uu - 2.0 * along), 0.0), squared + 2.0 * abs(along) + uu


@kernel
def sector_around(qx, qy, r, ux, uy, uu):
    """Return the sector of a place as it is seen from a capsule that is squeezed to a circle."""
    if uu == 0.0:
        return sector_of(qx, qy)
    length = math.sqrt(uu)
    along = (qx * ux + qy * uy) / uu * length / (r + length)
    return sector_of(qx - along * ux, qy - along * uy)


@kernel
def sector_of(x, y):
    """Return the angle of (x, y) in sectors, 0 <= s < SECTORS, good to 0.02 of one."""
    ax, ay = abs(x), abs(y)
    small, large = min(ax, ay), max(ax, ay)
    z = small / large if large > 0.0 else 0.0
    angle = z * (0.785398 + 0.273 * (1.0 - z))
    if ay > ax:
        angle = 1.570796 - angle
    if x < 0.0:
        angle = 3.141593 - angle
    if y < 0.0:
        angle = 6.283185 - angle
    s = angle * (SECTORS / 6.283185307)
    return s if s < SECTORS else 0.0
