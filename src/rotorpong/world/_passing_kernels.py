"""How near the ball passed the blade, in space and in time, compiled."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.physics.ball import Surface
from rotorpong.world._nearness_kernels import box_of
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


@inlined_kernel
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


@inlined_kernel
def distance(x, y, z, points, k):
    """Return the distance of a place to a point (the first three numbers of row k)."""
    dx, dy, dz = x - points[k, 0], y - points[k, 1], z - points[k, 2]
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@inlined_kernel
def is_near(positions, k, box, reach):
    """Tell whether a position is within reach of a box, corners apart."""
    x, y, z = positions[k, 0], positions[k, 1], positions[k, 2]
    inside = box[0] - reach <= x <= box[3] + reach and box[1] - reach <= y <= box[4] + reach
    return inside and box[2] - reach <= z <= box[5] + reach


@kernel
def near_span(positions, first, box, reach):
    """Return first and one beyond last of the positions from `first` on within reach of a box."""
    start, end = positions.shape[0], 0
    for k in range(first, positions.shape[0]):
        if is_near(positions, k, box, reach):
            start, end = min(start, k), k + 1
    return start, end


@kernel
def lateness(positions, track, nearness, sizes, longest):
    """Return the smallest lag (ticks, either sign) at which blade and ball meet face to face.

    Longer than `longest` if there is none. A blade too far away for one lag is so for as many more
    as it needs to come near at its fastest pace: those are passed over.

    Args:
        positions: of the ball, at all ticks.
        track: poses of the drone.
        nearness: the first tick at which the ball may be near, the box about the drone's places.
        sizes: of the racket.
        longest: lag, ticks.
    """
    racket, work, n = racket_of(sizes), make_work(), track.shape[0]
    reach, (tick, box) = reach_of(racket), nearness
    start, end = near_span(positions, tick, box, arm_of(racket) + reach)
    centres, best = np.empty((n, 3)), longest + 1
    first, last = max(0, start - longest), min(n, end + longest)
    pace = write_centres(track, first, last, racket, centres)
    blade_box = box_of(centres[first:last])
    for k in range(start, end):
        if not is_near(positions, k, blade_box, reach):
            continue
        for sign in (1, -1):
            most = abs(best) if best < 0 and sign > 0 else abs(best) - 1
            lag = nearest_lag(positions, k, track, centres, pace, racket, sign, most, work)
            if lag <= most:
                best = sign * lag
    return best


@kernel
def write_centres(track, first, last, racket, centres):
    """Write the blade's centre at some poses; return more than a blade's point moves in a tick."""
    way, turn = 0.0, 0.0
    for j in range(first, last):
        x, y, z = blade_centre(track, j, racket)
        centres[j, 0], centres[j, 1], centres[j, 2] = x, y, z
        if j > first:
            dx, dy, dz = x - centres[j - 1, 0], y - centres[j - 1, 1], z - centres[j - 1, 2]
            way = max(way, dx * dx + dy * dy + dz * dz)
            turn = max(turn, squared_chord(track, j))
    return math.sqrt(way) + reach_of(racket) * (2.5 * math.sqrt(turn) + SLACK) + SLACK


@kernel
def nearest_lag(positions, k, track, centres, pace, racket, sign, most, work):
    """Return the smallest lag up to `most`, of one sign, at which the blade meets ball k.

    Longer than `most` if there is none.
    """
    x, y, z, reach = positions[k, 0], positions[k, 1], positions[k, 2], reach_of(racket)
    lag = 0 if sign > 0 else max(0, k - track.shape[0] + 1)
    while lag <= most:
        j = k + sign * lag
        if j < 0 or j >= track.shape[0]:
            break
        away = distance(x, y, z, centres, j) - reach
        if away > 0.0:
            lag += max(1, int(away / pace))
        else:
            gap, is_struck = blade_meets(x, y, z, track, j, racket, work)
            if is_struck:
                return lag
            lag += max(1, int((gap - SLACK) / pace))
    return most + 1


@inlined_kernel
def squared_chord(track, j):
    """Return how far apart the unit quaternions j - 1 and j are: (2 sin(angle / 4))^2."""
    plus, minus = 0.0, 0.0
    for k in range(3, 7):
        plus += (track[j, k] + track[j - 1, k]) ** 2
        minus += (track[j, k] - track[j - 1, k]) ** 2
    return min(plus, minus)


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
