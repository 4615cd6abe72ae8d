"""How good a player is on the scale from hover, 0, to the oracle, 1, and how sure of it one can be.

With x, h, o in {0, 1} for whether player, hover and oracle hit a ball, means over n balls,

    S = (mean x - mean h) / (mean o - mean h)                                        Eq. (skill)
    e_i = ((x_i - h_i) - S (o_i - h_i)) / (mean o - mean h)
    var S = sum e_i^2 / (n (n - 1))                                                  Eq. (delta)

the delta method for a ratio of means of the same balls: what player, hover and oracle have in
common cancels, and hover's own S is 0 for certain. The score of a suite is the mean of its cells'
S, which are independent, so it weighs them alike; var = sum var S / cells^2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool
from numpy import ndarray

from rotorpong.lab.statistics import CONFIDENCE_95, skill

Hits = Bool[ndarray, "n"]


@dataclass(frozen=True, slots=True)
class Score:
    """A skill, or a mean of several."""

    value: float
    variance: float

    @property
    def interval(self) -> tuple[float, float]:
        """Of 95 %."""
        half = CONFIDENCE_95 * math.sqrt(self.variance)
        return self.value - half, self.value + half

    def as_json(self, name: str) -> dict[str, Any]:
        """Return value and interval under a name."""
        return {name: self.value, f"{name}_interval": self.interval}


def skill_score(player: Hits, hover: Hits, oracle: Hits) -> Score | None:
    """Return the skill on the same balls; None where hover and oracle are no scale.

    Args:
        player: which balls it hit, two at least.
        hover: the same of a drone that only hovers.
        oracle: the same of the oracle.
    """
    x, h, o = (hits.astype(float) for hits in (player, hover, oracle))
    value = skill(float(x.mean()), float(h.mean()), float(o.mean()))
    if value is None:
        return None
    errors = ((x - h) - value * (o - h)) / (o.mean() - h.mean())
    return Score(value, float(np.sum(errors**2)) / (len(x) * (len(x) - 1)))


def mean_score(scores: Sequence[Score | None]) -> Score | None:
    """Return the mean of independent scores; None if one of them is missing."""
    found = [score for score in scores if score is not None]
    if not found or len(found) < len(scores):
        return None
    count = len(found)
    return Score(
        sum(score.value for score in found) / count,
        sum(score.variance for score in found) / count**2,
    )
