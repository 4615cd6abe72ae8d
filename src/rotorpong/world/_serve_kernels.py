"""The launch that meets a target, compiled: scan the lower arc, then Newton in two unknowns.

Contacts are exact at any step. The scan takes long steps (40 ms leave 1e-7 m), the last launches,
which decide, short ones (10 ms leave 1e-9 m). Just before a target gets out of reach its two arcs
may lie between two steps of the scan, which then sees the height at the plane turn back on the same
side of the goal: the parabola through three steps tells where to look for the turning point.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.kernels import kernel
from rotorpong.world._contact_kernels import (
    CONTACT_COLUMNS,
    PASSED,
    POSITION,
    next_event,
)
from rotorpong.world._solid_kernels import (
    LAUNCHED,
    START,
    TABLE,
    copy_row,
    make_work,
    scene_of,
)

LOWEST, STEP = -4.0, 0.1  # m/s of vertical launch speed: where the scan begins, how it goes on
HIGHEST = (10.0, 4.0)  # m/s, where it ends: without a bounce, with one
STEEPEST = 1.5  # m at the plane per m/s of launch: no launch changes its height faster
NEWTON_STEPS = 12
NUDGE = 1e-5  # m/s
NEAR = 1e-5  # m from the target: the slopes are good enough
TOLERANCE = 1e-9  # m
MARGIN = 0.3  # m before the net that spin can carry a ball further
LONGEST = 2.0  # s
TURN_STEPS = 6  # of the search for a turning point
TURN_NEAR = 0.01  # m from the goal: no parabola through a step's neighbours is further off


@kernel
def try_launch(vy, vz, plane_x, bounces, scene, track, work, row, crossing):
    """Return 1 for a legal throw, `crossing` being its state at the plane; 0 or -1 if it is not.

    Thrown from LAUNCHED. -1: it reached the plane without the bounce, and so will any higher one.
    """
    copy_row(work, LAUNCHED, START)
    work[START, 4], work[START, 5] = vy, vz
    event, time = next_event(0.0, plane_x, LONGEST, scene, track, work, row, crossing)
    if bounces == 0:
        return int(event == PASSED)
    if event == PASSED:
        return -1
    if event != TABLE or row[POSITION] >= 0.0:
        return 0
    event, time = next_event(time, plane_x, LONGEST, scene, track, work, row, crossing)
    return int(event == PASSED)


@kernel
def lands_short(state, vz):
    """Tell whether even without drag the ball comes down well before the net."""
    height = state[2] - BALL_RADIUS
    time = (vz + math.sqrt(vz * vz + 2.0 * GRAVITY * max(height, 0.0))) / GRAVITY
    return state[0] + state[3] * time > MARGIN


@kernel
def lowest_over_net(state, last, plane_x, scene, track, work, row, crossing):
    """Return the first step of the scan that touches nothing before x = 0, by bisection."""
    low, high = -1, last + 1
    while high - low > 1:
        k = (low + high) // 2
        vz = LOWEST + k * STEP
        over = False
        if not lands_short(state, vz):
            copy_row(work, LAUNCHED, START)
            work[START, 5] = vz
            event, _ = next_event(0.0, plane_x, LONGEST, scene, track, work, row, crossing)
            over = event == PASSED or (event == TABLE and row[POSITION] < 0.0)
        if over:
            high = k
        else:
            low = k
    return high


@kernel
def newton(vy, vz, plane_x, goal, bounces, scenes, track, work, row, crossing):
    """Refine a launch until it meets the goal; return (found, vy, vz).

    Slopes are those of the last launch further from the goal than `NEAR`; from there on the steps
    of the flight are short.
    """
    yy, zy, yz, zz, determinant = 0.0, 0.0, 0.0, 0.0, 0.0
    scene, is_near = scenes[0], False
    for _ in range(NEWTON_STEPS):
        if try_launch(vy, vz, plane_x, bounces, scene, track, work, row, crossing) < 1:
            return False, vy, vz
        y, z = crossing[1], crossing[2]
        ey, ez = y - goal[0], z - goal[1]
        if is_near and abs(ey) < TOLERANCE and abs(ez) < TOLERANCE:
            return True, vy, vz
        if determinant == 0.0 or (not is_near and max(abs(ey), abs(ez)) > NEAR):
            if try_launch(vy + NUDGE, vz, plane_x, bounces, scene, track, work, row, crossing) < 1:
                return False, vy, vz
            yy, zy = (crossing[1] - y) / NUDGE, (crossing[2] - z) / NUDGE
            if try_launch(vy, vz + NUDGE, plane_x, bounces, scene, track, work, row, crossing) < 1:
                return False, vy, vz
            yz, zz = (crossing[1] - y) / NUDGE, (crossing[2] - z) / NUDGE
            determinant = yy * zz - yz * zy
            if abs(determinant) < 1e-12:
                return False, vy, vz
        else:
            scene, is_near = scenes[1], True
        vy -= (zz * ey - yz * ez) / determinant
        vz -= (yy * ez - zy * ey) / determinant
    return False, vy, vz


@kernel
def vertex_of(a, b, c):
    """Return (x, y) where the parabola through three points (x, y) with b between a, c turns."""
    left, right = b[0] - a[0], c[0] - b[0]
    rise, fall = (b[1] - a[1]) / left, (c[1] - b[1]) / right
    bend = (fall - rise) / (left + right)
    if bend == 0.0:
        return b
    x = 0.5 * (a[0] + b[0] - rise / bend)
    return x, b[1] + (x - b[0]) * (rise + bend * (x - a[0]))


@kernel
def beyond_turn(vy, a, b, c, plane_x, goal, bounces, scene, track, work, row, crossing):
    """Return (found, vz, error) of a launch between a and c that is on the goal's other side.

    a, b, c are (vz, error) of launches on the same side of it, b nearest.
    """
    side = math.copysign(1.0, b[1])
    for _ in range(TURN_STEPS):
        vz, error = vertex_of(a, b, c)
        if side * error > TURN_NEAR or not a[0] < vz < c[0] or vz == b[0]:
            break
        if try_launch(vy, vz, plane_x, bounces, scene, track, work, row, crossing) < 1:
            break
        turn = vz, crossing[2] - goal[1]
        if side * turn[1] < 0.0:
            return True, turn[0], turn[1]
        if side * turn[1] < side * b[1]:
            a, b, c = (a, turn, b) if vz < b[0] else (b, turn, c)
        elif vz < b[0]:
            a = turn
        else:
            c = turn
    return False, 0.0, 0.0


@kernel
def solve(state, plane_x, goal, bounces, parameters):
    """Return (solved, vy, vz) of the lowest legal launch through the goal (y, z).

    Args:
        state: (9,), at the release; its sideways and upward speed play no part.
        plane_x: m.
        goal: (2,), m.
        bounces: 0 or 1, on the drone's half.
        parameters: (2, k), of the solids with a long and with a short step.
    """
    work, row, crossing = make_work(), np.empty(CONTACT_COLUMNS), np.empty(9)
    track = np.empty((0, 7))
    for k in range(9):
        work[LAUNCHED, k] = state[k]
    work[LAUNCHED, 4] = 0.0
    scenes = (scene_of(parameters[0]), scene_of(parameters[1]))
    last = round((HIGHEST[bounces] - LOWEST) / STEP)
    k = lowest_over_net(state, last, plane_x, scenes[0], track, work, row, crossing)
    vy, legal = 0.0, 0  # of the last three launches, if as many in a row were legal:
    a, b, c = (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)
    while k <= last:
        vz = LOWEST + k * STEP
        kind = try_launch(vy, vz, plane_x, bounces, scenes[0], track, work, row, crossing)
        if kind < 0:
            break
        if kind == 0:
            legal, k = 0, k + 1
            continue
        a, b, c = b, c, (vz, crossing[2] - goal[1])
        legal += 1
        vy += (goal[0] - crossing[1]) * -state[3] / (state[0] - plane_x)
        low, high, crosses = b, c, legal > 1 and (c[1] > 0.0) != (b[1] > 0.0)
        if legal > 2 and not crosses and abs(b[1]) < min(abs(a[1]), abs(c[1])):
            crosses, x, y = beyond_turn(
                vy, a, b, c, plane_x, goal, bounces, scenes[0], track, work, row, crossing
            )
            low, high = (b, (x, y)) if x > b[0] else (a, (x, y))
        if crosses:
            start = high[0] - (high[0] - low[0]) * high[1] / (high[1] - low[1])
            found, y, z = newton(
                vy, start, plane_x, goal, bounces, scenes, track, work, row, crossing
            )
            if found:
                return True, y, z
        k += max(1, int(abs(c[1]) / (STEEPEST * STEP)))
    return False, 0.0, 0.0
