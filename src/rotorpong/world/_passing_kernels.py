"""How near the ball passed the blade, in space and in time, compiled."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics.ball import Surface
from rotorpong.world._solid_kernels import (
    blade_gap,
    body_point,
    ellipse_gap,
    make_work,
    pose_between,
)
from rotorpong.world.racket import Racket

SLACK = 1e-9  # m, more than rounding makes of any distance here


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
def blade_centre(track, j, racket):
    """Return where the blade's centre is at a pose."""
    w, x, y, z = track[j, 3], track[j, 4], track[j, 5], track[j, 6]
    n = 2.0 / (w * w + x * x + y * y + z * z)
    a, b, c = racket.x, racket.y, racket.z
    along = (1.0 - n * (y * y + z * z)) * a + n * (x * y - w * z) * b + n * (x * z + w * y) * c
    left = n * (x * y + w * z) * a + (1.0 - n * (x * x + z * z)) * b + n * (y * z - w * x) * c
    up = n * (x * z - w * y) * a + n * (y * z + w * x) * b + (1.0 - n * (x * x + y * y)) * c
    return track[j, 0] + along, track[j, 1] + left, track[j, 2] + up


@kernel
def arm_of(racket):
    """Return how far from the centre of mass the blade's centre is, m."""
    return math.sqrt(racket.x * racket.x + racket.y * racket.y + racket.z * racket.z)


@kernel
def reach_of(racket):
    """Return more than the distance at which a ball's centre can be when it touches the blade."""
    return max(racket.half_width, racket.half_height) + BALL_RADIUS + SLACK


@kernel
def distance(x, y, z, point):
    """Return the distance of a place to a point."""
    dx, dy, dz = x - point[0], y - point[1], z - point[2]
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@kernel
def near_span(positions, track, reach):
    """Return first and one beyond last of the positions within reach of the box about a track."""
    first, last = positions.shape[0], 0
    low_x, low_y, low_z = np.inf, np.inf, np.inf
    high_x, high_y, high_z = -np.inf, -np.inf, -np.inf
    for j in range(track.shape[0]):
        low_x, high_x = min(low_x, track[j, 0]), max(high_x, track[j, 0])
        low_y, high_y = min(low_y, track[j, 1]), max(high_y, track[j, 1])
        low_z, high_z = min(low_z, track[j, 2]), max(high_z, track[j, 2])
    for k in range(positions.shape[0]):
        inside_x = low_x - reach <= positions[k, 0] <= high_x + reach
        inside_y = low_y - reach <= positions[k, 1] <= high_y + reach
        if inside_x and inside_y and low_z - reach <= positions[k, 2] <= high_z + reach:
            first, last = min(first, k), k + 1
    return first, last


@kernel
def lateness(positions, track, sizes, longest):
    """Return the smallest lag (ticks, either sign) at which blade and ball meet face to face.

    Longer than `longest` if there is none. A blade too far away for one lag is so for as many more
    as it needs to come near at its fastest pace: those are passed over.
    """
    racket, work, n = racket_of(sizes), make_work(), track.shape[0]
    span = near_span(positions, track, arm_of(racket) + reach_of(racket))
    centres, pace, best = np.empty((n, 3)), SLACK, longest + 1
    first, last = max(0, span[0] - longest), min(n, span[1] + longest)
    for j in range(first, last):
        centres[j, 0], centres[j, 1], centres[j, 2] = blade_centre(track, j, racket)
        if j > first:
            way = distance(centres[j, 0], centres[j, 1], centres[j, 2], centres[j - 1])
            pace = max(pace, way + reach_of(racket) * turned(track, j))
    for k in range(span[0], span[1]):
        for sign in (1, -1):
            most = abs(best) if best < 0 and sign > 0 else abs(best) - 1
            lag = nearest_lag(positions, k, track, (centres, pace), racket, sign, most, work)
            if lag <= most:
                best = sign * lag
    return best


@kernel
def nearest_lag(positions, k, track, path, racket, sign, most, work):
    """Return the smallest lag up to `most`, of one sign, at which the blade meets ball k.

    Longer than `most` if there is none.
    """
    centres, pace = path
    x, y, z, reach = positions[k, 0], positions[k, 1], positions[k, 2], reach_of(racket)
    lag = 0 if sign > 0 else max(0, k - track.shape[0] + 1)
    while lag <= most:
        j = k + sign * lag
        if j < 0 or j >= track.shape[0]:
            break
        away = distance(x, y, z, centres[j]) - reach
        if away > 0.0:
            lag += max(1, int(away / pace))
        else:
            gap, is_struck = blade_meets(x, y, z, track, j, racket, work)
            if is_struck:
                return lag
            lag += max(1, int((gap - SLACK) / pace))
    return most + 1


@kernel
def turned(track, j):
    """Return more than the angle by which the drone turns from pose j - 1 to j."""
    dot, chord = 0.0, 0.0
    for k in range(3, 7):
        dot += track[j - 1, k] * track[j, k]
    for k in range(3, 7):  # of unit quaternions: 2 sin(angle / 4)
        chord += (track[j, k] - math.copysign(track[j - 1, k], dot * track[j - 1, k])) ** 2
    return 2.5 * math.sqrt(chord) + SLACK


@kernel
def blade_meets(x, y, z, track, j, racket, work):
    """Return the gap of a ball at this place to the blade at j, and whether its face is struck."""
    pose_between(track, j, 0.0, work)
    x, y, z = body_point(x, y, z, work)
    gap = blade_gap(x, y, z, racket)
    if x <= racket.x or gap > 0.0:
        return gap, False
    y, z = y - racket.y, z - racket.z
    off = ellipse_gap(y, z, racket.half_width, racket.half_height)[2]
    return gap, x - racket.x >= off
