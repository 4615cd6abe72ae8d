"""A suite played by one player: cell after cell, each kept as soon as it is done.

What a player knows beforehand is the ten shipped demonstrations or an experience file. Nothing is
learnt here: training is no part of a suite, so what it cost is told, by whom and on which serves,
and not weighed.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.experience import Run, Trial
from rotorpong.files import digest_of
from rotorpong.lab.evaluate import Knowledge, Result, evaluate, header, summary
from rotorpong.lab.spec import DECIDING_ONCE, Spec
from rotorpong.lab.suite.cells import QUICK_BALLS, Cell, Suite
from rotorpong.lab.suite.frozen import (
    Frozen,
    frozen,
    hits_in,
    letters,
    require_frozen,
    suite_digest,
)
from rotorpong.lab.suite.kept import Kept
from rotorpong.lab.suite.scores import Score, mean_score, skill_score

OF_CELLS = ("vehicle", "camera", "serves", "randomize", "balls", "seed", "experience", "blackout")
Advance = Callable[[str, int, int], None]


@dataclass(frozen=True, slots=True)
class Entrant:
    """Who plays a suite."""

    spec: Spec  # its player and eyes count
    knowledge: Knowledge | None = None  # None: the shipped demonstrations
    run: Run | None = None  # that the knowledge is from

    def check(self, suite: Suite) -> "Entrant":
        """Return the entrant if it can play.

        Raises:
            InputError: an experience that is of no use to the player, or that was gathered with a
                seed of the suite, which may be of its constant serve; or what `Spec.check` refuses.
        """
        player = self.spec.player
        if self.knowledge is not None and player not in DECIDING_ONCE:
            raise InputError(
                f"--experience with player {player!r}: has no effect; expected player "
                f"{' or '.join(DECIDING_ONCE)}"
            )
        if self.run is not None and self.run.seed in {cell.seed for cell in suite.cells}:
            raise InputError(
                f"--experience of seed {self.run.seed}: is a seed of suite {suite.name}; expected "
                "one of another seed"
            )
        self.spec.check()
        return self

    def as_json(self) -> dict[str, Any]:
        """Return all that is known about it."""
        head = header(self.spec, 0)
        contents = dict(head["contents"])
        if self.spec.is_own_player:
            contents["player"] = digest_of(Path(self.spec.player.rpartition(":")[0]))
        kept = {what: value for what, value in head.items() if what not in OF_CELLS}
        return {**kept, "contents": contents, "experience": self._experience()}

    def _experience(self) -> dict[str, Any] | None:
        if self.knowledge is None or self.run is None:
            return None
        run, trials = self.run, self.knowledge.trials
        told = ("player", "eyes", "vehicle", "camera", "serves", "seed", "version")
        return {
            **{what: getattr(run, what) for what in told},
            "spec": dict(run.spec),
            "demonstrations": len(self.knowledge.demonstrations),
            "balls": len(trials),
            "hits": sum(trial.outcome == "hit" for trial in trials),
            "digest": _digest(trials),
        }


def play_suite(
    suite: Suite,
    entrant: Entrant,
    *,
    quick: bool = False,
    workers: int = 1,
    kept: Kept | None = None,
    progress: Advance | None = None,
) -> dict[str, Any]:
    """Play a suite and return its JSON.

    Args:
        suite: what is played.
        entrant: who plays, checked.
        quick: the first balls of each cell only; the result compares with nothing.
        workers: processes; the result does not depend on it.
        kept: what is done already, and where what gets done is kept.
        progress: called with (cell, balls done, balls).

    Raises:
        RotorpongError: the balls here are not those that were frozen, or a worker died.
    """
    head = _head(suite, entrant, quick=quick)
    cells = {} if kept is None else kept.begin(head)
    known = frozen(suite)
    for cell in suite.cells:
        if cell.name in cells:
            continue
        balls = QUICK_BALLS if quick else cell.balls
        require_frozen(cell, known[cell.name], balls)
        advance = None if progress is None else _named(progress, cell.name)
        results = evaluate(
            cell.spec(entrant.spec),
            balls,
            knowledge=entrant.knowledge,
            workers=workers,
            progress=advance,
        )
        cells[cell.name] = cell_json(cell, results, entrant.spec, known[cell.name])
        if kept is not None:
            kept.keep(head, cells)
    return {**head, **scored(list(cells.values()), known), "cells": list(cells.values())}


def cell_json(
    cell: Cell, results: tuple[Result, ...], player: Spec, known: Frozen
) -> dict[str, Any]:
    """Return what a suite's JSON says of one cell."""
    balls = len(results)
    spec = cell.spec(player)
    apart = {"trials", *header(spec, balls)}
    found = {what: is_ for what, is_ in summary(spec, results).items() if what not in apart}
    outcomes = letters([result.outcome for result in results])
    score = cell_score(outcomes, known)
    return {
        "name": cell.name,
        "vehicle": cell.vehicle,
        "camera": cell.camera,
        "camera_pitch_deg": cell.camera_pitch_deg,
        "serves": cell.serves,
        "randomize": cell.randomize,
        "seed": cell.seed,
        "balls": balls,
        "digest": known.digest_of_first(balls),
        **found,
        "hover_hits": int(hits_in(known.hover[:balls]).sum()),
        "oracle_hits": int(hits_in(known.oracle[:balls]).sum()),
        **_told("skill", score),
        "outcomes": outcomes,
    }


def cell_score(outcomes: str, known: Frozen) -> Score | None:
    """Return the skill of a player whose outcomes these are, on the first balls of a cell."""
    texts = (outcomes, known.hover[: len(outcomes)], known.oracle[: len(outcomes)])
    return skill_score(*map(hits_in, texts))


def scored(cells: list[dict[str, Any]], known: dict[str, Frozen]) -> dict[str, Any]:
    """Return what a suite's JSON says of all cells together."""
    score = mean_score([cell_score(cell["outcomes"], known[cell["name"]]) for cell in cells])
    return {
        **_told("score", score),
        "balls": sum(cell["balls"] for cell in cells),
        "hits": sum(cell["hits"] for cell in cells),
    }


def _head(suite: Suite, entrant: Entrant, *, quick: bool) -> dict[str, Any]:
    return {
        "suite": suite.name,
        "digest": suite_digest(suite),
        "quick": quick,
        "comparable": not quick,
        **entrant.as_json(),
    }


def _told(name: str, score: Score | None) -> dict[str, Any]:
    return {name: None, f"{name}_interval": None} if score is None else score.as_json(name)


def _digest(trials: tuple[Trial, ...]) -> str:
    """Return a digest of what trials teach."""
    digest = hashlib.sha256()
    for trial in trials:
        tried = trial.attempt
        arrays = () if tried is None else (tried.state, tried.hitting_point, tried.mixture_weights)
        told = [trial.index, trial.outcome, trial.reward, *(array.tolist() for array in arrays)]
        digest.update(json.dumps(told).encode())
    return digest.hexdigest()


def _named(progress: Advance, name: str) -> Callable[[int, int], None]:
    return lambda done, balls: progress(name, done, balls)
