"""Rows of `rotorpong bench world --events`: our flight and bounce against measured matches.

Every event gives the ball's state just after it. A leg from a shot or bounce to the next bounce
tells what the air does (`physics.flight_legs`); the flight through its two measured positions gives
the state just before the bounce, and the next row the state just after it: what the table does
(`physics.flight_bounces`). The velocities of the rows are undone their common delay, which the legs
show, before they are compared.
"""

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError
from rotorpong.lab.bench.rows import Row, quantile_rows
from rotorpong.lab.event_files import Event, read_events
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, bounce
from rotorpong.physics.flight_bounces import (
    GRIPPING,
    SLIDING,
    UP,
    Bounces,
    sliding_friction,
)
from rotorpong.physics.flight_fit import fall
from rotorpong.physics.flight_legs import AirFit, Legs, fit_air, landing, undelayed

Progress = Callable[[int, int], None]
STEPS = 4
SHORTEST_LEG = 0.08  # s
LONGEST_FLIGHT = 3.0  # s: a ball that is gone for longer was missed in between
FEWEST = 20  # in a class that gets a row
_quantiles = functools.partial(quantile_rows, fewest=FEWEST)
SPIN_RATIOS = (0.0, 0.3, 0.45, 0.6, 0.8, 1.2)  # edges of classes
NORMAL_SPEEDS = (1.5, 2.0, 2.5, 3.0, 4.5)  # m/s
SPUN = 100.0  # rad/s that make a topspin or a backspin
FELT = 60.0  # rad/s of predicted change that its measurement can be compared with
LEAST_SLIP = 0.5  # m/s, of which a share can be told from noise
ODD_BALLS = np.errstate(divide="ignore", invalid="ignore")  # come in level, say: not finite
LONG_LEG = 0.3  # s, over which spin that decays can be told from noise


@dataclass(frozen=True, slots=True)
class Match:
    """Legs that end in a bounce, with the measured ball after it."""

    legs: Legs
    after: Ball
    from_shot: Bool[ndarray, "n"]  # else from a bounce


def rows(path: Path, progress: Progress) -> tuple[Row, ...]:
    """Return what a file or folder of events says about air and table.

    Args:
        path: a CSV of events, or a folder with such files in its tree.
        progress: called with (steps done, steps).

    Raises:
        InputError: a file is unreadable or damaged, or too few events are usable.
    """
    progress(0, STEPS)
    events, others, match = require(path)
    progress(1, STEPS)
    fit = fit_air(match.legs)
    found = [*_counts(events, others, match), *_air_rows(fit)]
    progress(2, STEPS)
    found += [*_lift_rows(match.legs, fit), *_flight_rows(match, fit)]
    progress(3, STEPS)
    bounces = bounces_of(match, fit)
    found += [*_bounce_rows(bounces, match), *_law_rows(bounces, match)]
    progress(STEPS, STEPS)
    return tuple(found)


def require(path: Path) -> tuple[tuple[Event, ...], int, Match]:
    """Return the events that `rows` measures, how many files are none, and the match of them.

    Raises:
        InputError: see `rows`.
    """
    events, others = read_events(path)
    match = match_of(events)
    if len(match.legs) < FEWEST:
        raise InputError(
            f"{path}: {len(match.legs)} flights to a bounce in {len(events)} events; expected at "
            f"least {FEWEST}"
        )
    return events, others, match


def match_of(events: tuple[Event, ...]) -> Match:
    """Return the legs that end in a bounce; events without velocity or after a gap are left out."""
    pairs = [pair for pair in itertools.pairwise(events) if _is_leg(*pair)]
    starts, ends = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    duration = np.array([end.time - start.time for start, end in pairs])
    legs = Legs(_balls(starts), _balls(ends).position, duration)
    from_shot = np.array([start.kind == "shot" for start in starts], dtype=bool)
    return Match(legs, _balls(ends), from_shot)


def bounces_of(match: Match, fit: AirFit) -> Bounces:
    """Return each bounce: before it by its leg's two ends, after it as measured, delay undone."""
    _, before = landing(match.legs, fit.air)
    return Bounces(before, undelayed(match.after, fit.air, fit.delay))


def _is_leg(start: Event, end: Event) -> bool:
    follows = start.rally == end.rally and end.number == start.number + 1
    lasts = SHORTEST_LEG < end.time - start.time <= LONGEST_FLIGHT
    free = start.kind != "net" and end.kind == "bounce"
    return follows and lasts and free and start.measured and end.measured


def _balls(events: list[Event]) -> Ball:
    parts = [[e.position for e in events], [e.velocity for e in events], [e.spin for e in events]]
    return Ball(*(np.array(part, dtype=float).reshape(-1, 3) for part in parts))


def _counts(events: tuple[Event, ...], others: int, match: Match) -> list[Row]:
    return [
        Row("events: rows read", len(events), "events"),
        Row("events: files passed over", others, "files"),
        Row("events: rows without velocity", sum(not e.measured for e in events), "events"),
        Row("events: flights to a bounce", len(match.legs), "flights"),
    ]


def _air_rows(fit: AirFit) -> list[Row]:
    return [
        Row("events: drag of all flights", fit.air.drag, "1/m"),
        Row("events: drag of all flights, standard error", fit.drag_sd, "1/m"),
        Row("events: Magnus coefficient of all flights", fit.air.magnus, "1"),
        Row("events: Magnus coefficient of all flights, standard error", fit.magnus_sd, "1"),
        Row("events: lift saturation of all flights", fit.air.saturation, "1"),
        Row("events: lift saturation of all flights, standard error", fit.saturation_sd, "1"),
        Row("events: delay of the velocities", 1e3 * fit.delay, "ms"),
    ]


def _lift_rows(legs: Legs, fit: AirFit) -> list[Row]:
    """Return the Magnus coefficient with our saturation, and the linear ones by spin ratio."""
    ours = fit_air(legs, saturation=Air().saturation).air
    found = [Row("events: Magnus coefficient, our saturation", ours.magnus, "1")]
    for low, high in itertools.pairwise((*SPIN_RATIOS, np.inf)):
        which = (legs.spin_ratio >= low) & (legs.spin_ratio < high)
        if which.sum() < FEWEST:
            continue
        linear = fit_air(legs[which], drag=fit.air.drag, saturation=0.0, delay=fit.delay).air
        ratio = float(np.median(legs.spin_ratio[which]))
        name = f"events: linear Magnus coefficient at spin ratio {ratio:.2f} (n = {which.sum()})"
        found.append(Row(name, linear.magnus, "1"))
    return found


def _flight_rows(match: Match, fit: AirFit) -> list[Row]:
    """Return how near the product's air, and that of all these flights, come to the bounces."""
    airs = {"our air": Air(), "air of all flights": fit.air}
    return [row for name, air in airs.items() for row in _landing_rows(match.legs, fit, name, air)]


def _landing_rows(legs: Legs, fit: AirFit, words: str, air: Air) -> list[Row]:
    start = undelayed(legs.start, air, fit.delay)
    end, times = fall(start, air, BALL_RADIUS, LONGEST_FLIGHT)
    landed = np.isfinite(times)
    miss = np.linalg.norm((end.position - legs.end)[:, :2], axis=1)
    late = np.abs(times - legs.duration)
    found = [Row(f"events: share that lands, {words}", float(landed.mean()), "1")]
    slow = legs.spin_ratio < SPIN_RATIOS[2]
    for which, kind in ((landed, "all"), (landed & slow, f"spin ratio < {SPIN_RATIOS[2]}")):
        name = f"{words}, {kind}"
        found += _quantiles(f"events: landing place error, {name}", 1e3 * miss[which], "mm")
        found += _quantiles(f"events: landing time error, {name}", 1e3 * late[which], "ms")
    return found


@ODD_BALLS
def _bounce_rows(bounces: Bounces, match: Match) -> list[Row]:
    """Return restitution, friction, grip and spin, each measured by itself."""
    as_given = -match.after.velocity[:, 2] / bounces.before.velocity[:, 2]
    friction, sliding = sliding_friction(bounces)
    found = [
        *_quantiles("events: restitution, velocities as given", as_given, "1"),
        *_quantiles("events: restitution, delay undone", bounces.restitution, "1"),
    ]
    speed = -bounces.before.velocity[:, 2]
    for low, high in itertools.pairwise(NORMAL_SPEEDS):
        at = (speed >= low) & (speed < high)
        name = f"events: restitution, delay undone, at {low:g}-{high:g} m/s"
        found += _quantiles(name, bounces.restitution[at], "1")
    found += _quantiles("events: friction of sliding balls", bounces.friction[sliding], "1")
    if not np.isfinite(friction):
        return found
    slips = np.linalg.norm(bounces.slip, axis=1) > LEAST_SLIP
    gripping = slips & (bounces.slip_over_grip(friction) < GRIPPING)
    found += _quantiles("events: slip that gripping balls lose", bounces.removed[gripping], "1")
    return [*found, *_spin_rows(bounces, match)]


def _spin_rows(bounces: Bounces, match: Match) -> list[Row]:
    """Return how spin changed at the bounce, and in flight: about the vertical."""
    felt = np.linalg.norm(bounces.predicted_spin_change, axis=1) > FELT
    found = _quantiles("events: spin change over a thin shell's", bounces.coupling[felt], "1")
    old, new = match.legs.start.spin[:, 2], match.after.spin[:, 2]
    lasting = (np.abs(old) > FELT) & (old * new > 0.0) & (match.legs.duration > LONG_LEG)
    decay = np.log(old[lasting] / new[lasting]) / match.legs.duration[lasting]
    return [*found, *_quantiles("events: decay of spin about the vertical", decay, "1/s")]


@ODD_BALLS
def _law_rows(bounces: Bounces, match: Match) -> list[Row]:
    """Return the errors of the product's bounce, measured minus predicted, by regime and spin."""
    predicted = bounce(bounces.before, UP, TABLE_SURFACE)
    ahead = bounces.before.velocity * [1.0, 1.0, 0.0]
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    aside = np.cross(UP, ahead)  # left of the flight; topspin turns about it
    topspin = np.sum(bounces.before.spin * aside, axis=1)
    slip = bounces.slip_over_grip(TABLE_SURFACE.friction)
    classes = {
        "all": slip > -1.0,
        "gripping": slip < GRIPPING,
        "between": (slip >= GRIPPING) & (slip <= SLIDING),
        "sliding": slip > SLIDING,
        "topspin": topspin > SPUN,
        "backspin": topspin < -SPUN,
        "little or side spin": np.abs(topspin) <= SPUN,
    }
    velocity = bounces.after.velocity - predicted.velocity
    spin = bounces.after.spin - predicted.spin
    as_given = match.after.velocity[:, 2] - predicted.velocity[:, 2]
    found = _spread("events: up velocity error, velocities as given", as_given, "m/s")
    for words, which in classes.items():
        if which.sum() >= FEWEST:
            found.append(Row(f"events: bounces, {words}", int(which.sum()), "bounces"))
            for axis, name in ((ahead, "forward"), (aside, "left"), (UP, "up")):
                found += _spread(
                    f"events: {name} velocity error, {words}",
                    np.sum(velocity * axis, axis=1)[which],
                    "m/s",
                )
                found += _spread(
                    f"events: {name} spin error, {words}",
                    np.sum(spin * axis, axis=1)[which],
                    "rad/s",
                )
    return found


def _spread(name: str, values: Float[ndarray, "n"], unit: str) -> list[Row]:
    """Return median and half the width between the 16 % and 84 % quantiles of what is finite."""
    values = values[np.isfinite(values)]
    if not len(values):
        return []
    low, middle, high = np.quantile(values, [0.16, 0.5, 0.84])
    return [
        Row(f"{name}, median", float(middle), unit),
        Row(f"{name}, spread", float(0.5 * (high - low)), unit),
    ]
