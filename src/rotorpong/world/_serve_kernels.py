"""The launch that meets a target, compiled: scan the lower arc, then Newton in two unknowns.

Contacts are exact at any step. The scan takes long steps (40 ms leave 1e-7 m), the last launches,
which decide, short ones (10 ms leave 1e-9 m). Two arcs less than a step of the scan apart, those
just before the target gets out of reach, may both be stepped over: then the launch is refused.
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
    vy, before, at, legal_before = 0.0, 0.0, 0.0, False
    while k <= last:
        vz = LOWEST + k * STEP
        kind = try_launch(vy, vz, plane_x, bounces, scenes[0], track, work, row, crossing)
        if kind < 0:
            break
        error = crossing[2] - goal[1]
        if kind == 1:
            vy += (goal[0] - crossing[1]) * -state[3] / (state[0] - plane_x)
        if kind == 1 and legal_before and (error > 0.0) != (before > 0.0):
            start = vz - (vz - at) * error / (error - before)
            found, y, z = newton(
                vy, start, plane_x, goal, bounces, scenes, track, work, row, crossing
            )
            if found:
                return True, y, z
        before, at, legal_before = error, vz, kind == 1
        k += max(1, int(abs(error) / (STEEPEST * STEP))) if kind == 1 else 1
    return False, 0.0, 0.0
