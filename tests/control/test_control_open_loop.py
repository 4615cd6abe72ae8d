"""Held commands add up to the motion, in the axes that a drone understands."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rotorpong.control import held_velocity
from rotorpong.conventions import InputError
from rotorpong.drone import HOVER
from rotorpong.primitives import Dmp, State

places = arrays(float, 3, elements=st.floats(-10.0, 10.0))


def flown(command, elapsed):
    """How far a command leads: right, down, forward."""
    return elapsed * np.array([-command.left, -command.up, command.forward])


@given(places, places, st.floats(1e-3, 10.0))
def test_a_held_command_leads_from_the_one_place_to_the_other(begin, end, elapsed):
    command = held_velocity(begin, end, elapsed)
    np.testing.assert_allclose(begin + flown(command, elapsed), end, atol=1e-12)
    assert command.yaw_rate == 0.0


@pytest.mark.parametrize("frames", [1, 7, 30, 200])
def test_held_commands_add_up_to_a_motion_at_any_frame_rate(frames):
    start = State(np.zeros(3), np.array([0.3, 0.0, -0.2]))
    goal = State(np.array([0.4, -0.2, 0.1]), np.array([1.0, 0.0, 0.5]))
    weights = 50.0 * np.random.default_rng(0).normal(size=(20, 3))
    times = np.linspace(0.0, 0.7, frames + 1)
    places = Dmp(weights).roll_out(start, goal, 0.7, times).position
    steps = [
        flown(held_velocity(*places[i : i + 2], 0.7 / frames), 0.7 / frames) for i in range(frames)
    ]
    np.testing.assert_allclose(np.sum(steps, axis=0), places[-1] - places[0], atol=1e-12)


def test_staying_is_hovering():
    here = np.array([1.0, 2.0, 3.0])
    assert held_velocity(here, here, 0.1) == HOVER


def test_twice_the_time_is_half_the_speed():
    quick, slow = (held_velocity(np.zeros(3), np.ones(3), t) for t in (0.5, 1.0))
    assert (quick.forward, quick.left, quick.up) == (2.0, -2.0, -2.0)
    assert (slow.forward, slow.left, slow.up) == (1.0, -1.0, -1.0)


@pytest.mark.parametrize("elapsed", [0.0, -0.1, float("nan"), float("inf")])
def test_no_time_to_fly_in_is_refused(elapsed):
    with pytest.raises(InputError, match="expected a positive number"):
        held_velocity(np.zeros(3), np.ones(3), elapsed)
