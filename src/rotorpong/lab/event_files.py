"""Measured events of matches: the ball's state just after each shot, bounce and touch of the net.

A CSV with the header `player_id,rally_id,type,timestamp,ball_pos,ball_vel_out,ball_spin_out`:
`rally_id` ends in `event1`, `event2`, ... in order of time; `type` is `net`, or `shot_` or
`bounce_` with a side; times in s; the vectors are written `[x y z]`, in m, m/s and rad/s, z up, the
origin at the centre of the table, x along it. Velocity and spin that were not measured are
`[nan nan nan]`. In a folder, down to its subfolders, any other file is passed over and counted.
"""

import csv
import itertools
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.flight_files import FARTHEST, FASTEST
from rotorpong.lab.number_rows import finite_number, read_lines

HEADER = "player_id,rally_id,type,timestamp,ball_pos,ball_vel_out,ball_spin_out"
FIELDS = len(HEADER.split(","))
KIND = re.compile(r"(shot|bounce)_\w+|net")
PLACE = re.compile(r"(.*)event(\d+)")
FASTEST_SPIN = 2000.0  # rad/s, twice the fastest ever measured


@dataclass(frozen=True, slots=True)
class Event:
    """A ball just after something touched it."""

    rally: str
    number: int  # in the rally
    kind: str  # shot, bounce or net
    time: float  # s
    position: Float[ndarray, "3"]  # m
    velocity: Float[ndarray, "3"]  # m/s, NaN if not measured
    spin: Float[ndarray, "3"]  # rad/s, NaN if not measured

    @property
    def measured(self) -> bool:
        """Whether velocity and spin are known."""
        return bool(np.isfinite(self.velocity).all() and np.isfinite(self.spin).all())


def read_events(path: Path) -> tuple[tuple[Event, ...], int]:
    """Return the events in a file, or in a folder's files, and how many files were passed over.

    Raises:
        InputError: a file is unreadable or damaged, or there are no events in any.
    """
    if not path.is_dir():
        return _events_of(path, read_lines(path)), 0
    files = sorted(file for file in path.rglob("*") if file.is_file())
    known = [(file, lines) for file in files if (lines := _lines_of_events(file))]
    if not known:
        raise InputError(f"{path}: {len(files)} files, none of them with the header {HEADER}")
    events = tuple(event for file, lines in known for event in _events_of(file, lines))
    return events, len(files) - len(known)


def _lines_of_events(path: Path) -> list[str] | None:
    try:
        lines = read_lines(path)
    except InputError:  # a picture, a video
        return None
    return lines if _has_header(lines) else None


def _has_header(lines: list[str]) -> bool:
    return bool(lines) and lines[0].replace(" ", "") == HEADER


def _events_of(path: Path, lines: list[str]) -> tuple[Event, ...]:
    if not _has_header(lines):
        given = f"begins with {lines[0][:40]!r}" if any(lines) else "is empty"
        raise InputError(f"{path}: {given}; expected the header {HEADER}")
    rows = ((i, line) for i, line in enumerate(lines[1:], start=2) if line)
    events = tuple(_event(path, f"{path}: line {i}", next(csv.reader([line]))) for i, line in rows)
    if not events:
        raise InputError(f"{path}: no row after its header; expected events")
    for one, other in itertools.pairwise(events):
        if one.rally == other.rally and other.time < one.time:
            raise InputError(
                f"{path}: {other.rally}event{other.number} at {other.time:g} s comes after "
                f"{one.time:g} s; expected increasing times"
            )
    return events


def _event(path: Path, where: str, fields: list[str]) -> Event:
    if len(fields) != FIELDS:
        raise InputError(f"{where}: {len(fields)} fields; expected {FIELDS}")
    player, rally, kind, stamp, *vectors = (field.strip() for field in fields)
    place = PLACE.fullmatch(rally)
    if place is None:
        raise InputError(f"{where}: rally_id {rally[:40]!r}; expected one that ends in event<n>")
    if KIND.fullmatch(kind) is None:
        raise InputError(f"{where}: type {kind[:40]!r}; expected shot_..., bounce_... or net")
    position, velocity, spin = (_vector(where, vector) for vector in vectors)
    missing = bool(np.isnan(velocity).all() and np.isnan(spin).all())
    limits = ((position, FARTHEST, "m"), (velocity, FASTEST, "m/s"), (spin, FASTEST_SPIN, "rad/s"))
    for vector, most, unit in limits[: 1 if missing else 3]:
        size = float(np.linalg.norm(vector))
        if not size <= most:
            raise InputError(f"{where}: {size:g} {unit}; expected at most {most:g}")
    return Event(
        rally=f"{path.name} {player} {place[1]}",
        number=int(place[2]),
        kind=kind.partition("_")[0],
        time=finite_number(f"{where}: timestamp", stamp),
        position=position,
        velocity=velocity,
        spin=spin,
    )


def _vector(where: str, field: str) -> Float[ndarray, "3"]:
    inside = field[1:-1].split() if field[:1] == "[" and field[-1:] == "]" else []
    try:
        vector = np.array([float(part) for part in inside])
    except ValueError:
        vector = np.empty(0)
    if vector.shape != (3,):
        raise InputError(f"{where}: {field[:60]!r}; expected a vector [x y z]")
    return vector
