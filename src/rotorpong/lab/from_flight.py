"""From a measured flight to a serve at the drone.

Measured flights are short and go anywhere. A recording is cut at its strokes and bounces
(`physics.flight_arcs`); an arc, with the arc after it if a table bounce joins them, is fitted
(`physics.flight_fit`) and brought to the drone (`placing`). Between two strokes there is at most
one serve: pairs of arcs are tried before single ones, long ones before short ones.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.flight_files import Flight, read_flight, read_flights
from rotorpong.lab.placing import Placed, place
from rotorpong.physics.flight_arcs import Arc, find_arcs
from rotorpong.physics.flight_fit import FEWEST_POINTS, FlightFit, fit_flight
from rotorpong.world.serves import Serve

SHORTEST = 0.12  # s that a flight must be seen for
MOST_RESIDUAL = 0.03  # m rms: what is further off is no free flight of a ball


@dataclass(frozen=True, slots=True)
class FlightServe:
    """A serve made of a measured flight."""

    name: str  # of the recording
    fit: FlightFit
    placed: Placed
    start_time: float  # s of the recording, at the first point of the flight

    @property
    def serve(self) -> Serve:
        """The serve."""
        return self.placed.serve

    def as_json(self) -> dict[str, Any]:
        """Return how it was made, as `serves from-flight --json` prints it."""
        return {
            "flight": self.name,
            "start_time_s": self.start_time,
            "points": self.fit.points,
            "residual_rms_mm": 1e3 * self.fit.residual_rms,
            "drag_per_m": self.fit.drag,
            "bounces": self.placed.bounces,
            "target_left_m": self.placed.left,
            "target_up_m": self.placed.up,
        }


@dataclass(frozen=True, slots=True)
class Conversion:
    """What became of a file or folder of flights."""

    serves: tuple[FlightServe, ...]
    files_passed_over: int  # in none of the layouts
    flights_passed_over: int  # with no serve in them

    def as_json(self) -> dict[str, Any]:
        """Return what `serves from-flight --json` prints."""
        return {
            "serves": [serve.as_json() for serve in self.serves],
            "files_passed_over": self.files_passed_over,
            "flights_passed_over": self.flights_passed_over,
        }


def serves_from_flight(flight: Flight) -> tuple[Serve, ...]:
    """Return the serves in a recording, one for each ball that was struck.

    Raises:
        InputError: there is none; the message says why.
    """
    return tuple(found.serve for found in convert_flight(flight))


def convert(path: Path) -> Conversion:
    """Return the serves in a flight file, or in the flights of a folder.

    Raises:
        InputError: a file is unreadable or damaged, or there is no serve in any.
    """
    if not path.is_dir():
        return Conversion(convert_flight(read_flight(path)), 0, 0)
    flights, others = read_flights(path)
    found: list[FlightServe] = []
    useless = 0
    for flight in flights:
        try:
            found += convert_flight(flight)
        except InputError:
            useless += 1
    if not found:
        raise InputError(f"{path}: no serve in any of its {len(flights)} flights")
    return Conversion(tuple(found), others, useless)


def convert_flight(flight: Flight) -> tuple[FlightServe, ...]:
    """Return the serves in a recording with all that is known of them.

    Raises:
        InputError: there is none; the message says why.
    """
    found, reasons = [], []
    for rally in _rallies(find_arcs(flight.times, flight.positions)):
        try:
            found.append(_serve_of(flight, rally))
        except InputError as error:
            reasons.append(str(error))
    if not found:
        why = reasons[0] if reasons else "no free flight in it"
        raise InputError(f"{flight.name}: no serve can be made of it: {why}")
    return tuple(found)


def _rallies(arcs: tuple[Arc, ...]) -> list[tuple[Arc, ...]]:
    """Return the arcs between strokes, longest recording first."""
    groups: list[tuple[Arc, ...]] = []
    for arc in arcs:
        if arc.follows_bounce:
            groups[-1] = (*groups[-1], arc)
        else:
            groups.append((arc,))
    return sorted(groups, key=lambda group: -sum(arc.points for arc in group))


def _serve_of(flight: Flight, rally: tuple[Arc, ...]) -> FlightServe:
    """Return the first serve that can be made of the arcs between two strokes."""
    reasons = []
    for arcs in _candidates(rally):
        points = slice(arcs[0].first, arcs[-1].last)
        lasts = flight.times[arcs[-1].last - 1] - flight.times[arcs[0].first]
        if lasts < SHORTEST:
            reasons.append(f"seen for {lasts:.3f} s of free flight; expected at least {SHORTEST:g}")
            continue
        fit = fit_flight(flight.times[points], flight.positions[points], bounces=len(arcs) == 2)
        if fit.residual_rms > MOST_RESIDUAL:
            reasons.append(
                f"its {fit.points} points are no free flight of a ball "
                f"(the best fit is {1e3 * fit.residual_rms:.0f} mm off, at most 30 expected)"
            )
            continue
        placed = place(fit, _chord(flight.positions[points]))
        if placed is not None:
            start_time = float(flight.times[arcs[0].first])
            return FlightServe(flight.name, fit, placed, start_time)
        reasons.append(
            "wherever it is moved, it does not reach the blade plane with at most one touch, "
            "of the table's near half"
        )
    raise InputError(reasons[0] if reasons else f"no {FEWEST_POINTS} points of free flight")


def _candidates(rally: tuple[Arc, ...]) -> Iterator[tuple[Arc, ...]]:
    """Yield arcs to fit: pairs around a bounce, then single ones, those with most points first."""
    pairs = list(itertools.pairwise(rally))
    singles = [(arc,) for arc in rally]
    for kind in (pairs, singles):
        for arcs in sorted(kind, key=lambda arcs: -sum(arc.points for arc in arcs)):
            if sum(arc.points for arc in arcs) >= FEWEST_POINTS:
                yield arcs


def _chord(positions: Float[ndarray, "n 3"]) -> Float[ndarray, "2"]:
    """Return the way from the first to the last point, seen from above."""
    return positions[-1, :2] - positions[0, :2]
