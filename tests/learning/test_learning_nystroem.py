"""Nystroem features: exact while every sample is an inducing point, bounded for ever."""

import pickle

import numpy as np
import pytest
from sklearn.base import clone, is_regressor
from sklearn.utils import estimator_checks

from rotorpong.conventions import InputError
from rotorpong.learning import CrKR, NystroemCrKR

rng = np.random.default_rng(0)
STATES, POINTS = rng.normal(size=(80, 6)), rng.normal(size=(80, 7))
COSTS = rng.uniform(1.0, 20.0, size=80)
QUERIES = rng.normal(size=(25, 6))


def surface(points):
    x, y, z = points.T[:3]
    return np.stack([np.sin(x) * y, z**2 / 2.0], axis=1)


def same(one, other, atol=1e-9):
    for ours, theirs in zip(
        *(e.predict(QUERIES, return_std=True) for e in (one, other)), strict=True
    ):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=atol)


@pytest.mark.parametrize("columns", [slice(None), 0])
@pytest.mark.parametrize("step", [1, 7, 30, 80])
def test_as_long_as_every_sample_induces_it_is_eq_6(columns, step):
    exact = CrKR(2.0, 0.1).fit(STATES, POINTS[:, columns], COSTS)
    ours = NystroemCrKR(2.0, 0.1, inducing_points=100, novelty=1e-9)
    for i in range(0, 80, step):
        part = slice(i, i + step)
        assert ours.partial_fit(STATES[part], POINTS[part, columns], COSTS[part]) is ours
    assert len(ours.inducing_points_) == ours.n_samples_seen_ == 80
    same(ours, exact)


@pytest.mark.parametrize("step", [1, 8, 9, 40])
def test_learning_one_by_one_is_learning_all_at_once(step):
    whole = NystroemCrKR(2.0, 0.1, inducing_points=20).fit(STATES, POINTS, COSTS)
    first = STATES[:40], POINTS[:40], COSTS[:40]
    parts = NystroemCrKR(2.0, 0.1, inducing_points=20).fit(*first)
    twin = NystroemCrKR(2.0, 0.1, inducing_points=20).fit(*first)
    for i in range(40, 80, step):
        part = slice(i, i + step)
        parts.partial_fit(STATES[part], POINTS[part], COSTS[part])
    twin.partial_fit(STATES[40:], POINTS[40:], COSTS[40:])
    same(parts, twin)
    assert whole.inducing_points_.shape == (20, 6)


def test_its_estimate_is_the_projected_process_in_closed_form():
    ours = NystroemCrKR(2.0, 0.1, inducing_points=15).fit(STATES, POINTS, COSTS)

    def kernel(a, b):
        return np.exp(-0.5 * ((a[:, None] / 2.0 - b / 2.0) ** 2).sum(axis=2))

    chosen = ours.inducing_points_
    within, cross = kernel(chosen, chosen), kernel(chosen, STATES)
    precision = within + (cross / (0.1 * COSTS)) @ cross.T
    dual = np.linalg.solve(precision, (cross / (0.1 * COSTS)) @ POINTS)
    new = kernel(QUERIES, chosen)
    known = np.sum(new * np.linalg.solve(within, new.T).T, axis=1)
    left = np.sum(new * np.linalg.solve(precision, new.T).T, axis=1)
    mean, deviation = ours.predict(QUERIES, return_std=True)
    np.testing.assert_allclose(mean, new @ dual, atol=1e-8)
    np.testing.assert_allclose(deviation[:, 0] ** 2, 1.0 - known + left + 0.1, atol=1e-8)


def test_its_memory_does_not_grow_with_the_samples():
    def size(estimator):
        return sum(v.nbytes for v in vars(estimator).values() if isinstance(v, np.ndarray))

    ours = NystroemCrKR(2.0, 0.1, inducing_points=30).fit(STATES[:5], POINTS[:5])
    before, pickled = size(ours), len(pickle.dumps(ours))
    for _ in range(10):
        ours.partial_fit(rng.normal(size=(300, 6)), rng.normal(size=(300, 7)))
    assert ours.n_samples_seen_ == 3005
    assert size(ours) == before
    assert abs(len(pickle.dumps(ours)) - pickled) < 100


def test_it_comes_near_the_exact_estimate():
    draw = np.random.default_rng(1)
    X, fresh = draw.normal(size=(1200, 4)), draw.normal(size=(300, 4))
    y = surface(X) + 0.1 * draw.normal(size=(1200, 2))

    def error(estimator):
        return np.sqrt(np.mean((estimator.fit(X, y).predict(fresh) - surface(fresh)) ** 2))

    exact = error(CrKR(2.0, 0.01))
    few, many = (error(NystroemCrKR(2.0, 0.01, inducing_points=m)) for m in (30, 250))
    assert many < 1.15 * exact
    assert few > many


def test_inducing_points_are_the_pivots_of_a_pivoted_cholesky_factor():
    from scipy.linalg.lapack import dpstrf

    scaled = STATES / 2.0
    kernel = np.exp(-0.5 * ((scaled[:, None] - scaled) ** 2).sum(axis=2))
    _, pivots, _, _ = dpstrf(kernel, lower=1)
    ours = NystroemCrKR(2.0, 0.1, inducing_points=25).fit(STATES, POINTS)
    np.testing.assert_allclose(ours.inducing_points_, STATES[pivots[:25] - 1], rtol=1e-12)


def test_what_is_not_new_induces_nothing():
    ours = NystroemCrKR(2.0, 0.1, inducing_points=50)
    ours.fit(np.repeat(STATES[:10], 5, axis=0), np.repeat(POINTS[:10], 5, axis=0))
    ours.partial_fit(STATES[:10], POINTS[:10])
    assert len(ours.inducing_points_) == 10
    ours.partial_fit(STATES[10:11], POINTS[10:11])
    np.testing.assert_allclose(ours.inducing_points_[-1], STATES[10])


def test_far_from_all_samples_it_knows_nothing():
    ours = NystroemCrKR(1.0, 0.3).fit(STATES, POINTS)
    mean, deviation = ours.predict(np.full((1, 6), 1e6), return_std=True)
    np.testing.assert_array_equal(mean, 0.0)
    np.testing.assert_allclose(deviation, np.sqrt(1.3))


def test_ten_thousand_samples_without_cost_leave_it_finite():
    ours = NystroemCrKR(1.0, 0.0, inducing_points=40).fit(STATES, POINTS, np.zeros(80))
    for _ in range(200):
        i = rng.integers(0, 80, size=50)
        ours.partial_fit(STATES[i], POINTS[i], np.zeros(50))
        ours.partial_fit(STATES[:3], POINTS[:3], np.zeros(3))
    mean, deviation = ours.predict(QUERIES, return_std=True)
    assert np.isfinite(mean).all()
    assert (deviation <= 1.0 + 1e-9).all()


def test_scikit_learn_takes_it_for_a_regressor_that_can_be_cloned():
    ours = NystroemCrKR(2.0, 0.3, inducing_points=7).fit(STATES, POINTS)
    copy = clone(ours)
    assert is_regressor(copy)
    assert not hasattr(copy, "coef_")
    assert copy.get_params() == ours.get_params()
    assert repr(copy).startswith("NystroemCrKR(length_scales=2.0")


@pytest.mark.parametrize(
    "check",
    [
        "check_regressors_train",
        "check_estimators_dtypes",
        "check_estimators_pickle",
        "check_regressors_int",
        "check_parameters_default_constructible",
        "check_methods_subset_invariance",
        "check_fit2d_1sample",
        "check_get_params_invariance",
        "check_set_params",
        "check_dict_unchanged",
        "check_fit_idempotent",
        "check_n_features_in",
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_it_passes_what_scikit_learn_asks_of_its_own(check):
    getattr(estimator_checks, check)("NystroemCrKR", NystroemCrKR())


def test_bad_samples_are_refused_and_change_nothing():
    ours = NystroemCrKR(2.0, 0.1, inducing_points=20).fit(STATES, POINTS)
    before = ours.predict(QUERIES)
    cases = [
        (STATES[:0], POINTS[:0], None, "no samples"),
        (STATES * np.nan, POINTS, None, "not finite"),
        (STATES, POINTS[:-1], None, "y of shape"),
        (STATES, POINTS, -COSTS, "negative"),
        (STATES, POINTS, COSTS[:-1], "one per sample"),
    ]
    for X, y, cost, message in cases:
        for learn in (ours.fit, ours.partial_fit):
            with pytest.raises(InputError, match=message):
                learn(X, y, cost)
    with pytest.raises(InputError, match="6, as in fit"):
        ours.partial_fit(STATES[:, :5], POINTS)
    with pytest.raises(InputError, match="as before"):
        ours.partial_fit(STATES, POINTS[:, 0])
    np.testing.assert_array_equal(ours.predict(QUERIES), before)


def test_bad_parameters_and_queries_are_refused():
    for name, value in (
        ("inducing_points", 0),
        ("novelty", 0.0),
        ("novelty", np.nan),
        ("length_scales", -1.0),
        ("regularization", -1.0),
        ("output_scales", [1.0, 2.0]),
    ):
        with pytest.raises(InputError, match=name):
            NystroemCrKR(**{name: value}).fit(STATES, POINTS)
    with pytest.raises(InputError, match="not fitted"):
        NystroemCrKR().predict(QUERIES)
    with pytest.raises(InputError, match="not fitted"):
        _ = NystroemCrKR().inducing_points_
