"""What became of balls that one player and another met alike: shares, and who hit what.

The balls of an evaluation depend on serves, seed and number alone, so players of two specs that
differ in nothing else meet the same. Which of two is better is then told by the balls that one hit
and the other missed, by McNemar's exact test; it compares these players as they stand, after one
training each, not the ways in which they came to be.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rotorpong.lab.comparison import paired
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import wilson_interval
from rotorpong.lab.train import knowledge_of

UNLIKELY = 0.05  # p-value below which two players are called different


def outcomes(spec: Spec, balls: int, *runs: Path) -> dict[str, Any]:
    """Return what became of each ball, which of them are reachable, and what training took.

    Args:
        spec: who plays what.
        balls: how many.
        runs: experience file of one training run; none: the shipped demonstrations.
    """
    known = knowledge_of(runs[0])[1] if runs else None
    results = evaluate(spec, balls, knowledge=known)
    return {
        "outcomes": [result.outcome for result in results],
        "reachable": [result.reachable for result in results],
        "training_balls": len(known.trials) if known else None,
        "training_hits": sum(trial.outcome == "hit" for trial in known.trials) if known else None,
    }


def shares(played: dict[str, Any]) -> dict[str, Any]:
    """Return per cent of hits, with Wilson's 95 % interval, near-hits and reachable balls.

    And the numbers of what `outcomes` returned that are no shares.
    """
    kinds: Sequence[str] = played["outcomes"]
    balls, hits = len(kinds), kinds.count("hit")
    low, high = wilson_interval(hits, balls) or (0.0, 1.0)
    return {
        "balls": balls,
        "hits": hits,
        "hit_percent": 100.0 * hits / balls,
        "hit_percent_interval": [100.0 * low, 100.0 * high],
        "near_hit_percent": 100.0 * kinds.count("near_hit") / balls,
        "reachable_percent": 100.0 * sum(played["reachable"]) / balls,
        "training_balls": played["training_balls"],
        "training_hits": played["training_hits"],
    }


def gained(ours: dict[str, Any], theirs: dict[str, Any]) -> dict[str, Any]:
    """Return which balls only the one or the other hit, points of difference, and McNemar's p."""
    hits = [[kind == "hit" for kind in played["outcomes"]] for played in (ours, theirs)]
    found = paired(*hits)
    points = 100.0 * (found["won"] - found["lost"]) / len(hits[0])
    return {"points": points, **found}


def pooled(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what several runs of `outcomes` come to, balls one after another."""
    whole = {what: [one for run in runs for one in run[what]] for what in ("outcomes", "reachable")}
    trained = all(run["training_balls"] is not None for run in runs)
    return {
        **whole,
        **{
            what: sum(run[what] for run in runs) if trained else None
            for what in ("training_balls", "training_hits")
        },
    }


def chance(p_value: float) -> str:
    """Return a p-value as it is written in a sentence."""
    return f"p = {p_value:.2g}" if p_value >= 1e-3 else "p < 0.001"
