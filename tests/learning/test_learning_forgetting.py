"""Bayesian linear regression that forgets, doubts and dares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal, norm

from rotorpong.conventions import InputError
from rotorpong.learning import BayesianLinearRegression

rng = np.random.default_rng(0)
FEATURES = np.concatenate([np.ones((60, 1)), rng.normal(size=(60, 5))], axis=1)
TARGETS = rng.uniform(size=60)
SHARES = rng.uniform(0.1, 2.0, size=60)
PRIOR = BayesianLinearRegression.prior(6, precision=2.0, noise_sd=0.3)


def learnt(keep=1.0):
    value = PRIOR
    for features, target, share in zip(FEATURES, TARGETS, SHARES, strict=True):
        value = value.forget(keep).update(features, float(target), float(share))
    return value


@settings(max_examples=20, deadline=None)
@given(keep=st.floats(0.05, 1.0))
def test_forgetting_is_a_batch_whose_old_observations_count_less(keep):
    ages = np.arange(59, -1, -1)
    shares = SHARES * keep**ages / 0.3**2
    information = 2.0 * np.eye(6) + FEATURES.T @ (shares[:, None] * FEATURES)
    weights = np.linalg.solve(information, FEATURES.T @ (shares * TARGETS))
    ours = learnt(keep)
    np.testing.assert_allclose(ours.covariance, np.linalg.inv(information), rtol=0, atol=1e-12)
    np.testing.assert_allclose(ours.weights, weights, rtol=0, atol=1e-12)


def test_who_forgets_nothing_is_who_never_forgets():
    assert PRIOR.forget(1.0) is PRIOR


def test_what_is_never_seen_again_winds_up_to_the_prior_and_no_further():
    value, usual = PRIOR, PRIOR.covariance / 0.9**1000
    one = np.eye(6)[0]
    for _ in range(1000):
        value = value.forget(0.9).update(one, 1.0)
    assert np.linalg.eigvalsh(value.covariance).max() <= 0.5 + 1e-12
    np.testing.assert_allclose(value.covariance[1:, 1:], 0.5 * np.eye(5), atol=1e-12)
    assert usual.max() > 1e40


def test_after_long_oblivion_it_knows_what_it_knew_before_anything():
    value = learnt()
    for _ in range(2000):
        value = value.forget(0.95)
    np.testing.assert_allclose(value.covariance, PRIOR.covariance, atol=1e-12)
    np.testing.assert_allclose(value.weights, 0.0, atol=1e-12)


def test_who_forgets_follows_what_drifts():
    draw = np.random.default_rng(1)
    keeps, tracks = PRIOR, PRIOR
    for t in range(400):
        features = np.append(1.0, draw.normal(size=5))
        target = float(features @ np.full(6, 1.0 if t < 200 else -1.0) + 0.3 * draw.normal())
        keeps, tracks = keeps.update(features, target), tracks.forget(0.95).update(features, target)
    assert np.abs(tracks.weights + 1.0).max() < 0.3
    assert np.abs(keeps.weights + 1.0).min() > 0.5


def test_drawn_weights_are_spread_as_they_are_believed():
    value = learnt()
    draws = np.stack([value.sample(np.random.default_rng(i)) for i in range(4000)])
    white = np.linalg.solve(np.linalg.cholesky(value.covariance), (draws - value.weights).T)
    np.testing.assert_allclose(white.mean(axis=1), 0.0, atol=5.0 / np.sqrt(4000))
    np.testing.assert_allclose(white @ white.T / 4000, np.eye(6), atol=5.0 * np.sqrt(2.0 / 4000))


def test_the_same_dice_draw_the_same_weights():
    one, other = (learnt().sample(np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_the_upper_bound_is_the_mean_and_so_many_deviations():
    value = learnt()
    expected = value.mean(FEATURES) + 2.5 * np.sqrt(value.variance(FEATURES))
    np.testing.assert_allclose(value.upper(FEATURES, 2.5), expected, rtol=1e-14)
    np.testing.assert_array_equal(value.upper(FEATURES, 0.0), value.mean(FEATURES))


def test_what_is_still_to_come_adds_up_to_the_evidence():
    value, total = PRIOR, 0.0
    for features, target, share in zip(FEATURES, TARGETS, SHARES, strict=True):
        total += value.log_likelihood(features, float(target), float(share))
        value = value.update(features, float(target), float(share))
    covariance = FEATURES @ FEATURES.T / 2.0 + np.diag(0.3**2 / SHARES)
    theirs = multivariate_normal(np.zeros(60), covariance).logpdf(TARGETS)
    assert total == pytest.approx(theirs, rel=1e-10)


def test_a_target_to_come_is_normal_about_the_mean():
    value = learnt()
    spread = np.sqrt(value.variance(FEATURES[0]) + 0.3**2)
    theirs = norm(value.mean(FEATURES[0]), spread).logpdf(0.7)
    assert value.log_likelihood(FEATURES[0], 0.7) == pytest.approx(theirs)
    assert value.log_likelihood(FEATURES[0], 0.7, weight=0.0) == 0.0


def test_bad_requests_are_refused():
    for keep in (0.0, -0.5, 1.5, np.nan):
        with pytest.raises(InputError, match="keep"):
            PRIOR.forget(keep)
    with pytest.raises(InputError, match="deviations"):
        PRIOR.upper(FEATURES, np.nan)
    with pytest.raises(InputError, match="expected 6"):
        PRIOR.log_likelihood(FEATURES[0, :3], 1.0)
    with pytest.raises(InputError, match="target"):
        PRIOR.log_likelihood(FEATURES[0], np.inf)
