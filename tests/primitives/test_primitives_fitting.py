"""A demonstration and the primitive it becomes."""

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression
from test_primitives_dmp import DEMONSTRATION_TIMES, swing

from rotorpong.conventions import InputError
from rotorpong.primitives import State, fit_dmp
from rotorpong.primitives.basis import activations, forcing_features, phase

FINE = np.linspace(0.0, 1.0, 1001)
STEP = 1e-6
SPEED = (swing(DEMONSTRATION_TIMES + STEP) - swing(DEMONSTRATION_TIMES - STEP)) / (2 * STEP)


def reproduce(dmp, duration=1.0):
    ends = dmp.ends
    start, goal = (State(ends.position[i], ends.velocity[i]) for i in (0, 1))
    return dmp.roll_out(start, goal, duration, FINE * duration)


def rms(error):
    return np.sqrt(np.mean(error**2))


def noisy(metres):
    shape = (len(DEMONSTRATION_TIMES), 3)
    return swing(DEMONSTRATION_TIMES) + metres * np.random.default_rng(1).normal(size=shape)


def test_a_clean_demonstration_is_reproduced_to_a_twentieth_of_a_millimetre():
    dmp = fit_dmp(DEMONSTRATION_TIMES, swing(DEMONSTRATION_TIMES))
    assert rms(reproduce(dmp).position - swing(FINE)) < 5e-5


def test_a_demonstration_with_2_mm_of_noise_is_reproduced_to_better_than_that():
    assert rms(reproduce(fit_dmp(DEMONSTRATION_TIMES, noisy(0.002))).position - swing(FINE)) < 2e-3


def test_the_paper_s_regression_reproduces_a_clean_demonstration_within_a_centimetre():
    dmp = fit_dmp(DEMONSTRATION_TIMES, swing(DEMONSTRATION_TIMES), method="lwr")
    assert rms(reproduce(dmp).position - swing(FINE)) < 1e-2


def test_the_paper_s_regression_weighs_the_forcing_for_each_basis_by_itself():
    known = fit_dmp(DEMONSTRATION_TIMES, noisy(0.002), basis=12)  # ends exactly at its goal
    rest = State(np.zeros(3), np.zeros(3))
    motion = known.roll_out(rest, rest, 1.0, FINE)
    ours = fit_dmp(FINE, motion.position, basis=12, method="lwr", velocities=motion.velocity)
    z = phase(FINE)
    forcing = forcing_features(z, 12) @ known.weights
    for k, bell in enumerate(activations(z, 12).T):
        alone = LinearRegression(fit_intercept=False)
        alone.fit(z[:, None], forcing, sample_weight=bell)
        scale = abs(known.weights).max()
        np.testing.assert_allclose(ours.weights[k], alone.coef_[:, 0], rtol=0, atol=1e-3 * scale)


@pytest.mark.parametrize("metres", [0.0, 0.002])
def test_the_end_point_is_exact_whatever_the_noise(metres):
    dmp = fit_dmp(DEMONSTRATION_TIMES, noisy(metres))
    goal = State(np.array([0.4, 0.3, -0.1]), np.array([-0.3, 1.0, 0.6]))
    motion = dmp.roll_out(State(np.zeros(3), np.zeros(3)), goal, 0.6, np.array([0.6]))
    np.testing.assert_allclose(motion.position[0], goal.position, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.velocity[0], goal.velocity, rtol=0, atol=1e-9)


def test_measured_velocities_are_those_of_both_ends():
    dmp = fit_dmp(DEMONSTRATION_TIMES, noisy(0.002), velocities=SPEED)
    np.testing.assert_allclose(dmp.ends.velocity, SPEED[[0, -1]], atol=1e-12)
    assert rms(reproduce(dmp).position - swing(FINE)) < 2e-3


def test_a_roll_out_is_fitted_back_to_the_same_motion():
    first = fit_dmp(DEMONSTRATION_TIMES, swing(DEMONSTRATION_TIMES))
    motion = reproduce(first)
    second = fit_dmp(FINE, motion.position)
    np.testing.assert_allclose(reproduce(second).position, motion.position, rtol=0, atol=1e-6)


def test_the_origin_of_time_and_place_and_the_duration_do_not_matter():
    plain = fit_dmp(DEMONSTRATION_TIMES, noisy(0.002))
    moved = fit_dmp(7.0 + 0.5 * DEMONSTRATION_TIMES, 3.0 + noisy(0.002))
    np.testing.assert_allclose(moved.weights, plain.weights, atol=1e-5 * abs(plain.weights).max())
    assert moved.ends.times[1] == pytest.approx(0.5)


def test_each_coordinate_is_fitted_by_itself():
    together = fit_dmp(DEMONSTRATION_TIMES, noisy(0.002))
    for i in range(3):
        alone = fit_dmp(DEMONSTRATION_TIMES, noisy(0.002)[:, [i]])
        np.testing.assert_allclose(alone.weights[:, 0], together.weights[:, i], rtol=1e-6)


def test_a_still_robot_gives_no_weights():
    dmp = fit_dmp(DEMONSTRATION_TIMES, np.ones((80, 3)))
    np.testing.assert_allclose(dmp.weights, 0.0, atol=1e-6)


def test_cross_validation_chooses_the_ridge_that_the_hat_matrix_gives():
    from rotorpong.primitives.fitting import RIDGES, SMALLEST_FREEDOM, _ridge

    rng = np.random.default_rng(0)
    plain, penalised, y = rng.normal(size=(30, 2)), rng.normal(size=(30, 12)), rng.normal(size=30)
    ours = _ridge(plain, penalised, y[:, None])[:, 0]
    scale = np.linalg.svd(penalised - plain @ np.linalg.lstsq(plain, penalised)[0])[1][0] ** 2
    design, penalty = np.hstack([plain, penalised]), np.diag([0.0] * 2 + [1.0] * 12)
    best = (np.inf, None)
    for ridge in RIDGES * scale:
        inverse = np.linalg.pinv(design.T @ design + ridge * penalty) @ design.T
        freedom = 30 - np.trace(design @ inverse)
        score = np.sum((y - design @ inverse @ y) ** 2) / freedom**2
        if freedom > SMALLEST_FREEDOM and score < best[0]:
            best = (score, (inverse @ y)[2:])
    np.testing.assert_allclose(ours, best[1], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("method", ["position", "lwr"])
def test_a_demonstration_that_cannot_be_used_is_refused(method):
    t, y = DEMONSTRATION_TIMES, swing(DEMONSTRATION_TIMES)
    holed = y.copy()
    holed[3, 1] = np.nan
    cases = [
        (t[::-1], y, "increasing"),
        (np.zeros(80), y, "increasing"),
        (np.append(t[:-1], t[-2]), y, "increasing"),
        (t[:1], y[:1], "at least 5"),
        (t[:4], y[:4], "at least 5"),
        ([], np.empty((0, 3)), "at least 5"),
        (t, holed, "1 not finite"),
        (np.append(t[:-1], np.inf), y, "not finite"),
        (t[:-1], y, "one per time"),
        (t, y[:, 0], "2 dimension"),
        (t, np.empty((80, 0)), "one per time"),
        (t[:, None], y, "1 dimension"),
        (t, "swing", "numbers"),
    ]
    for times, positions, message in cases:
        with pytest.raises(InputError, match=message):
            fit_dmp(times, positions, method=method)
    with pytest.raises(InputError, match="velocities of shape"):
        fit_dmp(t, y, method=method, velocities=y[:-1])
    for basis in (0, 3, 1000):
        with pytest.raises(InputError, match="basis"):
            fit_dmp(t, y, method=method, basis=basis)
