"""scikit-learn: the Gaussian process that CrKR is the mean of, with our noise lambda c.

`GaussianProcessRegressor(RBF, alpha=lambda c)` knows no partial_fit: one sample more is one fit
more. It searches length scales within the same bounds, by the same likelihood, its own way.
"""

import warnings
from functools import partial

import numpy as np

from rotorpong.lab.bench.learning_rows import some_samples, throws
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.learning import CrKR, tune
from rotorpong.learning.tuning import NOISE_BOUNDS, SCALE_BOUNDS

SUITE = "learning"
NAME = "scikit-learn, GaussianProcessRegressor"


def require() -> None:
    """Raise ImportError while scikit-learn is not installed."""
    import sklearn.gaussian_process  # noqa: F401


def rows(*, quick: bool) -> tuple[Row, ...]:
    """Measure scikit-learn and rotorpong in turns and return the rows."""
    return (*_fit_rows(1000, quick=quick), *_tuning_rows(60 if quick else 170))


def _fit_rows(n: int, *, quick: bool) -> list[Row]:
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF

    samples, labels, costs = some_samples(n + 1)
    ours = CrKR(2.0, 0.1).fit(samples[:n], labels[:n], costs[:n])
    ours.partial_fit(samples[n:], labels[n:], costs[n:])
    theirs = GaussianProcessRegressor(RBF(2.0), alpha=0.1 * costs, optimizer=None)
    fresh = some_samples(200, seed=1)[0]
    theirs.fit(samples, labels)
    mean, deviation = ours.predict(fresh, return_std=True)
    their_mean, their_deviation = theirs.predict(fresh, return_std=True)
    worst = float(np.abs(mean - their_mean).max())
    worst_variance = float(np.abs(deviation**2 - 0.1 - their_deviation**2).max())
    fit = cpu_seconds(partial(ours.fit, samples, labels, costs), quick=True)
    their_fit = cpu_seconds(partial(theirs.fit, samples, labels), quick=True)
    last = slice(n, n + 1)
    more = cpu_seconds(partial(ours.partial_fit, samples[last], labels[last]), quick=quick)
    name = f"at N = {n} against a peer"
    return [
        Row(f"CrKR, mean {name}, largest difference", worst, "1", 1e-10, "less"),
        Row(f"CrKR, variance {name}, largest difference", worst_variance, "1", 1e-10, "less"),
        Row(f"CrKR, fit {name}", 1e3 * fit, "ms", None, "less", NAME, their_fit / fit),
        Row(f"CrKR, one more {name}", 1e3 * more, "ms", None, "less", NAME, their_fit / more),
    ]


def _tuning_rows(n: int) -> list[Row]:
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    samples, labels = throws(n, seed=0)
    y = labels[:, 0] - labels[:, 0].mean() + 0.02 * np.random.default_rng(0).standard_normal(n)
    bounds = np.outer(samples.std(axis=0), SCALE_BOUNDS)
    kernel = ConstantKernel(1.0, (1e-6, 1e6)) * (
        RBF(np.ones(6), bounds) + WhiteKernel(0.1, NOISE_BOUNDS)
    )
    theirs = GaussianProcessRegressor(kernel, n_restarts_optimizer=3, random_state=0)
    seconds = cpu_seconds(partial(tune, samples, y), quick=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # length scales at their bounds
        their_seconds = cpu_seconds(partial(theirs.fit, samples, y), quick=True)
    lost = theirs.log_marginal_likelihood_value_ - tune(samples, y).log_likelihood
    name = f"tuning with N = {n}, 1 output"
    return [
        Row(f"{name}, against a peer", seconds, "s", None, "less", NAME, their_seconds / seconds),
        Row(f"{name}, log likelihood lost to the peer's", float(lost), "nats", 1e-3, "less"),
    ]
