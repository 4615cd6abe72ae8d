"""Length scales, regularization and output scales that make the labels most likely (ML-II, ARD).

    A = K(l) + lambda C,    y_j ~ N(0, sigma_j^2 A)
    L = -1/2 sum_j [y_j^T A^-1 y_j / sigma_j^2 + log det A + n log (2 pi sigma_j^2)]
    dL/dp = 1/2 tr [(sum_j a_j a_j^T / sigma_j^2 - J A^-1) dA/dp],    a_j = A^-1 y_j
    dA/d log l_d = K o (x_d - x'_d)^2 / l_d^2,    dA/d log lambda = lambda C

The output scales are profiled out: sigma_j^2 = y_j^T A^-1 y_j / n maximises L, and the gradient
stays as it is. They do not change the estimate of Eq. (6), only its deviation. One length scale per
input: an input that does not matter gets a long one.

As in Eq. (6) the labels have mean zero: centre them first, or the length scales will explain the
mean. From few samples of many inputs the maximum fits the noise: compare `CrKR.leave_one_out`.
"""

# ruff: noqa: N803  (X is scikit-learn's name)

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve, get_lapack_funcs
from scipy.optimize import minimize

from rotorpong.conventions import InputError
from rotorpong.learning.crkr import CrKR
from rotorpong.learning.samples import (
    NOISE_FLOOR,
    checked_samples,
    factorised,
    gaussian_kernel,
    noise_of,
)

STARTS = ((1.0, 1e-1), (3.0, 1e-2), (0.3, 1e-1), (10.0, 1e-3))  # see `_starts`
SCALE_BOUNDS = (1e-2, 1e3)  # of length scales, in standard deviations of the input
NOISE_BOUNDS = (1e-8, 1e2)  # of lambda times the median cost
COARSE = 200  # samples on which the starts are compared
COARSE_STEPS, FINE_STEPS = 100, 60  # of L-BFGS-B
_INVERT_FACTORISED: Any = get_lapack_funcs("potri", dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Tuned:
    """Parameters of the greatest marginal likelihood that was found."""

    length_scales: Float[ndarray, "m"]  # in the inputs' units
    regularization: float  # lambda
    output_scales: Float[ndarray, "*k"]  # sigma, in the labels' units; 0 for labels that are all 0
    log_likelihood: float  # L, of the samples that were used

    def crkr(self) -> CrKR:
        """Return an estimator with these parameters, still to be fitted."""
        return CrKR(self.length_scales, self.regularization, self.output_scales)


def tune(
    X: ArrayLike,
    y: ArrayLike,
    cost: ArrayLike | None = None,
    *,
    scale_outputs: bool = True,
    most_samples: int = 1000,
) -> Tuned:
    """Return the parameters of CrKR that make labels y at X with these costs most likely.

    Several starts, always the same, by L-BFGS-B on an even part of the samples; the best goes on
    with all of them. An input that never varies keeps the length scale 1. Length scales stay within
    0.01 to 1000 standard deviations of their input, lambda times the median cost within 1e-8 to
    100.

    Args:
        X: inputs, (n, features).
        y: labels of mean zero, (n,) or (n, outputs).
        cost: c, not negative; 1 each by default.
        scale_outputs: find the scale of each output too; otherwise they are 1.
        most_samples: of more samples, so many evenly spaced ones are used; O(n^3) a step.

    Raises:
        InputError: as `CrKR.fit`, or `most_samples` is not positive.
    """
    samples, labels, costs = checked_samples(X, y, cost)
    if most_samples < 1:
        raise InputError(f"most_samples {most_samples}: expected at least 1")
    spread = samples.std(axis=0)
    spread[spread <= 1e-12 * np.abs(samples).max(axis=0)] = 0.0  # rounding is no variation
    varies = spread > 0.0
    whole = Evidence(
        (samples[:, varies] - samples[:, varies].mean(axis=0)) / spread[varies],
        labels.reshape(len(labels), -1),
        costs,
        scale_outputs=scale_outputs,
    ).part(most_samples)
    point = _maximum(whole)
    scales = np.ones(samples.shape[1])
    scales[varies] = np.exp(point[:-1]) * spread[varies]
    found = whole.at(point)
    heights = found.output_scales.reshape(labels.shape[1:])
    return Tuned(scales, float(np.exp(point[-1])), heights, found.log_likelihood)


@dataclass(frozen=True, slots=True)
class Likelihood:
    """The log marginal likelihood at one point."""

    log_likelihood: float
    gradient: Float[ndarray, "p"]  # by the logarithms of length scales and lambda
    output_scales: Float[ndarray, "k"]


@dataclass(frozen=True, slots=True)
class Evidence:
    """Samples whose labels are to be explained."""

    samples: Float[ndarray, "n m"]
    labels: Float[ndarray, "n k"]
    costs: Float[ndarray, "n"]
    scale_outputs: bool = True

    def part(self, most: int) -> "Evidence":
        """Return at most so many of the samples, evenly spaced."""
        if len(self.samples) <= most:
            return self
        kept = np.linspace(0, len(self.samples) - 1, most).astype(int)
        return Evidence(self.samples[kept], self.labels[kept], self.costs[kept], self.scale_outputs)

    def at(self, point: Float[ndarray, "p"]) -> Likelihood:
        """Return L and its gradient where (log l, log lambda) = `point`; the module's equations."""
        n, lam = len(self.samples), np.exp(point[-1])
        height = self._height()
        y = self.labels[:, height > 0.0] / height[height > 0.0]
        z = self.samples / np.exp(point[:-1])
        kernel = gaussian_kernel(z, z, np.ones(z.shape[1]))
        factor, _ = factorised(kernel, noise_of(self.costs, lam))
        dual = cho_solve((factor, True), y, check_finite=False)
        squares = np.sum(y * dual, axis=0)
        variances = squares / n if self.scale_outputs else np.ones(len(squares))
        log_likelihood = -0.5 * np.sum(squares / variances + n * np.log(2.0 * np.pi * variances))
        log_likelihood -= y.shape[1] * np.sum(np.log(np.diag(factor)))
        log_likelihood -= n * np.sum(np.log(height[height > 0.0]))
        slope = dual / variances @ dual.T - y.shape[1] * _inverse(factor)
        scales = height.copy()
        scales[height > 0.0] *= np.sqrt(variances)
        return Likelihood(float(log_likelihood), self._gradient(slope, kernel, z, lam), scales)

    def _height(self) -> Float[ndarray, "k"]:
        """Return a first guess of the output scales."""
        if not self.scale_outputs:
            return np.ones(self.labels.shape[1])
        return np.sqrt(np.mean(self.labels**2, axis=0))

    def _gradient(
        self,
        slope: Float[ndarray, "n n"],
        kernel: Float[ndarray, "n n"],
        z: Float[ndarray, "n m"],
        lam: float,
    ) -> Float[ndarray, "p"]:
        noise = lam * self.costs
        by_noise = 0.5 * np.sum(np.where(noise > NOISE_FLOOR, noise, 0.0) * np.diag(slope))
        pull = slope * kernel
        np.fill_diagonal(pull, 0.0)  # a sample is no distance from itself
        by_scales = pull.sum(axis=1) @ z**2 - np.sum(z * (pull @ z), axis=0)
        return np.append(by_scales, by_noise)


def _inverse(factor: Float[ndarray, "n n"]) -> Float[ndarray, "n n"]:
    """Return (L L^T)^-1."""
    lower = np.tril(_INVERT_FACTORISED(factor, lower=1)[0])
    return lower + np.tril(lower, -1).T


def _maximum(whole: Evidence) -> Float[ndarray, "p"]:
    coarse = whole.part(COARSE)
    ends = [_climb(coarse, start, COARSE_STEPS) for start in _starts(whole)]
    best = max(ends, key=lambda point: coarse.at(point).log_likelihood)
    return best if coarse is whole else _climb(whole, best, FINE_STEPS)


def _starts(whole: Evidence) -> list[Float[ndarray, "p"]]:
    """Return length scales, as multiples of the typical distance, with lambda times a cost."""
    dimensions = whole.samples.shape[1]
    wide = np.sqrt(max(dimensions, 1))
    return [
        np.log(np.append(np.full(dimensions, scale * wide), noise / _typical(whole.costs)))
        for scale, noise in STARTS
    ]


def _climb(evidence: Evidence, start: Float[ndarray, "p"], steps: int) -> Float[ndarray, "p"]:
    size = evidence.labels.size

    def descent(point: Float[ndarray, "p"]) -> tuple[float, Float[ndarray, "p"]]:
        found = evidence.at(point)
        return -found.log_likelihood / size, -found.gradient / size

    noises = np.array(NOISE_BOUNDS) / _typical(evidence.costs)
    bounds = np.log([SCALE_BOUNDS] * (len(start) - 1) + [tuple(noises)])
    options = {"maxiter": steps, "ftol": 1e-12, "gtol": 1e-7}
    start = np.clip(start, *bounds.T)
    return minimize(descent, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options).x


def _typical(costs: Float[ndarray, "n"]) -> float:
    """Return the median of the costs that are not 0."""
    some = costs[costs > 0.0]
    return float(np.median(some)) if len(some) else 1.0
