"""A motion that waits: the same path, later; and instants that are counted exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from primitive_samples import FITTED, GOAL, START
from scipy.integrate import solve_ivp

from rotorpong.conventions import InputError
from rotorpong.primitives import Flight
from rotorpong.primitives.basis import DAMPING, PHASE_DECAY, STIFFNESS, forcing_features
from rotorpong.primitives.quintic import quintic_curvature, quintic_slope, quintic_value
from rotorpong.primitives.sampling import sample_times
from rotorpong.primitives.warping import WarpedClock

FLIGHT = Flight.begin(FITTED, START, GOAL, 0.8)
GAIN = 12.0
ERRORS = np.abs(np.sin(7.0 * np.arange(40))) * 0.1  # m, constant for 20 ms each
STEP = 0.02


def test_without_error_the_clock_is_that_on_the_wall():
    clock = WarpedClock(GAIN)
    for _ in range(10):
        clock = clock.advance(0.05, 0.0)
    assert clock.motion_time == pytest.approx(0.5, abs=1e-15)
    motion, plain = clock.sample(FLIGHT), FLIGHT.at(np.array([clock.motion_time]))
    np.testing.assert_array_equal(motion.velocity, plain.velocity)


def test_an_error_of_one_over_the_gain_halves_the_pace():
    assert WarpedClock(GAIN).advance(0.1, 1.0 / GAIN).motion_time == pytest.approx(0.05)


def test_phase_and_motion_are_those_of_the_slowed_equations():
    """Eqs. (3a) and (4) in real time, with every rate divided by 1 + k |error|."""
    dmp, tau, target = FITTED, 0.8, FLIGHT.target

    def rates(time, state):
        z, s, ds = state[0], state[1:4], state[4:7]  # ds: per motion time
        slow = 1.0 / (1.0 + GAIN * ERRORS[min(int(time / STEP), 39)])
        x = np.array(-np.log(z) / PHASE_DECAY)
        u = forcing_features(state[:1], len(dmp.weights))[0] @ dmp.weights
        g_pull = DAMPING * (quintic_value(target, x) - s) + quintic_slope(target, x) - tau * ds
        push = STIFFNESS * g_pull + quintic_curvature(target, x) + u
        return slow * np.concatenate([[-PHASE_DECAY * z / tau], ds, push / tau**2])

    state, clock = np.concatenate([[1.0], START.position, START.velocity]), WarpedClock(GAIN)
    for i, error in enumerate(ERRORS):
        span = (i * STEP, (i + 1) * STEP - 1e-12)
        state = solve_ivp(rates, span, state, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
        clock = clock.advance(STEP, float(error))
        there = clock.sample(FLIGHT)
        np.testing.assert_allclose(there.position[0], state[1:4], rtol=0, atol=1e-7)
        np.testing.assert_allclose(there.velocity[0], clock.rate * state[4:7], rtol=0, atol=1e-6)
        assert np.exp(-PHASE_DECAY * clock.motion_time / tau) == pytest.approx(state[0], rel=1e-8)
    assert clock.motion_time < 0.8 - 0.1


def test_a_robot_that_is_held_gets_the_whole_motion_later():
    clock, robot, elapsed = WarpedClock(20.0), START.position.copy(), 0.0
    furthest = 0.0
    while clock.motion_time < FLIGHT.arrival:
        wanted = clock.sample(FLIGHT).position[0]
        error = float(np.linalg.norm(wanted - robot))
        furthest = max(furthest, error)
        robot += (wanted - robot) * (0.0 if 0.2 < elapsed < 0.7 else 0.5)
        clock, elapsed = clock.advance(0.005, error), elapsed + 0.005
    assert elapsed > 1.1
    assert np.linalg.norm(clock.sample(FLIGHT).position[0] - GOAL.position) < 1e-9
    assert np.linalg.norm(robot - GOAL.position) < 0.1
    held = np.linalg.norm(
        FLIGHT.at(np.array([0.7])).position[0] - FLIGHT.at(np.array([0.2])).position[0]
    )
    assert furthest < held


def test_lost_time_is_made_up_by_turning_to_the_same_goal():
    clock = WarpedClock(GAIN).advance(0.4, 0.1)
    left = 0.8 - 0.4  # s, until the ball is there
    turned = FLIGHT.regoal(clock.motion_time, GOAL, clock.motion_time + left)
    end = turned.at(np.array([turned.arrival]))
    np.testing.assert_allclose(end.position[0], GOAL.position, atol=1e-9)


def test_a_clock_that_makes_no_sense_is_refused():
    for gain in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="gain"):
            WarpedClock(gain)
    with pytest.raises(InputError, match="motion_time"):
        WarpedClock(1.0, np.nan)
    for elapsed, error, message in ((-0.1, 0.0, "elapsed"), (np.nan, 0.0, "elapsed")):
        with pytest.raises(InputError, match=message):
            WarpedClock(1.0).advance(elapsed, error)
    for error in (-0.1, np.nan, np.inf):
        with pytest.raises(InputError, match="error"):
            WarpedClock(1.0).advance(0.1, error)
    with pytest.raises(InputError, match="expected one from"):
        WarpedClock(1.0).sample(Flight.begin(FITTED, START, GOAL, 0.8, since=2.0))


@settings(max_examples=200, deadline=None)
@given(ticks=st.integers(1, 3000), rate=st.sampled_from([1.0, 30.0, 240.0, 999.0, 1000.0, 1e4]))
def test_whole_ticks_have_one_sample_more_than_ticks(ticks, rate):
    times = sample_times(ticks / rate, rate)
    assert len(times) == ticks + 1
    assert times[0] == 0.0
    assert times[-1] == ticks / rate


@settings(max_examples=200, deadline=None)
@given(duration=st.floats(1e-3, 10.0), rate=st.floats(1.0, 2000.0))
def test_samples_are_ticks_and_the_end(duration, rate):
    times = sample_times(duration, rate)
    assert (times[0], times[-1]) == (0.0, duration)
    steps = np.diff(times)
    assert (steps > 0.0).all()
    np.testing.assert_allclose(steps[:-1], 1.0 / rate, rtol=1e-6)
    assert steps[-1] <= (1.0 + 1e-6) / rate
    FITTED.roll_out(START, GOAL, duration, times)


def test_samples_of_nothing_or_without_end_are_refused():
    for duration, rate in ((0.0, 30.0), (1.0, 0.0), (-1.0, 30.0), (np.nan, 30.0), (1.0, np.inf)):
        with pytest.raises(InputError, match="expected a positive number"):
            sample_times(duration, rate)
    with pytest.raises(InputError, match="at most"):
        sample_times(1e6, 1e6)
