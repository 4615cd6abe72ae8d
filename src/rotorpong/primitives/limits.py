"""What a vehicle can fly: limits of speed, acceleration and place, told and kept before the flight.

A number limits the norm, one number per coordinate each by itself, the box the goal. Peaks are
those of the polynomials that a motion is made of (`extrema.py`), not of samples.

Kept by time: the fastest duration, no shorter than what was asked, that is within the limits. More
time does not always help: between states in motion, a long time needs a detour. So the durations
are searched upwards in steps of 0.75 %, and the first that fits is refined to a relative 1e-9;
stretches of fitting durations narrower than a step may be missed.

Kept by goal: the nearest goal to the one asked on the line from the start, with the same velocity
and duration. With goal = start + c (asked - start) the motion is affine in c, so its largest speed
and acceleration are convex in c, and the fitting c, if any, are one interval.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import minimize_scalar

from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError
from rotorpong.primitives.dmp import Dmp, State, moving_target
from rotorpong.primitives.extrema import derived, largest_norm, pieces_of
from rotorpong.primitives.quintic import quintic_curvature, quintic_slope
from rotorpong.primitives.regoal import Flight

LONGEST_STRETCH = 20.0  # times what a motion between states at rest would need, is searched
MOST_STEPS = 4000
STEP = 1.0075  # from one duration to the next
FLIGHT_LOOKS = 1001  # samples of a flight
LOOKS = 121  # instants that rule a duration out before it is examined exactly
PRECISION = 1e-9  # of duration and goal
WITHIN = 1.0 + 1e-12  # ratio of a peak to its limit that rounding may give

Limit = float | Float[ndarray, "d"]


@dataclass(frozen=True, slots=True)
class Limits:
    """What a motion must not exceed."""

    speed: Limit | None = None  # m/s
    acceleration: Limit | None = None  # m/s^2
    goal_box: Float[ndarray, "2 d"] | None = None  # m, lowest and highest corner

    def __post_init__(self) -> None:
        """Check what the user gave."""
        for name, limit in (("speed", self.speed), ("acceleration", self.acceleration)):
            if limit is not None and not (np.asarray(limit) > 0.0).all():
                raise InputError(f"{name} limit {limit}: expected positive numbers")
        box = self.goal_box
        if box is not None and not (box[0] <= box[1]).all():
            raise InputError(f"goal_box {box.tolist()}: expected the lowest corner, then the other")

    @classmethod
    def of_commands(
        cls, largest: Float[ndarray, "4"], *, acceleration: Limit | None = None
    ) -> "Limits":
        """Return the limits of motions in level camera axes by the commands of a vehicle.

        Args:
            largest: forward, left, up in m/s, yaw rate: `Vehicle.limits`.
            acceleration: m/s^2, if one is known.
        """
        return cls(np.abs(CAMERA_FROM_BODY_AXES) @ largest[:3], acceleration)


@dataclass(frozen=True, slots=True)
class Peak:
    """The instant of a motion that comes nearest to a limit, or most beyond it."""

    value: float  # m/s or m/s^2: norm, or magnitude along `coordinate`
    time: float  # s since the start
    limit: float  # inf if there is none
    coordinate: int | None = None  # of a limit for each by itself

    @property
    def ratio(self) -> float:
        """Return value / limit."""
        return self.value / self.limit


@dataclass(frozen=True, slots=True)
class LimitReport:
    """How near a motion comes to its limits."""

    speed: Peak
    acceleration: Peak
    goal_is_inside: bool

    @property
    def ratio(self) -> float:
        """Return the larger ratio of peak to limit, above 1 if the motion cannot be flown."""
        return max(self.speed.ratio, self.acceleration.ratio)

    @property
    def is_feasible(self) -> bool:
        """Tell whether all limits are kept."""
        return self.goal_is_inside and self.ratio <= WITHIN


@dataclass(frozen=True, slots=True)
class Adjusted:
    """A motion within its limits, as near as possible to what was asked."""

    goal: State
    duration: float  # s
    report: LimitReport


def report_limits(
    dmp: Dmp, start: State, goal: State, duration: float, limits: Limits
) -> LimitReport:
    """Return the peaks of the motion that `dmp.roll_out` would give, beside their limits.

    Raises:
        InputError: as `Dmp.roll_out`, or limits of other dimensions.
    """
    _check_dimensions(dmp, limits)
    target = moving_target(dmp, start, goal, duration)
    polynomials = pieces_of(target, dmp.answer())
    return LimitReport(
        _peak(derived(polynomials, 1, duration), limits.speed, duration),
        _peak(derived(polynomials, 2, duration), limits.acceleration, duration),
        _is_inside(goal.position, limits.goal_box),
    )


def report_flight(flight: Flight, limits: Limits) -> LimitReport:
    """Return the peaks of what is left of a flight, say one that has just turned.

    What keeps its rate is no polynomial: the peaks are those of a thousand samples, each refined
    between its neighbours. Their times are the flight's.

    Raises:
        InputError: limits of other dimensions.
    """
    _check_dimensions(flight.dmp, limits)
    goal = flight.at(np.array([flight.arrival])).position[0]
    return LimitReport(
        _refined(flight, "velocity", limits.speed),
        _refined(flight, "acceleration", limits.acceleration),
        _is_inside(goal, limits.goal_box),
    )


def with_limits(
    dmp: Dmp,
    start: State,
    goal: State,
    duration: float,
    limits: Limits,
    *,
    adjust: Literal["time", "goal"] = "time",
) -> Adjusted | None:
    """Return the motion nearest to what is asked that keeps the limits, `None` if none does.

    Args:
        dmp: the primitive.
        start: state at time 0.
        goal: state that is asked for.
        duration: s, that is asked for.
        limits: to be kept.
        adjust: "time" gives it longer, "goal" a nearer goal, see above.

    Raises:
        InputError: as `report_limits`, or another `adjust`.
    """
    if adjust not in ("time", "goal"):
        raise InputError(f"adjust {adjust!r}: expected time or goal")
    report = report_limits(dmp, start, goal, duration, limits)
    if report.is_feasible:
        return Adjusted(goal, duration, report)
    if adjust == "time":
        return _longer(dmp, start, goal, _durations(duration, report), limits)
    return _nearer(dmp, start, goal, duration, limits)


def _durations(asked: float, report: LimitReport) -> Float[ndarray, "m"]:
    """Return the durations to try; between rest and rest, peaks go with 1/tau and 1/tau^2."""
    needed = max(1.0, report.speed.ratio, math.sqrt(report.acceleration.ratio))
    steps = min(math.ceil(math.log(LONGEST_STRETCH * needed) / math.log(STEP)), MOST_STEPS)
    return asked * STEP ** np.arange(steps + 1.0)


def _longer(
    dmp: Dmp, start: State, goal: State, durations: Float[ndarray, "m"], limits: Limits
) -> Adjusted | None:
    if not _is_inside(goal.position, limits.goal_box):
        return None

    def ratio(tau: float) -> float:
        return report_limits(dmp, start, goal, tau, limits).ratio

    hopeful = np.flatnonzero(_sampled_ratios(dmp, start, goal, durations, limits) <= WITHIN)
    for i in hopeful:
        if ratio(durations[i]) <= WITHIN:
            shortest = durations[max(i - 1, 0)]
            found = _last_within(ratio, float(durations[i]), float(shortest))
            return Adjusted(goal, found, report_limits(dmp, start, goal, found, limits))
    return None


def _nearer(
    dmp: Dmp, start: State, goal: State, duration: float, limits: Limits
) -> Adjusted | None:
    away = goal.position - start.position
    low, high = _line_in_box(start.position, away, limits.goal_box)

    def at(share: float) -> State:
        place = start.position + share * away
        box = limits.goal_box  # against rounding
        return replace(goal, position=place if box is None else np.clip(place, *box))

    def ratio(share: float) -> float:
        return report_limits(dmp, start, at(share), duration, limits).ratio

    if low > high:
        return None
    share = high
    if ratio(high) > WITHIN:
        inner = low
        if ratio(low) > WITHIN:
            least = minimize_scalar(
                ratio, bounds=(low, high), method="bounded", options={"xatol": PRECISION}
            )
            inner = float(least.x)
        if ratio(inner) > WITHIN:
            return None
        share = _last_within(ratio, inner, high)
    return Adjusted(at(share), duration, report_limits(dmp, start, at(share), duration, limits))


def _last_within(ratio: Callable[[float], float], good: float, bad: float) -> float:
    """Bisect between a value that keeps the limits and one that does not; return the former."""
    while abs(bad - good) > PRECISION * max(abs(good), abs(bad), PRECISION):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if ratio(middle) <= WITHIN else (good, middle)
    return good


def _sampled_ratios(
    dmp: Dmp, start: State, goal: State, durations: Float[ndarray, "m"], limits: Limits
) -> Float[ndarray, "m"]:
    """Return, for each duration, a ratio that the motion reaches for certain."""
    x = np.linspace(0.0, 1.0, LOOKS)
    still = pieces_of(np.zeros((6, len(start.position))), dmp.answer())
    targets = [moving_target(dmp, start, goal, float(tau)) for tau in durations]
    stack = np.stack(targets, axis=1)[:, :, None]
    ratios = np.zeros(len(durations))
    orders = ((1, quintic_slope, limits.speed), (2, quintic_curvature, limits.acceleration))
    for order, derivative, limit in orders:
        if limit is not None:
            answer = _values(derived(still, order, 1.0), x)
            rates = derivative(stack, x[:, None]) + answer
            share = _shares(rates / durations[:, None, None] ** order, limit)
            ratios = np.maximum(ratios, share.max(axis=1))
    return ratios


def _values(
    polynomials: Float[ndarray, "n pieces d"], x: Float[ndarray, "m"]
) -> Float[ndarray, "m d"]:
    pieces = polynomials.shape[1]
    piece = np.minimum((x * pieces).astype(np.intp), pieces - 1)
    powers = (x * pieces - piece) ** np.arange(len(polynomials))[:, None]
    return np.einsum("nmd,nm->md", polynomials[:, piece], powers)


def _shares(rates: Float[ndarray, "m n d"], limit: Limit) -> Float[ndarray, "m n"]:
    if np.ndim(limit) == 0:
        return np.linalg.norm(rates, axis=2) / limit
    return np.abs(rates / limit).max(axis=2)


def _peak(polynomials: Float[ndarray, "n pieces d"], limit: Limit | None, duration: float) -> Peak:
    if limit is None or np.ndim(limit) == 0:
        found = largest_norm(polynomials)
        most = math.inf if limit is None else float(limit)
        return Peak(found.value, found.fraction * duration, most)
    peaks = []
    for i, most in enumerate(np.asarray(limit).tolist()):
        found = largest_norm(polynomials[:, :, i : i + 1])
        peaks.append(Peak(found.value, found.fraction * duration, most, i))
    return max(peaks, key=lambda peak: peak.ratio)


def _refined(flight: Flight, name: str, limit: Limit | None) -> Peak:
    most = np.ravel(math.inf if limit is None else limit)
    by_norm = limit is None or np.ndim(limit) == 0

    def sizes(times: Float[ndarray, "n"]) -> Float[ndarray, "n c"]:
        rates = getattr(flight.at(times), name)
        return np.linalg.norm(rates, axis=1, keepdims=True) if by_norm else np.abs(rates)

    instants = np.linspace(flight.since, flight.arrival, FLIGHT_LOOKS)
    values = sizes(instants)
    shares = values if limit is None else values / most
    i, c = (int(k) for k in np.unravel_index(np.argmax(shares), shares.shape))
    around = instants[[max(i - 1, 0), min(i + 1, FLIGHT_LOOKS - 1)]]
    best = minimize_scalar(
        lambda time: -sizes(np.array([time]))[0, c],
        bounds=tuple(around),
        method="bounded",
        options={"xatol": PRECISION},
    )
    found = [(float(-best.fun), float(best.x)), (float(values[i, c]), float(instants[i]))]
    return Peak(*max(found), float(most[c]), None if by_norm else c)


def _is_inside(position: Float[ndarray, "d"], box: Float[ndarray, "2 d"] | None) -> bool:
    return box is None or bool(((box[0] <= position) & (position <= box[1])).all())


def _line_in_box(
    begin: Float[ndarray, "d"], away: Float[ndarray, "d"], box: Float[ndarray, "2 d"] | None
) -> tuple[float, float]:
    """Return the first and last share of `away` that lie in the box; first > last if none does."""
    if box is None:
        return 0.0, 1.0
    low, high = 0.0, 1.0
    for b, a, (near, far) in zip(begin, away, box.T, strict=True):
        if a == 0.0:
            if not near <= b <= far:
                return 1.0, 0.0
            continue
        first, last = sorted(((near - b) / a, (far - b) / a))
        low, high = max(low, first), min(high, last)
    return low, high


def _check_dimensions(dmp: Dmp, limits: Limits) -> None:
    d = dmp.weights.shape[1]
    for name, limit, shapes in (
        ("speed limit", limits.speed, ((), (d,))),
        ("acceleration limit", limits.acceleration, ((), (d,))),
        ("goal_box", limits.goal_box, ((2, d),)),
    ):
        if limit is not None and np.shape(limit) not in shapes:
            raise InputError(
                f"{name} of shape {np.shape(limit)}: expected one of {list(shapes)}, as the "
                f"primitive has {d} coordinates"
            )
