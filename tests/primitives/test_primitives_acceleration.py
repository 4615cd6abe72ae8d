"""Accelerations of roll-outs, given and found, and the gain of each coordinate."""

from inspect import unwrap

import numpy as np
import pytest
from hypothesis import given, settings
from primitive_samples import FITTED, GOAL, PAPER, REST, START, durations, states, vectors

from rotorpong.conventions import InputError
from rotorpong.primitives import Dmp, Library, State, integrate_dmp, mix
from rotorpong.primitives.scaling import scaled_to

TIMES = np.linspace(0.0, 0.8, 40)


@pytest.mark.parametrize("dmp", [FITTED, PAPER])
def test_accelerations_are_those_of_equation_4(dmp):
    ours = dmp.roll_out(START, GOAL, 0.8, TIMES)
    reference = integrate_dmp(dmp, START, GOAL, 0.8, TIMES)
    np.testing.assert_allclose(ours.acceleration, reference.acceleration, rtol=0, atol=2e-5)


def test_acceleration_is_the_derivative_of_velocity():
    times, step = np.linspace(0.05, 0.75, 50), 1e-6
    after, before = (FITTED.roll_out(START, GOAL, 0.8, times + h) for h in (step, -step))
    ours = FITTED.roll_out(START, GOAL, 0.8, times).acceleration
    np.testing.assert_allclose((after.velocity - before.velocity) / (2 * step), ours, atol=1e-4)


@settings(max_examples=50, deadline=None)
@given(start=states, goal=states, first=vectors, last=vectors, duration=durations)
def test_a_state_with_an_acceleration_is_left_or_met_with_it(start, goal, first, last, duration):
    leave = State(start.position, start.velocity, first)
    meet = State(goal.position, goal.velocity, last)
    motion = FITTED.roll_out(leave, meet, duration, np.array([0.0, duration]))
    scale = 1.0 + 100.0 / duration**2
    np.testing.assert_allclose(motion.acceleration, [first, last], rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(motion.position[1], goal.position, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.velocity, [start.velocity, goal.velocity], atol=1e-9)


def test_a_motion_with_given_accelerations_solves_equation_4():
    start = State(START.position, START.velocity, np.array([1.0, -2.0, 3.0]))
    goal = State(GOAL.position, GOAL.velocity, np.zeros(3))
    ours = FITTED.roll_out(start, goal, 0.8, TIMES)
    reference = integrate_dmp(FITTED, start, goal, 0.8, TIMES)
    np.testing.assert_allclose(ours.position, reference.position, rtol=0, atol=1e-7)
    np.testing.assert_allclose(ours.velocity, reference.velocity, rtol=0, atol=1e-6)


def test_an_acceleration_given_twice_or_wrongly_is_refused():
    fast = State(START.position, START.velocity, np.ones(3))
    with pytest.raises(InputError, match="start_acceleration"):
        FITTED.roll_out(fast, GOAL, 0.8, TIMES, start_acceleration=np.ones(3))
    wild = State(np.zeros(3), np.zeros(3), np.array([0.0, np.inf, 0.0]))
    for start, goal in ((wild, GOAL), (START, wild)):
        with pytest.raises(InputError, match="expected finite"):
            FITTED.roll_out(start, goal, 0.8, TIMES)


def test_a_gain_for_each_coordinate_is_that_gain_in_each_alone():
    gains = np.array([0.5, -1.0, 2.0])
    together = Dmp(FITTED.weights, gains)
    moved, solved = (
        solve(together, START, GOAL, 0.8, TIMES).position for solve in (Dmp.roll_out, integrate_dmp)
    )
    np.testing.assert_allclose(moved, solved, rtol=0, atol=1e-7)
    for i, gain in enumerate(gains):
        alone = Dmp(FITTED.weights, float(gain)).roll_out(START, GOAL, 0.8, TIMES).position
        np.testing.assert_allclose(moved[:, i], alone[:, i], rtol=0, atol=1e-14)


@pytest.mark.parametrize("by", ["displacement", "velocity"])
def test_twice_the_demonstrations_amplitude_is_twice_its_motion(by):
    ends = FITTED.ends
    goal = State(2 * (ends.position[1] - ends.position[0]), 2 * ends.velocity[1])
    start = State(np.zeros(3), 2 * ends.velocity[0])
    times = np.linspace(0.0, 1.0, 30)
    shown = FITTED.roll_out(
        State(ends.position[0], ends.velocity[0]),
        State(ends.position[1], ends.velocity[1]),
        1.0,
        times,
    )
    double = scaled_to(FITTED, start, goal, by=by).roll_out(start, goal, 1.0, times)
    np.testing.assert_allclose(double.position, 2 * (shown.position - ends.position[0]), atol=1e-9)


def test_goal_equal_to_start_is_met_scaled_or_not():
    for dmp in (FITTED, scaled_to(FITTED, REST, REST)):
        motion = dmp.roll_out(REST, REST, 0.7, np.array([0.0, 0.35, 0.7]))
        np.testing.assert_allclose(motion.position[[0, -1]], 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.position, 0.0, rtol=0, atol=1e-12)  # scaled by zero


def test_a_coordinate_that_did_not_move_keeps_its_gain():
    from rotorpong.primitives import fit_dmp

    t = np.linspace(0.0, 1.0, 50)
    flat = fit_dmp(t, np.stack([t**3, 0.1 * np.sin(np.pi * t) ** 2], axis=1))
    goal = State(np.array([2.0, 1.0]), np.zeros(2))
    gain = scaled_to(flat, State(np.zeros(2), np.zeros(2)), goal).forcing_gain
    assert gain[0] == pytest.approx(2.0, abs=1e-3)
    assert gain[1] == 1.0


def test_scaling_without_a_demonstration_or_by_the_unknown_is_refused():
    with pytest.raises(InputError, match="without the ends"):
        scaled_to(Dmp(FITTED.weights), START, GOAL)
    with pytest.raises(InputError, match="expected displacement or velocity"):
        unwrap(scaled_to)(FITTED, START, GOAL, by="magic")
    with pytest.raises(InputError, match="expected 3 numbers"):
        scaled_to(FITTED, State(np.zeros(2), np.zeros(2)), GOAL)


def test_gains_of_coordinates_are_mixed_saved_and_read(tmp_path):
    gains = np.array([0.5, 1.0, 2.0])
    library = Library((Dmp(FITTED.weights, gains), Dmp(FITTED.weights)))
    blend = mix(library.primitives, np.array([1.0, 3.0]))
    np.testing.assert_allclose(blend.weights, (gains / 4 + 0.75) * FITTED.weights, rtol=1e-14)
    library.save(tmp_path / "library.json")
    read = Library.load(tmp_path / "library.json")
    np.testing.assert_array_equal(read.primitives[0].forcing_gain, gains)
    assert read.primitives[1].forcing_gain == 1.0
    text = (tmp_path / "library.json").read_text().replace("[0.5, 1.0, 2.0]", "[0.5, 1.0]")
    (tmp_path / "library.json").write_text(text)
    with pytest.raises(InputError, match="2 gains for 3 coordinates"):
        Library.load(tmp_path / "library.json")
