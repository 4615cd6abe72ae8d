"""Freeze a suite: digests of its balls, and what hover and the oracle make of them.

python benchmarks/freeze_suite.py v1

This was done once for each suite and is refused where it was: results of a suite compare only as
long as its balls, its floor and its ceiling stay. What should be otherwise is another suite.
"""

import json
import sys
from dataclasses import asdict

from rotorpong import __version__
from rotorpong.files import write_whole
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import Spec
from rotorpong.lab.suite.cells import QUICK_BALLS, SUITES, Cell
from rotorpong.lab.suite.frozen import Frozen, balls_digest, letters, path_of


def main() -> None:
    """Freeze the suite named on the command line."""
    suite = SUITES[sys.argv[1]]
    path = path_of(suite)
    if path.exists():
        sys.exit(f"{path.name}: is frozen; make another suite")
    cells = {}
    for cell in suite.cells:
        cells[cell.name] = asdict(frozen_cell(cell))
        print(cell.name, flush=True)
    content = {"suite": suite.name, "version": __version__, "cells": cells}
    write_whole(path, (json.dumps(content, indent=1) + "\n").encode())


def frozen_cell(cell: Cell) -> Frozen:
    """Play a cell with hover and with the oracle."""
    return Frozen(
        balls_digest(cell, cell.balls),
        balls_digest(cell, QUICK_BALLS),
        hover=outcomes(cell, Spec("hover", "truth")),
        oracle=outcomes(cell, Spec("oracle", "truth")),
    )


def outcomes(cell: Cell, player: Spec) -> str:
    """Return the outcome of each ball of a cell, a letter each."""
    return letters([result.outcome for result in evaluate(cell.spec(player), cell.balls)])


if __name__ == "__main__":
    main()
