"""The mixture of motor primitives: which of them to trust for this ball (section IV.C).

    gamma_k(s, delta) = exp(V_k(s, delta)),  V_k = w_k . phi(s, delta)

V_k is the expected reward of primitive k, by Bayesian linear regression. The motion is the blend of
all primitives with weights gamma_k / sum gamma; each learns the reward of the blend to the extent
that it took part in it.

exp(V) with V between 0 and 1 hardly selects: one of ten whose V is 1 while the others' is 0 gets
23 % of the weight. `Selection` names other rules; "paper" is the one above.

The blend of motions that all end in the same hitting point ends there as well, whatever gamma is.
So gamma cannot move the hitting point, only change the shape of the motion: its swing, peak speed,
and how well a drone follows. What a hit tells about primitives is no more than that. And credit by
the weights themselves teaches primitives that start alike the same: nothing ever sets them apart.
The paper's start from one demonstration each.
"""

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.learning.bayesian import BayesianLinearRegression

Rule = Literal["paper", "temperature", "greedy", "thompson", "ucb"]
RULES: tuple[str, ...] = get_args(Rule)


@dataclass(frozen=True, slots=True)
class Selection:
    """How expected rewards become weights.

    paper: gamma = exp(V). temperature: gamma = exp(V / temperature). The others choose one and
    leave nothing to the rest: greedy the greatest V, ucb the greatest V + deviations sd(V),
    thompson the greatest of V drawn from what is believed. Among equals the first is chosen.
    """

    rule: str = "paper"  # one of RULES
    temperature: float = 1.0  # of rule temperature, in units of the reward
    deviations: float = 1.0  # of rule ucb

    def __post_init__(self) -> None:
        """Check that the rule exists and its numbers have a meaning."""
        if self.rule not in RULES:
            known = ", ".join(RULES)
            raise InputError(f"selection {self.rule!r}: expected one of {known}")
        if not (np.isfinite(self.temperature) and self.temperature > 0.0):
            raise InputError(f"temperature {self.temperature}: expected a positive number")
        if not (np.isfinite(self.deviations) and self.deviations >= 0.0):
            raise InputError(f"deviations {self.deviations}: expected a number, not negative")


PAPER = Selection()


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
        """Return gamma_k / sum gamma, the paper's; each row sums to 1."""
        return _normalised(self.values(features), temperature=1.0)

    def select(
        self,
        features: Float[ndarray, "*batch m"],
        selection: Selection = PAPER,
        rng: np.random.Generator | None = None,
    ) -> Float[ndarray, "*batch k"]:
        """Return the weight of each primitive by a rule; each row sums to 1.

        Args:
            features: phi of the serve, or of many.
            selection: the rule.
            rng: throws the dice of rule thompson, once for all rows.

        Raises:
            InputError: other features, or thompson without `rng`.
        """
        match selection.rule:
            case "paper":
                return self.weights(features)
            case "temperature":
                return _normalised(self.values(features), temperature=selection.temperature)
            case "greedy":
                return _greatest(self.values(features))
            case "ucb":
                bounds = [r.upper(features, selection.deviations) for r in self.regressions]
                return _greatest(np.stack(bounds, axis=-1))
            case _:
                return _greatest(self._drawn_values(features, rng))

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

    def forget(self, keep: float) -> "Mixture":
        """Return the mixture when past rewards count `keep` times what they did."""
        return Mixture(tuple(value.forget(keep) for value in self.regressions))

    def _drawn_values(
        self, features: Float[ndarray, "*batch m"], rng: np.random.Generator | None
    ) -> Float[ndarray, "*batch k"]:
        if rng is None:
            raise InputError("selection 'thompson' without rng: expected a generator")
        drawn = [replace(value, weights=value.sample(rng)) for value in self.regressions]
        return Mixture(tuple(drawn)).values(features)


def _normalised(
    values: Float[ndarray, "*batch k"], *, temperature: float
) -> Float[ndarray, "*batch k"]:
    shifted = values - values.max(axis=-1, keepdims=True)  # the sum cancels the shift
    gamma = np.exp(shifted / temperature)
    return gamma / gamma.sum(axis=-1, keepdims=True)


def _greatest(values: Float[ndarray, "*batch k"]) -> Float[ndarray, "*batch k"]:
    """Return 1 for the first of the greatest values in each row, 0 for the others."""
    return np.eye(values.shape[-1])[np.argmax(values, axis=-1)]
