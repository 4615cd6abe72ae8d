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
from scipy.spatial.distance import cdist

from rotorpong.conventions import InputError

NOISE_FLOOR = 1e-10  # least lambda c_n: duplicated samples still factorise at N = 2000
SMALLEST_PIVOT = 1e-12  # an appended row with less left than this calls for a new factor
JITTERS = (0.0, *(10.0**k for k in range(-9, 1)))  # added to the noise until it factorises
_SOLVE_TRIANGLE: Any = get_lapack_funcs("trtrs", dtype=np.float64)
PARAMETERS = ("length_scales", "regularization")


class CrKR:
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

    def __init__(self, length_scales: ArrayLike = 1.0, regularization: float = 1.0) -> None:
        """Keep the parameters; they are checked by `fit`, as scikit-learn does.

        Args:
            length_scales: one for all inputs or one per input, in the inputs' units.
            regularization: lambda, the variance of the noise of a sample of cost 1.
        """
        self.length_scales = length_scales
        self.regularization = regularization

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
        samples, labels, costs = _samples(X, y, cost)
        scales = _length_scales(self.length_scales, samples.shape[1])
        regularization = _regularization(self.regularization)
        self.n_features_in_ = samples.shape[1]
        self.X_, self.y_, self.cost_ = samples, labels, costs
        self._scales, self._regularization = scales, regularization
        self._refit()
        return self

    def partial_fit(self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None) -> "CrKR":
        """Learn further samples with the parameters of the last `fit`, in O(N^2) each.

        The outcome is that of one `fit` to all samples. Arguments and errors are those of `fit`.
        """
        if not hasattr(self, "dual_coef_"):
            return self.fit(X, y, cost)
        samples, labels, costs = _samples(X, y, cost)
        self._require_features(samples)
        if labels.shape[1:] != self.y_.shape[1:]:
            raise InputError(
                f"y of shape {labels.shape}: expected rows of shape {self.y_.shape[1:]}, as before"
            )
        old = len(self.X_)
        self.X_ = np.concatenate([self.X_, samples])
        self.y_ = np.concatenate([self.y_, labels])
        self.cost_ = np.concatenate([self.cost_, costs])
        if not self._append(old):
            self._refit()
        self._solve_back()
        return self

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:  # noqa: FBT001
        """Return the labels expected at X, (n,) or (n, outputs).

        Args:
            X: inputs, (n, features).
            return_std: also return the standard deviation of a label of cost 1, of the same shape
                as the labels: sqrt of the Gaussian process' variance + lambda.

        Raises:
            InputError: not fitted, a number that is not finite, or another number of features.
        """
        if not hasattr(self, "dual_coef_"):
            raise InputError("CrKR is not fitted: expected fit(X, y, cost) before predict")
        samples = _matrix("X", X)
        self._require_features(samples)
        kernel = _kernel(samples, self.X_, self._scales)
        mean = kernel @ self.dual_coef_
        if not return_std:
            return mean
        explained = np.sum(self._forward(kernel.T) ** 2, axis=0)
        deviation = np.sqrt(np.maximum(1.0 - explained, 0.0) + self._regularization)
        return mean, np.broadcast_to(deviation.reshape(-1, *[1] * (mean.ndim - 1)), mean.shape)

    def score(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        """Return the coefficient of determination R^2, averaged over the outputs."""
        predicted = self.predict(X)
        labels = _finite("y", y)
        if labels.shape != predicted.shape:
            raise InputError(f"y of shape {labels.shape}: expected {predicted.shape}")
        weights = _column("sample_weight", sample_weight, len(labels))
        if not weights.any():
            raise InputError("score of nothing: expected samples of positive weight")
        center = np.average(labels, axis=0, weights=weights)
        missed = weights @ (labels - predicted) ** 2
        spread = weights @ (labels - center) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            scores = np.where(spread > 0.0, 1.0 - missed / spread, np.where(missed > 0.0, 0.0, 1.0))
        return float(np.mean(scores))

    def get_params(self, deep: bool = True) -> dict[str, Any]:  # noqa: FBT001
        """Return the parameters by name; `deep` is scikit-learn's and changes nothing."""
        return {name: getattr(self, name) for name in PARAMETERS}

    def set_params(self, **params: Any) -> "CrKR":
        """Change parameters by name; the next `fit` uses them."""
        for name in params:
            if name not in PARAMETERS:
                raise InputError(f"parameter {name!r}: expected one of {', '.join(PARAMETERS)}")
        for name, value in params.items():
            setattr(self, name, value)
        return self

    def __sklearn_tags__(self) -> Any:
        """Tell scikit-learn that this is a regressor; imported only when it asks."""
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True, multi_output=True),
            regressor_tags=RegressorTags(),
            input_tags=InputTags(),
        )

    def __sklearn_is_fitted__(self) -> bool:
        """Tell scikit-learn whether `fit` has been called."""
        return hasattr(self, "dual_coef_")

    def __repr__(self) -> str:
        """Return the constructor call."""
        inside = ", ".join(f"{name}={value!r}" for name, value in self.get_params().items())
        return f"CrKR({inside})"

    def _require_features(self, samples: Float[ndarray, "n m"]) -> None:
        if samples.shape[1] != self.n_features_in_:
            raise InputError(
                f"X has {samples.shape[1]} features: expected {self.n_features_in_}, as in fit"
            )

    def _noise(self, start: int) -> Float[ndarray, "n"]:
        return np.maximum(self._regularization * self.cost_[start:], NOISE_FLOOR) + self.jitter_

    def _refit(self) -> None:
        kernel = _kernel(self.X_, self.X_, self._scales)
        for jitter in JITTERS:
            self.jitter_ = jitter
            try:
                factor = cholesky(kernel + np.diag(self._noise(0)), lower=True, check_finite=False)
            except LinAlgError:
                continue
            self._factor = np.asfortranarray(factor)
            self._whitened = self._forward(self.y_)
            self._solve_back()
            return
        raise InputError(f"{len(kernel)} samples: their kernel has no Cholesky factor")

    def _append(self, old: int) -> bool:
        """Grow the factor by the samples from `old` on; say whether it went well."""
        fresh = self.X_[old:]
        cross = self._forward(_kernel(self.X_[:old], fresh, self._scales))
        block = _kernel(fresh, fresh, self._scales) + np.diag(self._noise(old))
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


def _kernel(
    a: Float[ndarray, "n m"], b: Float[ndarray, "k m"], length_scales: Float[ndarray, "m"]
) -> Float[ndarray, "n k"]:
    return np.exp(-0.5 * cdist(a / length_scales, b / length_scales, "sqeuclidean"))


def _samples(
    X: ArrayLike, y: ArrayLike, cost: ArrayLike | None
) -> tuple[Float[ndarray, "n m"], Float[ndarray, "n *k"], Float[ndarray, "n"]]:
    samples, labels = _matrix("X", X), _finite("y", y)
    if not len(samples):
        raise InputError("X has no samples: expected at least one")
    if labels.ndim not in (1, 2) or len(labels) != len(samples) or labels.size == 0:
        raise InputError(
            f"y of shape {labels.shape}: expected ({len(samples)},) or ({len(samples)}, outputs)"
        )
    return samples, labels, _column("cost", cost, len(samples))


def _matrix(name: str, values: ArrayLike) -> Float[ndarray, "n m"]:
    array = _finite(name, values)
    if array.ndim != 2 or array.shape[1] == 0:
        raise InputError(f"{name} of shape {array.shape}: expected (samples, features)")
    return array


def _column(name: str, values: ArrayLike | None, n: int) -> Float[ndarray, "n"]:
    if values is None:
        return np.ones(n)
    array = _finite(name, values)
    if array.shape != (n,):
        raise InputError(f"{name} of shape {array.shape}: expected ({n},), one per sample")
    if (array < 0.0).any():
        raise InputError(f"{name} {array.min()}: expected none negative")
    return array


def _finite(name: str, values: ArrayLike) -> ndarray:
    try:
        given = np.asarray(values)
        array = given.astype(float, casting="unsafe" if given.dtype == object else "same_kind")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers ({error})") from error
    if not np.isfinite(array).all():
        raise InputError(f"{name}: {(~np.isfinite(array)).sum()} not finite, expected none")
    return array


def _length_scales(values: ArrayLike, features: int) -> Float[ndarray, "m"]:
    scales = _finite("length_scales", values)
    if scales.shape not in ((), (features,)) or not (scales > 0.0).all():
        raise InputError(f"length_scales {values}: expected 1 or {features} positive numbers")
    return np.broadcast_to(scales, (features,))


def _regularization(value: float) -> float:
    number = _finite("regularization", value)
    if number.shape != () or number < 0.0:
        raise InputError(f"regularization {value}: expected a number, not negative")
    return float(number)
