"""The rules of `judging`, compiled: when a serve is over, how near and how late the blade was."""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.world._contact_kernels import FACING, SOLID
from rotorpong.world._passing_kernels import (
    arm_of,
    blade_centre,
    distance,
    lateness,
    racket_of,
    reach_of,
)
from rotorpong.world._solid_kernels import (
    BLADE,
    FLOOR,
    HULL,
    blade_gap,
    body_point,
    make_work,
    pose_between,
)
from rotorpong.world.court import (
    FLOOR_HEIGHT,
    NET_HALF_LENGTH,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)

PLAYING, HIT, HULL_TOUCHED, FAULT, MISSED, NEARLY_HIT = range(6)
LONGEST_SERVE = 3000  # ticks
PASSED = 0.5  # m behind the centre of mass: the ball is gone,
PASSED_TIME = 0.15  # s at its speed: if it is gone so far that a late blade would show
FULL_FACE = math.cos(math.radians(45.0))
NEAR_DISTANCE = 0.05  # m
NEAR_LAG = 100  # ticks
LONGEST_LAG = 200  # ticks that a blade may be late or early to be called so


@kernel
def ending(contacts, path, track, ticks, hull):
    """Return how a serve ended in a leg (PLAYING: it goes on) and the deciding contact, or -1.

    Args:
        contacts: (m, 14) of the leg, in order.
        path: (k, 9) states of the ball after each tick of the leg.
        track: (k + 1, 7) poses of the drone.
        ticks: flown since the release.
        hull: radius and half height, m.
    """
    fallen = False
    for k in range(contacts.shape[0]):
        solid = int(contacts[k, SOLID])
        if solid == BLADE and contacts[k, FACING] >= FULL_FACE:
            return HIT, k
        if solid == HULL:
            return HULL_TOUCHED, k
        fallen = fallen or solid == FLOOR
    for k in range(track.shape[0]):
        if hull_in_court(track[k, 0], track[k, 1], track[k, 2], hull):
            return FAULT, -1
    last = path.shape[0] - 1
    passed = False
    if last >= 0:
        behind = max(PASSED, -PASSED_TIME * path[last, 3])
        passed = path[last, 0] < track[track.shape[0] - 1, 0] - behind
    if fallen or passed or ticks >= LONGEST_SERVE:
        return MISSED, -1
    return PLAYING, -1


@kernel
def hull_in_court(x, y, z, hull):
    """Tell whether the hull of a nearly level drone reaches floor, table or net."""
    radius, half_height = hull
    low = z - half_height
    if low < FLOOR_HEIGHT:
        return True
    if low >= NET_HEIGHT:
        return False
    beyond = abs(x) >= TABLE_HALF_LENGTH + radius or abs(y) >= TABLE_HALF_WIDTH + radius
    if low < 0.0 and not beyond:
        return True
    return abs(x) < radius and abs(y) < NET_HALF_LENGTH + radius


@kernel
def judged(code, balls, track, sizes):
    """Return the final code of a serve that is over, its miss distance (m) and its lag (ticks).

    The miss distance is the least gap between ball and blade at the ticks. The lag is the
    smallest, either sign, at which they would have met face to face; longer than LONGEST_LAG if
    there is none.

    Args:
        code: as `ending` returns it.
        balls: (n, 9) states of the ball.
        track: (n, 7) poses of the drone.
        sizes: of the racket: half axes and place.
    """
    if code == HIT:
        return code, 0.0, 0
    miss = max(least_gap(balls, track, racket_of(sizes)), 0.0)
    lag = lateness(balls, track, sizes, LONGEST_LAG)
    if code == MISSED and (miss < NEAR_DISTANCE or abs(lag) <= NEAR_LAG):
        return NEARLY_HIT, miss, lag
    return code, miss, lag


@kernel
def least_gap(balls, track, racket):
    """Return the least gap between ball and blade over all ticks, m.

    Instants that cannot matter are passed over: the blade lies in a ball about its centre, and that
    at the end of an arm.
    """
    work, reach, arm = make_work(), reach_of(racket), arm_of(racket)
    nearest, closest, least = 0, np.inf, np.inf
    for k in range(balls.shape[0]):
        away = squared_distance(balls[k], track[k])
        if away < closest:
            nearest, closest = k, away
    furthest = np.inf
    for turn in range(-1, balls.shape[0]):
        k = nearest if turn < 0 else turn
        if squared_distance(balls[k], track[k]) > furthest:
            continue
        x, y, z = blade_centre(track, k, racket)
        if distance(x, y, z, balls[k]) - reach > least:
            continue
        pose_between(track, k, 0.0, work)
        x, y, z = body_point(balls[k, 0], balls[k, 1], balls[k, 2], work)
        least = min(least, blade_gap(x, y, z, racket))
        furthest = (max(least, 0.0) + arm + reach) ** 2
    return least


@kernel
def squared_distance(a, b):
    """Return the squared distance of two points (the first three numbers of each)."""
    dx, dy, dz = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return dx * dx + dy * dy + dz * dz
