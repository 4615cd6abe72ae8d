"""Bayesian linear regression with known noise, one observation at a time.

    V = w . phi, w ~ N(0, I / alpha), r = V + N(0, sigma^2)
    q = P phi,  h = c q / (sigma^2 + c phi . q),  w += h (r - w . phi),  P -= h q^T

P is the covariance of w, c the weight of the observation: a fraction c of one counts as an
observation of precision c / sigma^2. The order of the observations does not matter, and the outcome
is that of the whole batch at once, P = (alpha I + F^T C F / sigma^2)^-1, w = P F^T C r / sigma^2.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError


@dataclass(frozen=True, slots=True)
class BayesianLinearRegression:
    """What is known of w."""

    weights: Float[ndarray, "m"]  # mean of w
    covariance: Float[ndarray, "m m"]  # P
    noise_sd: float  # sigma, in units of the target

    @classmethod
    def prior(
        cls, features: int, *, precision: float = 1.0, noise_sd: float = 0.3
    ) -> "BayesianLinearRegression":
        """Return what is known before any observation: w ~ N(0, I / precision).

        Raises:
            InputError: a number that is not positive.
        """
        for name, number in (
            ("features", features),
            ("precision", precision),
            ("noise_sd", noise_sd),
        ):
            if not (np.isfinite(number) and number > 0):
                raise InputError(f"{name} {number}: expected a positive number")
        return cls(np.zeros(features), np.eye(features) / precision, float(noise_sd))

    def update(
        self, features: Float[ndarray, "m"], target: float, weight: float = 1.0
    ) -> "BayesianLinearRegression":
        """Return what is known after one more observation.

        Args:
            features: phi.
            target: r.
            weight: how much of an observation this is, from 0; scales its precision.

        Raises:
            InputError: a number that is not finite, a negative weight, or other features.
        """
        _require_features(features, len(self.weights))
        if not np.isfinite(target):
            raise InputError(f"target {target}: expected a finite number")
        if not (np.isfinite(weight) and weight >= 0.0):
            raise InputError(f"weight {weight}: expected a finite number, not negative")
        q = self.covariance @ features
        gain = q * (weight / (self.noise_sd**2 + weight * (features @ q)))
        weights = self.weights + gain * (target - self.weights @ features)
        covariance = self.covariance - np.outer(gain, q)
        return replace(self, weights=weights, covariance=(covariance + covariance.T) / 2)

    def mean(self, features: Float[ndarray, "*batch m"]) -> Float[ndarray, "*batch"]:
        """Return the expected V at `features`."""
        _require_features(features, len(self.weights))
        return np.asarray(features @ self.weights)

    def variance(self, features: Float[ndarray, "*batch m"]) -> Float[ndarray, "*batch"]:
        """Return how uncertain V itself is at `features`; the noise of a target is not in it."""
        _require_features(features, len(self.weights))
        return np.asarray(np.sum(features @ self.covariance * features, axis=-1))


def _require_features(features: ndarray, expected: int) -> None:
    if features.shape[-1:] != (expected,):
        raise InputError(f"features of shape {features.shape}: expected {expected} of them")
    if not np.isfinite(features).all():
        raise InputError(f"features {features}: expected finite numbers")
