"""Bayesian linear regression with known noise, one observation at a time.

    V = w . phi, w ~ N(0, I / alpha), r = V + N(0, sigma^2)
    q = P phi,  h = c q / (sigma^2 + c phi . q),  w += h (r - w . phi),  P -= h q^T

P is the covariance of w, c the weight of the observation: a fraction c of one counts as an
observation of precision c / sigma^2. The order of the observations does not matter, and the outcome
is that of the whole batch at once, P = (alpha I + F^T C F / sigma^2)^-1, w = P F^T C r / sigma^2.

Where w drifts, old observations are forgotten before each new one:

    P^-1 <- rho P^-1 + (1 - rho) alpha I,    P^-1 w <- rho P^-1 w

The usual P <- P / rho winds up: what is not observed for long becomes ever less certain, without
bound, and the next observation of it throws w anywhere. Here P never exceeds the prior I / alpha.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import cho_factor, cho_solve

from rotorpong.conventions import InputError


@dataclass(frozen=True, slots=True)
class BayesianLinearRegression:
    """What is known of w."""

    weights: Float[ndarray, "m"]  # mean of w
    covariance: Float[ndarray, "m m"]  # P
    noise_sd: float  # sigma, in units of the target
    prior_precision: float = 1.0  # alpha, what forgetting leads back to

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
        return cls(
            np.zeros(features), np.eye(features) / precision, float(noise_sd), float(precision)
        )

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
        self._require_observation(features, target, weight)
        q = self.covariance @ features
        gain = q * (weight / (self.noise_sd**2 + weight * (features @ q)))
        weights = self.weights + gain * (target - self.weights @ features)
        covariance = self.covariance - np.outer(gain, q)
        return replace(self, weights=weights, covariance=(covariance + covariance.T) / 2)

    def forget(self, keep: float) -> "BayesianLinearRegression":
        """Return what is still known when past observations count `keep` times what they did.

        Args:
            keep: rho, above 0; 1 forgets nothing.

        Raises:
            InputError: `keep` is not in (0, 1].
        """
        if not 0.0 < keep <= 1.0:
            raise InputError(f"keep {keep}: expected a number above 0, at most 1")
        if keep == 1.0:
            return self
        identity = np.eye(len(self.weights))
        information = keep * cho_solve(cho_factor(self.covariance), identity)
        pull = information @ self.weights
        factor = cho_factor(information + (1.0 - keep) * self.prior_precision * identity)
        covariance = cho_solve(factor, identity)
        weights = cho_solve(factor, pull)
        return replace(self, weights=weights, covariance=(covariance + covariance.T) / 2)

    def mean(self, features: Float[ndarray, "*batch m"]) -> Float[ndarray, "*batch"]:
        """Return the expected V at `features`."""
        _require_features(features, len(self.weights))
        return np.asarray(features @ self.weights)

    def variance(self, features: Float[ndarray, "*batch m"]) -> Float[ndarray, "*batch"]:
        """Return how uncertain V itself is at `features`; the noise of a target is not in it."""
        _require_features(features, len(self.weights))
        return np.asarray(np.sum(features @ self.covariance * features, axis=-1))

    def upper(
        self, features: Float[ndarray, "*batch m"], deviations: float = 1.0
    ) -> Float[ndarray, "*batch"]:
        """Return an upper confidence bound of V: its mean plus so many standard deviations."""
        if not np.isfinite(deviations):
            raise InputError(f"deviations {deviations}: expected a finite number")
        spread = np.sqrt(np.maximum(self.variance(features), 0.0))
        return np.asarray(self.mean(features) + deviations * spread)

    def sample(self, rng: np.random.Generator) -> Float[ndarray, "m"]:
        """Return weights drawn from what is known of w (Thompson)."""
        variances, axes = np.linalg.eigh(self.covariance)
        spread = np.sqrt(np.maximum(variances, 0.0))
        return self.weights + axes @ (spread * rng.standard_normal(len(spread)))

    def log_likelihood(
        self, features: Float[ndarray, "m"], target: float, weight: float = 1.0
    ) -> float:
        """Return the log density of a target that is still to come.

        Summed over observations, each before it is learnt, it is their log marginal likelihood
        (the evidence), by which noise and prior can be chosen. Arguments and errors as of `update`.
        """
        self._require_observation(features, target, weight)
        if weight == 0.0:
            return 0.0
        variance = self.noise_sd**2 / weight + self.variance(features)
        error = target - self.mean(features)
        return float(-0.5 * (np.log(2.0 * np.pi * variance) + error**2 / variance))

    def _require_observation(
        self, features: Float[ndarray, "m"], target: float, weight: float
    ) -> None:
        _require_features(features, len(self.weights))
        if not np.isfinite(target):
            raise InputError(f"target {target}: expected a finite number")
        if not (np.isfinite(weight) and weight >= 0.0):
            raise InputError(f"weight {weight}: expected a finite number, not negative")


def _require_features(features: ndarray, expected: int) -> None:
    if features.shape[-1:] != (expected,):
        raise InputError(f"features of shape {features.shape}: expected {expected} of them")
    if not np.isfinite(features).all():
        raise InputError(f"features {features}: expected finite numbers")
