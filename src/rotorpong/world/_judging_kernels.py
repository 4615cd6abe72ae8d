"""The rules of `judging`, compiled: when a serve is over, how near and how late the blade was."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world._contact_kernels import (
    BLADE,
    FLOOR,
    HULL,
    blade_gap,
    body_point,
    ellipse_gap,
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
SOLID_COLUMN, FACING_COLUMN = 1, 11  # of a contact's row
SLACK = 1e-9  # m, more than rounding makes of any distance here


@kernel
def ending(contacts, path, track, ticks, hull):
    """Return how a serve ended in a leg (PLAYING: it goes on) and the deciding contact, or -1.

    Args:
        contacts: (m, 14) of the leg, in order.
        path: (k, 9) states of the ball after each tick of the leg.
        track: (k + 1, 7) poses of the drone.
        ticks: flown since the release.
        hull: of the drone.
    """
    fallen = False
    for k in range(contacts.shape[0]):
        solid = int(contacts[k, SOLID_COLUMN])
        if solid == BLADE and contacts[k, FACING_COLUMN] >= FULL_FACE:
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
    low = z - hull.half_height
    if low < FLOOR_HEIGHT:
        return True
    if low >= NET_HEIGHT:
        return False
    beyond = abs(x) >= TABLE_HALF_LENGTH + hull.radius or abs(y) >= TABLE_HALF_WIDTH + hull.radius
    if low < 0.0 and not beyond:
        return True
    return abs(x) < hull.radius and abs(y) < NET_HALF_LENGTH + hull.radius


@kernel
def judged(code, balls, track, racket, scratch):
    """Return the final code of a serve that is over, its miss distance (m) and its lag (ticks).

    The lag is longer than LONGEST_LAG if there is none.
    """
    if code == HIT:
        return code, 0.0, 0
    least, lag = nearness(balls, track, racket, LONGEST_LAG, scratch)
    miss = max(least, 0.0)
    if code == MISSED and (miss < NEAR_DISTANCE or abs(lag) <= NEAR_LAG):
        return NEARLY_HIT, miss, lag
    return code, miss, lag


@kernel
def nearness(balls, track, racket, longest, scratch):
    """Return the least gap (m) between ball and blade, and the blade's lateness (ticks).

    The gap is the least of those at the ticks. The lateness is the smallest lag, either sign, at
    which blade and ball would have met face to face; longer than `longest` if there is none.
    Instants that cannot matter are passed over: the blade lies in a ball about its centre.

    Args:
        balls: (n, 9) states of the ball.
        track: (n, 7) poses of the drone.
        racket: the blade.
        longest: ticks.
        scratch: (n, 3) for the blade's centres.
    """
    rotation, position = np.empty((3, 3)), np.empty(3)
    reach = max(racket.half_width, racket.half_height) + BALL_RADIUS + SLACK
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for k in range(balls.shape[0]):
        pose_between(track, k, 0.0, rotation, position)
        for i in range(3):
            centre = (
                position[i]
                + rotation[i, 0] * racket.x
                + rotation[i, 1] * racket.y
                + rotation[i, 2] * racket.z
            )
            scratch[k, i] = centre
            low[i], high[i] = min(low[i], centre - reach), max(high[i], centre + reach)
    least = least_gap(balls, track, racket, reach, scratch)
    return least, lateness(balls, track, racket, longest, (low, high), scratch)


@kernel
def least_gap(balls, track, racket, reach, centres):
    """Return the least gap between ball and blade over all ticks, m."""
    rotation, position, body = np.empty((3, 3)), np.empty(3), np.empty(3)
    nearest, closest = 0, np.inf
    for k in range(balls.shape[0]):
        away = distance(balls[k], centres[k])
        if away < closest:
            nearest, closest = k, away
    least = np.inf
    for turn in range(-1, balls.shape[0]):
        k = nearest if turn < 0 else turn
        if distance(balls[k], centres[k]) - reach > least:
            continue
        pose_between(track, k, 0.0, rotation, position)
        body_point(balls[k, 0], balls[k, 1], balls[k, 2], rotation, position, body)
        least = min(least, blade_gap(body, racket))
    return least


@kernel
def distance(a, b):
    """Return the distance of two points (the first three numbers of each)."""
    dx, dy, dz = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@kernel
def lateness(balls, track, racket, longest, box, centres):
    """Return the smallest lag (ticks) at which blade and ball meet, longer than `longest` if none.

    `box` is (low, high), what the blade swept: a ball outside is met by no blade.
    """
    low, high = box
    first, last = balls.shape[0], -1
    for k in range(balls.shape[0]):
        x, y, z = balls[k, 0], balls[k, 1], balls[k, 2]
        beside = x < low[0] or x > high[0] or y < low[1] or y > high[1]
        if not (beside or z < low[2] or z > high[2]):
            first, last = min(first, k), k
    scratch = np.empty((3, 3)), np.empty(3), np.empty(3)
    for size in range(longest + 1 if last >= 0 else 0):
        for lag in (size, -size):
            for k in range(max(first, -lag), min(last, track.shape[0] - 1 - lag) + 1):
                if meets(balls[k], track, k + lag, racket, centres, scratch):
                    return lag
    return longest + 1


@kernel
def meets(ball, track, j, racket, centres, scratch):
    """Tell whether the blade of tick j has, or has passed, the ball on its face."""
    reach = max(racket.half_width, racket.half_height) + BALL_RADIUS + SLACK
    if distance(ball, centres[j]) > reach:
        return False
    rotation, position, body = scratch
    pose_between(track, j, 0.0, rotation, position)
    body_point(ball[0], ball[1], ball[2], rotation, position, body)
    if body[0] <= racket.x or blade_gap(body, racket) > 0.0:
        return False
    y, z = body[1] - racket.y, body[2] - racket.z
    off = ellipse_gap(y, z, racket.half_width, racket.half_height)[2]
    return body[0] - racket.x >= off
