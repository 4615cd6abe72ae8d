"""The rules of `judging`, compiled: when a serve is over, how near and how late the blade was."""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.world._contact_kernels import FACING, SOLID
from rotorpong.world._passing_kernels import (
    SLACK,
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
    least_blade_gap,
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
NEARNESS = (0.9, 2.0)  # m from drone to ball: what is further is not looked at for gap, for lag
CLOSE = 6  # where in a watch the first ticks are at which the ball may be nearer than these
WATCH_COLUMNS = 8
NEAR_LAG = 100  # ticks
LONGEST_LAG = 200  # ticks that a blade may be late or early to be called so


@kernel
def ending(contacts, passed, track, box, ticks, hull):
    """Return how a serve ended in a leg (PLAYING: it goes on) and the deciding contact, or -1.

    Args:
        contacts: (m, 14) of the leg, in order.
        passed: whether the ball `has_passed` the drone.
        track: (k + 1, 7) poses of the drone.
        box: about its places.
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
    for k in range(track.shape[0] if box_in_court(box, hull) else 0):
        if hull_in_court(track[k, 0], track[k, 1], track[k, 2], hull):
            return FAULT, -1
    if fallen or passed or ticks >= LONGEST_SERVE:
        return MISSED, -1
    return PLAYING, -1


@inlined_kernel
def has_passed(ball_x, velocity_x, drone_x):
    """Tell whether a ball is so far behind a drone that the serve is over."""
    return ball_x < drone_x - max(PASSED, -PASSED_TIME * velocity_x)


@inlined_kernel
def box_in_court(box, hull):
    """Tell whether the hull can reach floor, table or net somewhere in a box of places."""
    radius, half_height = hull
    low = box[2] - half_height
    if low < FLOOR_HEIGHT:
        return True
    if low >= NET_HEIGHT:
        return False
    half_length = TABLE_HALF_LENGTH + radius if low < 0.0 else radius
    return box[0] < half_length and box[3] > -half_length


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
def judged(code, balls, track, watch, sizes):
    """Return the final code of a serve that is over, its miss distance (m) and its lag (ticks).

    The miss distance is the least gap between ball and blade at the ticks. The lag is the
    smallest, either sign, at which they would have met face to face; longer than LONGEST_LAG if
    there is none. Ticks in which the ball was too far away to matter are passed over.

    Args:
        code: as `ending` returns it.
        balls: (n, 9) states of the ball.
        track: (n, 7) poses of the drone.
        watch: the box about them 0:6; for each NEARNESS the first tick that may be within it.
        sizes: of the racket: half axes and place.
    """
    if code == HIT:
        return code, 0.0, 0
    racket, n, wide = racket_of(sizes), balls.shape[0], 0.0
    reach, first = arm_of(racket) + reach_of(racket), int(min(watch[CLOSE], n))
    least = least_gap(balls, track, first, racket)
    if not least < NEARNESS[0] - reach:
        least = least_gap(balls, track, 0, racket)
    for k in range(3):
        wide += (watch[3 + k] - watch[k]) ** 2
    first = int(min(watch[CLOSE + 1], n))
    if not math.sqrt(wide) < NEARNESS[1] - reach:  # the drone may have flown to where the ball was
        first = 0
    miss, lag = max(least, 0.0), lateness(balls, track, (first, watch), sizes, LONGEST_LAG)
    if code == MISSED and (miss < NEAR_DISTANCE or abs(lag) <= NEAR_LAG):
        return NEARLY_HIT, miss, lag
    return code, miss, lag


@kernel
def least_gap(balls, track, first, racket):
    """Return the least gap between ball and blade from tick `first` on, m; inf if there is none.

    Instants that cannot matter are passed over: the blade lies in a ball about its centre, and that
    at the end of an arm.
    """
    work, reach, arm = make_work(), reach_of(racket), arm_of(racket)
    least, furthest = np.inf, np.inf
    for turn in range(first - 1, balls.shape[0]):
        k = turn if turn >= first else nearest_tick(balls, track, first, racket)
        if k >= balls.shape[0]:
            break
        if squared_distance(balls, track, k) > furthest:
            continue
        x, y, z = blade_centre(track, k, racket)
        if distance(x, y, z, balls, k) - reach > least:
            continue
        pose_between(track, k, 0.0, work)
        x, y, z = body_point(balls[k, 0], balls[k, 1], balls[k, 2], work)
        if least_blade_gap(x, y, z, racket) > least + SLACK:
            continue
        least = min(least, blade_gap(x, y, z, racket))
        furthest = (max(least, 0.0) + arm + reach) ** 2
    return least


@kernel
def nearest_tick(balls, track, first, racket):
    """Return a tick, from `first` on, at which ball and blade are about as near as they get."""
    nearest, closest, n = first, np.inf, balls.shape[0]
    for k in range(first, n):
        away = squared_distance(balls, track, k)
        if away < closest:
            nearest, closest = k, away
    for step in (-1, 1):
        k, closest = nearest, np.inf
        while first <= k < n:
            x, y, z = blade_centre(track, k, racket)
            away = distance(x, y, z, balls, k)
            if away > closest:
                break
            nearest, closest, k = k, away, k + step
    return nearest


@inlined_kernel
def squared_distance(balls, track, k):
    """Return the squared distance of ball and drone at tick k."""
    dx, dy, dz = balls[k, 0] - track[k, 0], balls[k, 1] - track[k, 1], balls[k, 2] - track[k, 2]
    return dx * dx + dy * dy + dz * dz
