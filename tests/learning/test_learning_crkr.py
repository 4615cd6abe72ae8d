"""Eq. (6) against what must be true of it, scikit-learn and Gaussian processes."""

import pickle
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone, is_regressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF
from sklearn.kernel_ridge import KernelRidge
from sklearn.metrics import r2_score
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils import estimator_checks

from rotorpong.conventions import InputError
from rotorpong.learning import CrKR

rng = np.random.default_rng(0)
STATES, POINTS = rng.normal(size=(60, 6)), rng.normal(size=(60, 7))
COSTS = rng.uniform(1.0, 20.0, size=60)
QUERIES = rng.normal(size=(25, 6))
SCALES = np.array([0.5, 1.0, 2.0, 3.0, 1.5, 0.8])


def gaussian_process(costs, regularization, scales=SCALES):
    return GaussianProcessRegressor(RBF(scales), alpha=regularization * costs, optimizer=None)


def test_costs_are_the_noise_of_a_gaussian_process():
    ours = CrKR(SCALES, 0.3).fit(STATES, POINTS, COSTS)
    theirs = gaussian_process(COSTS, 0.3).fit(STATES, POINTS)
    mean, deviation = ours.predict(QUERIES, return_std=True)
    their_mean, their_deviation = theirs.predict(QUERIES, return_std=True)
    np.testing.assert_allclose(mean, their_mean, rtol=0, atol=1e-10)
    np.testing.assert_allclose(deviation**2, their_deviation**2 + 0.3, rtol=0, atol=1e-10)
    assert deviation.shape == their_deviation.shape


def test_a_vector_of_labels_gives_a_vector_of_estimates():
    ours = CrKR(SCALES, 0.3).fit(STATES, POINTS[:, 0], COSTS)
    theirs = gaussian_process(COSTS, 0.3).fit(STATES, POINTS[:, 0])
    mean, deviation = ours.predict(QUERIES, return_std=True)
    assert mean.shape == deviation.shape == (25,)
    np.testing.assert_allclose(mean, theirs.predict(QUERIES), rtol=0, atol=1e-10)


def test_costs_are_the_inverse_sample_weights_of_kernel_ridge_regression():
    ours = CrKR(1.0, 0.3).fit(STATES, POINTS, COSTS)
    theirs = KernelRidge(alpha=0.3, kernel="rbf", gamma=0.5)
    theirs.fit(STATES, POINTS, sample_weight=1.0 / COSTS)
    np.testing.assert_allclose(ours.predict(QUERIES), theirs.predict(QUERIES), rtol=0, atol=1e-10)


def test_every_cost_is_1_unless_stated():
    ours, ones = CrKR(2.0, 0.3).fit(STATES, POINTS), CrKR(2.0, 0.3)
    ones.fit(STATES, POINTS, np.ones(60))
    np.testing.assert_array_equal(ours.predict(QUERIES), ones.predict(QUERIES))


def test_without_regularization_it_interpolates():
    ours = CrKR(1.0, 0.0).fit(STATES, POINTS)
    np.testing.assert_allclose(ours.predict(STATES), POINTS, atol=1e-6)


def test_a_sample_without_cost_is_met_and_an_infinitely_costly_one_ignored():
    costs = COSTS.copy()
    costs[3], costs[4] = 0.0, 1e14
    ours = CrKR(1.0, 0.3).fit(STATES, POINTS, costs)
    np.testing.assert_allclose(ours.predict(STATES[3:4]), POINTS[3:4], atol=1e-6)
    kept = np.arange(60) != 4
    rest = CrKR(1.0, 0.3).fit(STATES[kept], POINTS[kept], costs[kept])
    np.testing.assert_allclose(ours.predict(QUERIES), rest.predict(QUERIES), atol=1e-8)


def test_far_from_all_samples_the_estimate_is_0_and_knows_nothing():
    ours = CrKR(1.0, 0.3).fit(STATES, POINTS)
    mean, deviation = ours.predict(np.full((1, 6), 1e6), return_std=True)
    np.testing.assert_array_equal(mean, 0.0)
    np.testing.assert_allclose(deviation, np.sqrt(1.3))


def test_many_queries_give_what_each_gives_alone():
    ours = CrKR(SCALES, 0.3).fit(STATES, POINTS, COSTS)
    together = ours.predict(QUERIES)
    alone = np.concatenate([ours.predict(query[None]) for query in QUERIES])
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-12)
    assert ours.predict(QUERIES[:0]).shape == (0, 7)


@pytest.mark.parametrize("columns", [slice(None), 0])
@pytest.mark.parametrize("step", [1, 7])
def test_samples_learnt_one_after_another_equal_one_fit(columns, step):
    labels = POINTS[:, columns]
    grown = CrKR(SCALES, 0.05).fit(STATES[:10], labels[:10], COSTS[:10])
    for i in range(10, 60, step):
        part = slice(i, i + step)
        assert grown.partial_fit(STATES[part], labels[part], COSTS[part]) is grown
    whole = CrKR(SCALES, 0.05).fit(STATES, labels, COSTS)
    found = [estimator.predict(QUERIES, return_std=True) for estimator in (grown, whole)]
    for ours, theirs in zip(*found, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-10)
    np.testing.assert_allclose(grown.dual_coef_, whole.dual_coef_, rtol=0, atol=1e-10)


def test_the_first_part_of_a_fit_is_a_fit():
    grown = CrKR(2.0, 0.1).partial_fit(STATES, POINTS, COSTS)
    whole = CrKR(2.0, 0.1).fit(STATES, POINTS, COSTS)
    np.testing.assert_array_equal(grown.predict(QUERIES), whole.predict(QUERIES))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), split=st.integers(1, 11), length=st.floats(0.3, 5.0))
def test_any_split_of_the_samples_gives_the_same_estimate(seed, split, length):
    draw = np.random.default_rng(seed)
    X, y, cost = draw.normal(size=(12, 3)), draw.normal(size=(12, 2)), draw.uniform(0.5, 9, 12)
    grown = CrKR(length, 0.05).fit(X[:split], y[:split], cost[:split])
    grown.partial_fit(X[split:], y[split:], cost[split:])
    whole = CrKR(length, 0.05).fit(X, y, cost)
    np.testing.assert_allclose(grown.predict(X), whole.predict(X), rtol=0, atol=1e-10)


def test_a_duplicated_sample_counts_as_one_of_half_the_cost():
    twice = CrKR(1.0, 0.3).fit(np.repeat(STATES, 2, 0), np.repeat(POINTS, 2, 0), np.ones(120))
    once = CrKR(1.0, 0.3).fit(STATES, POINTS, np.full(60, 0.5))
    np.testing.assert_allclose(twice.predict(QUERIES), once.predict(QUERIES), atol=1e-10)


@pytest.mark.parametrize("length", [1.0, 10.0, 1000.0])
def test_duplicates_without_cost_or_regularization_stay_finite(length):
    X, y = np.tile(STATES, (5, 1)), np.tile(POINTS, (5, 1))
    whole = CrKR(length, 0.0).fit(X, y, np.zeros(300))
    grown = CrKR(length, 0.0)
    for i in range(0, 300, 10):
        grown.partial_fit(X[i : i + 10], y[i : i + 10], np.zeros(10))
    for ours in (whole, grown):
        mean, deviation = ours.predict(QUERIES, return_std=True)
        assert np.isfinite(mean).all()
        assert np.isfinite(deviation).all()
        assert ours.jitter_ <= 1e-6


def test_scikit_learn_takes_it_for_a_regressor_that_can_be_cloned():
    ours = CrKR(SCALES, 0.3)
    copy = clone(ours.fit(STATES, POINTS))
    assert is_regressor(copy)
    assert not hasattr(copy, "dual_coef_")
    assert copy.get_params()["regularization"] == 0.3
    assert copy.set_params(regularization=0.5).regularization == 0.5


def test_it_works_in_a_pipeline_with_costs_and_cross_validation():
    y = STATES @ rng.normal(size=(6, 2))
    pipeline = make_pipeline(StandardScaler(), CrKR(4.0, 0.01))
    pipeline.fit(STATES, y, crkr__cost=COSTS)
    scaled = StandardScaler().fit(STATES)
    alone = CrKR(4.0, 0.01).fit(scaled.transform(STATES), y, COSTS)
    expected = alone.predict(scaled.transform(QUERIES))
    np.testing.assert_allclose(pipeline.predict(QUERIES), expected)
    scores = cross_val_score(pipeline, STATES, y, params={"crkr__cost": COSTS}, cv=5)
    assert scores.shape == (5,)
    assert scores.min() > 0.5
    search = GridSearchCV(pipeline, {"crkr__length_scales": [0.1, 4.0]}).fit(STATES, y)
    assert search.best_params_ == {"crkr__length_scales": 4.0}


@pytest.mark.parametrize(
    "check",
    [
        "check_estimator_cloneable",
        "check_estimator_tags_renamed",
        "check_estimator_repr",
        "check_no_attributes_set_in_init",
        "check_estimators_overwrite_params",
        "check_estimators_fit_returns_self",
        "check_readonly_memmap_input",
        "check_estimators_dtypes",
        "check_estimators_pickle",
        "check_f_contiguous_array_estimator",
        "check_regressor_multioutput",
        "check_regressors_int",
        "check_parameters_default_constructible",
        "check_methods_sample_order_invariance",
        "check_methods_subset_invariance",
        "check_fit2d_1sample",
        "check_fit2d_1feature",
        "check_get_params_invariance",
        "check_set_params",
        "check_dict_unchanged",
        "check_fit_idempotent",
        "check_fit_check_is_fitted",
        "check_n_features_in",
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_it_passes_what_scikit_learn_asks_of_its_own(check):
    getattr(estimator_checks, check)("CrKR", CrKR())


def test_the_score_is_scikit_learn_s_r2():
    ours = CrKR(2.0, 0.3).fit(STATES[:40], POINTS[:40])
    for columns in (slice(None), 0):
        ours.fit(STATES[:40], POINTS[:40, columns])
        y, found = POINTS[40:, columns], ours.predict(STATES[40:])
        assert ours.score(STATES[40:], y) == pytest.approx(r2_score(y, found))
        weighted = ours.score(STATES[40:], y, COSTS[40:])
        assert weighted == pytest.approx(r2_score(y, found, sample_weight=COSTS[40:]))
    constant = np.ones(20)
    assert ours.score(STATES[40:], constant) == r2_score(constant, ours.predict(STATES[40:]))


def test_a_pickled_estimator_goes_on_learning():
    ours = CrKR(2.0, 0.1).fit(STATES[:30], POINTS[:30])
    copy = pickle.loads(pickle.dumps(ours))
    copy.partial_fit(STATES[30:], POINTS[30:])
    whole = CrKR(2.0, 0.1).fit(STATES, POINTS)
    np.testing.assert_allclose(copy.predict(QUERIES), whole.predict(QUERIES), atol=1e-10)


def test_the_caller_s_arrays_are_copied_and_not_changed():
    X, y, cost = STATES.copy(), POINTS.copy(), COSTS.copy()
    ours = CrKR(2.0, 0.1).fit(X, y, cost)
    before = ours.predict(QUERIES)
    np.testing.assert_array_equal(y, POINTS)
    X[:], y[:], cost[:] = 0.0, 0.0, 0.0
    ours.partial_fit(STATES[:1], POINTS[:1])
    assert not np.array_equal(before, ours.predict(QUERIES))
    np.testing.assert_array_equal(ours.X_[:60], STATES)


def test_scikit_learn_is_not_imported_by_learning():
    import subprocess

    code = "import sys, rotorpong.learning; sys.exit('sklearn' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_bad_samples_are_refused_and_change_nothing():
    holed = STATES.copy()
    holed[0, 0] = np.nan
    cases = [
        (STATES[:0], POINTS[:0], None, "no samples"),
        (STATES[:, :0], POINTS, None, "samples, features"),
        (STATES[0], POINTS, None, "samples, features"),
        (holed, POINTS, None, "1 not finite"),
        (STATES, POINTS * np.inf, None, "not finite"),
        (STATES, POINTS[:-1], None, "y of shape"),
        (STATES, POINTS[:, :0], None, "y of shape"),
        (STATES, POINTS[:, :, None], None, "y of shape"),
        (STATES, POINTS, COSTS[:-1], "one per sample"),
        (STATES, POINTS, COSTS[:, None], "one per sample"),
        (STATES, POINTS, -COSTS, "negative"),
        (STATES, POINTS, COSTS * np.nan, "not finite"),
        (STATES, POINTS, COSTS * np.inf, "not finite"),
        ([["a", "b"]], [1.0], None, "numbers"),
        ([[1.0], [1.0, 2.0]], [1.0, 2.0], None, "numbers"),
        (STATES * 1j, POINTS, None, "numbers"),
    ]
    ours = CrKR(2.0, 0.1).fit(STATES, POINTS)
    before = ours.predict(QUERIES)
    for X, y, cost, message in cases:
        for learn in (ours.fit, ours.partial_fit, CrKR(2.0, 0.1).partial_fit):
            with pytest.raises(InputError, match=message):
                learn(X, y, cost)
    with pytest.raises(InputError, match="6, as in fit"):
        ours.partial_fit(STATES[:, :5], POINTS)
    for labels in (POINTS[:, 0], POINTS[:, :6]):
        with pytest.raises(InputError, match="as before"):
            ours.partial_fit(STATES, labels)
    np.testing.assert_array_equal(ours.predict(QUERIES), before)


def test_bad_queries_are_refused():
    ours = CrKR(2.0, 0.1).fit(STATES, POINTS)
    with pytest.raises(InputError, match="not fitted"):
        CrKR().predict(QUERIES)
    with pytest.raises(InputError, match="6, as in fit"):
        ours.predict(QUERIES[:, :3])
    with pytest.raises(InputError, match="samples, features"):
        ours.predict(QUERIES[0])
    with pytest.raises(InputError, match="not finite"):
        ours.predict(QUERIES * np.nan)
    with pytest.raises(InputError, match="y of shape"):
        ours.score(STATES, POINTS[:, 0])
    with pytest.raises(InputError, match="nothing"):
        ours.score(STATES[:0], POINTS[:0])


@pytest.mark.parametrize("scales", [0.0, -1.0, np.nan, [1.0, 2.0], np.ones((6, 1)), "wide"])
def test_bad_length_scales_are_refused_when_fitted(scales):
    with pytest.raises(InputError, match="length_scales"):
        CrKR(scales).fit(STATES, POINTS)


@pytest.mark.parametrize("regularization", [-1.0, np.nan, np.inf])
def test_a_bad_regularization_is_refused_when_fitted(regularization):
    with pytest.raises(InputError, match="regularization"):
        CrKR(1.0, regularization).fit(STATES, POINTS)


def test_an_unknown_parameter_is_refused_and_changes_nothing():
    ours = CrKR(2.0, 0.1)
    with pytest.raises(InputError, match="length_scales, regularization"):
        ours.set_params(regularization=5.0, ridge=1.0)
    assert ours.regularization == 0.1
