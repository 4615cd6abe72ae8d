"""Results of a suite as a leaderboard takes them: whole, of the frozen balls, and adding up.

Whether the player really plays so is told by its command alone, which whoever doubts it runs again.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.lab.statistics import rate, wilson_interval
from rotorpong.lab.suite.cells import SUITES, Cell, Suite
from rotorpong.lab.suite.frozen import LETTERS, Frozen, frozen, suite_digest
from rotorpong.lab.suite.playing import cell_score, scored

TEXTS = ("command", "version", "player", "eyes")
OTHERS = ("eye_settings", "player_settings", "contents", "experience")
CLOSE = 1e-9
EXPECTED = "expected what `rotorpong suite` writes with --out"


def read_entry(path: Path) -> dict[str, Any]:
    """Read a result.

    Raises:
        InputError: it is none, is quick, is of other balls, or does not add up.
    """
    found = _read(path)
    try:
        complaint = _complaint(found)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError):
        complaint = "is no result of a suite"
    if complaint is not None:
        raise InputError(f"{path.name}: {complaint}; {EXPECTED}")
    return found


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); {EXPECTED}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON; {EXPECTED}") from error


def _complaint(found: Any) -> str | None:
    suite = SUITES[found["suite"]]
    if found["quick"] is not False or found["comparable"] is not True:
        return "is a quick run, which compares with nothing"
    absent = [what for what in TEXTS if not (isinstance(found[what], str) and found[what])]
    absent += [what for what in OTHERS if what not in found]
    if absent:
        return f"does not say {', '.join(absent)}"
    if found["digest"] != suite_digest(suite):
        return f"is not of the balls, floor and ceiling of suite {suite.name}"
    return _complaint_of_cells(suite, found)


def _complaint_of_cells(suite: Suite, found: dict[str, Any]) -> str | None:
    known = frozen(suite)
    names = [cell["name"] for cell in found["cells"]]
    if names != [cell.name for cell in suite.cells]:
        return f"has the cells {', '.join(names)}"
    for cell, told in zip(suite.cells, found["cells"], strict=True):
        wrong = _differing(told, _expected(cell, told, known[cell.name]))
        if wrong or not _is_within(told):
            return f"does not add up in cell {cell.name} ({', '.join(wrong) or 'reachable'})"
    wrong = _differing(found, scored(found["cells"], known))
    return f"does not add up ({', '.join(wrong)})" if wrong else None


def _expected(cell: Cell, told: dict[str, Any], known: Frozen) -> dict[str, Any]:
    """Return all that follows from the outcomes of a cell."""
    outcomes = told["outcomes"]
    if set(outcomes) - set(LETTERS.values()):
        raise ValueError(outcomes)
    hits, balls = outcomes.count(LETTERS["hit"]), cell.balls
    within, reachable = told["hits_of_reachable"], told["reachable"]
    score = cell_score(outcomes, known)
    return {
        "balls": len(outcomes),
        "digest": known.digest,
        "hits": hits,
        "hit_rate": rate(hits, balls),
        "hit_rate_interval": wilson_interval(hits, balls),
        "hit_rate_of_reachable": rate(within, reachable),
        "hit_rate_of_reachable_interval": wilson_interval(within, reachable),
        "near_hits": outcomes.count(LETTERS["near_hit"]),
        "skill": None if score is None else score.value,
        "skill_interval": None if score is None else score.interval,
    } | {what: getattr(cell, what) for what in ("balls", "seed", "serves", "vehicle", "camera")}


def _is_within(told: dict[str, Any]) -> bool:
    """Tell whether what cannot be computed anew is possible."""
    reachable, hits = told["reachable"], told["hits_of_reachable"]
    return len(told["outcomes"]) == told["balls"] >= reachable >= hits and told["hits"] >= hits


def _differing(told: Mapping[str, Any], expected: Mapping[str, Any]) -> list[str]:
    return [what for what, value in expected.items() if not _same(told[what], value)]


def _same(told: Any, expected: Any) -> bool:
    if isinstance(expected, tuple):
        pairs = zip(told, expected, strict=True)
        return all(_same(one, other) for one, other in pairs)
    if isinstance(expected, float):
        return math.isclose(told, expected, rel_tol=CLOSE, abs_tol=CLOSE)
    return type(told) is type(expected) and told == expected
