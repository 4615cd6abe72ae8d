"""CrKR that is tuned anew while it learns.

The parameters in force after n samples are those that `tune` finds for the first m of them, m the
greatest of 10, 15, 22, 33, ... that is not above n; the samples after m are added one by one. So
all depends on the samples and their order alone, to the last bit, and not on when somebody asked.
"""

# ruff: noqa: N803  (X is scikit-learn's name)

from typing import Any

from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike

from rotorpong.learning.crkr import CrKR
from rotorpong.learning.regressor import KernelRegressor
from rotorpong.learning.samples import checked_samples
from rotorpong.learning.tuning import tune

FIRST = 10  # samples, for a first tuning
GROWTH = 1.5  # times as many, for the next


class SelfTuningCrKR(KernelRegressor):
    """CrKR with length scales, regularization and output scales of its own finding.

    Attributes:
        n_features_in_: inputs per sample, once fitted.
    """

    PARAMETERS = ("length_scales", "regularization")
    LEARNT = "n_features_in_"

    def __init__(self, length_scales: ArrayLike = 1.0, regularization: float = 1.0) -> None:
        """Keep the parameters that are in force while there are fewer than 10 samples."""
        self.length_scales = length_scales
        self.regularization = regularization

    def fit(self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None) -> "SelfTuningCrKR":
        """Forget everything and learn; arguments and errors are those of `CrKR.fit`."""
        self._crkr = CrKR(self.length_scales, self.regularization).fit(X, y, cost)
        self._tuned_with = 0
        self.n_features_in_ = self._crkr.n_features_in_
        return self

    def partial_fit(
        self, X: ArrayLike, y: ArrayLike, cost: ArrayLike | None = None
    ) -> "SelfTuningCrKR":
        """Learn further samples; arguments and errors are those of `CrKR.partial_fit`."""
        if not self.__sklearn_is_fitted__():
            return self.fit(X, y, cost)
        samples, labels, costs = checked_samples(X, y, cost)
        self._crkr.require_alike(samples, labels)
        _add(self._crkr, samples, labels, costs)
        return self

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:  # noqa: FBT001
        """Return the labels expected at X; arguments and errors are those of `CrKR.predict`."""
        return self.tuned().predict(X, return_std)

    def tuned(self) -> CrKR:
        """Return the estimator in force, tuned as far as the samples allow.

        Raises:
            InputError: not fitted.
        """
        self._require_fitted()
        crkr, due = self._crkr, _due(len(self._crkr.X_))
        if due > self._tuned_with:
            found = tune(crkr.X_[:due], crkr.y_[:due], crkr.cost_[:due])
            self._crkr = found.crkr().fit(crkr.X_[:due], crkr.y_[:due], crkr.cost_[:due])
            _add(self._crkr, crkr.X_[due:], crkr.y_[due:], crkr.cost_[due:])
            self._tuned_with = due
        return self._crkr


def _add(
    crkr: CrKR, samples: Float[ndarray, "n m"], labels: ndarray, costs: Float[ndarray, "n"]
) -> None:
    for i in range(len(samples)):
        crkr.partial_fit(samples[i : i + 1], labels[i : i + 1], costs[i : i + 1])


def _due(samples: int) -> int:
    """Return with how many samples the parameters in force were found; 0 if untuned."""
    due, following = 0, FIRST
    while following <= samples:
        due, following = following, int(GROWTH * following)
    return due
