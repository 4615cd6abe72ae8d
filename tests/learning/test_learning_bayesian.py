"""Bayesian linear regression and the mixture built on it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import DotProduct
from sklearn.linear_model import Ridge

from rotorpong.conventions import InputError
from rotorpong.learning import BayesianLinearRegression, Mixture

rng = np.random.default_rng(0)
FEATURES = np.concatenate([np.ones((100, 1)), rng.normal(size=(100, 12))], axis=1)
TARGETS = rng.uniform(size=100)
SHARES = rng.uniform(0.0, 2.0, size=100)
QUERIES = rng.normal(size=(5, 13))
PRIOR = BayesianLinearRegression.prior(13, precision=2.0, noise_sd=0.3)


def learnt(order=range(100), value=PRIOR):
    for i in order:
        value = value.update(FEATURES[i], float(TARGETS[i]), float(SHARES[i]))
    return value


def test_one_after_another_equals_the_whole_batch():
    information = 2.0 * np.eye(13) + FEATURES.T @ (SHARES[:, None] * FEATURES) / 0.3**2
    weights = np.linalg.solve(information, FEATURES.T @ (SHARES * TARGETS) / 0.3**2)
    ours = learnt()
    np.testing.assert_allclose(ours.covariance, np.linalg.inv(information), rtol=0, atol=1e-12)
    np.testing.assert_allclose(ours.weights, weights, rtol=0, atol=1e-12)


def test_its_mean_is_ridge_regression_with_sample_weights():
    theirs = Ridge(alpha=2.0 * 0.3**2, fit_intercept=False, solver="cholesky")
    theirs.fit(FEATURES, TARGETS, sample_weight=SHARES)
    np.testing.assert_allclose(learnt().weights, theirs.coef_, rtol=0, atol=1e-11)


def test_it_is_the_gaussian_process_with_a_linear_kernel():
    process = GaussianProcessRegressor(DotProduct(1e-9), alpha=0.3**2 / SHARES, optimizer=None)
    mean, deviation = process.fit(FEATURES, TARGETS).predict(QUERIES, return_std=True)
    ours = learnt(value=BayesianLinearRegression.prior(13, precision=1.0, noise_sd=0.3))
    np.testing.assert_allclose(ours.mean(QUERIES), mean, atol=1e-9)
    np.testing.assert_allclose(ours.variance(QUERIES), deviation**2, atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(order=st.permutations(range(30)))
def test_the_order_of_the_observations_does_not_matter(order):
    one, other = learnt(range(30)), learnt(order)
    np.testing.assert_allclose(one.weights, other.weights, atol=1e-11)
    np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-12)


def test_an_observation_never_raises_the_variance_of_any_value():
    value = PRIOR
    for features, target in zip(FEATURES, TARGETS, strict=True):
        after = value.update(features, float(target))
        assert (after.variance(FEATURES) <= value.variance(FEATURES) + 1e-12).all()
        assert np.linalg.eigvalsh(after.covariance).min() > 0.0
        value = after


def test_the_weight_of_an_observation_counts_it():
    twice = PRIOR.update(FEATURES[0], 0.4).update(FEATURES[0], 0.4)
    double = PRIOR.update(FEATURES[0], 0.4, weight=2.0)
    np.testing.assert_allclose(twice.weights, double.weights, atol=1e-13)
    np.testing.assert_allclose(twice.covariance, double.covariance, atol=1e-13)
    none = PRIOR.update(FEATURES[0], 0.4, weight=0.0)
    np.testing.assert_array_equal(none.weights, PRIOR.weights)
    np.testing.assert_array_equal(none.covariance, PRIOR.covariance)


def test_an_update_leaves_the_old_record_alone():
    before = PRIOR.covariance.copy()
    learnt()
    np.testing.assert_array_equal(PRIOR.covariance, before)
    np.testing.assert_array_equal(PRIOR.weights, 0.0)


def test_many_features_give_what_each_gives_alone():
    ours = learnt()
    np.testing.assert_allclose(ours.mean(QUERIES), [ours.mean(q) for q in QUERIES])
    np.testing.assert_allclose(ours.variance(QUERIES), [ours.variance(q) for q in QUERIES])


def test_bad_observations_are_refused():
    good = FEATURES[0]
    for features, target, weight, message in (
        (good[:5], 0.5, 1.0, "expected 13"),
        (good * np.nan, 0.5, 1.0, "finite"),
        (good, np.nan, 1.0, "target"),
        (good, 0.5, -0.1, "not negative"),
        (good, 0.5, np.nan, "weight"),
    ):
        with pytest.raises(InputError, match=message):
            PRIOR.update(features, target, weight)
    for read in (PRIOR.mean, PRIOR.variance):
        with pytest.raises(InputError, match="expected 13"):
            read(QUERIES[:, :4])
    for bad in (
        {"features": 0},
        {"features": 3, "precision": 0.0},
        {"features": 3, "noise_sd": -1},
    ):
        with pytest.raises(InputError, match="positive"):
            BayesianLinearRegression.prior(**bad)


def test_before_any_reward_all_primitives_weigh_the_same():
    mixture = Mixture.prior(4, 13)
    np.testing.assert_allclose(mixture.weights(FEATURES[0]), 0.25)
    np.testing.assert_array_equal(mixture.values(FEATURES[0]), 0.0)


def trained_mixture():
    mixture = Mixture.prior(3, 13)
    for i in range(40):
        features = FEATURES[i]
        mixture = mixture.update(features, float(TARGETS[i]), mixture.weights(features))
    return mixture


def test_the_weights_are_the_normalised_exponentials_of_the_values():
    mixture = Mixture.prior(3, 13)
    mixture = mixture.update(FEATURES[0], 1.0, np.array([1.0, 0.0, 0.2]))
    gamma = np.exp(mixture.values(QUERIES))
    np.testing.assert_allclose(mixture.weights(QUERIES), gamma / gamma.sum(1, keepdims=True))
    np.testing.assert_allclose(mixture.weights(QUERIES).sum(axis=1), 1.0)
    np.testing.assert_allclose(mixture.weights(QUERIES[0]), mixture.weights(QUERIES)[0])


def test_each_primitive_learns_by_itself_to_the_extent_of_its_credit():
    credits = rng.uniform(size=(40, 3))
    mixture = Mixture.prior(3, 13)
    alone = list(mixture.regressions)
    for i, credit in enumerate(credits):
        mixture = mixture.update(FEATURES[i], float(TARGETS[i]), credit)
        alone = [
            value.update(FEATURES[i], float(TARGETS[i]), float(part))
            for value, part in zip(alone, credit, strict=True)
        ]
    expected = [value.mean(QUERIES[0]) for value in alone]
    np.testing.assert_allclose(mixture.values(QUERIES[0]), expected)


def test_the_primitive_that_is_rewarded_gains_weight():
    features = FEATURES[0]
    mixture = Mixture.prior(3, 13)
    for _ in range(20):
        mixture = mixture.update(features, 1.0, np.array([1.0, 0.0, 0.0]))
        mixture = mixture.update(features, 0.0, np.array([0.0, 1.0, 1.0]))
    weights = mixture.weights(features)
    assert weights[0] > weights[1]
    assert weights[0] == pytest.approx(np.e / (np.e + 2), abs=0.01)


def test_huge_values_do_not_overflow():
    mixture = Mixture.prior(2, 1, noise_sd=1e-6)
    one = np.ones(1)
    mixture = mixture.update(one, 1e4, np.array([1.0, 0.0]))
    np.testing.assert_array_equal(mixture.weights(one), [1.0, 0.0])


def test_rewards_that_have_no_meaning_are_refused():
    mixture = trained_mixture()
    with pytest.raises(InputError, match="one per primitive"):
        mixture.update(FEATURES[0], 1.0, np.ones(2))
    with pytest.raises(InputError, match="not negative"):
        mixture.update(FEATURES[0], 1.0, np.array([1.0, -1.0, 0.0]))
    with pytest.raises(InputError, match="target"):
        mixture.update(FEATURES[0], np.nan, np.ones(3))
    with pytest.raises(InputError, match="expected 13"):
        mixture.weights(FEATURES[0, :4])
    with pytest.raises(InputError, match="primitives 0"):
        Mixture.prior(0, 13)
