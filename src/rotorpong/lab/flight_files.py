"""Measured flights: positions of a ball over time, in the layouts that trackers write.

Three layouts, recognised by their content; times in s, positions in m, z up, the table's playing
surface at about z = 0:

- header `time_s,x_m,y_m,z_m`, comma separated;
- header `Timestamp,X,Y,Z`, comma separated;
- no header, `t;x;y;z`.

In a folder any other file is passed over and counted; a file in one of the layouts that is damaged
is an error there as well.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.number_rows import parse_rows, read_lines
from rotorpong.physics.flight_fit import FEWEST_POINTS

HEADERS = ("time_s,x_m,y_m,z_m", "Timestamp,X,Y,Z")
LAYOUTS = "header time_s,x_m,y_m,z_m, header Timestamp,X,Y,Z, or headerless t;x;y;z"
FARTHEST = 10.0  # m from the table's centre
FASTEST = 60.0  # m/s, median over a recording
SHORTEST = 1e-4  # s between points; coarse stamps of two points may be equal


@dataclass(frozen=True, slots=True)
class Flight:
    """What a tracker saw of a ball; strokes and bounces may lie inside."""

    name: str
    times: Float[ndarray, "n"]  # s, increasing; equal where stamps are coarse
    positions: Float[ndarray, "n 3"]  # m, z up


def is_flight(lines: list[str]) -> bool:
    """Tell whether the lines of a file are in one of the three layouts."""
    return _header(lines) is not None


def read_flight(path: Path) -> Flight:
    """Return the flight in a file.

    Raises:
        InputError: the file is unreadable, in no known layout, or its numbers are no ball's.
    """
    return flight_from_lines(path, read_lines(path))


def flight_from_lines(path: Path, lines: list[str]) -> Flight:
    """Return the flight in the lines of the file `path`.

    Raises:
        InputError: see `read_flight`.
    """
    header = _header(lines)
    if header is None:
        begin = next((line for line in lines if line), "")
        given = f"begins with {begin[:40]!r}" if begin else "is empty"
        raise InputError(f"{path}: {given}; expected a flight: {LAYOUTS}")
    first, delimiter = header
    rows, numbers = parse_rows(path, lines, first=first, delimiter=delimiter, columns=4)
    _check(path, rows, numbers)
    return Flight(str(path), rows[:, 0].copy(), rows[:, 1:].copy())


def read_flights(folder: Path) -> tuple[tuple[Flight, ...], int]:
    """Return the flights in a folder, by name, and how many other files were passed over.

    Raises:
        InputError: there is no flight in it, or one of them is damaged.
    """
    try:
        files = sorted(path for path in folder.iterdir() if path.is_file())
    except OSError as error:
        raise InputError(f"{folder}: cannot be read ({error.strerror})") from None
    return _flights_among(folder, files)


def read_flight_tree(path: Path) -> tuple[tuple[Flight, ...], int]:
    """Return the flight in a file, or those in a folder and its subfolders; see `read_flights`."""
    if not path.is_dir():
        return (read_flight(path),), 0
    return _flights_among(path, sorted(file for file in path.rglob("*") if file.is_file()))


def _flights_among(folder: Path, files: list[Path]) -> tuple[tuple[Flight, ...], int]:
    known = [(path, lines) for path in files if (lines := _lines_of_flight(path))]
    if not known:
        raise InputError(f"{folder}: {len(files)} files, none of them a flight: {LAYOUTS}")
    return tuple(flight_from_lines(*one) for one in known), len(files) - len(known)


def _lines_of_flight(path: Path) -> list[str] | None:
    try:
        lines = read_lines(path)
    except InputError:  # a picture, a video, a table of another kind
        return None
    return lines if is_flight(lines) else None


def _header(lines: list[str]) -> tuple[int, str] | None:
    """Return the index of the first row and the delimiter."""
    at = next((i for i, line in enumerate(lines) if line), None)
    if at is None:
        return None
    compact = lines[at].replace(" ", "")
    if compact in HEADERS:
        return at + 1, ","
    fields = compact.split(";")
    return (at, ";") if len(fields) == 4 and all(map(_is_number, fields)) else None


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _check(path: Path, rows: Float[ndarray, "n 4"], numbers: list[int]) -> None:
    """Raise InputError unless this can be a ball on a table tennis court, in metres and seconds."""
    if len(rows) < FEWEST_POINTS:
        raise InputError(f"{path}: {len(rows)} points; expected at least {FEWEST_POINTS}")
    far = np.abs(rows[:, 1:]).max(axis=1)
    if far.max() > FARTHEST:
        i = int(np.argmax(far > FARTHEST))
        raise InputError(
            f"{path}: line {numbers[i]}: {far[i]:g} m; expected metres, at most {FARTHEST:g} from "
            "the table's centre"
        )
    steps = np.diff(rows[:, 0])
    if steps.min() < 0.0:
        i = int(np.argmax(steps < 0.0))
        raise InputError(
            f"{path}: line {numbers[i + 1]}: time {rows[i + 1, 0]:g} s after {rows[i, 0]:g} s; "
            "expected increasing times"
        )
    if not steps.any():
        raise InputError(f"{path}: every time is {rows[0, 0]:g} s; expected increasing times")
    speed = np.median(
        np.linalg.norm(np.diff(rows[:, 1:], axis=0), axis=1) / np.maximum(steps, SHORTEST)
    )
    if speed > FASTEST:
        raise InputError(
            f"{path}: a ball at {speed:.0f} m/s; expected metres and seconds, at most {FASTEST:g}"
        )
