"""What every kernel regression has for scikit-learn and for exploring, without needing either."""

# ruff: noqa: N803  (X is scikit-learn's name)

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike

from rotorpong.conventions import InputError
from rotorpong.learning.samples import column, finite, matrix


class KernelRegressor(ABC):
    """Parameters by name, score, exploration; a subclass learns and predicts."""

    PARAMETERS: ClassVar[tuple[str, ...]]  # names of the constructor's arguments
    LEARNT: ClassVar[str]  # an attribute that exists once `fit` was called
    n_features_in_: int

    @abstractmethod
    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:  # noqa: FBT001
        """Return the labels expected at X, and on request their standard deviations."""

    def explore(
        self, X: ArrayLike, rng: np.random.Generator, *, most: ArrayLike | None = None
    ) -> ndarray:
        """Return labels to try at X, drawn from what is believed of a label of cost 1.

            delta ~ N(mean(s), sigma^2 var(s))       Kober's exploration

        Rows and outputs are drawn independently. Where little is known much is tried; never less
        than lambda.

        Args:
            X: inputs, (n, features).
            rng: throws the dice.
            most: how far a label may lie from its mean, one for all outputs or one each, in the
                labels' units; what falls beyond is moved to that bound.

        Raises:
            InputError: not fitted, a number that is not finite, another number of features, or
                a bound that is negative or of another shape.
        """
        mean, deviation = self.predict(X, return_std=True)
        step = deviation * rng.standard_normal(mean.shape)
        if most is not None:
            bound = finite("most", most)
            if bound.shape not in {(), mean.shape[1:]} or (bound < 0.0).any():
                wanted = " or ".join(["1", *map(str, mean.shape[1:])])
                raise InputError(f"most {most}: expected {wanted} numbers, none negative")
            step = np.clip(step, -bound, bound)
        return mean + step

    def score(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        """Return the coefficient of determination R^2, averaged over the outputs."""
        predicted = self.predict(X)
        labels = finite("y", y)
        if labels.shape != predicted.shape:
            raise InputError(f"y of shape {labels.shape}: expected {predicted.shape}")
        weights = column("sample_weight", sample_weight, len(labels))
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
        return {name: getattr(self, name) for name in self.PARAMETERS}

    def set_params(self, **params: Any) -> Any:
        """Change parameters by name; the next `fit` uses them."""
        for name in params:
            if name not in self.PARAMETERS:
                raise InputError(
                    f"parameter {name!r}: expected one of {', '.join(self.PARAMETERS)}"
                )
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
        return hasattr(self, self.LEARNT)

    def __repr__(self) -> str:
        """Return the constructor call."""
        inside = ", ".join(f"{name}={value!r}" for name, value in self.get_params().items())
        return f"{type(self).__name__}({inside})"

    def _require_fitted(self) -> None:
        if not self.__sklearn_is_fitted__():
            raise InputError(f"{type(self).__name__} is not fitted: expected fit(X, y, cost) first")

    def _queries(self, X: ArrayLike) -> Float[ndarray, "n m"]:
        self._require_fitted()
        samples = matrix("X", X)
        self._require_features(samples)
        return samples

    def _require_features(self, samples: Float[ndarray, "n m"]) -> None:
        if samples.shape[1] != self.n_features_in_:
            raise InputError(
                f"X has {samples.shape[1]} features: expected {self.n_features_in_}, as in fit"
            )


def beside(rows: Float[ndarray, "n"], dimensions: int) -> ndarray:
    """Return `rows` shaped to multiply the rows of an array of so many dimensions."""
    return rows.reshape(-1, *[1] * (dimensions - 1))
