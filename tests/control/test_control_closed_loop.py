"""The closed loop brings a drone back to its course, delays and limits or not."""

from dataclasses import replace

import numpy as np
import pytest
from lagging_drone import INTERVAL, LaggingDrone, flown, quintic_course

from rotorpong.control import Follower, follower
from rotorpong.control.closed_loop import PACE, ClosedLoop, gains
from rotorpong.control.feed_forward import FeedForward
from rotorpong.control.observer import Observer, turn
from rotorpong.control.plant import UNKNOWN_PLANT, Axis
from rotorpong.drone import HOVER

GOAL = (0.3, -0.1, 0.2)
AXES = (Axis(0.4, dead_time=0.066), Axis(0.43, 0.056, dead_time=0.1), Axis(0.35, gain=1.1))
PLANT = replace(UNKNOWN_PLANT, axes=AXES, velocity_white=1e-3)


@pytest.mark.parametrize("axis", [*AXES, Axis(1.86, 0.24, 3.6)])
def test_slow_poles_go_where_they_are_wanted_and_fast_ones_stay(axis):
    phi, gamma = axis.transition(INTERVAL)
    found = np.linalg.eigvals(phi - np.outer(gamma, gains(axis, INTERVAL)))
    own, most = np.linalg.eigvals(phi), np.exp(-PACE * INTERVAL)
    wanted = np.where(np.abs(own) < most, own, most)
    np.testing.assert_allclose(np.poly(found), np.poly(wanted), atol=1e-9)


def test_a_drone_off_its_course_comes_back_at_the_pace_that_was_asked():
    drone, control = (
        LaggingDrone((Axis(0.4),) * 3),
        ClosedLoop(replace(PLANT, axes=(Axis(0.4),) * 3)),
    )
    course = quintic_course(0.33, 1.32, (0.05, 0.0, 0.0), start=(0.05, 0.0, 0.0))
    error = flown(control, drone, course, hover=10)
    t = np.arange(len(error)) * 1e-3
    left = -0.05 * (1.0 + PACE * t) * np.exp(-PACE * t)
    assert np.abs(error[:, 0] - left).max() < 0.004
    assert np.abs(error[:, 1:]).max() < 1e-3


@pytest.mark.parametrize("offset", [0.05, -0.1])
def test_an_offset_of_the_commands_is_seen_and_taken_off(offset):
    course = quintic_course(0.33, 0.99, GOAL)
    plant = replace(PLANT, command_offset=0.1)
    looking, blind = (
        flown(control, LaggingDrone(AXES, offset=offset), course, hover=10)
        for control in (ClosedLoop(plant), FeedForward(plant))
    )
    blind -= blind[0]
    assert np.abs(looking[-1]).max() < 0.3 * np.abs(blind[-1]).max()


def test_without_noise_delays_are_made_up_for():
    course = quintic_course(0.33 + 0.1, 0.99, GOAL)
    error = flown(ClosedLoop(PLANT), LaggingDrone(AXES), course, hover=10)
    assert np.abs(error).max() < 0.006


def test_the_state_ahead_is_what_the_drone_does_with_the_commands_on_their_way():
    drone, observer = LaggingDrone(AXES), Observer(PLANT)
    rng = np.random.default_rng(0)
    for _ in range(20):
        velocity = rng.normal(size=3)
        observer.sent(drone.time, velocity)
        command = follower("open").command(
            quintic_course(drone.time, INTERVAL, velocity * INTERVAL), drone.time, INTERVAL
        )
        _, navdata = drone.command(command)
        observer.sense(navdata, AXES)
    now = drone.time
    ahead = observer.at(now + np.array([axis.dead_time for axis in AXES]), AXES)
    for _ in range(4):
        drone.command(command)
    for i, (axis, belief) in enumerate(zip(AXES, ahead, strict=True)):
        tick = round((now + axis.dead_time) * 1000)
        assert belief.mean[0] == pytest.approx(drone.path[tick][i], abs=2e-3)
        assert belief.mean[1] == pytest.approx(drone.speeds[tick][i], abs=1e-2)


def test_noise_is_weighed_and_certainty_never_negative():
    drone, observer = LaggingDrone(AXES, noise=np.random.default_rng(1)), Observer(UNKNOWN_PLANT)
    for _ in range(30):
        observer.sent(drone.time, np.zeros(3))
        observer.sense(drone.command(HOVER)[1], AXES)
    for belief in observer.at(np.full(3, drone.time), AXES):
        assert (np.linalg.eigvalsh(belief.covariance) > -1e-15).all()
        assert abs(belief.mean[1]) < 3.0 * np.sqrt(belief.covariance[1, 1])
        assert abs(belief.mean[0]) < 3.0 * np.sqrt(belief.covariance[0, 0])


def test_limits_are_kept_and_nothing_winds_up():
    most = 0.5
    plant = replace(PLANT, limits=np.full(3, most), axes=(Axis(0.4),) * 3)
    drone = LaggingDrone(plant.axes, limits=most)
    course = quintic_course(0.33, 2.64, (0.4, 0.0, 0.0), start=(0.4, 0.0, 0.0))
    error = flown(ClosedLoop(plant), drone, course, hover=10)
    assert abs(error[-1, 0]) < 0.01
    assert error[:, 0].max() < 0.06


def test_a_drone_that_turned_flies_the_course_of_the_axes_that_it_departed_in():
    axes = (Axis(0.4),) * 3
    plant = replace(PLANT, axes=axes)
    drone, control = LaggingDrone(axes, heading=1.0), ClosedLoop(plant)
    course = quintic_course(0.33, 0.99, GOAL)
    assert np.abs(flown(control, drone, course, hover=10)).max() < 0.006
    np.testing.assert_allclose(turn(0.5) @ turn(-0.5), np.eye(3), atol=1e-15)
    forward = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(turn(np.pi / 2) @ forward, [-1.0, 0.0, 0.0], atol=1e-15)


def test_it_departs_where_it_will_be_and_before_any_navdata_from_a_hover():
    control = ClosedLoop(PLANT)
    assert control.depart(1.0).time == pytest.approx(1.1)
    drone = LaggingDrone(AXES)
    for _ in range(10):
        now = drone.time
        sent, navdata = drone.command(
            follower("open").command(
                quintic_course(now, INTERVAL, (0.0, 0.0, 0.3 * INTERVAL)), now, INTERVAL
            )
        )
        control.sent(now, sent)
        control.sense(navdata)
    departure, here = control.depart(drone.time), drone.path[-1]
    for _ in range(4):
        drone.command(sent)
    then = drone.path[round(departure.time * 1000)]
    np.testing.assert_allclose(departure.position, then - here, atol=2e-3)


@pytest.mark.parametrize("control", ["open", "feed_forward", "closed_loop"])
def test_every_control_is_a_follower_and_hovers_when_the_motion_is_over(control):
    one = follower(control)
    assert isinstance(one, Follower)
    assert one.command(quintic_course(0.0, 0.5, GOAL), 0.6, INTERVAL) == HOVER
