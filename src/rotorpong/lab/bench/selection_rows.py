"""How well rules of selection find the right primitive: rows of `bench learning`.

A toy: ten primitives, a context s of six standard normal numbers, phi = (1, s). Primitive k hits
with the probability 0.4 + 0.3 w_k . s, clipped, w_k a random direction. Nothing is tuned. One trial
draws a context, weights by the rule, and a hit or miss. A rule either picks one primitive, drawn by
its weights, or blends all: then the weighted mean of the probabilities decides. Counted are the
hits of trials 200 to 300.

As the paper's, each primitive starts from one demonstration, a hit of its own: without it, blends
would credit all alike for ever.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.lab.bench.rows import Row
from rotorpong.learning import Mixture, Selection

PRIMITIVES, CONTEXTS = 10, 6
TRIALS, COUNTED = 300, 200
SEEDS, QUICK_SEEDS = 40, 2
COLD = Selection("temperature", temperature=0.1)


@dataclass(frozen=True, slots=True)
class Way:
    """How a learner selects and learns."""

    name: str
    selection: Selection = Selection("paper")  # noqa: RUF009  (immutable)
    blends: bool = False
    misses: bool = True  # learns from them
    shares: bool = True  # credit by responsibility; otherwise all in full


WAYS = (
    Way("one drawn by exp(V), hits only", misses=False),
    Way("one drawn by exp(V)"),
    Way("one drawn by exp(V / 0.1)", COLD),
    Way("greedy", Selection("greedy")),
    Way("Thompson", Selection("thompson")),
    Way("UCB, 1 deviation", Selection("ucb")),
    Way("blend by exp(V), hits only", blends=True, misses=False),
    Way("blend by exp(V / 0.1)", COLD, blends=True),
    Way("blend by exp(V / 0.1), credit in full to all", COLD, blends=True, shares=False),
)


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure: a minute, or a few seconds."""
    seeds = range(QUICK_SEEDS if quick else SEEDS)
    chances = np.mean([_known_rates(seed) for seed in seeds], axis=0)
    found = [
        Row("selection toy, always the best", float(chances[0]), "of trials hit"),
        Row("selection toy, any at random", float(chances[1]), "of trials hit"),
    ]
    for way in WAYS:
        rate = float(np.mean([hits_of(way, seed)[COUNTED:] for seed in seeds]))
        found.append(Row(f"selection toy, {way.name}", rate, "of trials hit"))
    return tuple(found)


def hits_of(way: Way, seed: int) -> Bool[ndarray, "n"]:
    """Return which trials are hits."""
    directions, rng = _toy(seed)
    mixture, hits = _demonstrated(directions, rng), np.zeros(TRIALS, bool)
    for trial in range(TRIALS):
        context = rng.standard_normal(CONTEXTS)
        features, chances = np.append(1.0, context), _chances(directions, context)
        weights = mixture.select(features, way.selection, rng)
        if not way.blends:
            weights = np.eye(PRIMITIVES)[rng.choice(PRIMITIVES, p=weights)]
        hits[trial] = rng.random() < weights @ chances
        if hits[trial] or way.misses:
            credit = weights if way.shares else np.ones(PRIMITIVES)
            mixture = mixture.update(features, float(hits[trial]), credit)
    return hits


def _known_rates(seed: int) -> tuple[float, float]:
    """Return what who knows everything, and who knows nothing, could expect."""
    directions, rng = _toy(seed)
    chances = _chances(directions, rng.standard_normal((2000, CONTEXTS)))
    return float(chances.max(axis=1).mean()), float(chances.mean())


def _demonstrated(directions: Float[ndarray, "k 6"], rng: np.random.Generator) -> Mixture:
    """Return the mixture after one hit of each primitive."""
    mixture = Mixture.prior(PRIMITIVES, CONTEXTS + 1)
    for k, credit in enumerate(np.eye(PRIMITIVES)):
        context = rng.standard_normal(CONTEXTS)
        while rng.random() >= _chances(directions, context)[k]:
            context = rng.standard_normal(CONTEXTS)
        mixture = mixture.update(np.append(1.0, context), 1.0, credit)
    return mixture


def _toy(seed: int) -> tuple[Float[ndarray, "k 6"], np.random.Generator]:
    rng = np.random.default_rng(seed)
    directions = rng.standard_normal((PRIMITIVES, CONTEXTS))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True), rng


def _chances(
    directions: Float[ndarray, "k 6"], context: Float[ndarray, "*batch 6"]
) -> Float[ndarray, "*batch k"]:
    return np.clip(0.4 + 0.3 * context @ directions.T, 0.0, 1.0)
