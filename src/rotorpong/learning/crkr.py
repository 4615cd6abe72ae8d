"""Cost-regularised kernel regression: where, how fast and when to hit.

    delta_i(s) = k(s)^T (K + lambda C)^-1 Delta_i                           Eq. (6)
    var(s) = k(s, s) + lambda - k(s)^T (K + lambda C)^-1 k(s)
    k(a, b) = exp(-|a - b|^2 / 2), distances in length scales

C is the diagonal of the samples' costs: a cheap sample binds the estimate, a costly one may be
ignored. This is the mean of a Gaussian process whose sample n carries noise of variance
lambda c_n; var is that of a new label of cost 1 (Kober's exploration), the process' own variance
plus lambda.

Bare Eq. (6): nothing is centred or scaled, the estimate falls to zero far from all samples. The
Cholesky factor L of K + lambda C is kept together with L^-1 Delta, so a further sample costs
O(N^2); its buffer grows by doubling, in Fortran order, where LAPACK solves without a copy.
"""

# ruff: noqa: N803  (X is scikit-learn's name)

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, cholesky, get_lapack_funcs

from rotorpong.conventions import InputError
from rotorpong.learning.regressor import KernelRegressor, beside
from rotorpong.learning.samples import (
    checked_length_scales,
    checked_output_scales,
    checked_regularization,
    checked_samples,
    factorised,
    gaussian_kernel,
    noise_of,
)

SMALLEST_PIVOT = 1e-12  # an appended row with less left than this calls for a new factor
_SOLVE_TRIANGLE: Any = get_lapack_funcs("trtrs", dtype=np.float64)
_INVERT_TRIANGLE: Any = get_lapack_funcs("trtri", dtype=np.float64)


class CrKR(KernelRegressor):
    """Cost-regularised kernel regression with scikit-learn's conventions.

    It fits into scikit-learn's Pipeline, clone and cross_val_score without needing scikit-learn.

    Attributes:
        n_features_in_: inputs per sample, once fitted.
        X_: samples, (n, features).
        y_: labels, (n,) or (n, outputs), as they were given.
        cost_: costs, (n,).
        dual_coef_: (K + lambda C)^-1 y, of the shape of `y_`.
        jitter_: what had to be added to the noise for the factor to exist; 0 as a rule.
    """

    PARAMETERS = ("length_scales", "regularization", "output_scales")
    LEARNT = "dual_coef_"

    def __init__(
        self,
        length_scales: ArrayLike = 1.0,
        regularization: float = 1.0,
        output_scales: ArrayLike = 1.0,
    ) -> None:
        """Keep the parameters; they are checked by `fit`, as scikit-learn does.

        Args:
            length_scales: one for all inputs or one per input, in the inputs' units.
            regularization: lambda, the variance of the noise of a sample of cost 1.
            output_scales: standard deviation of the labels where nothing is known, one for all
                outputs or one each; scales the deviations, never the estimate.
        """
        self.length_scales = length_scales
        self.regularization = regularization
        self.output_scales = output_scales

    def fit(self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None) -> "CrKR":
        """Forget everything and learn from samples X (n, features), labels y, costs (n,).

        Args:
            X: inputs s, one row per sample.
            y: labels delta, (n,) or (n, outputs).
            cost: c, not negative; 1 each by default.

        Raises:
            InputError: no samples, a number that is not finite, shapes that do not agree, a
                negative cost or a parameter out of range.
        """
        samples, labels, costs = checked_samples(X, y, cost)
        scales = checked_length_scales(self.length_scales, samples.shape[1])
        lam = checked_regularization(self.regularization)
        heights = checked_output_scales(self.output_scales, labels.shape[1:])
        self.n_features_in_ = samples.shape[1]
        self.X_, self.y_, self.cost_ = samples, labels, costs
        self._scales, self._regularization, self._output_scales = scales, lam, heights
        self._refit()
        return self

    def partial_fit(self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None) -> "CrKR":
        """Learn further samples with the parameters of the last `fit`, in O(N^2) each.

        The outcome is that of one `fit` to all samples. Arguments and errors are those of `fit`.
        """
        if not self.__sklearn_is_fitted__():
            return self.fit(X, y, cost)
        samples, labels, costs = checked_samples(X, y, cost)
        self.require_alike(samples, labels)
        old = len(self.X_)
        self.X_ = np.concatenate([self.X_, samples])
        self.y_ = np.concatenate([self.y_, labels])
        self.cost_ = np.concatenate([self.cost_, costs])
        if not self._append(old):
            self._refit()
        self._solve_back()
        return self

    def require_alike(self, samples: Float[ndarray, "n m"], labels: ndarray) -> None:
        """Raise InputError unless samples and labels have the shapes of those of the last `fit`."""
        self._require_features(samples)
        if labels.shape[1:] != self.y_.shape[1:]:
            raise InputError(
                f"y of shape {labels.shape}: expected rows of shape {self.y_.shape[1:]}, as before"
            )

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:  # noqa: FBT001
        """Return the labels expected at X, (n,) or (n, outputs).

        Args:
            X: inputs, (n, features).
            return_std: also return the standard deviation of a label of cost 1, of the same shape
                as the labels: output scale times sqrt of the Gaussian process' variance + lambda.

        Raises:
            InputError: not fitted, a number that is not finite, or another number of features.
        """
        samples = self._queries(X)
        kernel = gaussian_kernel(samples, self.X_, self._scales)
        mean = kernel @ self.dual_coef_
        if not return_std:
            return mean
        explained = np.sum(self._forward(kernel.T) ** 2, axis=0)
        deviation = np.sqrt(np.maximum(1.0 - explained, 0.0) + self._regularization)
        return mean, beside(deviation, mean.ndim) * self._output_scales

    def leave_one_out(self) -> Float[ndarray, "n *k"]:
        """Return what each label differs by from the estimate of all other samples, as `y_`.

        In closed form, dual_coef / diag (K + lambda C)^-1: no sample is learnt again. Its mean
        square tells how well a choice of parameters generalises. O(N^3).

        Raises:
            InputError: not fitted.
        """
        self._require_fitted()
        inverse = _INVERT_TRIANGLE(self._factor[: len(self.X_), : len(self.X_)], lower=1)[0]
        precision = np.sum(np.square(inverse, out=inverse), axis=0)
        return self.dual_coef_ / beside(precision, self.y_.ndim)

    def log_marginal_likelihood(self) -> float:
        """Return log p(y) of what was learnt, summed over the outputs.

        y_j ~ N(0, sigma_j^2 (K + lambda C)) with the output scales sigma. Outputs of scale 0 are
        left out.

        Raises:
            InputError: not fitted.
        """
        self._require_fitted()
        n = len(self.X_)
        variances = np.atleast_1d(self._output_scales) ** 2
        some = variances > 0.0
        squares = np.atleast_1d(np.sum(self._whitened**2, axis=0))[some] / variances[some]
        half_log_det = np.sum(np.log(np.diag(self._factor)[:n]))
        constant = n * np.log(2.0 * np.pi * variances[some])
        return float(-0.5 * np.sum(squares + constant) - np.sum(some) * half_log_det)

    def _refit(self) -> None:
        noise = noise_of(self.cost_, self._regularization)
        factor, self.jitter_ = factorised(gaussian_kernel(self.X_, self.X_, self._scales), noise)
        self._factor = np.asfortranarray(factor)
        self._whitened = self._forward(self.y_)
        self._solve_back()

    def _append(self, old: int) -> bool:
        """Grow the factor by the samples from `old` on; say whether it went well."""
        fresh = self.X_[old:]
        cross = self._forward(gaussian_kernel(self.X_[:old], fresh, self._scales))
        noise = noise_of(self.cost_[old:], self._regularization) + self.jitter_
        block = gaussian_kernel(fresh, fresh, self._scales) + np.diag(noise)
        try:
            corner = cholesky(block - cross.T @ cross, lower=True, check_finite=False)
        except LinAlgError:
            return False
        if np.min(np.diag(corner)) ** 2 <= SMALLEST_PIVOT:
            return False
        total = len(self.X_)
        if total > len(self._factor):
            larger = np.zeros((2 * total, 2 * total), order="F")
            larger[:old, :old] = self._factor[:old, :old]
            self._factor = larger
        self._factor[old:total, :old] = cross.T
        self._factor[old:total, old:total] = corner
        rest = self.y_[old:] - cross.T @ self._whitened
        self._whitened = np.concatenate([self._whitened, _SOLVE_TRIANGLE(corner, rest, lower=1)[0]])
        return True

    def _forward(self, right: Float[ndarray, "n *m"]) -> Float[ndarray, "n *m"]:
        """Return L^-1 right."""
        solved = _SOLVE_TRIANGLE(self._factor[:, : len(right)], right, lower=1)[0]
        return solved.reshape(right.shape)

    def _solve_back(self) -> None:
        factor = self._factor[:, : len(self._whitened)]
        solved = _SOLVE_TRIANGLE(factor, self._whitened, lower=1, trans=1)[0]
        self.dual_coef_ = solved.reshape(self.y_.shape)
