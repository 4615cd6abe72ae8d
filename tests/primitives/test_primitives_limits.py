"""Peaks are the peaks, and adjusted motions keep their limits, barely."""

from inspect import unwrap

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from primitive_samples import FITTED, GOAL, PAPER, START, durations, some_dmps, states

from rotorpong.conventions import InputError
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.primitives import Dmp, Flight, State
from rotorpong.primitives.limits import Limits, report_flight, report_limits, with_limits

REST = State(np.zeros(3), np.zeros(3))
AWAY = State(np.array([1.0, 0.4, 0.3]), np.array([0.6, 0.2, 0.1]))


def dense(dmp, start, goal, duration, samples=20001):
    return dmp.roll_out(start, goal, duration, np.linspace(0.0, duration, samples))


@settings(max_examples=40, deadline=None)
@given(start=states, goal=states, duration=durations, scale=st.floats(-3.0, 3.0))
def test_no_sample_is_faster_than_the_peak_and_one_is_nearly_as_fast(start, goal, duration, scale):
    dmp = Dmp(scale * FITTED.weights)
    report = report_limits(dmp, start, goal, duration, Limits())
    motion = dense(dmp, start, goal, duration, 4001)
    for peak, rates in (
        (report.speed, motion.velocity),
        (report.acceleration, motion.acceleration),
    ):
        fastest = np.linalg.norm(rates, axis=1).max()
        assert fastest <= peak.value * (1.0 + 1e-9) + 1e-12
        assert fastest >= peak.value * (1.0 - 1e-3)
    there = dmp.roll_out(start, goal, duration, np.array([report.speed.time]))
    assert np.linalg.norm(there.velocity) == pytest.approx(report.speed.value, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("dmp", [FITTED, PAPER, *some_dmps(2)])
def test_the_worst_coordinate_is_told(dmp):
    limits = Limits(speed=np.array([1.0, 2.0, 0.7]), acceleration=np.array([8.0, 3.0, 9.0]))
    report = report_limits(dmp, START, GOAL, 0.9, limits)
    motion = dense(dmp, START, GOAL, 0.9)
    for peak, rates, limit in (
        (report.speed, motion.velocity, limits.speed),
        (report.acceleration, motion.acceleration, limits.acceleration),
    ):
        ratios = np.abs(rates).max(axis=0) / limit
        assert peak.coordinate == np.argmax(ratios)
        assert peak.ratio == pytest.approx(ratios.max(), rel=1e-6)
        assert peak.limit == limit[peak.coordinate]
    assert not report.is_feasible


@pytest.mark.parametrize(
    "limits", [Limits(), Limits(1.5, 9.0), Limits(np.array([1.0, 2.0, 0.7]), np.full(3, 8.0))]
)
def test_a_flight_that_never_turned_has_the_peaks_of_its_roll_out(limits):
    exact = report_limits(FITTED, START, GOAL, 0.9, limits)
    found = report_flight(Flight.begin(FITTED, START, GOAL, 0.9, since=3.0), limits)
    for ours, theirs in ((found.speed, exact.speed), (found.acceleration, exact.acceleration)):
        assert ours.value == pytest.approx(theirs.value, rel=1e-7)
        assert ours.time == pytest.approx(3.0 + theirs.time, abs=1e-4)
        assert (ours.limit, ours.coordinate) == (theirs.limit, theirs.coordinate)
    assert found.is_feasible == exact.is_feasible


def test_a_flight_that_turned_is_judged_by_what_is_left_of_it():
    box = np.array([[-1.0, -1.0, -1.0], [0.5, 1.0, 1.0]])
    flight = Flight.begin(FITTED, START, GOAL, 0.9)
    turned = flight.regoal(0.3, AWAY, 0.8)
    times = np.linspace(0.3, 0.8, 100001)
    speed = np.linalg.norm(turned.at(times).velocity, axis=1)
    report = report_flight(turned, Limits(2.0, goal_box=box))
    assert report.speed.value == pytest.approx(speed.max(), rel=1e-8)
    assert report.speed.value >= speed.max() * (1.0 - 1e-12)
    assert not report.goal_is_inside
    with pytest.raises(InputError, match="3 coordinates"):
        report_flight(turned, Limits(np.ones(2)))


def test_a_still_robot_has_peaks_of_zero():
    report = report_limits(Dmp(np.zeros((20, 3))), REST, REST, 1.0, Limits(1.0, 1.0))
    assert report.speed.value == report.acceleration.value == report.ratio == 0.0
    assert report.is_feasible


def test_the_peak_of_a_rest_to_rest_quintic_is_that_of_the_textbook():
    goal = State(np.array([0.0, 0.0, 2.0]), np.zeros(3))
    report = report_limits(Dmp(np.zeros((20, 3))), REST, goal, 0.5, Limits())
    assert report.speed.value == pytest.approx(15 / 8 * 2.0 / 0.5, rel=1e-12)
    assert report.speed.time == pytest.approx(0.25, rel=1e-6)
    assert report.acceleration.value == pytest.approx(10 / np.sqrt(3) * 2.0 / 0.5**2, rel=1e-12)


@pytest.mark.parametrize(
    "limits",
    [
        Limits(speed=2.0),
        Limits(acceleration=9.0),
        Limits(speed=np.array([1.5, 1.0, 1.0]), acceleration=12.0),
        Limits(2.0, np.array([7.0, 6.0, 9.0])),
    ],
)
def test_time_is_given_until_the_limits_are_kept_and_no_longer(limits):
    asked = 0.3
    found = with_limits(FITTED, REST, AWAY, asked, limits)
    assert found.duration > asked
    assert found.report.is_feasible
    assert found.report.ratio == pytest.approx(1.0, abs=1e-6)
    for shorter in np.linspace(asked, found.duration * (1.0 - 1e-6), 40):
        assert not report_limits(FITTED, REST, AWAY, shorter, limits).is_feasible
    motion = dense(FITTED, REST, AWAY, found.duration)
    for rates, limit in (
        (motion.velocity, limits.speed),
        (motion.acceleration, limits.acceleration),
    ):
        if limit is not None:
            largest = (np.linalg.norm(rates, axis=1) if np.ndim(limit) == 0 else np.abs(rates)).max(
                axis=0
            )
            assert (largest <= np.asarray(limit) * (1.0 + 1e-9)).all()
    np.testing.assert_allclose(motion.position[-1], AWAY.position, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "limits", [Limits(speed=1.2), Limits(acceleration=15.0), Limits(1.5, 20.0)]
)
def test_the_goal_is_drawn_nearer_until_the_limits_are_kept_and_no_further(limits):
    dmp = Dmp(0.2 * FITTED.weights)
    asked = State(2.0 * AWAY.position, AWAY.velocity)
    found = with_limits(dmp, REST, asked, 0.9, limits, adjust="goal")
    share = found.goal.position / asked.position
    assert np.ptp(share) < 1e-12
    assert 0.0 < share[0] < 1.0
    np.testing.assert_array_equal(found.goal.velocity, asked.velocity)
    assert found.report.is_feasible
    for further in np.linspace(share[0] + 1e-6, 1.0, 30):
        goal = State(further * asked.position, asked.velocity)
        assert not report_limits(dmp, REST, goal, 0.9, limits).is_feasible


def test_a_goal_outside_the_box_is_drawn_to_its_face():
    box = np.array([[-1.0, -1.0, -1.0], [0.5, 1.0, 1.0]])
    found = with_limits(FITTED, REST, AWAY, 1.0, Limits(goal_box=box), adjust="goal")
    np.testing.assert_allclose(found.goal.position, 0.5 * AWAY.position, atol=1e-12)
    assert found.report.is_feasible
    assert with_limits(FITTED, REST, AWAY, 1.0, Limits(goal_box=box)) is None
    beside = box + np.array([0.0, 5.0, 0.0])
    assert with_limits(FITTED, REST, AWAY, 1.0, Limits(goal_box=beside), adjust="goal") is None


@settings(max_examples=15, deadline=None)
@given(start=states, goal=states, duration=durations, adjust=st.sampled_from(["time", "goal"]))
def test_what_is_adjusted_keeps_the_limits_everywhere(start, goal, duration, adjust):
    limits = Limits(speed=5.0, acceleration=30.0)
    found = with_limits(FITTED, start, goal, duration, limits, adjust=adjust)
    if found is None:
        return
    assert found.duration >= duration
    motion = dense(FITTED, start, found.goal, found.duration, 4001)
    assert np.linalg.norm(motion.velocity, axis=1).max() <= 5.0 * (1.0 + 1e-9)
    assert np.linalg.norm(motion.acceleration, axis=1).max() <= 30.0 * (1.0 + 1e-9)
    np.testing.assert_array_equal(found.goal.velocity, goal.velocity)


def test_however_little_time_is_asked_for_the_fastest_motion_is_the_same():
    found = [
        with_limits(FITTED, REST, AWAY, asked, Limits(2.0, 9.0)).duration for asked in (0.3, 1e-3)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_a_motion_within_its_limits_is_left_as_it_is():
    found = with_limits(FITTED, REST, AWAY, 1.0, Limits(speed=100.0))
    assert (found.goal, found.duration) == (AWAY, 1.0)


@pytest.mark.parametrize("adjust", ["time", "goal"])
def test_what_no_adjustment_can_keep_is_none(adjust):
    assert with_limits(FITTED, REST, AWAY, 1.0, Limits(speed=0.3), adjust=adjust) is None


def test_the_limits_of_a_vehicle_are_those_of_its_commands_in_camera_axes():
    forward, left, up, _ = ARDRONE2.limits
    limits = Limits.of_commands(ARDRONE2.limits, acceleration=9.0)
    np.testing.assert_array_equal(limits.speed, [left, up, forward])
    assert limits.acceleration == 9.0


def test_limits_that_have_no_meaning_are_refused():
    for bad in (0.0, -1.0, np.nan, np.array([1.0, 0.0, 1.0])):
        with pytest.raises(InputError, match="speed limit"):
            Limits(speed=bad)
        with pytest.raises(InputError, match="acceleration limit"):
            Limits(acceleration=bad)
    with pytest.raises(InputError, match="goal_box"):
        Limits(goal_box=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]))
    for limits in (
        Limits(speed=np.ones(2)),
        Limits(acceleration=np.ones(4)),
        Limits(goal_box=np.array([[0.0, 0.0], [1.0, 1.0]])),
    ):
        with pytest.raises(InputError, match="3 coordinates"):
            report_limits(FITTED, REST, AWAY, 1.0, limits)
    with pytest.raises(InputError, match="adjust"):
        unwrap(with_limits)(FITTED, REST, AWAY, 1.0, Limits(1.0), adjust="luck")
    with pytest.raises(InputError, match="duration"):
        with_limits(FITTED, REST, AWAY, 0.0, Limits(1.0))
