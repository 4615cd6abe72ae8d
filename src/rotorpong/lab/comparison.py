"""An evaluation beside others of the same balls: who hit what the other missed, and skill.

Of each pair McNemar's exact test looks at the balls that one of the two hit and the other did not.
Skill puts a hit rate between that of a drone that only hovers, 0, and that of the oracle, 1. What
is compared are these players as they stand, not the ways in which they came to be: whether training
helps, say, takes several runs of it.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.drone import OUTCOMES
from rotorpong.lab.statistics import mcnemar, skill

BALLS = ("serves", "seed", "balls", "randomize", "version")  # equal: the same balls were thrown
GAME = ("vehicle", "camera", "racket")  # equal as well: hover and oracle are floor and ceiling
TOLD = ("player", "eyes", *GAME, "experience", "hits", "hit_rate")
EXPECTED = "expected what `rotorpong evaluate --json` of this version prints"


@dataclass(frozen=True, slots=True)
class Evaluation:
    """What an evaluation printed."""

    path: Path
    found: dict[str, Any]

    @property
    def hits(self) -> list[bool]:
        """Which balls were hit, by index."""
        return hits_of(self.found)


def read_evaluation(path: Path) -> Evaluation:
    """Read what `rotorpong evaluate --json` printed.

    Raises:
        InputError: it is unreadable or something else.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; {EXPECTED}")
    try:
        found = json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON; {EXPECTED}") from error
    if not isinstance(found, dict) or not _is_whole(found):
        raise InputError(f"{path}: is no evaluation; {EXPECTED}")
    return Evaluation(path, found)


def require_same_balls(header: dict[str, Any], other: Evaluation) -> None:
    """Raise InputError unless the balls of an evaluation are those of another.

    Args:
        header: of the one, as `evaluate.header` makes it.
        other: the other.
    """
    for what in BALLS:
        ours, theirs = (_contents(found, what) for found in (header, other.found))
        if ours != theirs:
            raise InputError(f"{other.path}: {what} {theirs}, here {ours}; expected the same balls")


def compared(found: dict[str, Any], others: Sequence[Evaluation]) -> dict[str, Any]:
    """Return what an evaluation's JSON says of others: `skill` and `against`.

    Args:
        found: what was evaluated.
        others: of the same balls.
    """
    return {"skill": _skill(found, others), "against": [_against(found, one) for one in others]}


def hits_of(found: dict[str, Any]) -> list[bool]:
    """Return which balls of an evaluation were hit, by index."""
    return [trial["outcome"] == "hit" for trial in found["trials"]]


def paired(ours: Sequence[bool], theirs: Sequence[bool]) -> dict[str, Any]:
    """Return how many of the same balls only the one or the other hit, and how likely by chance."""
    pairs = list(zip(ours, theirs, strict=True))
    won, lost = pairs.count((True, False)), pairs.count((False, True))
    return {"won": won, "lost": lost, "p_value": mcnemar(won, lost)}


def _is_whole(found: dict[str, Any]) -> bool:
    trials = found.get("trials")
    keys = all(key in found for key in (*BALLS, *TOLD))
    if not (keys and isinstance(trials, list) and isinstance(found.get("contents"), dict)):
        return False
    outcomes = [trial.get("outcome") for trial in trials if isinstance(trial, dict)]
    hits = outcomes.count("hit")
    known = isinstance(found["player"], str) and all(outcome in OUTCOMES for outcome in outcomes)
    return known and (len(trials), len(outcomes), hits) == (
        found["balls"], found["balls"], found["hits"]
    )  # fmt: skip


def _contents(found: dict[str, Any], what: str) -> Any:
    """Return a value; of a file a digest, which tells more than its name."""
    return found["contents"].get(what, found[what])


def _against(found: dict[str, Any], other: Evaluation) -> dict[str, Any]:
    told = {key: other.found[key] for key in TOLD}
    return {"file": str(other.path), **told, **paired(hits_of(found), other.hits)}


def _skill(found: dict[str, Any], others: Sequence[Evaluation]) -> float | None:
    rates: dict[str, float] = {}
    for one in (found, *(other.found for other in others)):
        if all(_contents(one, what) == _contents(found, what) for what in GAME):
            rates.setdefault(one["player"], one["hits"] / one["balls"])
    if not {"hover", "oracle"} <= rates.keys():
        return None
    return skill(found["hits"] / found["balls"], rates["hover"], rates["oracle"])
