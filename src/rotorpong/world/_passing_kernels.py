"""How near the ball passed the blade, in space and in time, compiled."""

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics.ball import Surface
from rotorpong.world._solid_kernels import (
    PLACE,
    ROTATION,
    blade_gap,
    body_point,
    ellipse_gap,
    make_work,
    pose_between,
)
from rotorpong.world.racket import Racket


@kernel
def racket_of(p):
    """Return a racket from half axes and place; its surface plays no part."""
    return Racket(Surface(0.0, 0.0), p[0], p[1], p[2], p[3], p[4])


@kernel
def blade_gaps(positions, track, sizes, out):
    """Write the gap between ball k and the blade at pose k."""
    racket, work = racket_of(sizes), make_work()
    for k in range(positions.shape[0]):
        pose_between(track, k, 0.0, work)
        x, y, z = body_point(positions[k, 0], positions[k, 1], positions[k, 2], work)
        out[k] = blade_gap(x, y, z, racket)


@kernel
def blade_centres(track, racket, work, out):
    """Write where the blade's centre is at each pose, and the box about them in the last rows."""
    n = track.shape[0]
    for k in range(3):
        out[n, k], out[n + 1, k] = np.inf, -np.inf
    for j in range(n):
        pose_between(track, j, 0.0, work)
        for k in range(3):
            r = ROTATION + k
            arm = work[r, 0] * racket.x + work[r, 1] * racket.y + work[r, 2] * racket.z
            out[j, k] = work[PLACE, k] + arm
            out[n, k] = min(out[n, k], out[j, k])
            out[n + 1, k] = max(out[n + 1, k], out[j, k])


@kernel
def near_span(positions, box, reach):
    """Return first and one beyond last of the positions within reach of a box."""
    first, last = positions.shape[0], 0
    for k in range(positions.shape[0]):
        inside = True
        for axis in range(3):
            if not box[0, axis] - reach <= positions[k, axis] <= box[1, axis] + reach:
                inside = False
        if inside:
            first, last = min(first, k), k + 1
    return first, last


@kernel
def lateness(positions, track, sizes, longest):
    """Return the smallest lag (ticks, either sign) at which blade and ball meet face to face.

    Longer than `longest` if there is none.
    """
    racket, work = racket_of(sizes), make_work()
    reach = max(racket.half_width, racket.half_height) + BALL_RADIUS
    centres = np.empty((track.shape[0] + 2, 3))
    blade_centres(track, racket, work, centres)
    span = near_span(positions, centres[track.shape[0] :], reach)
    for size in range(longest + 1):
        for lag in (size, -size):
            if blade_meets(positions, track, centres, racket, reach, lag, span, work):
                return lag
    return longest + 1


@kernel
def blade_meets(positions, track, centres, racket, reach, lag, span, work):
    """Tell whether the blade, `lag` ticks after each ball position, would have been struck."""
    for k in range(max(span[0], -lag), min(span[1], track.shape[0] - lag)):
        px, py, pz, j = positions[k, 0], positions[k, 1], positions[k, 2], k + lag
        dx, dy, dz = px - centres[j, 0], py - centres[j, 1], pz - centres[j, 2]
        if dx * dx + dy * dy + dz * dz > reach * reach:
            continue
        pose_between(track, j, 0.0, work)
        x, y, z = body_point(px, py, pz, work)
        if x > racket.x and blade_gap(x, y, z, racket) <= 0.0:
            y, z = y - racket.y, z - racket.z
            if x - racket.x >= ellipse_gap(y, z, racket.half_width, racket.half_height)[2]:
                return True
    return False
