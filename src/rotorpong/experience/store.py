"""One run in one SQLite file: what it is, what it was shown, what became of each serve.

    run -> demonstrations, in order
        -> trials, by index -> truth (tables of `truth.py`, which only lab opens)

A trial acknowledged is a trial kept: `add_trial` returns after the commit of one transaction that
holds the trial and its truth. The key of a trial is (run, index), so adding it again changes
nothing, and a run resumed after kill -9 ends with the rows of an uninterrupted one.
The file is made under another name and linked into place: it is there whole or not at all.
"""

import json
import os
import secrets
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

from rotorpong.conventions import InputError, StoreError
from rotorpong.experience import database
from rotorpong.experience.records import Attempt, Demonstration, Run, Trial, canonical_json
from rotorpong.files import sync_folder

SCHEMA = {
    "runs": """CREATE TABLE runs(
  id INTEGER PRIMARY KEY, seed INTEGER, player TEXT, eyes TEXT, vehicle TEXT, camera TEXT,
  serves TEXT, version TEXT, pilot TEXT, spec_json TEXT, seal BLOB)""",
    "demonstrations": """CREATE TABLE demonstrations(
  run INTEGER REFERENCES runs, place INTEGER, seed INTEGER, trial INTEGER, spec_json TEXT,
  pilot TEXT, commands BLOB, seal BLOB, PRIMARY KEY (run, place)) WITHOUT ROWID""",
    "trials": """CREATE TABLE trials(
  run INTEGER REFERENCES runs, trial INTEGER, outcome TEXT, reward, contact_offset, contact_time_s,
  state BLOB, hitting_point BLOB, mixture_weights BLOB, seal BLOB,
  PRIMARY KEY (run, trial)) WITHOUT ROWID""",
}
NEIGHBOURS = {"truth_trials"}

Record = TypeVar("Record")
TruthWriter = Callable[[sqlite3.Connection, int], object]  # connection, run id


def create(path: str | PathLike[str], run: Run) -> "Store":
    """Make a new experience file for `run` and open it for writing.

    Raises:
        StoreError: the file exists, or the folder is missing, full or forbidden.
    """
    path = Path(path)
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    with database.reporting(path):
        if not path.parent.is_dir():
            raise StoreError(f"{path}: the folder {path.parent} does not exist")
        if path.exists():
            raise _in_the_way(path)
        try:
            _write_draft(draft, run)
            _publish(draft, path)
        finally:
            draft.unlink(missing_ok=True)
        sync_folder(path.absolute().parent)
    return open_store(path)


def open_store(path: str | PathLike[str], *, readonly: bool = False) -> "Store":
    """Open an experience file: for reading, any number of times; for writing, once at a time.

    Raises:
        StoreError: the file is missing, damaged, foreign, forbidden, or has a writer already.
    """
    path = Path(path)
    with database.reporting(path):
        if path.is_dir():
            raise StoreError(f"{path}: is a folder; expected an experience file")
        if not path.exists():
            raise StoreError(f"{path}: does not exist; expected an experience file")
        connection = database.connect(path, readonly=readonly)
        try:
            return Store(path, connection, readonly=readonly)
        except BaseException:
            connection.close()
            raise


class Store:
    """An open experience file; a context manager. Made by `create` and `open_store`."""

    def __init__(self, path: Path, connection: sqlite3.Connection, *, readonly: bool) -> None:
        self.path = path
        self.connection = connection
        self.readonly = readonly
        with self._located():
            database.check(connection, SCHEMA, NEIGHBOURS)
            self.run = _only_run(connection)
            if not readonly:
                _claim(connection)

    def __enter__(self) -> "Store":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Fold the log into the file and let go of it.

        Where a reader or a full disk prevents the folding, the log stays beside the file
        (`FILE-wal`), nothing is lost, and the next writer folds it.
        """
        if not self.readonly:
            with suppress(sqlite3.Error):
                if self.connection.in_transaction:
                    self.connection.execute("ROLLBACK")
                self.connection.execute("PRAGMA busy_timeout = 0")
                self.connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
                self.connection.execute("PRAGMA journal_mode = DELETE")
        self.connection.close()

    def check_run(self, run: Run) -> None:
        """Raise StoreError naming the fields in which `run` is not the run of this file."""
        kept, asked = self.run.identity(), run.identity()
        differing = [
            f"{name} is {kept.get(name, 'absent')}, given {asked.get(name, 'absent')}"
            for name in sorted(kept.keys() | asked.keys())
            if kept.get(name) != asked.get(name)
        ]
        if differing:
            raise StoreError(f"{self.path}: is another run: {'; '.join(differing)}")

    def add_demonstrations(self, demonstrations: Sequence[Demonstration]) -> None:
        """Keep the demonstrations that the run starts from, all or none, in this order.

        Raises:
            StoreError: other demonstrations are kept already, or they cannot be written.
        """
        with self._transaction():
            for place, demonstration in enumerate(demonstrations):
                row = (self.run.id, place, *_demonstration_row(demonstration))
                database.keep(self.connection, "demonstrations", row)

    def add_trial(self, trial: Trial, truth: TruthWriter | None = None) -> bool:
        """Keep a trial and what `truth` writes, in one transaction; durable on return.

        Args:
            trial: what the player's side knows.
            truth: called inside the transaction with the connection and the run's id.

        Returns:
            False if the very same trial was kept before.

        Raises:
            StoreError: it cannot be written, or another trial has its index. Nothing of it is
                kept then, and everything acknowledged before is.
        """
        with self._transaction():
            new = database.keep(self.connection, "trials", (self.run.id, *_trial_row(trial)))
            if truth is not None:
                truth(self.connection, self.run.id)
        return new

    def demonstrations(self) -> tuple[Demonstration, ...]:
        """Return the demonstrations in the order they were added."""
        return self.read("demonstrations", _demonstration)

    def trials(self) -> tuple[Trial, ...]:
        """Return the trials by index."""
        return self.read("trials", _trial)

    def count(self) -> int:
        """Return how many trials are kept."""
        with self._located():
            return self.connection.execute("SELECT count(*) FROM trials").fetchone()[0]

    def read(self, table: str, record: Callable[[tuple[Any, ...]], Record]) -> tuple[Record, ...]:
        """Return the rows of `table` as records, by key; nothing if there is no such table.

        Raises:
            StoreError: a row does not match its seal, or is no such record.
        """
        with self._located():
            if not database.has_table(self.connection, table):
                return ()
            try:
                return tuple(record(row) for row in database.rows(self.connection, table))
            except InputError as error:
                raise StoreError(f"damaged: {error}") from error

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """Commit what the body wrote, or nothing of it, and hold the write lock again."""
        with self._located():
            if self.readonly:
                raise StoreError("was opened for reading only")
            try:
                yield
                self.connection.execute("COMMIT")
            finally:
                if self.connection.in_transaction:
                    self.connection.execute("ROLLBACK")
                self.connection.execute("BEGIN IMMEDIATE")

    @contextmanager
    def _located(self) -> Iterator[None]:
        """Make every error a StoreError that begins with the path."""
        try:
            with database.reporting(self.path):
                yield
        except StoreError as error:
            if str(error).startswith(f"{self.path}: "):
                raise
            raise StoreError(f"{self.path}: {error}") from error


def _write_draft(draft: Path, run: Run) -> None:
    connection = sqlite3.connect(draft, isolation_level=None)
    try:
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("BEGIN")
        connection.execute(f"PRAGMA application_id = {database.APPLICATION_ID}")
        connection.execute(f"PRAGMA user_version = {database.FORMAT}")
        for statement in SCHEMA.values():
            connection.execute(statement)
        database.keep(connection, "runs", _run_row(run))
        connection.execute("COMMIT")
    finally:
        connection.close()


def _publish(draft: Path, path: Path) -> None:
    """Give the draft its name, never over another file."""
    try:
        os.link(draft, path)
    except FileExistsError as error:
        raise _in_the_way(path) from error
    except OSError:  # a file system without hard links
        draft.rename(path)


def _in_the_way(path: Path) -> StoreError:
    return StoreError(f"{path}: exists; use --resume to go on with it, or another name")


def _claim(connection: sqlite3.Connection) -> None:
    """Take the write lock, which is held between transactions too: one writer at a time."""
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute("PRAGMA busy_timeout = 0")  # a second writer learns at once
    connection.execute("BEGIN IMMEDIATE")
    connection.execute("DELETE FROM trials WHERE false")  # fails where nothing may be written
    connection.execute(f"PRAGMA busy_timeout = {int(1000 * database.BUSY_SECONDS)}")


def _only_run(connection: sqlite3.Connection) -> Run:
    found = list(database.rows(connection, "runs"))
    if len(found) != 1:
        raise StoreError(f"damaged: {len(found)} runs; expected one")
    *head, spec = found[0]
    return Run(*head, spec=json.loads(spec))


def _run_row(run: Run) -> tuple[Any, ...]:
    head = (run.id, run.seed, run.player, run.eyes, run.vehicle, run.camera)
    return (*head, run.serves, run.version, run.pilot, canonical_json(run.spec))


def _demonstration_row(demonstration: Demonstration) -> tuple[Any, ...]:
    spec = canonical_json(demonstration.spec)
    commands = database.blob(demonstration.commands)
    return demonstration.seed, demonstration.trial, spec, demonstration.pilot, commands


def _demonstration(row: tuple[Any, ...]) -> Demonstration:
    _, _, seed, trial, spec, pilot, commands = row
    return Demonstration(seed, trial, json.loads(spec), pilot, database.array(commands, -1, 5))


def _trial_row(trial: Trial) -> tuple[Any, ...]:
    attempt = trial.attempt
    arrays = (None, None, None)
    if attempt is not None:
        parts = (attempt.state, attempt.hitting_point, attempt.mixture_weights)
        arrays = tuple(database.blob(part) for part in parts)
    numbers = (trial.reward, trial.contact_offset, trial.contact_time)
    return trial.index, trial.outcome, *(database.number(value) for value in numbers), *arrays


def _trial(row: tuple[Any, ...]) -> Trial:
    _, index, outcome, reward, offset, time, state, hitting_point, weights = row
    attempt = None
    if state is not None:
        attempt = Attempt(
            database.array(state, 6), database.array(hitting_point, 7), database.array(weights, -1)
        )
    return Trial(index, outcome, reward, attempt, offset, time)
