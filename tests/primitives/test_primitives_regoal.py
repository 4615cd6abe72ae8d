"""A flight that turns to other goals and arrivals, against the equation solved leg by leg."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from primitive_samples import FITTED, GOAL, PAPER, START, durations, states
from scipy.integrate import solve_ivp

from rotorpong.conventions import InputError
from rotorpong.primitives import Flight, State
from rotorpong.primitives.basis import DAMPING, PHASE_DECAY, STIFFNESS, forcing_features
from rotorpong.primitives.quintic import quintic_curvature, quintic_slope, quintic_value

OTHER = State(np.array([0.2, -0.4, 0.6]), np.array([1.0, 0.5, -0.5]))


def jump(before, after, time):
    """Return how far position, velocity and acceleration jump where one becomes the other."""
    ends = [flight.at(np.array([time])) for flight in (before, after)]
    return [
        np.abs(getattr(ends[1], name) - getattr(ends[0], name)).max()
        for name in ("position", "velocity", "acceleration")
    ]


def integrated(leg, begin, stops):
    """Solve Eqs. (3a) and (4) in real time with the leg's target, from (z, s, v)."""
    left = leg.arrival - leg.since
    tau = left / (1.0 - leg.phase_clock)
    d = leg.target.shape[1]

    def rates(time, state):
        z, s, v = state[0], state[1 : d + 1], state[d + 1 :]
        q = np.array((time - leg.since) / left)
        g, g_rate = quintic_value(leg.target, q), quintic_slope(leg.target, q) / left
        g_push = quintic_curvature(leg.target, q) / left**2
        u = forcing_features(state[:1], len(leg.dmp.weights))[0] @ leg.dmp.weights
        pull = STIFFNESS * (DAMPING * (g - s) + tau * (g_rate - v)) + leg.dmp.forcing_gain * u
        return np.concatenate([[-PHASE_DECAY * z / tau], v, pull / tau**2 + g_push])

    solution = solve_ivp(
        rates, (leg.since, stops[-1]), begin, "DOP853", t_eval=stops, rtol=1e-12, atol=1e-12
    )
    return solution.y.T


def test_the_first_leg_is_the_roll_out_at_another_time():
    times = np.linspace(0.0, 0.8, 30)
    push = np.array([1.0, -2.0, 0.5])
    plain = FITTED.roll_out(START, GOAL, 0.8, times, start_acceleration=push)
    flight = Flight.begin(FITTED, START, GOAL, 0.8, since=7.0, start_acceleration=push)
    assert flight.arrival == 7.8
    ours = flight.at(7.0 + times)
    for name in ("position", "velocity", "acceleration"):
        np.testing.assert_allclose(getattr(ours, name), getattr(plain, name), atol=1e-10)


@settings(max_examples=60, deadline=None)
@given(
    start=states,
    first=states,
    second=states,
    duration=durations,
    turn=st.floats(0.0, 0.95),
    left=st.floats(0.05, 3.0),
)
def test_turning_never_jumps_and_meets_the_new_goal(start, first, second, duration, turn, left):
    flight = Flight.begin(FITTED, start, first, duration)
    time = turn * duration
    for arrival in (None, time + left):
        turned = flight.regoal(time, second, arrival)
        place, rate, push = jump(flight, turned, time)
        assert place < 1e-12
        assert rate < 1e-12
        assert push < 1e-9 * (1.0 + np.abs(flight.at(np.array([time])).acceleration).max())
        end = turned.at(np.array([turned.arrival]))
        np.testing.assert_allclose(end.position[0], second.position, rtol=0, atol=1e-9)
        np.testing.assert_allclose(end.velocity[0], second.velocity, rtol=0, atol=1e-9)


@pytest.mark.parametrize("dmp", [FITTED, PAPER])
def test_every_leg_solves_equation_4_whatever_arrivals_do(dmp):
    flight = Flight.begin(dmp, START, GOAL, 0.8)
    begin = np.concatenate([[1.0], START.position, START.velocity])
    for time, goal, arrival in ((0.2, OTHER, 1.3), (0.6, GOAL, 0.95), (0.8, OTHER, None)):
        stops = np.linspace(flight.since, time, 12)
        states_there = integrated(flight, begin, stops)
        ours = flight.at(stops)
        np.testing.assert_allclose(ours.position, states_there[:, 1:4], rtol=0, atol=1e-7)
        np.testing.assert_allclose(ours.velocity, states_there[:, 4:], rtol=0, atol=1e-6)
        begin = states_there[-1]
        flight = flight.regoal(time, goal, arrival)
    stops = np.linspace(flight.since, flight.arrival, 12)
    last = integrated(flight, begin, stops)
    np.testing.assert_allclose(flight.at(stops).position, last[:, 1:4], rtol=0, atol=1e-7)


def test_turning_to_the_same_goal_at_the_same_arrival_changes_nothing():
    flight = Flight.begin(FITTED, START, GOAL, 0.8)
    times = np.linspace(0.3, 0.8, 20)
    turned = flight.regoal(0.3, GOAL)
    np.testing.assert_allclose(turned.at(times).position, flight.at(times).position, atol=1e-12)
    np.testing.assert_allclose(turned.at(times).velocity, flight.at(times).velocity, atol=1e-11)


def test_with_the_arrival_kept_the_targets_acceleration_does_not_jump():
    flight = Flight.begin(FITTED, START, GOAL, 0.8)
    turned = flight.regoal(0.3, OTHER)
    assert turned.echo == pytest.approx(0.0, abs=1e-15)
    before = quintic_curvature(flight.target, np.array(0.3 / 0.8)) / 0.8**2
    after = quintic_curvature(turned.target, np.array(0.0)) / 0.5**2
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-10)


def test_a_goal_with_an_acceleration_is_met_with_it_after_turning():
    hard = State(OTHER.position, OTHER.velocity, np.array([3.0, -1.0, 0.0]))
    turned = Flight.begin(FITTED, START, GOAL, 0.8).regoal(0.3, hard, 1.1)
    end = turned.at(np.array([1.1]))
    np.testing.assert_allclose(end.acceleration[0], hard.acceleration, rtol=0, atol=1e-9)
    np.testing.assert_allclose(end.position[0], hard.position, rtol=0, atol=1e-9)


def test_the_clock_of_the_phase_ends_with_the_flight():
    turned = Flight.begin(FITTED, START, GOAL, 0.8).regoal(0.2, OTHER, 1.4)
    assert turned.phase_clock == pytest.approx(0.25)
    assert turned.phase_clock + turned.pace * (turned.arrival - turned.since) == pytest.approx(1.0)


def test_a_hundred_turns_add_up_no_error():
    rng = np.random.default_rng(0)
    flight = Flight.begin(FITTED, START, GOAL, 1.0)
    for time in np.linspace(0.005, 0.9, 100):
        goal = State(rng.normal(size=3), rng.normal(size=3))
        turned = flight.regoal(time, goal, rng.uniform(1.0, 1.2))
        assert max(jump(flight, turned, time)[:2]) < 1e-12
        flight = turned
    end = flight.at(np.array([flight.arrival]))
    np.testing.assert_allclose(end.position[0], goal.position, rtol=0, atol=1e-9)


def test_a_flight_that_cannot_be_is_refused():
    flight = Flight.begin(FITTED, START, GOAL, 0.8, since=1.0)
    for time in (0.9, np.nextafter(1.8, 0.0), 1.8, 2.0, np.nan):
        with pytest.raises(InputError, match=r"expected one from 1\.0 s to before 1\.8 s"):
            flight.regoal(time, OTHER)
    for arrival in (1.2, 1.1, np.inf, np.nan):
        with pytest.raises(InputError, match="arrival"):
            flight.regoal(1.2, OTHER, arrival)
    for goal in (
        State(np.zeros(2), np.zeros(2)),
        State(np.array([0.0, np.nan, 0.0]), np.zeros(3)),
        State(np.zeros(3), np.zeros(3), np.full(3, np.inf)),
    ):
        with pytest.raises(InputError, match="expected"):
            flight.regoal(1.2, goal)
    for times in (np.array([0.9]), np.array([1.9]), np.array([np.nan])):
        with pytest.raises(InputError, match=r"expected one from 1\.0 s to 1\.8 s"):
            flight.at(times)
    with pytest.raises(InputError, match="since"):
        Flight.begin(FITTED, START, GOAL, 0.8, since=np.nan)
    with pytest.raises(InputError, match="duration"):
        Flight.begin(FITTED, START, GOAL, 0.0)
