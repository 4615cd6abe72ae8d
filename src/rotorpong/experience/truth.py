"""What really happened, in a table of its own that only lab may open.

A row goes into the same transaction as its trial:

    store.add_trial(trial, truth=record(row))

World frame, SI. The serve is the ball's state at release. No learner may read any of it: an import
contract forbids this module to everything but lab.
"""

import sqlite3
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.experience import database
from rotorpong.experience.records import require_array, require_finite, require_integer
from rotorpong.experience.store import Store

TABLE = "truth_trials"
STATEMENT = f"""CREATE TABLE IF NOT EXISTS {TABLE}(
  run INTEGER, trial INTEGER, miss_distance_m, time_error_s, landing_x_m,
  serve BLOB, seal BLOB, PRIMARY KEY (run, trial),
  FOREIGN KEY (run, trial) REFERENCES trials) WITHOUT ROWID"""


@dataclass(frozen=True, slots=True, eq=False)
class TruthRow:
    """The truth about one trial."""

    index: int
    miss_distance: float | None  # m, 0 for a hit; None: the player broke off
    time_error: float | None  # s, blade minus ball, positive = late
    landing_x: float | None  # m, where a hit ball first touched the table beyond the net
    serve_position: Float[ndarray, "3"]  # m, at release
    serve_velocity: Float[ndarray, "3"]  # m/s
    serve_spin: Float[ndarray, "3"]  # rad/s

    def __post_init__(self) -> None:
        """Refuse wrong shapes and numbers that are not finite."""
        require_integer("index", self.index)
        for name in ("miss_distance", "time_error", "landing_x"):
            require_finite(name, getattr(self, name))
        for name in ("serve_position", "serve_velocity", "serve_spin"):
            require_array(name, getattr(self, name), 3)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TruthRow) and _row(self) == _row(other)


def record(row: TruthRow) -> Callable[[sqlite3.Connection, int], None]:
    """Return what writes `row` inside the transaction of its trial."""

    def write(connection: sqlite3.Connection, run: int) -> None:
        connection.execute(STATEMENT)
        database.keep(connection, TABLE, (run, *_row(row)))

    return write


def truth_rows(store: Store) -> tuple[TruthRow, ...]:
    """Return the truth about every trial that has one, by index.

    Raises:
        StoreError: the table is damaged.
    """
    return store.read(TABLE, _truth)


def _row(row: TruthRow) -> tuple[Any, ...]:
    serve = np.concatenate([row.serve_position, row.serve_velocity, row.serve_spin])
    numbers = (row.miss_distance, row.time_error, row.landing_x)
    return row.index, *(database.number(value) for value in numbers), database.blob(serve)


def _truth(row: tuple[Any, ...]) -> TruthRow:
    _, index, miss_distance, time_error, landing_x, serve = row
    return TruthRow(index, miss_distance, time_error, landing_x, *database.array(serve, 3, 3))
