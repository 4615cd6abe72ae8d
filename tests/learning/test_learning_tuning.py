"""Parameters of greatest marginal likelihood, against scikit-learn and finite differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from rotorpong.conventions import InputError
from rotorpong.learning import CrKR, tune
from rotorpong.learning.tuning import NOISE_BOUNDS, SCALE_BOUNDS, Evidence

rng = np.random.default_rng(0)
INPUTS = rng.normal(size=(60, 3)) * [1.0, 5.0, 0.2]
CLEAN = np.stack([np.sin(INPUTS[:, 0]), INPUTS[:, 0] * INPUTS[:, 1] / 5.0], axis=1)
LABELS = CLEAN + 0.1 * rng.normal(size=(60, 2))
COSTS = rng.uniform(1.0, 20.0, size=60)


def test_the_likelihood_is_that_of_a_normal_distribution():
    ours = CrKR([1.0, 5.0, 1.0], 0.1, [2.0, 0.5]).fit(INPUTS, LABELS, COSTS)
    scaled = INPUTS / [1.0, 5.0, 1.0]
    kernel = np.exp(-0.5 * ((scaled[:, None] - scaled) ** 2).sum(axis=2))
    covariance = kernel + 0.1 * np.diag(COSTS)
    theirs = [
        multivariate_normal(np.zeros(60), scale**2 * covariance).logpdf(y)
        for scale, y in zip([2.0, 0.5], LABELS.T, strict=True)
    ]
    assert ours.log_marginal_likelihood() == pytest.approx(sum(theirs), rel=1e-10)


def test_the_likelihood_is_scikit_learn_s_and_so_is_its_gradient():
    point = np.log([0.8, 2.0, 1.5, 0.3])
    ours = Evidence(INPUTS, LABELS, COSTS, scale_outputs=False).at(point)
    kernel = RBF(np.exp(point[:-1]))
    theirs = GaussianProcessRegressor(kernel, alpha=0.3 * COSTS, optimizer=None).fit(INPUTS, LABELS)
    value, gradient = theirs.log_marginal_likelihood(point[:-1], eval_gradient=True)
    assert ours.log_likelihood == pytest.approx(value, rel=1e-12)
    np.testing.assert_allclose(ours.gradient[:-1], gradient, rtol=1e-9, atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    point=st.lists(st.floats(-1.0, 2.0), min_size=4, max_size=4),
    scaled=st.booleans(),
)
def test_the_gradient_is_what_finite_differences_say(seed, point, scaled):
    draw = np.random.default_rng(seed)
    evidence = Evidence(
        draw.normal(size=(15, 3)), draw.normal(size=(15, 2)), draw.uniform(0.5, 9, 15), scaled
    )
    point = np.array(point)
    found = evidence.at(point)
    ahead = [evidence.at(point + 1e-5 * axis).log_likelihood for axis in np.eye(4)]
    behind = [evidence.at(point - 1e-5 * axis).log_likelihood for axis in np.eye(4)]
    slopes = (np.array(ahead) - behind) / 2e-5
    np.testing.assert_allclose(found.gradient, slopes, rtol=1e-5, atol=1e-5)


@pytest.mark.filterwarnings("ignore:The optimal value")
def test_the_optimum_is_no_worse_than_scikit_learn_s():
    y = LABELS[:, 0]
    bounds = np.outer(INPUTS.std(axis=0), SCALE_BOUNDS)
    kernel = ConstantKernel(1.0, (1e-6, 1e6)) * (
        RBF(np.ones(3), bounds) + WhiteKernel(0.1, NOISE_BOUNDS)
    )
    theirs = GaussianProcessRegressor(kernel, n_restarts_optimizer=3, random_state=0)
    theirs.fit(INPUTS, y)
    ours = tune(INPUTS, y)
    assert ours.log_likelihood > theirs.log_marginal_likelihood_value_ - 1e-5
    found = theirs.kernel_
    assert ours.length_scales[0] == pytest.approx(found.k2.k1.length_scale[0], rel=0.02)
    assert ours.output_scales == pytest.approx(np.sqrt(found.k1.constant_value), rel=0.02)


def test_with_unequal_costs_it_is_no_worse_than_scikit_learn_s_with_our_noise():
    ours = tune(INPUTS, LABELS, COSTS, scale_outputs=False)
    kernel = RBF(np.ones(3), (1e-3, 1e5))
    theirs = GaussianProcessRegressor(
        kernel, alpha=ours.regularization * COSTS, n_restarts_optimizer=2, random_state=0
    ).fit(INPUTS, LABELS)
    assert ours.log_likelihood == pytest.approx(theirs.log_marginal_likelihood_value_, abs=1e-4)


def test_what_it_says_of_itself_is_what_its_estimator_says():
    for labels in (LABELS, LABELS[:, 0]):
        found = tune(INPUTS, labels, COSTS)
        fitted = found.crkr().fit(INPUTS, labels, COSTS)
        assert fitted.log_marginal_likelihood() == pytest.approx(found.log_likelihood, rel=1e-9)


def test_an_input_that_does_not_matter_gets_a_long_scale():
    found = tune(INPUTS, LABELS)
    relative = found.length_scales / [1.0, 5.0, 0.2]
    assert relative[2] > 20.0 * relative[0]


def test_the_noise_that_was_added_is_found_again():
    draw = np.random.default_rng(1)
    x = np.linspace(0.0, 20.0, 300)[:, None]
    costs = draw.uniform(0.5, 5.0, size=300)
    y = np.sin(x[:, 0]) + 0.2 * np.sqrt(costs) * draw.normal(size=300)
    found = tune(x, y, costs)
    noise = found.output_scales * np.sqrt(found.regularization)
    assert noise == pytest.approx(0.2, abs=4 * 0.2 / np.sqrt(600))


@pytest.mark.parametrize(("inputs", "outputs"), [(1e-3, 1e6), (70.0, 1e-6), (1e3, 1.0)])
def test_units_do_not_matter(inputs, outputs):
    plain = tune(INPUTS[:20], LABELS[:20])
    other = tune(inputs * INPUTS[:20], outputs * LABELS[:20])
    gained = 40 * np.log(outputs)
    assert other.log_likelihood + gained == pytest.approx(plain.log_likelihood, abs=1e-3)


def test_the_same_samples_give_the_same_parameters():
    one, other = tune(INPUTS, LABELS, COSTS), tune(INPUTS, LABELS, COSTS)
    np.testing.assert_array_equal(one.length_scales, other.length_scales)
    assert one.regularization == other.regularization


def test_tuning_generalises_better_than_one_scale_for_all():
    draw = np.random.default_rng(2)
    fresh = draw.normal(size=(200, 3)) * [1.0, 5.0, 0.2]
    truth = np.stack([np.sin(fresh[:, 0]), fresh[:, 0] * fresh[:, 1] / 5.0], axis=1)
    found = tune(INPUTS, LABELS).crkr().fit(INPUTS, LABELS).predict(fresh)
    plain = CrKR(3.0 * np.array([1.0, 5.0, 0.2]), 0.1).fit(INPUTS, LABELS).predict(fresh)
    assert np.sqrt(np.mean((found - truth) ** 2)) < 0.7 * np.sqrt(np.mean((plain - truth) ** 2))


ODD = {
    "one sample": (np.ones((1, 3)), np.ones(1)),
    "two samples": (INPUTS[:2], LABELS[:2]),
    "fewer samples than inputs": (rng.normal(size=(4, 9)), rng.normal(size=4)),
    "constant inputs": (np.full((9, 2), 0.1), rng.normal(size=9)),
    "one constant input": (INPUTS * [1.0, 0.0, 1.0] + 0.1, LABELS),
    "constant outputs": (INPUTS, np.ones(60)),
    "outputs that are 0": (INPUTS, np.zeros((60, 2))),
    "duplicates": (np.repeat(INPUTS, 2, axis=0), np.repeat(LABELS, 2, axis=0)),
    "contradicting duplicates": (np.repeat(INPUTS[:20], 2, axis=0), rng.normal(size=40)),
    "tiny numbers": (1e-100 * INPUTS, 1e-100 * LABELS),
}


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("cost", [None, 0.0, 1e-9, 1e9])
def test_odd_samples_give_finite_parameters_that_can_be_fitted(name, cost):
    X, y = ODD[name]
    costs = None if cost is None else np.full(len(X), cost)
    found = tune(X, y, costs)
    assert (found.length_scales > 0.0).all()
    assert np.isfinite([*found.length_scales, found.regularization, found.log_likelihood]).all()
    mean, deviation = found.crkr().fit(X, y, costs).predict(X, return_std=True)
    assert np.isfinite(mean).all()
    assert np.isfinite(deviation).all()


def test_of_many_samples_an_even_part_is_used():
    draw = np.random.default_rng(3)
    X = draw.normal(size=(1000, 1))
    y = np.sin(2.0 * X[:, 0]) + 0.1 * draw.normal(size=1000)
    some = tune(X, y, most_samples=150)
    all_of_them = tune(X, y, most_samples=300)
    assert some.length_scales[0] == pytest.approx(all_of_them.length_scales[0], rel=0.3)
    part = np.linspace(0, 999, 150).astype(int)
    fitted = some.crkr().fit(X[part], y[part])
    assert fitted.log_marginal_likelihood() == pytest.approx(some.log_likelihood, rel=1e-9)


def test_bad_samples_are_refused():
    cases = [
        (INPUTS[:0], LABELS[:0], None, "no samples"),
        (INPUTS * np.nan, LABELS, None, "not finite"),
        (INPUTS, LABELS[:-1], None, "y of shape"),
        (INPUTS, LABELS, -COSTS, "negative"),
        (INPUTS, LABELS, COSTS[:-1], "one per sample"),
    ]
    for X, y, cost, message in cases:
        with pytest.raises(InputError, match=message):
            tune(X, y, cost)
    with pytest.raises(InputError, match="most_samples 0"):
        tune(INPUTS, LABELS, most_samples=0)
    with pytest.raises(InputError, match="not fitted"):
        CrKR().log_marginal_likelihood()
