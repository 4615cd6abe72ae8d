"""The mixture of motor primitives: which of them to trust for this ball (section IV.C).

    gamma_k(s, delta) = exp(V_k(s, delta)),  V_k = w_k . phi(s, delta)

V_k is the expected reward of primitive k, by Bayesian linear regression. The motion is the blend of
all primitives with weights gamma_k / sum gamma; each learns the reward of the blend to the extent
that it took part in it.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.learning.bayesian import BayesianLinearRegression


@dataclass(frozen=True, slots=True)
class Mixture:
    """One regression per primitive."""

    regressions: tuple[BayesianLinearRegression, ...]

    @classmethod
    def prior(
        cls, primitives: int, features: int, *, precision: float = 1.0, noise_sd: float = 0.3
    ) -> "Mixture":
        """Return the mixture before any reward: all primitives weigh the same.

        Raises:
            InputError: a number that is not positive.
        """
        if primitives < 1:
            raise InputError(f"primitives {primitives}: expected at least 1")
        value = BayesianLinearRegression.prior(features, precision=precision, noise_sd=noise_sd)
        return cls((value,) * primitives)

    def values(self, features: Float[ndarray, "*batch m"]) -> Float[ndarray, "*batch k"]:
        """Return the expected reward V of each primitive."""
        return np.stack([value.mean(features) for value in self.regressions], axis=-1)

    def weights(self, features: Float[ndarray, "*batch m"]) -> Float[ndarray, "*batch k"]:
        """Return gamma_k / sum gamma; each row sums to 1."""
        values = self.values(features)
        gamma = np.exp(values - values.max(axis=-1, keepdims=True))  # the sum cancels the shift
        return gamma / gamma.sum(axis=-1, keepdims=True)

    def update(
        self, features: Float[ndarray, "m"], reward: float, credit: Float[ndarray, "k"]
    ) -> "Mixture":
        """Return the mixture after one more reward.

        Args:
            features: phi of the serve.
            reward: r of the motion.
            credit: how much of the observation each primitive takes, from 0; the weights it was
                blended with, or 1 for the one that was chosen and 0 for the rest.

        Raises:
            InputError: another number of credits or features, a negative credit, a number that is
                not finite.
        """
        if len(credit) != len(self.regressions):
            raise InputError(
                f"{len(credit)} credits: expected {len(self.regressions)}, one per primitive"
            )
        pairs = zip(self.regressions, credit, strict=True)
        return Mixture(tuple(value.update(features, reward, part) for value, part in pairs))
