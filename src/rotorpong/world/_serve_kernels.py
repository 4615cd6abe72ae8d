"""The launch that meets a target, compiled: scan the lower arc, then Newton in two unknowns.

Flights have exact contacts at any step; the scan takes long steps (20 ms leave 1e-8 m), the last
corrections short ones.
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
from rotorpong.world._solid_kernels import TABLE, copy_state, make_work, scene_of

LOWEST, STEP = -4.0, 0.1  # m/s of vertical launch speed: where the scan begins, how it goes on
HIGHEST = (10.0, 4.0)  # m/s, where it ends: without a bounce, with one
NEWTON_STEPS = 12
NUDGE = 1e-5  # m/s
NEAR = 1e-5  # m from the target: the slopes are good enough
TOLERANCE = 1e-9  # m
MARGIN = 0.3  # m before the net that spin can carry a ball further
LONGEST = 2.0  # s


@kernel
def try_launch(state, vy, vz, plane_x, bounces, scene, work, row, crossing):
    """Return 1 for a legal throw, `crossing` being its state at the plane; 0 or -1 if it is not.

    -1: the throw reached the plane without the bounce, and so will any higher one.
    """
    launched = work.launched
    copy_state(state, launched)
    launched[4], launched[5] = vy, vz
    event, time = next_event(launched, 0.0, plane_x, LONGEST, scene, work, row, crossing)
    if bounces == 0:
        return int(event == PASSED)
    if event == PASSED:
        return -1
    if event != TABLE or row[POSITION] >= 0.0:
        return 0
    event, time = next_event(launched, time, plane_x, LONGEST, scene, work, row, crossing)
    return int(event == PASSED)


@kernel
def lands_short(state, vz):
    """Tell whether even without drag the ball comes down well before the net."""
    height = state[2] - BALL_RADIUS
    time = (vz + math.sqrt(vz * vz + 2.0 * GRAVITY * max(height, 0.0))) / GRAVITY
    return state[0] + state[3] * time > MARGIN


@kernel
def newton(state, vy, vz, plane_x, goal, bounces, scenes, work, row, crossing):
    """Refine a launch until it meets the goal; return (found, vy, vz).

    Slopes are those of the last launch further from the goal than `NEAR`; from there on the steps
    of the flight are short.
    """
    yy, zy, yz, zz, determinant = 0.0, 0.0, 0.0, 0.0, 0.0
    scene, is_near = scenes[0], False
    for _ in range(NEWTON_STEPS):
        if try_launch(state, vy, vz, plane_x, bounces, scene, work, row, crossing) < 1:
            return False, vy, vz
        y, z = crossing[1], crossing[2]
        ey, ez = y - goal[0], z - goal[1]
        if is_near and abs(ey) < TOLERANCE and abs(ez) < TOLERANCE:
            return True, vy, vz
        if determinant == 0.0 or (not is_near and max(abs(ey), abs(ez)) > NEAR):
            if try_launch(state, vy + NUDGE, vz, plane_x, bounces, scene, work, row, crossing) < 1:
                return False, vy, vz
            yy, zy = (crossing[1] - y) / NUDGE, (crossing[2] - z) / NUDGE
            if try_launch(state, vy, vz + NUDGE, plane_x, bounces, scene, work, row, crossing) < 1:
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
    scenes = (scene_of(parameters[0]), scene_of(parameters[1]))
    vy, before, legal_before = 0.0, 0.0, False
    for k in range(round((HIGHEST[bounces] - LOWEST) / STEP) + 1):
        vz = LOWEST + k * STEP
        if lands_short(state, vz):
            continue
        kind = try_launch(state, vy, vz, plane_x, bounces, scenes[0], work, row, crossing)
        if kind < 0:
            break
        error = crossing[2] - goal[1]
        if kind == 1:
            vy += (goal[0] - crossing[1]) * -state[3] / (state[0] - plane_x)
        if kind == 1 and legal_before and (error > 0.0) != (before > 0.0):
            start = vz - STEP * error / (error - before)
            found, y, z = newton(
                state, vy, start, plane_x, goal, bounces, scenes, work, row, crossing
            )
            if found:
                return True, y, z
        before, legal_before = error, kind == 1
    return False, 0.0, 0.0
