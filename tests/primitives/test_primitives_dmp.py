"""Eqs. (3)-(5): the closed form against the differential equation and what must be true of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from rotorpong.conventions import InputError
from rotorpong.primitives import Dmp, State, fit_dmp, integrate_dmp
from rotorpong.primitives.basis import (
    DAMPING,
    STIFFNESS,
    forcing_features,
    phase,
    response_table,
    responses,
)
from rotorpong.primitives.quintic import (
    quintic_coefficients,
    quintic_curvature,
    quintic_slope,
    quintic_value,
)

DEMONSTRATION_TIMES = np.linspace(0.0, 1.0, 80)
START = State(np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.0, -0.4]))
GOAL = State(np.array([0.4, 0.3, -0.1]), np.array([-0.3, 1.0, 0.6]))


def swing(x):
    """A back-swing, then a stroke that ends in motion."""
    forward = 0.3 * x**3 - 0.15 * np.sin(np.pi * x) ** 2 * (1 - x)
    left = 0.1 * x**2 - 0.05 * np.sin(2 * np.pi * x) ** 2
    up = 0.3 * x**4 + 0.7 * x**5 - 0.2 * x**3
    return np.stack([forward, left, up], axis=-1)


@pytest.fixture(scope="module")
def dmp():
    return fit_dmp(DEMONSTRATION_TIMES, swing(DEMONSTRATION_TIMES))


def random_dmp(basis=20, scale=300.0):
    return Dmp(scale * np.random.default_rng(3).normal(size=(basis, 3)))


@pytest.mark.parametrize("duration", [0.6, 1.0, 1.7])
@pytest.mark.parametrize("forcing_gain", [1.3, 1.0, 0.5])
def test_the_closed_form_solves_equation_4(dmp, duration, forcing_gain):
    primitive = Dmp(dmp.weights, forcing_gain)
    times = np.random.default_rng(0).uniform(0.0, duration, 40)
    push = np.array([1.0, -2.0, 0.5])
    ours = primitive.roll_out(START, GOAL, duration, times, start_acceleration=push)
    reference = integrate_dmp(primitive, START, GOAL, duration, times, start_acceleration=push)
    np.testing.assert_allclose(ours.position, reference.position, rtol=0, atol=1e-7)
    np.testing.assert_allclose(ours.velocity, reference.velocity, rtol=0, atol=1e-6)


def test_any_weights_solve_equation_4():
    times = np.linspace(0.0, 0.8, 33)
    ours = random_dmp().roll_out(START, GOAL, 0.8, times)
    reference = integrate_dmp(random_dmp(), START, GOAL, 0.8, times)
    np.testing.assert_allclose(ours.position, reference.position, rtol=0, atol=1e-7)
    np.testing.assert_allclose(ours.velocity, reference.velocity, rtol=0, atol=1e-6)


@settings(max_examples=50, deadline=None)
@given(
    duration=st.floats(0.2, 5.0),
    numbers=st.lists(st.floats(-3.0, 3.0), min_size=12, max_size=12),
)
def test_a_fitted_primitive_meets_any_goal_in_any_time_exactly(dmp, duration, numbers):
    s0, v0, s1, v1 = np.array(numbers).reshape(4, 3)
    motion = dmp.roll_out(State(s0, v0), State(s1, v1), duration, np.array([0.0, duration]))
    np.testing.assert_allclose(motion.position, [s0, s1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.velocity, [v0, v1], rtol=0, atol=1e-9)


def test_without_weights_the_motion_is_the_quintic_of_the_boundary_states():
    duration = 0.7
    times = np.linspace(0.0, duration, 11)
    motion = Dmp(np.zeros((20, 3))).roll_out(START, GOAL, duration, times)
    powers = np.arange(6)
    conditions = np.zeros((6, 6))
    for row, (time, order) in enumerate([(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]):
        basis = np.polynomial.Polynomial.basis
        conditions[row] = [basis(k).deriv(order)(time * duration) for k in powers]
    zero = np.zeros(3)
    known = [START.position, START.velocity, zero, GOAL.position, GOAL.velocity, zero]
    b = np.linalg.solve(conditions, known)
    np.testing.assert_allclose(motion.position, times[:, None] ** powers @ b, atol=1e-12)
    slopes = powers[1:] * times[:, None] ** powers[:-1]
    np.testing.assert_allclose(motion.velocity, slopes @ b[1:], atol=1e-11)


def test_the_start_acceleration_is_that_of_the_moving_target():
    push = np.array([2.0, -1.0, 0.5])
    step = 1e-4
    still = Dmp(np.zeros((20, 3)))
    motion = still.roll_out(
        START, GOAL, 0.6, np.array([0.0, step, 0.6 - step, 0.6]), start_acceleration=push
    )
    first, second, before, last = motion.velocity
    np.testing.assert_allclose((second - first) / step, push, atol=1e-2)
    np.testing.assert_allclose((last - before) / step, 0.0, atol=1e-2)


def test_velocity_is_the_derivative_of_position(dmp):
    times = np.linspace(0.05, 0.75, 50)
    step = 1e-6
    after = dmp.roll_out(START, GOAL, 0.8, times + step).position
    before = dmp.roll_out(START, GOAL, 0.8, times - step).position
    velocity = dmp.roll_out(START, GOAL, 0.8, times).velocity
    np.testing.assert_allclose((after - before) / (2 * step), velocity, atol=1e-6)


def test_changing_the_duration_keeps_the_shape_between_states_at_rest(dmp):
    rest = np.zeros(3)
    start, goal = State(START.position, rest), State(GOAL.position, rest)
    x = np.linspace(0.0, 1.0, 20)
    slow, fast = dmp.roll_out(start, goal, 2.0, 2.0 * x), dmp.roll_out(start, goal, 0.5, 0.5 * x)
    np.testing.assert_allclose(slow.position, fast.position, atol=1e-12)
    np.testing.assert_allclose(4 * slow.velocity, fast.velocity, atol=1e-11)


def test_many_times_give_what_each_gives_alone(dmp):
    times = np.array([0.7, 0.0, 0.31, 0.31, 0.9])
    together = dmp.roll_out(START, GOAL, 0.9, times)
    for i, time in enumerate(times):
        alone = dmp.roll_out(START, GOAL, 0.9, np.array([time]))
        np.testing.assert_array_equal(together.position[i], alone.position[0])
        np.testing.assert_array_equal(together.velocity[i], alone.velocity[0])
    np.testing.assert_allclose(
        together.position, integrate_dmp(dmp, START, GOAL, 0.9, times).position, atol=1e-7
    )


def test_no_times_give_an_empty_motion(dmp):
    for motion in (
        dmp.roll_out(START, GOAL, 0.9, np.empty(0)),
        integrate_dmp(dmp, START, GOAL, 0.9, np.empty(0)),
    ):
        assert motion.position.shape == motion.velocity.shape == (0, 3)


def test_a_time_a_rounding_error_beyond_the_end_is_the_end(dmp):
    duration = 0.7
    motion = dmp.roll_out(START, GOAL, duration, np.array([-1e-10, duration + 1e-10]))
    np.testing.assert_allclose(motion.position, [START.position, GOAL.position], atol=1e-12)


@pytest.mark.parametrize("basis", [4, 20, 60])
def test_the_responses_are_the_integrals_they_claim_to_be(basis):
    a = STIFFNESS / 2
    for x in (0.137, 0.71, 1.0):
        position, slope = (table[-1] for table in responses(np.linspace(0.0, x, 400), basis))
        for k in (0, basis // 2, basis - 1):

            def force(y, k=k):
                return forcing_features(phase(np.array([y])), basis)[0, k]

            def answer(y, x=x, force=force):
                return (x - y) * np.exp(-a * (x - y)) * force(y)

            def answer_slope(y, x=x, force=force):
                return (1 - a * (x - y)) * np.exp(-a * (x - y)) * force(y)

            centre = k / (basis - 1)
            hints = {"points": [centre], "epsabs": 1e-13, "limit": 200} if centre < x else {}
            assert position[k] == pytest.approx(quad(answer, 0, x, **hints)[0], abs=1e-10)
            assert slope[k] == pytest.approx(quad(answer_slope, 0, x, **hints)[0], abs=1e-10)


@pytest.mark.parametrize("basis", [4, 10, 20, 60])
def test_the_table_interpolates_the_responses_to_1e_10(basis):
    x = np.concatenate([[0.0], np.sort(np.random.default_rng(0).uniform(size=2000)), [1.0]])
    table = response_table(basis)
    pieces = table.shape[1]
    piece = np.minimum((x * pieces).astype(int), pieces - 1)
    local = (x * pieces - piece)[:, None]
    position, slope = responses(x, basis)
    np.testing.assert_allclose(quintic_value(table[:, piece], local), position, atol=1e-10)
    np.testing.assert_allclose(
        pieces * quintic_slope(table[:, piece], local), slope, rtol=0, atol=1e-10
    )


def test_damping_is_critical():
    roots = np.roots([1.0, STIFFNESS, STIFFNESS * DAMPING])
    np.testing.assert_allclose(roots, -STIFFNESS / 2)


def test_a_quintic_has_the_states_it_was_made_from():
    start, end = np.random.default_rng(0).normal(size=(2, 3, 4))
    coefficients = quintic_coefficients(start, end)
    for x, state in ((np.array(0.0), start), (np.array(1.0), end)):
        found = [f(coefficients, x) for f in (quintic_value, quintic_slope, quintic_curvature)]
        np.testing.assert_allclose(found, state, atol=1e-12)


@pytest.mark.parametrize("solve", [Dmp.roll_out, integrate_dmp])
def test_a_motion_that_cannot_be_is_refused(dmp, solve):
    times = np.linspace(0.0, 0.5, 5)
    flat = State(np.zeros(2), np.zeros(2))
    lost = State(np.array([0.0, np.nan, 0.0]), np.zeros(3))
    with pytest.raises(InputError, match=r"time 0\.5 s: expected 0 to 0\.4 s"):
        solve(dmp, START, GOAL, 0.4, times)
    with pytest.raises(InputError, match=r"time -0\.1"):
        solve(dmp, START, GOAL, 0.4, times - 0.1)
    with pytest.raises(InputError, match="time nan"):
        solve(dmp, START, GOAL, 0.5, times * np.nan)
    for duration in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match="duration"):
            solve(dmp, START, GOAL, duration, times)
    for start, goal in ((flat, GOAL), (START, flat), (START, lost), (lost, GOAL)):
        with pytest.raises(InputError, match="expected"):
            solve(dmp, start, goal, 0.5, times)
    with pytest.raises(InputError, match="expected 3 numbers"):
        solve(dmp, START, GOAL, 0.5, times, start_acceleration=np.zeros(2))
