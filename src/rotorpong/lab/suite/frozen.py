"""What of a suite is committed: digests of its balls, and what hover and the oracle made of them.

A digest is of what is really thrown: release position, velocity and spin of each ball to 1 mm,
1 mm/s and 1 mrad/s, so that the last bits of another processor do not count, and the air and the
table that it meets. `benchmarks/freeze_suite.py` wrote the files, once.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rotorpong.conventions import RotorpongError
from rotorpong.drone import Outcome
from rotorpong.experience.records import canonical_json
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.spec import Spec
from rotorpong.lab.suite.cells import QUICK_BALLS, Cell, Suite
from rotorpong.lab.trial import encounter, stage_of
from rotorpong.world.serves import Serve

LETTERS: Mapping[Outcome, str] = {
    "hit": "h",
    "near_hit": "n",
    "miss": "m",
    "unseen": "u",
    "hull": "d",  # of the drone
    "fault": "f",
}
PLACES, MEDIUM_PLACES = 3, 6  # digits after the point: of m, m/s, rad/s; of air and table


@dataclass(frozen=True, slots=True)
class Frozen:
    """What is committed of one cell."""

    digest: str  # of all balls
    quick_digest: str  # of the first
    hover: str  # the outcome of each ball, a letter of LETTERS
    oracle: str

    def digest_of_first(self, balls: int) -> str:
        """Return the digest of a quick run's balls, or of all."""
        return self.quick_digest if balls == QUICK_BALLS else self.digest


def frozen(suite: Suite) -> dict[str, Frozen]:
    """Return what is committed of each cell, by its name."""
    cells = json.loads(path_of(suite).read_text("utf-8"))["cells"]
    return {name: Frozen(**cell) for name, cell in cells.items()}


def path_of(suite: Suite) -> Path:
    """Return where it is committed."""
    return Path(__file__).with_name(f"{suite.name}.json")


def suite_digest(suite: Suite) -> str:
    """Return one digest of all that is committed of a suite: balls, floor and ceiling."""
    cells = {name: asdict(cell) for name, cell in frozen(suite).items()}
    return hashlib.sha256(canonical_json(cells).encode()).hexdigest()


def require_frozen(cell: Cell, known: Frozen, balls: int) -> None:
    """Raise RotorpongError unless the first balls of a cell are those that were frozen."""
    found = balls_digest(cell, balls)
    if found != known.digest_of_first(balls):
        raise RotorpongError(
            f"cell {cell.name!r}: the balls thrown here (sha256 {found[:12]}) are not those that "
            f"were frozen ({known.digest_of_first(balls)[:12]}): nothing to compare with"
        )


def balls_digest(cell: Cell, balls: int) -> str:
    """Return a digest of the first balls that a cell throws."""
    spec = cell.spec(Spec())
    stage = stage_of(spec)
    digest = hashlib.sha256()
    for index in range(balls):
        generators = trial_generators(spec.seed, stage.purpose, index)
        digest.update(_text(encounter(stage, index, generators)[1]).encode())
    return digest.hexdigest()


def letters(outcomes: list[Outcome]) -> str:
    """Return outcomes as a text of one letter each."""
    return "".join(LETTERS[outcome] for outcome in outcomes)


def hits_in(text: str) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which letters of a text are hits."""
    return np.array([letter == LETTERS["hit"] for letter in text])


def _text(serve: Serve) -> str:
    ball = serve.ball
    thrown = np.concatenate([ball.position, ball.velocity, ball.spin])
    numbers = [f"{value:.{PLACES}f}" for value in np.round(thrown, PLACES) + 0.0]  # no -0
    numbers += [f"{value:.{MEDIUM_PLACES}f}" for value in (*serve.air, *serve.table)]
    return " ".join(numbers) + "\n"
