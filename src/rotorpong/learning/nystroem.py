"""Cost-regularised kernel regression in bounded memory: Nystroem features, learnt recursively.

    phi(s) = L^-1 k_M(s),  L L^T = K_MM,      phi(a) . phi(b) ~ k(a, b)
    delta(s) = w . phi(s),  w ~ N(0, I),  the label of a sample with noise of variance lambda c
    var(s) = k(s, s) - phi . phi + phi^T P phi + lambda,   P the covariance of w

M are m inducing points among the samples. On them the features are exact, so as long as all samples
are inducing points this is Eq. (6); later it is the best approximation by their kernels. Inducing
points are chosen greedily, by the largest variance that those before leave (pivoted Cholesky); a
later sample that they do not explain joins them while there is room, which changes nothing for the
samples before: their new feature is 0 (kernel recursive least squares with approximate linear
dependence; Engel, Mannor and Meir 2004).

P is kept as S S^T. One sample is learnt by Potter's square root filter, O(m^2), many at once by a
Cholesky factor; neither can make P indefinite. Features that no inducing point has yet are 0, and
all arrays have their final size from the beginning.
"""

# ruff: noqa: N803  (X is scikit-learn's name)

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike
from scipy.linalg import cholesky, get_blas_funcs, get_lapack_funcs

from rotorpong.conventions import InputError
from rotorpong.learning.regressor import KernelRegressor, beside
from rotorpong.learning.samples import (
    checked_length_scales,
    checked_output_scales,
    checked_regularization,
    checked_samples,
    gaussian_kernel,
    noise_of,
)

BLOCK = 1024  # samples learnt at once
FEW = 8  # so many are learnt one by one
CANDIDATES = 10  # times the inducing points: samples among which `fit` chooses
_SOLVE_TRIANGLE: Any = get_lapack_funcs("trtrs", dtype=np.float64)
_ADD_OUTER: Any = get_blas_funcs("ger", dtype=np.float64)


class NystroemCrKR(KernelRegressor):
    """CrKR whose memory and time per sample do not grow with the samples.

    Attributes:
        n_features_in_: inputs per sample, once fitted.
        inducing_points_: chosen samples, (at most m, features).
        coef_: w, (m,) or (m, outputs).
        n_samples_seen_: how many samples were learnt.
    """

    PARAMETERS = (
        "length_scales",
        "regularization",
        "output_scales",
        "inducing_points",
        "novelty",
    )
    LEARNT = "coef_"

    def __init__(
        self,
        length_scales: ArrayLike = 1.0,
        regularization: float = 1.0,
        output_scales: ArrayLike = 1.0,
        *,
        inducing_points: int = 400,
        novelty: float = 1e-6,
    ) -> None:
        """Keep the parameters; they are checked by `fit`.

        Args:
            length_scales: as of `CrKR`.
            regularization: as of `CrKR`.
            output_scales: as of `CrKR`.
            inducing_points: m, the most there may be.
            novelty: a sample joins the inducing points only if they leave more than this of its
                variance, k(s, s) - phi . phi; between 0 and 1.
        """
        self.length_scales = length_scales
        self.regularization = regularization
        self.output_scales = output_scales
        self.inducing_points = inducing_points
        self.novelty = novelty

    def fit(self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None) -> "NystroemCrKR":
        """Forget everything and learn from samples; arguments and errors are those of `CrKR.fit`.

        Raises:
            InputError: also if `inducing_points` or `novelty` is out of range.
        """
        samples, labels, costs = checked_samples(X, y, cost)
        scales = checked_length_scales(self.length_scales, samples.shape[1])
        lam = checked_regularization(self.regularization)
        heights = checked_output_scales(self.output_scales, labels.shape[1:])
        m = self._room()
        self.n_features_in_ = samples.shape[1]
        self._scales, self._regularization, self._output_scales = scales, lam, heights
        self._points, self._used = np.zeros((m, samples.shape[1])), 0
        self._factor, self._root = np.eye(m, order="F"), np.eye(m, order="F")
        self.coef_ = np.zeros((m, *labels.shape[1:]))
        self.n_samples_seen_ = 0
        even = np.linspace(0, len(samples) - 1, min(len(samples), CANDIDATES * m)).astype(int)
        self._grown_features(samples[even])
        self._learn(samples, labels, noise_of(costs, lam))
        return self

    def partial_fit(
        self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None
    ) -> "NystroemCrKR":
        """Learn further samples in O(m^2) each; arguments and errors are those of `fit`."""
        if not self.__sklearn_is_fitted__():
            return self.fit(X, y, cost)
        samples, labels, costs = checked_samples(X, y, cost)
        self._require_features(samples)
        if labels.shape[1:] != self.coef_.shape[1:]:
            wanted = self.coef_.shape[1:]
            raise InputError(f"y of shape {labels.shape}: expected rows of {wanted}, as before")
        self._learn(samples, labels, noise_of(costs, self._regularization))
        return self

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:  # noqa: FBT001
        """Return the labels expected at X; arguments and errors are those of `CrKR.predict`."""
        features = self._features(self._queries(X))
        mean = features @ self.coef_
        if not return_std:
            return mean
        unexplained = np.maximum(1.0 - np.sum(features**2, axis=1), 0.0)
        explained = np.sum((features @ self._root) ** 2, axis=1)
        deviation = np.sqrt(unexplained + explained + self._regularization)
        return mean, beside(deviation, mean.ndim) * self._output_scales

    @property
    def inducing_points_(self) -> Float[ndarray, "k m"]:
        """The chosen samples, in the inputs' units."""
        self._require_fitted()
        return self._points[: self._used] * self._scales

    def _room(self) -> int:
        points, novelty = self.inducing_points, self.novelty
        if not isinstance(points, int | np.integer) or points < 1:
            raise InputError(f"inducing_points {points}: expected a whole number, at least 1")
        if not 0.0 < novelty < 1.0:
            raise InputError(f"novelty {novelty}: expected a number between 0 and 1")
        return int(points)

    def _learn(
        self, samples: Float[ndarray, "n d"], labels: ndarray, noise: Float[ndarray, "n"]
    ) -> None:
        for begin in range(0, len(samples), BLOCK):
            part = slice(begin, begin + BLOCK)
            features = self._grown_features(samples[part])
            if len(features) <= FEW:
                for row in zip(features, labels[part], noise[part], strict=True):
                    self._learn_one(*row)
            else:
                self._learn_many(features, labels[part], noise[part])
        self.n_samples_seen_ += len(samples)

    def _features(self, samples: Float[ndarray, "n d"]) -> Float[ndarray, "n m"]:
        """Return phi of every sample; 0 where there is no inducing point yet."""
        kernel = np.zeros((len(self._points), len(samples)), order="F")
        kernel[: self._used] = self._kernel(self._points[: self._used], samples)
        return _solve(self._factor, kernel).T

    def _kernel(
        self, scaled: Float[ndarray, "k d"], samples: Float[ndarray, "n d"]
    ) -> Float[ndarray, "k n"]:
        return gaussian_kernel(scaled, samples / self._scales, np.ones(self.n_features_in_))

    def _grown_features(self, samples: Float[ndarray, "n d"]) -> Float[ndarray, "n m"]:
        """Return phi of every sample, after those that are new have become inducing points."""
        features = self._features(samples)
        left = 1.0 - np.sum(features**2, axis=1)
        while self._used < len(self._points):
            best = int(np.argmax(left))
            if not left[best] > self.novelty:
                break
            row, root, k = features[best].copy(), np.sqrt(left[best]), self._used
            self._points[k] = samples[best] / self._scales
            self._factor[k, :k], self._factor[k, k] = row[:k], root
            self._used += 1
            near = self._kernel(self._points[k : k + 1], samples)[0]
            features[:, k] = (near - features @ row) / root
            left -= features[:, k] ** 2
        return features

    def _learn_one(self, features: Float[ndarray, "m"], label: Any, noise: float) -> None:
        """Learn one sample, by Potter's square root filter."""
        q = self._root.T @ features
        total = noise + q @ q
        gain = self._root @ q
        error = label - features @ self.coef_
        self.coef_ += np.multiply.outer(gain / total, error)
        step = -1.0 / (total + np.sqrt(noise * total))
        self._root = _ADD_OUTER(step, gain, q, a=self._root, overwrite_a=True)

    def _learn_many(
        self, features: Float[ndarray, "n m"], labels: ndarray, noise: Float[ndarray, "n"]
    ) -> None:
        """Learn many samples: S <- S (I + S^T F^T N^-1 F S)^-T/2, w += P F^T N^-1 (y - F w)."""
        white = (features @ self._root) / np.sqrt(noise)[:, None]
        information = np.eye(len(self._root)) + white.T @ white
        factor = cholesky(information, lower=True, check_finite=False)
        self._root = np.asfortranarray(_solve(factor, self._root.T).T)
        error = labels - features @ self.coef_
        pull = features.T @ (error / beside(noise, error.ndim))
        self.coef_ = self.coef_ + self._root @ (self._root.T @ pull)


def _solve(factor: Float[ndarray, "m m"], right: Float[ndarray, "m n"]) -> Float[ndarray, "m n"]:
    """Return L^-1 right."""
    return _SOLVE_TRIANGLE(factor, right, lower=1)[0].reshape(right.shape)
