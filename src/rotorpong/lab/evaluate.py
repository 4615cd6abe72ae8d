"""How good is a player: a fixed number of serves, in one process or several, never learning.

Trials share nothing, so any number of workers gives the same results in the same order.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import numpy as np

from rotorpong.drone import Outcome, Player
from rotorpong.experience import Demonstration, Trial, shipped_demonstrations
from rotorpong.lab.demonstrate import Progress, lessons_of
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec, own_player
from rotorpong.lab.statistics import rate, wilson_interval
from rotorpong.lab.trial import Stage, play_trial
from rotorpong.play.hover import Hover
from rotorpong.play.paper import PaperPlayer

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
    miss_distance: float  # m
    time_error: float | None  # s
    landing_x: float | None  # m

    def as_json(self) -> dict[str, Any]:
        """Return the trial as `evaluate --json` prints it."""
        return {
            "index": self.index,
            "outcome": self.outcome,
            "reachable": None,
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
    for part in _played(spec, known, chunks, workers):
        results.extend(part)
        if progress is not None:
            progress(len(results), balls)
    return tuple(results)


def summary(spec: Spec, results: Sequence[Result]) -> dict[str, Any]:
    """Return what `evaluate --json` prints."""
    balls, outcomes = len(results), [result.outcome for result in results]
    misses = [result.miss_distance for result in results if result.outcome != "hit"]
    hits = outcomes.count("hit")
    return {
        "player": spec.player,
        "eyes": spec.eyes,
        "vehicle": spec.vehicle_name,
        "camera": spec.camera_name,
        "serves": spec.serves,
        "balls": balls,
        "seed": spec.seed,
        "hits": hits,
        "hit_rate": rate(hits, balls),
        "hit_rate_interval": wilson_interval(hits, balls),
        "reachable": None,
        "hits_of_reachable": None,
        "hit_rate_of_reachable": None,
        "near_hits": outcomes.count("near_hit"),
        "returned": sum(result.landing_x is not None for result in results),
        "miss_distance_median_m": float(np.median(misses)) if misses else None,
        "trials": [result.as_json() for result in results],
    }


def make_player(spec: Spec, knowledge: Knowledge, *, explore: bool = False) -> PaperPlayer:
    """Return the paper's player with what it knows."""
    player = PaperPlayer(lessons_of(knowledge.demonstrations, spec), explore=explore)
    for trial in knowledge.trials:
        if trial.outcome == "hit" and trial.attempt is not None:
            player.remember(trial.attempt, trial.reward)
    return player


def _played(
    spec: Spec, knowledge: Knowledge, chunks: list[range], workers: int
) -> Iterator[list[Result]]:
    if workers == 1 or len(chunks) < 2:
        yield from map(_Table(spec, knowledge).play, chunks)
        return
    with ProcessPoolExecutor(
        min(workers, len(chunks)), get_context("spawn"), _sit_down, (spec, knowledge)
    ) as pool:
        yield from pool.map(_play_here, chunks)


class _Table:
    """A spec made ready: where chunk after chunk is played."""

    def __init__(self, spec: Spec, knowledge: Knowledge) -> None:
        source = serve_source(spec.serves, spec.seed)
        self._stage = Stage(spec, spec.setting(), source, "evaluate")
        self._player = _player_factory(spec, knowledge)

    def play(self, chunk: range) -> list[Result]:
        return [self._result(index) for index in chunk]

    def _result(self, index: int) -> Result:
        truth = play_trial(self._stage, index, self._player()).truth
        return Result(
            index, truth.verdict.outcome, truth.miss_distance, truth.time_error, truth.landing_x
        )


_here: _Table | None = None


def _sit_down(spec: Spec, knowledge: Knowledge) -> None:
    global _here
    _here = _Table(spec, knowledge)


def _play_here(chunk: range) -> list[Result]:
    assert _here is not None, "a worker plays after it sat down"
    return _here.play(chunk)


def _player_factory(spec: Spec, knowledge: Knowledge) -> Callable[[], Player]:
    """Return what makes the player of each trial; ours keep nothing from serve to serve."""
    if spec.is_own_player:
        return own_player(spec.player)
    player: Player = Hover() if spec.player == "hover" else make_player(spec, knowledge)
    return lambda: player
