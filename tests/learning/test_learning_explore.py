"""Exploring, leaving one out, and safety in numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF

from rotorpong.conventions import InputError
from rotorpong.learning import CrKR, NystroemCrKR

rng = np.random.default_rng(0)
STATES, POINTS = rng.normal(size=(40, 6)), rng.normal(size=(40, 3))
COSTS = rng.uniform(1.0, 20.0, size=40)
QUERIES = rng.normal(size=(5, 6))
HEIGHTS = np.array([0.1, 1.0, 5.0])


@pytest.mark.parametrize("kind", [CrKR, NystroemCrKR])
def test_what_is_tried_is_spread_as_the_estimate_is_unsure(kind):
    ours = kind(2.0, 0.3, HEIGHTS).fit(STATES, POINTS, COSTS)
    mean, deviation = ours.predict(QUERIES, return_std=True)
    draws = np.stack([ours.explore(QUERIES, np.random.default_rng(i)) for i in range(1000)])
    sure = 5.0 / np.sqrt(1000)  # 5 sigma of 1000 draws
    np.testing.assert_allclose((draws.mean(axis=0) - mean) / deviation, 0.0, atol=sure)
    np.testing.assert_allclose(draws.std(axis=0) / deviation, 1.0, atol=sure)


def test_nothing_that_is_tried_lies_beyond_the_bound():
    ours = CrKR(2.0, 0.3, HEIGHTS).fit(STATES, POINTS, COSTS)
    mean = ours.predict(QUERIES)
    bound = np.array([0.0, 0.2, 100.0])
    tried = np.stack(
        [ours.explore(QUERIES, np.random.default_rng(i), most=bound) for i in range(9)]
    )
    assert (np.abs(tried - mean) <= bound + 1e-12).all()
    free = np.stack([ours.explore(QUERIES, np.random.default_rng(i)) for i in range(9)])
    np.testing.assert_array_equal(tried[..., 2], free[..., 2])
    assert (np.abs(free - mean)[..., 1] > 0.2).any()


def test_a_vector_of_labels_is_explored_as_a_vector():
    ours = CrKR(2.0, 0.3, 5.0).fit(STATES, POINTS[:, 0], COSTS)
    assert ours.explore(QUERIES, np.random.default_rng(0), most=0.1).shape == (5,)


def test_output_scales_scale_the_deviation_and_nothing_else():
    plain = CrKR(2.0, 0.3).fit(STATES, POINTS, COSTS)
    scaled = CrKR(2.0, 0.3, HEIGHTS).fit(STATES, POINTS, COSTS)
    mean, deviation = plain.predict(QUERIES, return_std=True)
    same, other = scaled.predict(QUERIES, return_std=True)
    np.testing.assert_array_equal(mean, same)
    np.testing.assert_allclose(other, deviation * HEIGHTS, rtol=1e-15)


@pytest.mark.parametrize("columns", [slice(None), 0])
def test_leaving_one_out_is_learning_from_all_others(columns):
    labels = POINTS[:, columns]
    ours = CrKR(2.0, 0.3).fit(STATES[:30], labels[:30], COSTS[:30])
    ours.partial_fit(STATES[30:], labels[30:], COSTS[30:])
    found = ours.leave_one_out()
    for i in range(40):
        kept = np.arange(40) != i
        rest = CrKR(2.0, 0.3).fit(STATES[kept], labels[kept], COSTS[kept])
        expected = labels[i] - rest.predict(STATES[i : i + 1])[0]
        np.testing.assert_allclose(found[i], expected, rtol=0, atol=1e-10)


def test_leaving_one_out_leaves_the_estimator_alone():
    ours = CrKR(2.0, 0.3).fit(STATES, POINTS, COSTS)
    before = ours.predict(QUERIES)
    ours.leave_one_out()
    np.testing.assert_array_equal(ours.predict(QUERIES), before)
    ours.partial_fit(QUERIES, POINTS[:5])
    assert np.isfinite(ours.predict(QUERIES)).all()


def test_a_thousand_samples_equal_scikit_learn_s_process():
    draw = np.random.default_rng(1)
    X, y, cost = draw.normal(size=(1000, 6)), draw.normal(size=(1000, 7)), draw.uniform(1, 20, 1000)
    ours = (
        CrKR(1.5, 0.1).fit(X[:999], y[:999], cost[:999]).partial_fit(X[999:], y[999:], cost[999:])
    )
    theirs = GaussianProcessRegressor(RBF(1.5), alpha=0.1 * cost, optimizer=None).fit(X, y)
    fresh = draw.normal(size=(50, 6))
    np.testing.assert_allclose(ours.predict(fresh), theirs.predict(fresh), rtol=0, atol=1e-10)


def test_three_thousand_samples_with_duplicates_and_hardly_any_noise_are_met():
    draw = np.random.default_rng(2)
    X = draw.normal(size=(1500, 4))
    y = np.stack([np.sin(X[:, 0]), X[:, 1] * X[:, 2]], axis=1)
    cost = np.where(np.arange(3000) % 3 == 0, 0.0, 1e-6)
    ours = CrKR(3.0, 1.0).fit(np.tile(X, (2, 1)), np.tile(y, (2, 1)), cost)
    assert ours.jitter_ <= 1e-8
    np.testing.assert_allclose(ours.predict(X)[::3], y[::3], atol=1e-4)
    np.testing.assert_allclose(ours.predict(X), y, atol=5e-3)  # 5 sigma of the noise
    mean, deviation = ours.partial_fit(X[:1], y[:1]).predict(X, return_std=True)
    np.testing.assert_allclose(mean, y, atol=5e-3)
    np.testing.assert_allclose(deviation, 1.0, atol=1e-3)  # of a new label: lambda is 1


@settings(max_examples=40, deadline=None)
@given(
    length=st.floats(1e-3, 1e4),
    regularization=st.floats(0.0, 1e6),
    costs=st.lists(st.sampled_from([0.0, 1e-300, 1e-12, 1.0, 1e12]), min_size=12, max_size=12),
    seed=st.integers(0, 2**32 - 1),
)
@pytest.mark.parametrize("kind", [CrKR, NystroemCrKR])
def test_whatever_is_learnt_stays_finite(kind, length, regularization, costs, seed):
    draw = np.random.default_rng(seed)
    X = draw.integers(0, 3, size=(12, 2)).astype(float)  # many of them the same
    y = draw.normal(size=(12, 2))
    ours = kind(length, regularization).fit(X[:4], y[:4], np.array(costs[:4]))
    for i in range(4, 12):
        ours.partial_fit(X[i : i + 1], y[i : i + 1], np.array(costs[i : i + 1]))
    mean, deviation = ours.predict(X, return_std=True)
    assert np.isfinite(mean).all()
    assert (deviation >= np.sqrt(regularization)).all()
    assert (deviation <= np.sqrt(1.0 + regularization) + 1e-6).all()


def test_bad_requests_are_refused():
    ours = CrKR(2.0, 0.3).fit(STATES, POINTS)
    dice = np.random.default_rng(0)
    for most in (-1.0, [1.0, 2.0], np.nan):
        with pytest.raises(InputError, match="most"):
            ours.explore(QUERIES, dice, most=most)
    with pytest.raises(InputError, match="6, as in fit"):
        ours.explore(QUERIES[:, :2], dice)
    with pytest.raises(InputError, match="not fitted"):
        CrKR().explore(QUERIES, dice)
    with pytest.raises(InputError, match="not fitted"):
        CrKR().leave_one_out()
    for heights in (-1.0, [1.0, 2.0], np.nan, "high"):
        with pytest.raises(InputError, match="output_scales"):
            CrKR(2.0, 0.3, heights).fit(STATES, POINTS)
