"""What became of so many balls: hits, near-hits, and balls on the drone; how far it went for them.

A ball that touches the drone's hull is no near-hit, whatever it missed the blade by: the first
outcome that matches counts. Behind the blade is the hull, so most balls that pass near the blade
end there. They are counted apart, where they missed it by as little as a near-hit does.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS
from rotorpong.drone import Player
from rotorpong.lab.trial import Played, Stage, play_trial
from rotorpong.world._judging_kernels import NEAR_DISTANCE, NEAR_LAG
from rotorpong.world.contact import TICK
from rotorpong.world.racket import HOME_BLADE

KINDS = {
    "hits": "hit_percent",
    "near_hits": "near_hit_percent",
    "near_hulls": "near_hull_percent",
    "hulls": "hull_percent",
}
"""Of a tally's balls, and how their share is called."""
HEADS = {
    "hit_percent": "hits, %",
    "near_hit_percent": "near-hits, %",
    "near_hull_percent": "near, but on the hull, %",
    "hull_percent": "on the hull, %",
}


def tally(stage: Stage, player: Player, balls: int) -> dict[str, Any]:
    """Return how many balls of a stage became what, and sums of squared ways.

    Args:
        stage: where the serves are played; the first ones are.
        player: who plays, without learning.
        balls: how many.
    """
    played = [play_trial(stage, index, player) for index in range(balls)]
    outcomes = [one.outcome for one in played]
    return {
        "balls": balls,
        "hits": outcomes.count("hit"),
        "near_hits": outcomes.count("near_hit"),
        "near_hulls": sum(one.outcome == "hull" and is_near(one) for one in played),
        "hulls": outcomes.count("hull"),
        "moved_m2": math.fsum(moved(one) ** 2 for one in played),
    }


def is_near(played: Played) -> bool:
    """Tell whether a ball missed the blade by as little as a near-hit, wherever it ended."""
    miss, late = played.miss_distance, played.time_error
    return (miss is not None and miss < NEAR_DISTANCE) or (
        late is not None and abs(late) <= NEAR_LAG * TICK
    )


def moved(played: Played) -> float:
    """Return how far the blade had gone, right or left and up or down, when the ball came, m."""
    blade, at = played.truth.blade_path, arrival(played.truth.ball_path)
    return float(np.linalg.norm((blade[at] - blade[0])[1:]))


def arrival(path: Float[ndarray, "n 3"]) -> int:
    """Return the tick at which a ball is at the blade's plane of home, or its path ends before."""
    passed = np.flatnonzero(path[:, 0] < HOME_BLADE[0] + BALL_RADIUS)
    return int(passed[0]) if len(passed) else len(path) - 1


def percent(tallies: Sequence[dict[str, Any]], what: str = "hits") -> float:
    """Return the share of all balls of some tallies, per cent."""
    return 100.0 * sum(one[what] for one in tallies) / sum(one["balls"] for one in tallies)


def spread(values: Sequence[float]) -> dict[str, Any]:
    """Return mean, standard deviation and the mean's standard error; None where one is unknown."""
    several = len(values) > 1
    sd = float(np.std(values, ddof=1)) if several else None
    error = None if sd is None else sd / math.sqrt(len(values))
    return {"mean": float(np.mean(values)), "sd": sd, "error": error}
