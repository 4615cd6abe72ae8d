"""The flights of `flight_fit`, compiled: along measured times with bounces, and back in time."""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import bounce, step
from rotorpong.physics.ball import STEP

ROOT_STEPS = 60
ROOT_TOLERANCE = 1e-12  # m


@kernel
def fall_fraction(state, dt, air, height, probe):
    """Return where in a step the centre comes down to `height`: regula falsi with bisection."""
    a, b = 0.0, 1.0
    fa = state[2] - height
    step(state, dt, air, probe)
    fb = probe[2] - height
    for k in range(ROOT_STEPS):
        c = b - fb * (b - a) / (fb - fa) if k % 3 < 2 else 0.5 * (a + b)
        step(state, c * dt, air, probe)
        fc = probe[2] - height
        if abs(fc) < ROOT_TOLERANCE:
            return c
        if fc > 0.0:
            a, fa = c, fc
        else:
            b, fb = c, fc
    return b


@kernel
def follow(state, times, air, surface, height, most, path):
    """Write the state at each time; the centre bounces at `height`, wherever that is.

    Args:
        state: (9,) at the first time, changed in place.
        times: (n,) s, increasing.
        air: what it does to the ball.
        surface: what it bounces off.
        height: of the centre at a bounce, m.
        most: bounces; then it falls through.
        path: (n, 9).

    Returns:
        The number of bounces.
    """
    after, normal, still = np.empty(9), np.array([0.0, 0.0, 1.0]), np.zeros(3)
    bounces = 0
    path[0] = state
    for i in range(1, times.shape[0]):
        rest = times[i] - times[i - 1]
        while rest > 0.0:
            dt = min(rest, STEP)
            step(state, dt, air, after)
            if bounces < most and state[2] >= height and after[2] < height:
                dt *= fall_fraction(state, dt, air, height, after)
                step(state, dt, air, after)
                bounce(after, normal, still, surface)
                after[2] = height
                bounces += 1
            state[:] = after
            rest -= dt
        path[i] = state
    return bounces


@kernel
def fall(states, air, height, longest, times):
    """Fly every state until its centre comes down to `height`; the time is NaN if it does not.

    Args:
        states: (n, 9), changed in place.
        air: what it does to the ball.
        height: m.
        longest: s.
        times: (n,), written.
    """
    after = np.empty(9)
    for i in range(states.shape[0]):
        state, time, times[i] = states[i], 0.0, np.nan
        while time < longest:
            step(state, STEP, air, after)
            if state[2] >= height and after[2] < height:
                dt = STEP * fall_fraction(state, STEP, air, height, after)
                step(state, dt, air, after)
                state[:] = after
                times[i] = time + dt
                break
            state[:] = after
            time += STEP


@kernel
def trace(state, air, dt, path):
    """Write the states after 0, 1, 2 ... steps of free flight; a negative dt goes back in time."""
    path[0] = state
    for i in range(1, path.shape[0]):
        step(path[i - 1], dt, air, path[i])


@kernel
def fly_each(states, air, durations):
    """Fly state i for durations[i] seconds, in place; a negative duration goes back in time."""
    for i in range(states.shape[0]):
        steps = max(1, math.ceil(abs(durations[i]) / STEP))
        for _ in range(steps):
            step(states[i], durations[i] / steps, air, states[i])
