"""Rows of `rotorpong bench world --flights`: our flight against measured ones.

Every recording is cut at its strokes and bounces (`physics.flight_arcs`). Each arc of free flight
is fitted with less and more of our model (`physics.flight_fit`); what a model leaves, it does not
explain. Drag and lift of the whole population come from fits that believe nearly nothing, the
Magnus coefficient from those whose spin was measured by other means (`lab.spin_files`): the linear
one, by which the lift is that times the spin, and the one of our law, which saturates; the
restitution from the fits on either side of a bounce (`physics.flight_bounces`).
"""

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError
from rotorpong.lab.bench.rows import Row, quantile_rows
from rotorpong.lab.flight_files import Flight, read_flight_tree
from rotorpong.lab.spin_files import spin_of
from rotorpong.physics.ball import Air, Ball, Surface, bounce, fly
from rotorpong.physics.flight_arcs import Arc, find_arcs
from rotorpong.physics.flight_bounces import UP, bounce_between
from rotorpong.physics.flight_fit import USUAL, Belief, FlightFit, fall, fit_flight

Progress = Callable[[int, int], None]
FEWEST_POINTS, SHORTEST = 12, 0.12  # points and s of an arc that tells drag from lift
OPEN = Belief(drag_sd=0.1, drag_range=(0.0, 0.5), spin_sd=400.0, saturation=0.0)
"""Nearly nothing is believed; lift is measured as the spin that would give it if it were linear."""
MODELS = {
    "gravity only": Belief(drag=0.0, drag_sd=0.0, spin_sd=0.0),
    "default drag": Belief(drag=Air().drag, drag_sd=0.0, spin_sd=0.0),
    "fitted drag": Belief(drag_sd=0.1, drag_range=(0.0, 0.5), spin_sd=0.0),
    "drag and spin": USUAL,
}
RESIDUAL_TARGET = 0.4  # of what gravity alone leaves
LONG = 0.25  # s of an arc whose drag counts
FEWEST = 5  # values that get a median
_quantiles = functools.partial(quantile_rows, fewest=FEWEST)
STRAIGHT = 0.7  # cosine between the lift and that of the measured spin
SPIN_RATIOS = (0.0, 0.15, 0.4, 0.7, 1.5)  # edges of classes
NORMAL_SPEEDS = (1.5, 2.0, 2.5, 3.0, 4.5)  # m/s, edges of classes
MOST_RESIDUAL = 0.01  # m rms: what a flight on which constants are fitted may leave
DROP, REBOUND = 0.305, (0.230, 0.245, 0.260)  # m: ITTF technical leaflet T3, ball on steel
DROP_STEPS = 60


@dataclass(frozen=True, slots=True)
class Fitted:
    """One arc of a recording and what was fitted to it."""

    flight: Flight
    arc: Arc
    residuals: dict[str, float]  # m rms, by model
    open_fit: FlightFit

    @property
    def lasts(self) -> float:
        """Length of the arc, s."""
        return float(self.flight.times[self.arc.last - 1] - self.flight.times[self.arc.first])


def rows(path: Path, progress: Progress) -> tuple[Row, ...]:
    """Return what measured flights say about the product's flight and bounce.

    Args:
        path: a flight, or a folder with flights in its tree.
        progress: called with (flights done, flights).

    Raises:
        InputError: a file is unreadable or damaged, or no flight is long enough.
    """
    flights, others = require(path)
    arcs: list[list[Fitted]] = []
    for done, flight in enumerate(flights):
        progress(done, len(flights))
        arcs.append(fit_arcs(flight))
    progress(len(flights), len(flights))
    found = list(itertools.chain(*arcs))
    counts = [
        Row("flights: recordings", len(flights), "files"),
        Row("flights: files passed over", others, "files"),
        Row("flights: arcs of free flight", len(found), "arcs"),
    ]
    return (
        *counts,
        *_residual_rows(found),
        *_drag_rows(found),
        *_magnus_rows(found),
        *_bounce_rows(arcs),
        *drop_rows(Air()),
    )


def require(path: Path) -> tuple[tuple[Flight, ...], int]:
    """Return the flights that `rows` measures, and how many files are none.

    Raises:
        InputError: see `rows`.
    """
    flights, others = read_flight_tree(path)
    if not any(map(_long_arcs, flights)):
        raise InputError(
            f"{path}: no free flight of {FEWEST_POINTS} points and {SHORTEST:g} s in "
            f"{len(flights)} recordings"
        )
    return flights, others


def fit_arcs(flight: Flight) -> list[Fitted]:
    """Return the fits of the arcs of a recording that are long enough."""
    return [_fitted(flight, arc) for arc in _long_arcs(flight)]


def drop_rows(air: Air) -> list[Row]:
    """Return the restitutions at which a dropped ball rebounds as the ITTF asks, air included."""
    return [
        Row(
            f"ITTF drop: restitution for a rebound of {1e3 * height:.0f} mm",
            restitution_of_drop(height, air),
            "1",
        )
        for height in REBOUND
    ]


def restitution_of_drop(height: float, air: Air) -> float:
    """Return the restitution of a ball that drops 305 mm in air and rebounds to `height` (m)."""
    still = np.zeros((1, 3))
    landed, _ = fall(Ball(DROP * UP[None], still, still), air, 0.0, 1.0)
    low, high = 0.5, 1.0
    for _ in range(DROP_STEPS):
        middle = 0.5 * (low + high)
        up = bounce(landed, UP, Surface(middle, 0.0))
        low, high = (middle, high) if _apex(up, air) < height else (low, middle)
    return 0.5 * (low + high)


def _apex(ball: Ball, air: Air) -> float:
    """Return the greatest height of a rising ball, m: where its speed goes through 0."""
    low, high = 0.0, 1.0
    for _ in range(DROP_STEPS):
        middle = 0.5 * (low + high)
        rising = fly(ball, air, middle).velocity[0, 2] > 0.0
        low, high = (middle, high) if rising else (low, middle)
    return float(fly(ball, air, low).position[0, 2])


def _long_arcs(flight: Flight) -> list[Arc]:
    return [
        arc
        for arc in find_arcs(flight.times, flight.positions)
        if arc.points >= FEWEST_POINTS
        and flight.times[arc.last - 1] - flight.times[arc.first] >= SHORTEST
    ]


def _fitted(flight: Flight, arc: Arc) -> Fitted:
    points = slice(arc.first, arc.last)
    times, positions = flight.times[points], flight.positions[points]
    residuals = {
        name: fit_flight(times, positions, bounces=False, belief=belief).residual_rms
        for name, belief in MODELS.items()
    }
    return Fitted(flight, arc, residuals, fit_flight(times, positions, bounces=False, belief=OPEN))


def _residual_rows(found: list[Fitted]) -> list[Row]:
    medians = {name: float(np.median([one.residuals[name] for one in found])) for name in MODELS}
    ratio = medians["drag and spin"] / max(medians["gravity only"], 1e-9)
    return [
        *(
            Row(f"flights: residual, {name}, median rms", 1e3 * value, "mm")
            for name, value in medians.items()
        ),
        Row(
            "flights: residual, drag and spin over gravity only",
            ratio,
            "1",
            target=RESIDUAL_TARGET,
            better="less",
        ),
    ]


def _drag_rows(found: list[Fitted]) -> list[Row]:
    good = [one for one in found if one.lasts >= LONG and _is_clean(one)]
    return _quantiles("flights: drag", np.array([one.open_fit.drag for one in good]), "1/m")


def _magnus_rows(found: list[Fitted]) -> list[Row]:
    """Return the Magnus coefficient that turns measured spin into the measured lift."""
    known: dict[Path, dict[int, Float[ndarray, "3"]]] = {}
    measured = []
    for one in found:
        spin = spin_of(one.flight.name, known) if one.arc.first == 0 else None
        if spin is not None and _is_clean(one):
            measured.append(lift(one.open_fit, spin))
    if not measured:
        return []
    magnus, cosine, ratio = np.array(measured).T
    agree = cosine > STRAIGHT
    found_rows = [
        Row("flights: arcs with measured spin", len(measured), "arcs"),
        Row("flights: spin and lift within 45 degrees", float(agree.mean()), "1"),
        Row("flights: spin against the lift", float(np.mean(cosine < -STRAIGHT)), "1"),
        *_quantiles("flights: linear Magnus coefficient", magnus[agree], "1"),
    ]
    small = magnus * (1.0 + Air().saturation * ratio)  # at small spin ratios, by our law
    found_rows += _quantiles("flights: Magnus coefficient, our saturation", small[agree], "1")
    for low, high in itertools.pairwise(SPIN_RATIOS):
        at = agree & (ratio >= low) & (ratio < high)
        words = f"at spin ratio {low:g}-{high:g}"
        found_rows += _quantiles(f"flights: linear Magnus coefficient {words}", magnus[at], "1")
        name = f"flights: Magnus coefficient, our saturation, {words}"
        found_rows += _quantiles(name, small[at], "1")
    return found_rows


def lift(fit: FlightFit, spin: Float[ndarray, "3"]) -> tuple[float, float, float]:
    """Return linear Magnus coefficient, cosine between fitted and measured spin, and spin ratio."""
    speed = float(np.linalg.norm(fit.ball.velocity))
    along = fit.ball.velocity / speed
    fitted, measured = (w - (w @ along) * along for w in (fit.spin, spin))
    size = float(np.linalg.norm(measured))
    share = float(fitted @ measured) / size**2
    cosine = float(fitted @ measured) / (size * max(float(np.linalg.norm(fitted)), 1e-9))
    return fit.air.magnus * share, cosine, BALL_RADIUS * size / speed


def _bounce_rows(arcs: list[list[Fitted]]) -> list[Row]:
    pairs = [pair for flight in arcs for pair in itertools.pairwise(flight) if _is_bounce(*pair)]
    measured = [
        bounce_between(
            before.open_fit,
            after.open_fit,
            float(after.flight.times[after.arc.first] - before.flight.times[before.arc.first]),
        )
        for before, after in pairs
    ]
    restitution = np.array([one.restitution[0] for one in measured])
    found = _quantiles("flights: restitution", restitution, "1")
    speed = np.array([-one.before.velocity[0, 2] for one in measured])
    for low, high in itertools.pairwise(NORMAL_SPEEDS):
        at = (speed >= low) & (speed < high)
        found += _quantiles(f"flights: restitution at {low:g}-{high:g} m/s", restitution[at], "1")
    folders = np.array([str(Path(before.flight.name).parent) for before, _ in pairs])
    flat = np.array([one.before.velocity[0, :2] for one in measured]).reshape(-1, 2)
    for folder in sorted(set(folders.tolist())):
        at = folders == folder
        found += both_ways(Path(folder).name, flat[at], restitution[at])
    return found


def both_ways(
    folder: str, flat: Float[ndarray, "n 2"], restitution: Float[ndarray, "n"]
) -> list[Row]:
    """Return the restitution of balls that fly one way, the other way, and the mean of the two.

    A measured frame that is tilted by a small angle a adds a v to every vertical speed, down and
    up; with v of 8 m/s, half a degree is 0.06 in the restitution. The mean of both ways is free
    of it.
    """
    main = np.linalg.svd(flat, full_matrices=False)[2][0]
    ways = [restitution[sign * (flat @ main) > 0.0] for sign in (1.0, -1.0)]
    medians = [float(np.median(way)) for way in ways if len(way) >= FEWEST]
    found = [
        Row(f"flights: restitution in {folder}, way {i}, median", median, "1")
        for i, median in enumerate(medians, start=1)
    ]
    if len(medians) == 2:
        mean = float(np.mean(medians))
        found.append(Row(f"flights: restitution in {folder}, mean of both ways", mean, "1"))
    return found


def _is_bounce(before: Fitted, after: Fitted) -> bool:
    joined = after.arc.follows_bounce and before.arc.last == after.arc.first
    return joined and _is_clean(before) and _is_clean(after)


def _is_clean(one: Fitted) -> bool:
    return one.open_fit.residual_rms < MOST_RESIDUAL
