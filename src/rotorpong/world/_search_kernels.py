"""Where in a step the ball first touches a solid, compiled.

A step in which a gap can have been negative is known beforehand (see also `_nearness_kernels`), and
is searched by going forward no further than the gap allows; nothing else of it is computed. Contact
times solve gap = 0 on the step's own RK4 path, so restitution does not depend on where in a step
the contact falls.
"""

import math

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.kernels import kernel
from rotorpong.world._nearness_kernels import ball_travel
from rotorpong.world._solid_kernels import (
    BLADE,
    END,
    PROBE,
    START,
    TABLE,
    body_point,
    gap,
    least_blade_gap,
    pose_between,
    step_row,
)

LOOKS = 64  # a step is looked at as often, where it may graze
ROOT_STEPS = 60
ROOT_TOLERANCE = 1e-12  # m


@kernel
def nearest_contact(solids, dt, way, track, span, scene, work):
    """Return (solid, fraction) of the first contact of the step from START to END.

    Args:
        solids: the first to look at, one beyond the last.
        dt: of the step, s.
        way: more than the ball, and than the drone, moves in it, m.
        track: poses.
        span: tick, where in it the step begins, and its share of it.
        scene: parameters.
        work: scratch.

    Returns:
        (-1, 1) if there is none.
    """
    hit, first = -1, 1.0
    i, base, scale = span
    for solid in range(solids[0], solids[1]):
        travel = way[0] if solid < BLADE else way[0] + way[1]
        if is_clear(solid, travel, dt, track, span, scene, work):
            continue
        low = gap(solid, START, track, i, base, scene, work)
        if low > travel:
            continue
        high = gap(solid, END, track, i, base + scale, scene, work)
        if (high >= 0.0 and low + high > travel) or (low < 0.0 and high > low):
            continue
        upper = 1.0
        if high >= 0.0:
            upper = clear_fraction(solid, low, travel, dt, track, span, scene, work)
            if upper < 0.0:
                continue
        f = contact_fraction(solid, low, upper, dt, track, span, scene, work)
        if hit < 0 or f < first:
            hit, first = solid, f
    return hit, first


@kernel
def is_clear(solid, travel, dt, track, span, scene, work):
    """Tell at small cost whether a solid cannot be touched in the step; False where unsure."""
    if solid == TABLE:
        return stays_above(work, dt, scene.air)
    if solid == BLADE:
        i, base, _ = span
        pose_between(track, i, base, work)
        x, y, z = body_point(work[START, 0], work[START, 1], work[START, 2], work)
        return least_blade_gap(x, y, z, scene.racket) > travel
    return False


@kernel
def stays_above(work, dt, air):
    """Tell whether the ball stays above the table's plane through the step from START to END.

    Under an upward acceleration a the path dips a dt^2 / 8 below its chord at most.
    """
    low, high = work[START, 2] - BALL_RADIUS, work[END, 2] - BALL_RADIUS
    if low < 0.0 or high < 0.0:
        return False
    speed = ball_travel(work[START, 3], work[START, 4], work[START, 5], dt) / dt
    spin = math.sqrt(work[START, 6] ** 2 + work[START, 7] ** 2 + work[START, 8] ** 2)
    push = (air.drag * speed + abs(air.magnus) * spin) * speed - GRAVITY
    return push <= 0.0 or min(low, high) >= push * dt * dt / 8.0


@kernel
def clear_fraction(solid, low, travel, dt, track, span, scene, work):
    """Return the first fraction of a step seen with a negative gap, -1 if there is none.

    Goes forward as far as the gap allows, but no less than 1/64 of the step: a graze that is missed
    is shallower than 10 micrometres.
    """
    f, here = 0.0, low
    while True:
        f += max(here / travel, 1.0 / LOOKS)
        if f >= 1.0:
            return -1.0
        here = gap_within(solid, f, dt, track, span, scene, work)
        if here < 0.0:
            return f


@kernel
def contact_fraction(solid, low, upper, dt, track, span, scene, work):
    """Return where in (0, upper] of the step the gap vanishes: regula falsi as Illinois has it."""
    a, fa, b, side = 0.0, max(low, 0.0), upper, 0
    fb = gap_within(solid, b, dt, track, span, scene, work)
    for _ in range(ROOT_STEPS):
        c = b - fb * (b - a) / (fb - fa) if fa > fb else a
        fc = gap_within(solid, c, dt, track, span, scene, work)
        if abs(fc) < ROOT_TOLERANCE or b - a < 1e-15:
            return c
        if fc > 0.0:
            a, fa = c, fc
            fb = 0.5 * fb if side == 1 else fb
            side = 1
        else:
            b, fb = c, fc
            fa = 0.5 * fa if side == -1 else fa
            side = -1
    return a


@kernel
def gap_within(solid, f, dt, track, span, scene, work):
    """Return the gap at a fraction of the step from START; the ball there is PROBE."""
    step_row(work, START, f * dt, scene.air, PROBE)
    i, base, scale = span
    return gap(solid, PROBE, track, i, base + scale * f, scene, work)
