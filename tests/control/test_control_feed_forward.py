"""Feed-forward is exact where the drone is what it is taken for."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lagging_drone import INTERVAL, TICK, LaggingDrone, flown, quintic_course

from rotorpong.control import Course
from rotorpong.control.feed_forward import FeedForward, command_of, feed_forward, velocity_of
from rotorpong.control.open_loop import OpenLoop
from rotorpong.control.plant import UNKNOWN_PLANT, Axis
from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, VelocityCommand

GOAL = (0.3, -0.1, 0.2)
LAGS = (Axis(0.4), Axis(0.3, gain=1.2), Axis(0.5))


def sure_of(axes, **more):
    """A plant of these axes, whose navdata teach next to nothing."""
    return replace(UNKNOWN_PLANT, axes=axes, velocity_white=1e6, **more)


@settings(deadline=None, max_examples=15)
@given(st.floats(0.1, 1.5), st.integers(12, 60))
def test_a_first_order_lag_is_where_it_is_meant_to_be_at_every_command(lag, milliseconds):
    axes, interval, drone = (Axis(lag),) * 3, milliseconds * TICK, LaggingDrone((Axis(lag),) * 3)
    course = quintic_course(0.0, 20 * interval, GOAL)
    worst = 0.0
    for _ in range(20):
        drone.command(command_of(feed_forward(course, axes, drone.time, interval).wanted), interval)
        p, v, _ = course.at(np.array([drone.time]))[:, 0]
        reach = np.array([x[0] + lag * x[1] for x in drone.states])
        np.testing.assert_allclose(reach, p + lag * v, atol=1e-9)
        worst = max(worst, float(np.abs(drone.path[-1] - p).max()))
    t = np.linspace(0.0, course.duration, 2001)
    _, v, a = course.at(t)
    jerk = np.abs(np.gradient(a, t, axis=0))
    assert worst <= interval**2 / 8.0 * (np.abs(a).max() + lag * jerk.max()) * 1.01


def test_open_loop_is_late_by_its_lag_and_feed_forward_is_not():
    course = quintic_course(0.099, 0.792, GOAL)
    late = flown(OpenLoop(), LaggingDrone(LAGS), course, hover=3)
    sharp = flown(FeedForward(sure_of(LAGS)), LaggingDrone(LAGS), course, hover=3)
    assert np.abs(late).max() > 0.05
    assert np.abs(sharp).max() < 0.002


@pytest.mark.parametrize("dead_time", [0.033, 0.1, 0.132])
def test_a_known_dead_time_changes_nothing_but_when_the_command_is_sent(dead_time):
    slow = tuple(replace(axis, dead_time=dead_time) for axis in LAGS)
    course = quintic_course(0.099 + dead_time, 0.792, GOAL)
    plain = replace(course, begin=0.099)
    prompt = flown(FeedForward(sure_of(LAGS)), LaggingDrone(LAGS), plain, hover=3)
    delayed = flown(FeedForward(sure_of(slow)), LaggingDrone(slow), course, hover=3)
    np.testing.assert_allclose(delayed, prompt, atol=1e-9)


def test_acceleration_that_takes_time_to_build_up_is_asked_for_ahead():
    axes = (Axis(0.43, 0.056),) * 3
    course = quintic_course(0.099, 0.99, GOAL)
    error = flown(FeedForward(sure_of(axes)), LaggingDrone(axes), course, hover=3)
    ignored = tuple(replace(axis, bend=0.0) for axis in axes)
    other = flown(FeedForward(sure_of(ignored)), LaggingDrone(axes), course, hover=3)
    assert np.abs(error).max() < 0.004 < 0.01 < np.abs(other).max()


def test_a_command_beyond_the_limits_says_so_and_keeps_to_them():
    course, most = quintic_course(0.0, 0.5, GOAL), np.array([0.5, 2.0, 9.0])
    demand = feed_forward(course, LAGS, 0.2, INTERVAL, most)
    assert demand.is_cut
    assert (np.abs(demand.velocity) <= most).all()
    assert demand.velocity[2] == demand.wanted[2]
    assert not feed_forward(course, LAGS, 0.2, INTERVAL, np.full(3, 9.0)).is_cut
    assert not feed_forward(course, LAGS, 0.2, INTERVAL).is_cut


def test_what_a_cut_command_owed_is_made_up_for():
    most = 0.6
    course = quintic_course(0.099, 0.99, (0.3, 0.0, 0.0))
    drone, control = LaggingDrone(LAGS, most), FeedForward(sure_of(LAGS, limits=np.full(3, most)))
    error = flown(control, drone, course, hover=3)
    wanted = [
        feed_forward(course, LAGS, t, INTERVAL).wanted[0] for t in np.arange(0.099, 1.08, INTERVAL)
    ]
    assert max(wanted) > 1.1 * most
    assert np.abs(error[:, 0]).max() > 0.01
    place, speed = drone.states[0]
    assert place + LAGS[0].lag * speed == pytest.approx(0.3, abs=1e-6)


def test_over_the_end_it_hovers_and_before_it_departs_after_the_dead_time():
    control = FeedForward(sure_of((Axis(0.4, dead_time=0.1),) * 3))
    assert control.command(quintic_course(0.0, 0.5, GOAL), 0.5, INTERVAL) == HOVER
    departure = control.depart(2.0)
    assert departure.time == 2.1
    assert not departure.position.any()


def test_a_velocity_is_the_same_as_a_command():
    command = VelocityCommand(0.3, -0.2, 0.1)
    assert command_of(velocity_of(command)) == command


def test_a_course_goes_on_over_its_ends_as_it_ended():
    course = quintic_course(1.0, 0.5, GOAL)
    np.testing.assert_allclose(course.at(np.array([0.0, 9.0]))[0], [(0.0, 0.0, 0.0), GOAL])
    flying = Course(
        0.0, 1.0, lambda t: (np.outer(t, GOAL), np.tile(GOAL, (len(t), 1)), 0.0 * np.outer(t, GOAL))
    )
    np.testing.assert_allclose(flying.at(np.array([-1.0, 3.0]))[0], np.outer([-1.0, 3.0], GOAL))


@pytest.mark.parametrize("interval", [0.0, -1.0, np.nan, np.inf])
def test_an_interval_that_is_none_is_refused(interval):
    with pytest.raises(InputError, match=r"interval .* s: expected a positive number"):
        feed_forward(quintic_course(0.0, 0.5, GOAL), LAGS, 0.0, interval)


@pytest.mark.parametrize(("begin", "duration"), [(np.nan, 1.0), (0.0, 0.0), (0.0, np.inf)])
def test_a_course_without_duration_is_refused(begin, duration):
    with pytest.raises(InputError, match="expected a finite beginning and a positive duration"):
        quintic_course(begin, duration, GOAL)
