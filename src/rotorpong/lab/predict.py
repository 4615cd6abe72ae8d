"""How far off the flight filter's predictions of measured flights are.

Every run of points that spans the window and whose ball nobody struck until the target is one
prediction: the filter is fitted to these points and nothing else (`vision.flight_points`), carried
on, bounces included, and compared with the place that was measured then, interpolated between two
neighbouring points. Beside it stand the same filter without spin, and without air.

Recordings are cut at strokes and gaps, never at table bounces (`physics.flight_arcs`): a stroke
cannot be foreseen. The cut looks at the track, not at what was predicted. Errors are told apart by
what happened: `free` of any bounce, `after_bounce` inside the window, `over_bounce` between window
and target.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.flight_files import Flight, read_flight_tree
from rotorpong.lab.flight_frames import along_x, bounce_heights, heights_by_others
from rotorpong.physics.flight_arcs import Arc, find_arcs
from rotorpong.vision.flight_filter import LONGEST_FLIGHT, predict
from rotorpong.vision.flight_points import (
    DRAG_ONLY,
    GRAVITY_ONLY,
    MATCH,
    TRACKED,
    Expectation,
    PointNoise,
    belief_after,
    prior_of,
)

MODELS = {"full": MATCH, "drag_only": DRAG_ONLY, "gravity_only": GRAVITY_ONLY}
KINDS = ("free", "after_bounce", "over_bounce")
FEWEST_POINTS = 5  # in a window
FRAMES_APART = 2.0  # usual steps between the two points that a target lies between, at most
SHORTEST_WINDOW = 0.02  # s
HIGHEST_TABLE = 2.0  # m, either way
LARGEST_SD_MM, LARGEST_SD_MS = 100.0, 50.0

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked of every flight."""

    window: float = 0.15  # s of points that the filter sees
    ahead: float = 0.2  # s after the last of them
    noise: PointNoise = TRACKED
    table_height: float | None = None  # m in the files' frame; None: by other flights' bounces

    def check(self) -> "Question":
        """Return it.

        Raises:
            InputError: a number is not finite or out of range.
        """
        _require("window-s", self.window, SHORTEST_WINDOW, LONGEST_FLIGHT)
        _require("ahead-s", self.ahead, 1e-3, LONGEST_FLIGHT)
        _require("point-sd-mm", 1e3 * self.noise.place_sd, 1e-3, LARGEST_SD_MM)
        _require("stamp-sd-ms", 1e3 * self.noise.stamp_sd, 0.0, LARGEST_SD_MS)
        if self.table_height is not None:
            _require("table-height-m", self.table_height, -HIGHEST_TABLE, HIGHEST_TABLE)
        return self


@dataclass(frozen=True, slots=True)
class Window:
    """Points first .. last - 1 of a flight, and a place measured later."""

    first: int
    last: int
    time: float  # s, of the target
    target: Float[ndarray, "3"]  # m
    kind: str  # one of KINDS


@dataclass(frozen=True, slots=True)
class Recording:
    """A flight, its table along x."""

    flight: Flight
    table_height: float  # m
    windows: tuple[Window, ...]
    longest: float  # s between strokes


@dataclass(frozen=True, slots=True)
class Missed:
    """By how much one prediction missed."""

    kind: str
    errors: dict[str, float]  # m, by model


def predict_flights(path: Path, question: Question, progress: Progress) -> dict[str, Any]:
    """Return what `predict --json` prints.

    Args:
        path: a flight, or a folder with flights in its tree.
        question: what to ask.
        progress: called with (flights done, flights).

    Raises:
        InputError: a file is unreadable or damaged, a number is out of range, or no flight is long
            enough.
    """
    question.check()
    flights, others = read_flight_tree(path)
    recordings = _recordings(flights, question)
    if not any(one.windows for one in recordings):
        raise InputError(
            f"{path}: no window of {question.window:g} s with a point {question.ahead:g} s after "
            f"it and {FEWEST_POINTS} points in it; the longest flight between strokes lasts "
            f"{max(one.longest for one in recordings):.3f} s"
        )
    missed: list[list[Missed]] = []
    for one in recordings:
        progress(len(missed), len(recordings))
        missed.append([_missed(one, window, question.noise) for window in one.windows])
    progress(len(recordings), len(recordings))
    return {
        "path": str(path),
        "window_s": question.window,
        "ahead_s": question.ahead,
        **_pooled([one for flight in missed for one in flight]),
        "flights": [
            {"flight": one.flight.name, "table_height_m": one.table_height, **_by_model(found)}
            for one, found in zip(recordings, missed, strict=True)
            if found
        ],
        "files_passed_over": others,
        "flights_passed_over": sum(not found for found in missed),
    }


def windows_of(flight: Flight, arcs: tuple[Arc, ...], question: Question) -> Iterator[Window]:
    """Yield the windows of a flight with a place that was measured `ahead` after them.

    Args:
        flight: a recording.
        arcs: it, cut.
        question: how long a window is, and how far ahead the target.
    """
    steps = np.diff(flight.times)
    usual = float(np.median(steps[steps > 0.0]))
    for low, high, bounces in _rallies(flight, arcs):
        times = flight.times[:high]
        for first in range(low, high):
            end = times[first] + question.window
            last = int(np.searchsorted(times, end + 0.5 * usual))
            whole = times[last - 1] - times[first] > max(question.window - usual, 0.0)
            time = float(times[last - 1]) + question.ahead
            if last - first < FEWEST_POINTS or not whole:
                continue
            target = _place_at(flight, slice(last - 1, high), time, FRAMES_APART * usual)
            if target is not None:
                kind = _kind(bounces, times[first], times[last - 1], time)
                yield Window(first, last, time, target, kind)


def predicted(
    flight: Flight, window: Window, expectation: Expectation, noise: PointNoise, height: float
) -> Float[ndarray, "3"]:
    """Return where the filter expects the ball at the window's target, m.

    Args:
        flight: a recording.
        window: of its points, the only ones that are used.
        expectation: before them.
        noise: of them.
        height: m, of the table.
    """
    points = slice(window.first, window.last)
    times, positions = flight.times[points], flight.positions[points]
    belief = belief_after(times, positions, expectation, noise=noise, table_height=height)
    return predict(belief, window.time, prior_of(expectation, height)).position


def _recordings(flights: tuple[Flight, ...], question: Question) -> list[Recording]:
    """Return what is asked of each flight; those of one folder are of one frame."""
    folders: dict[Path, list[Flight]] = {}
    for flight in flights:
        folders.setdefault(Path(flight.name).parent, []).append(flight)
    return [one for found in folders.values() for one in _of_one_frame(tuple(found), question)]


def _of_one_frame(flights: tuple[Flight, ...], question: Question) -> Iterator[Recording]:
    flights = along_x(flights)
    arcs = [find_arcs(flight.times, flight.positions) for flight in flights]
    heights = heights_by_others([bounce_heights(*one) for one in zip(flights, arcs, strict=True)])
    if question.table_height is not None:
        heights = [question.table_height] * len(flights)
    for flight, cut, height in zip(flights, arcs, heights, strict=True):
        lasts = [
            flight.times[high - 1] - flight.times[low] for low, high, _ in _rallies(flight, cut)
        ]
        yield Recording(flight, height, tuple(windows_of(flight, cut, question)), max(lasts))


def _missed(one: Recording, window: Window, noise: PointNoise) -> Missed:
    places = {
        name: predicted(one.flight, window, expectation, noise, one.table_height)
        for name, expectation in MODELS.items()
    }
    errors = {name: float(np.linalg.norm(place - window.target)) for name, place in places.items()}
    return Missed(window.kind, errors)


def _rallies(flight: Flight, arcs: tuple[Arc, ...]) -> list[tuple[int, int, tuple[float, ...]]]:
    """Return first and one past the last point between strokes, and the times of the bounces."""
    found: list[tuple[int, int, tuple[float, ...]]] = []
    for arc in arcs:
        if arc.follows_bounce and found:
            low, _, bounces = found[-1]
            bounce = float(flight.times[arc.first - 1 : arc.first + 1].mean())
            found[-1] = (low, arc.last, (*bounces, bounce))
        else:
            found.append((arc.first, arc.last, ()))
    return found


def _place_at(
    flight: Flight, points: slice, time: float, apart: float
) -> Float[ndarray, "3"] | None:
    """Return the place at a time, on the line between two points; None where they are far apart."""
    times, positions = flight.times[points], flight.positions[points]
    after = int(np.searchsorted(times, time))
    if not 0 < after < len(times) or times[after] - times[after - 1] > apart:
        return None
    share = (time - times[after - 1]) / (times[after] - times[after - 1])
    return positions[after - 1] + share * (positions[after] - positions[after - 1])


def _kind(bounces: tuple[float, ...], first: float, last: float, time: float) -> str:
    if any(last <= bounce < time for bounce in bounces):
        return "over_bounce"
    return "after_bounce" if any(first < bounce < last for bounce in bounces) else "free"


def _pooled(missed: list[Missed]) -> dict[str, Any]:
    """Return the summary of all, and the spin filter's by what happened."""
    kinds = {
        kind: _summary([one.errors["full"] for one in missed if one.kind == kind]) for kind in KINDS
    }
    return {**_by_model(missed), **kinds}


def _by_model(missed: list[Missed]) -> dict[str, Any]:
    """Return the summary of the whole filter, and below it those of what it is beside."""
    summaries = {name: _summary([one.errors[name] for one in missed]) for name in MODELS}
    return {**summaries.pop("full"), **summaries}


def _summary(errors: list[float]) -> dict[str, Any]:
    """Return median, 90 % quantile (m) and count; None of nothing."""
    median, p90 = np.quantile(errors, [0.5, 0.9]).tolist() if errors else (None, None)
    return {"median_m": median, "p90_m": p90, "n": len(errors)}


def _require(name: str, value: float, least: float, most: float) -> None:
    if not (math.isfinite(value) and least <= value <= most):
        raise InputError(f"{name} {value:g}: expected a number from {least:g} to {most:g}")
