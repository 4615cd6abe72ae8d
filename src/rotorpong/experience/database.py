"""The SQLite file beneath the store: durable, checked, and with errors of one line.

Durability: WAL with synchronous FULL, so a transaction that was acknowledged survives kill -9 and
power loss, and readers read while the writer writes. One writer at a time: it holds the write lock
from opening to closing. Closing folds the write-ahead log back into the file and leaves WAL mode,
so that a copy of the one file is complete and a read-only medium can be read.

Damage: SQLite checks its trees but not the bytes of a row. So every row ends in a seal,

    seal = BLAKE2b-128(table name and the values of the row),

compared on reading. A row edited by hand counts as damaged. Floats lie in columns without a
declared type: SQLite's REAL turns -0.0 into 0.0. Arrays are little-endian float64 blobs.
"""

import hashlib
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from rotorpong.conventions import StoreError

APPLICATION_ID = int.from_bytes(b"rpng", "big")  # in the file's header
FORMAT = 1  # the header's user_version
BUSY_SECONDS = 5.0  # how long a reader waits for a lock
NUMBER = "<f8"

EXPLANATIONS = {  # primary result code -> one line
    sqlite3.SQLITE_BUSY: "another process is using it; wait for that to end or stop it",
    sqlite3.SQLITE_FULL: "the disk is full; every trial acknowledged so far is kept",
    sqlite3.SQLITE_IOERR: "the disk is full or failing; every trial acknowledged so far is kept",
    sqlite3.SQLITE_NOTADB: "not an experience file; expected an SQLite file made by rotorpong",
    sqlite3.SQLITE_CORRUPT: "damaged; expected an experience file as rotorpong left it",
    sqlite3.SQLITE_READONLY: "cannot be written; expected a file and a folder with permission",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened; expected a file and a folder with permission",
    sqlite3.SQLITE_PERM: "cannot be opened; expected a file and a folder with permission",
}
NO_ROOM_FOR_A_LOG = {sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY}  # WAL, read-only medium


@contextmanager
def reporting(path: Path) -> Iterator[None]:
    """Turn what SQLite and the operating system raise into a StoreError naming `path`."""
    try:
        yield
    except sqlite3.Error as error:
        line = EXPLANATIONS.get(_code(error), "cannot be used as an experience file")
        cause = " ".join(str(error).split())
        raise StoreError(f"{path}: {line} ({cause})") from error
    except OSError as error:
        raise StoreError(f"{path}: {error.strerror}") from error
    except UnicodeEncodeError as error:
        raise StoreError(f"{path}: {error.object!r} is not Unicode text") from error
    except UnicodeDecodeError as error:  # out of a message of SQLite that quotes the file
        raise StoreError(f"{path}: {EXPLANATIONS[sqlite3.SQLITE_CORRUPT]}") from error


def connect(path: Path, *, readonly: bool) -> sqlite3.Connection:
    """Open an existing file without changing it; the caller closes."""
    connection = _connect(path, "mode=ro" if readonly else "mode=rw")
    try:
        connection.execute("PRAGMA schema_version").fetchone()
    except sqlite3.Error as error:
        connection.close()
        log = path.with_name(f"{path.name}-wal")
        if not readonly or _code(error) not in NO_ROOM_FOR_A_LOG or log.exists():
            raise
        return _connect(path, "immutable=1")
    return connection


def check(connection: sqlite3.Connection, schema: dict[str, str], neighbours: set[str]) -> None:
    """Raise unless the file is ours, of this format, with these tables, and whole.

    Args:
        connection: just opened; nothing is written to it.
        schema: table name -> the statement that made it.
        neighbours: further tables that other modules may have added.

    Raises:
        sqlite3.Error: damaged, or not SQLite.
        StoreError: of another program, format or layout. The message lacks the path.
    """
    application = _pragma(connection, "application_id")
    if application != APPLICATION_ID:
        raise StoreError(f"not an experience file: its application id is {application}")
    version = _pragma(connection, "user_version")
    if version != FORMAT:
        hint = "upgrade rotorpong" if version > FORMAT else "it is damaged"
        raise StoreError(f"format {version}; this rotorpong reads format {FORMAT}: {hint}")
    found = dict(connection.execute("SELECT name, sql FROM sqlite_master"))
    extra = found.keys() - schema.keys() - neighbours
    if extra or any(found.get(name) != statement for name, statement in schema.items()):
        given, expected = ", ".join(sorted(map(str, found))), ", ".join(schema)
        raise StoreError(f"foreign or damaged layout: tables {given}; expected {expected}")
    complaint = _pragma(connection, "quick_check(1)")
    if complaint != "ok":
        raise StoreError(f"damaged: {' '.join(str(complaint).split())}")


def keep(connection: sqlite3.Connection, table: str, row: tuple[Any, ...]) -> bool:
    """Insert `row` into `table`; return False if the very same row was there already.

    Raises:
        StoreError: another row has its key, so this is not the same run.
    """
    sealed = (*row, seal(table, row))
    marks = ", ".join("?" * len(sealed))
    statement = f"INSERT OR IGNORE INTO {table} VALUES ({marks})"
    if connection.execute(statement, sealed).rowcount:
        return True
    same = f"SELECT 1 FROM {table} WHERE seal = ?"
    if connection.execute(same, sealed[-1:]).fetchone() is None:
        raise StoreError(f"{table} {row[:2]} is kept with other values; the kept ones stay")
    return False


def has_table(connection: sqlite3.Connection, table: str) -> bool:
    """Return whether the file has a table of that name."""
    found = connection.execute("SELECT count(*) FROM sqlite_master WHERE name = ?", (table,))
    return bool(found.fetchone()[0])


def rows(connection: sqlite3.Connection, table: str) -> Iterator[tuple[Any, ...]]:
    """Return the rows of `table` in the order of their key, without their seals.

    Raises:
        StoreError: a row does not match its seal.
    """
    for *row, sealed in connection.execute(f"SELECT * FROM {table} ORDER BY 1, 2"):
        if sealed != seal(table, tuple(row)):
            raise StoreError(f"damaged: {table} {tuple(row[:2])} does not match its seal")
        yield tuple(row)


def seal(table: str, row: tuple[Any, ...]) -> bytes:
    """Return the 16 bytes that a row of `table` ends in."""
    return hashlib.blake2b(repr((table, *row)).encode(), digest_size=16).digest()


def number(value: float | None) -> float | None:
    """Return a column's value: a float even where an integer was given."""
    return None if value is None else float(value)


def blob(numbers: ndarray) -> bytes:
    """Return the bytes of an array, row by row."""
    return np.ascontiguousarray(numbers, dtype=NUMBER).tobytes()


def array(numbers: bytes, *shape: int) -> ndarray:
    """Return the array of a blob; one length may be -1.

    Raises:
        StoreError: the length does not fit `shape`.
    """
    unit = 8 * int(np.prod([n for n in shape if n > 0]))
    fits = len(numbers) % unit == 0 if -1 in shape else len(numbers) == unit
    if not fits or not numbers:
        raise StoreError(f"damaged: {len(numbers)} bytes where float64 {shape} was expected")
    return np.frombuffer(numbers, NUMBER).astype(np.float64).reshape(shape)


def _connect(path: Path, how: str) -> sqlite3.Connection:
    connection = sqlite3.connect(
        f"{path.absolute().as_uri()}?{how}", uri=True, isolation_level=None, timeout=BUSY_SECONDS
    )
    for setting in ("trusted_schema = OFF", "cell_size_check = ON", "foreign_keys = ON"):
        connection.execute(f"PRAGMA {setting}")
    return connection


def _code(error: sqlite3.Error) -> int:
    return getattr(error, "sqlite_errorcode", 0) & 0xFF


def _pragma(connection: sqlite3.Connection, name: str) -> Any:
    return connection.execute(f"PRAGMA {name}").fetchone()[0]
