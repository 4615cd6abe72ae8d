"""How good is a player: a fixed number of serves, in one process or several, never learning.

Trials share nothing, so any number of workers gives the same results in the same order.
"""

from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rotorpong import __version__
from rotorpong.drone import Outcome, Player
from rotorpong.experience import Demonstration, Trial, shipped_demonstrations
from rotorpong.lab.control_settings import PAPERS_CONTROL
from rotorpong.lab.demonstrate import Progress, lessons_of
from rotorpong.lab.learners import Learner, learner_of, settings_of
from rotorpong.lab.oracle import Gate, Oracle
from rotorpong.lab.player_settings import DECIDING_ONCE
from rotorpong.lab.reachable import is_reachable
from rotorpong.lab.spec import Spec, own_player
from rotorpong.lab.statistics import rate, wilson_interval
from rotorpong.lab.trial import Controls, new_drone, play_trial, stage_of
from rotorpong.lab.workers import in_workers
from rotorpong.play.hover import Hover
from rotorpong.play.nearest import NearestPlayer

CHUNK = 10  # trials that a worker takes at once


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What a player starts from: demonstrations, and the hits of a training run."""

    demonstrations: tuple[Demonstration, ...]
    trials: tuple[Trial, ...] = ()


@dataclass(frozen=True, slots=True)
class Result:
    """One trial, as the outside contract names it."""

    index: int
    outcome: Outcome
    miss_distance: float | None  # m, 0 for a hit; None: the player broke off
    time_error: float | None  # s
    landing_x: float | None  # m
    reachable: bool = field(kw_only=True)  # by anybody

    def as_json(self) -> dict[str, Any]:
        """Return the trial as `evaluate --json` prints it."""
        return {
            "index": self.index,
            "outcome": self.outcome,
            "reachable": self.reachable,
            "miss_distance_m": self.miss_distance,
            "time_error_s": self.time_error,
            "landing_x_m": self.landing_x,
        }


def evaluate(
    spec: Spec,
    balls: int,
    *,
    knowledge: Knowledge | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> tuple[Result, ...]:
    """Play `balls` serves and return their results, by index.

    Args:
        spec: what is played.
        balls: how many serves.
        knowledge: for players that learn; the ten shipped demonstrations by default.
        workers: processes.
        progress: called with (done, balls).
    """
    known = knowledge or Knowledge(shipped_demonstrations())
    results: list[Result] = []
    chunks = [range(i, min(i + CHUNK, balls)) for i in range(0, balls, CHUNK)]
    with closing(_played(spec, known, chunks, workers)) as parts:
        for part in parts:
            results.extend(part)
            if progress is not None:
                progress(len(results), balls)
    return tuple(results)


def header(spec: Spec, balls: int, experience: Path | None = None) -> dict[str, Any]:
    """Return what an evaluation's JSON says before anything is played: what is evaluated."""
    return {
        "player": spec.player,
        "eyes": spec.eyes,
        "vehicle": spec.vehicle_name,
        "camera": spec.camera_name,
        "serves": spec.serves_name,
        "racket": spec.racket,
        "blackout": spec.blackout,
        "randomize": spec.randomize,
        "ball": spec.ball,
        "eye_settings": spec.eye_settings.as_json(spec.eyes, spec.ball),
        "player_settings": spec.player_settings.as_json(spec.player),
        **({"control": spec.control or PAPERS_CONTROL} if spec.player in DECIDING_ONCE else {}),
        "experience": None if experience is None else str(experience),
        "contents": spec.contents(),
        "version": __version__,
        "balls": balls,
        "seed": spec.seed,
    }


def summary(
    spec: Spec, results: Sequence[Result], head: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Return what `evaluate --json` prints, comparisons apart.

    Args:
        spec: what was played.
        results: of all balls.
        head: what `header` said before the first of them; None: says it now.
    """
    balls, outcomes = len(results), [result.outcome for result in results]
    misses = [
        r.miss_distance for r in results if r.outcome != "hit" and r.miss_distance is not None
    ]
    hits = outcomes.count("hit")
    within = [result for result in results if result.reachable]
    hits_within = sum(result.outcome == "hit" for result in within)
    return {
        **(head or header(spec, balls)),
        "hits": hits,
        "hit_rate": rate(hits, balls),
        "hit_rate_interval": wilson_interval(hits, balls),
        "reachable": len(within),
        "hits_of_reachable": hits_within,
        "hit_rate_of_reachable": rate(hits_within, len(within)),
        "hit_rate_of_reachable_interval": wilson_interval(hits_within, len(within)),
        "near_hits": outcomes.count("near_hit"),
        "returned": sum(result.landing_x is not None for result in results),
        "miss_distance_median_m": float(np.median(misses)) if misses else None,
        "trials": [result.as_json() for result in results],
    }


def make_player(spec: Spec, knowledge: Knowledge, *, explore: bool = False) -> Learner:
    """Return the spec's player, one that learns, with what it knows."""
    player = learner_of(spec, lessons_of(knowledge.demonstrations, spec), explore=explore)
    remember(player, knowledge.trials)
    return player


def remember(player: Learner, trials: Sequence[Trial]) -> None:
    """Teach `player` what it learnt from these trials when it played them."""
    for trial in trials:
        player.recall(trial.outcome, trial.attempt, trial.reward)


def _played(
    spec: Spec, knowledge: Knowledge, chunks: list[range], workers: int
) -> Generator[list[Result], None, None]:
    ours = None if spec.is_own_player else player_of(spec, knowledge)
    if workers == 1 or len(chunks) < 2:
        yield from map(_Table(spec, ours).play, chunks)
        return
    workers = min(workers, len(chunks))
    yield from in_workers(
        _play_here, chunks, workers=workers, begin=_sit_down, arguments=(spec, ours)
    )


class _Table:
    """A spec made ready: where chunk after chunk is played."""

    def __init__(self, spec: Spec, ours: Player | None) -> None:
        """Take a seat.

        Args:
            spec: what is played.
            ours: a player that keeps nothing from serve to serve; None: the user's own.
        """
        self._stage = stage_of(spec)
        self._player = own_player(spec.player) if ours is None else lambda: ours

    def play(self, chunk: range) -> list[Result]:
        return [self._result(index) for index in chunk]

    def _result(self, index: int) -> Result:
        player = self._player()
        watch = Gate if self._stage.spec.player == "oracle" else Controls
        played = play_trial(self._stage, index, player, watch=watch)
        return Result(
            index,
            played.outcome,
            played.miss_distance,
            played.time_error,
            played.truth.landing_x,
            reachable=is_reachable(new_drone(self._stage, index)),
        )


_here: _Table | None = None


def _sit_down(spec: Spec, ours: Player | None) -> None:
    global _here
    _here = _Table(spec, ours)


def _play_here(chunk: range) -> list[Result]:
    assert _here is not None, "a worker plays after it sat down"
    return _here.play(chunk)


def player_of(spec: Spec, knowledge: Knowledge) -> Player:
    """Return the spec's player, one of ours, with what it knows."""
    if spec.player == "oracle":
        return Oracle()
    if spec.player == "nearest":
        return NearestPlayer(lessons_of(knowledge.demonstrations, spec), settings_of(spec))
    return Hover() if spec.player == "hover" else make_player(spec, knowledge)
