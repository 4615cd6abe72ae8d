"""The launch that meets a target, compiled: scan the lower arc, then Newton in two unknowns."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.kernels import kernel
from rotorpong.world._contact_kernels import TABLE, approach, copy_state, make_work

LOWEST, HIGHEST, STEP = -4.0, 4.0, 0.1  # m/s of vertical launch speed
NEWTON_STEPS = 12
NUDGE = 1e-5  # m/s
TOLERANCE = 1e-9  # m
MARGIN = 0.3  # m before the net that spin can carry a ball further
LONGEST = 2.0  # s


@kernel
def try_launch(state, vy, vz, plane_x, solids, work, contacts, crossing):
    """Return 1 for a legal throw, `crossing` being its state at the plane; 0 or -1 if it is not.

    -1: the throw reached the plane without a bounce, and so will any higher one.
    """
    copy_state(state, work.other)
    work.other[4], work.other[5] = vy, vz
    time, count = approach(work.other, plane_x, LONGEST, solids, work, contacts, crossing)
    if time >= 0.0 and count == 0:
        return -1
    if time < 0.0 or count != 1:
        return 0
    return int(int(contacts[0, 1]) == TABLE and contacts[0, 2] < 0.0)


@kernel
def lands_short(state, vz):
    """Tell whether even without drag the ball comes down well before the net."""
    height = state[2] - BALL_RADIUS
    time = (vz + math.sqrt(vz * vz + 2.0 * GRAVITY * max(height, 0.0))) / GRAVITY
    return state[0] + state[3] * time > MARGIN


@kernel
def newton(state, vy, vz, plane_x, goal, solids, work, contacts, crossing):
    """Refine a launch until it meets the goal; return (found, vy, vz)."""
    for _ in range(NEWTON_STEPS):
        if try_launch(state, vy, vz, plane_x, solids, work, contacts, crossing) < 1:
            return False, vy, vz
        ey, ez = crossing[1] - goal[0], crossing[2] - goal[1]
        if abs(ey) < TOLERANCE and abs(ez) < TOLERANCE:
            return True, vy, vz
        y, z = crossing[1], crossing[2]
        if try_launch(state, vy + NUDGE, vz, plane_x, solids, work, contacts, crossing) < 1:
            return False, vy, vz
        yy, zy = (crossing[1] - y) / NUDGE, (crossing[2] - z) / NUDGE
        if try_launch(state, vy, vz + NUDGE, plane_x, solids, work, contacts, crossing) < 1:
            return False, vy, vz
        yz, zz = (crossing[1] - y) / NUDGE, (crossing[2] - z) / NUDGE
        determinant = yy * zz - yz * zy
        if abs(determinant) < 1e-12:
            return False, vy, vz
        vy -= (zz * ey - yz * ez) / determinant
        vz -= (yy * ez - zy * ey) / determinant
    return False, vy, vz


@kernel
def solve(state, plane_x, goal, solids):
    """Return (solved, vy, vz) of the lowest legal launch through the goal (y, z)."""
    work, contacts, crossing = make_work(), np.empty((2, 14)), np.empty(9)
    vy, before, legal_before = 0.0, 0.0, False
    for k in range(round((HIGHEST - LOWEST) / STEP) + 1):
        vz = LOWEST + k * STEP
        if lands_short(state, vz):
            continue
        kind = try_launch(state, vy, vz, plane_x, solids, work, contacts, crossing)
        if kind < 0:
            break
        error = crossing[2] - goal[1]
        if kind == 1:
            vy += (goal[0] - crossing[1]) * -state[3] / (state[0] - plane_x)
        if kind == 1 and legal_before and (error > 0.0) != (before > 0.0):
            start = vz - STEP * error / (error - before)
            found, y, z = newton(state, vy, start, plane_x, goal, solids, work, contacts, crossing)
            if found:
                return True, y, z
        before, legal_before = error, kind == 1
    return False, 0.0, 0.0
