"""How near the ball passed the blade, in space and in time, compiled."""


import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics.ball import Surface
from rotorpong.world._solid_kernels import blade_gap, body_point, ellipse_gap, pose_between
from rotorpong.world.racket import Racket


@kernel
def racket_of(p):
    """Return a racket from half axes and place; its surface plays no part."""
    return Racket(Surface(0.0, 0.0), p[0], p[1], p[2], p[3], p[4])


@kernel
def blade_gaps(positions, track, sizes, out):
    """Write the gap between ball k and the blade at pose k."""
    racket, rotation, position, body = racket_of(sizes), np.empty((3, 3)), np.empty(3), np.empty(3)
    for k in range(positions.shape[0]):
        pose_between(track, k, 0.0, rotation, position)
        body_point(positions[k, 0], positions[k, 1], positions[k, 2], rotation, position, body)
        out[k] = blade_gap(body, racket)


@kernel
def blade_centres(track, racket, rotation, position, out):
    """Write where the blade's centre is at each pose."""
    for j in range(track.shape[0]):
        pose_between(track, j, 0.0, rotation, position)
        for k in range(3):
            r = rotation[k]
            out[j, k] = position[k] + r[0] * racket.x + r[1] * racket.y + r[2] * racket.z


@kernel
def near_span(positions, centres, reach):
    """Return first and one beyond last of the positions that any of the centres can reach."""
    first, last = positions.shape[0], 0
    for k in range(positions.shape[0]):
        inside = True
        for axis in range(3):
            low, high = centres[0, axis], centres[1, axis]
            if not low - reach <= positions[k, axis] <= high + reach:
                inside = False
        if inside:
            first, last = min(first, k), k + 1
    return first, last


@kernel
def lateness(positions, track, sizes, longest):
    """Return the smallest lag (ticks, either sign) at which blade and ball meet face to face.

    Longer than `longest` if there is none.
    """
    racket, rotation, position, body = racket_of(sizes), np.empty((3, 3)), np.empty(3), np.empty(3)
    reach = max(racket.half_width, racket.half_height) + BALL_RADIUS
    centres, box = np.empty((track.shape[0], 3)), np.empty((2, 3))
    blade_centres(track, racket, rotation, position, centres)
    for axis in range(3):
        box[0, axis], box[1, axis] = centres[:, axis].min(), centres[:, axis].max()
    span = near_span(positions, box, reach)
    scratch = (rotation, position, body)
    for size in range(longest + 1):
        for lag in (size, -size):
            if blade_meets(positions, track, centres, racket, reach, lag, span, scratch):
                return lag
    return longest + 1


@kernel
def blade_meets(positions, track, centres, racket, reach, lag, span, scratch):
    """Tell whether the blade, `lag` ticks after each ball position, would have been struck."""
    rotation, position, body = scratch
    for k in range(max(span[0], -lag), min(span[1], track.shape[0] - lag)):
        px, py, pz, j = positions[k, 0], positions[k, 1], positions[k, 2], k + lag
        dx, dy, dz = px - centres[j, 0], py - centres[j, 1], pz - centres[j, 2]
        if dx * dx + dy * dy + dz * dz > reach * reach:
            continue
        pose_between(track, j, 0.0, rotation, position)
        body_point(px, py, pz, rotation, position, body)
        if body[0] > racket.x and blade_gap(body, racket) <= 0.0:
            y, z = body[1] - racket.y, body[2] - racket.z
            off = ellipse_gap(y, z, racket.half_width, racket.half_height)[2]
            if body[0] - racket.x >= off:
                return True
    return False
