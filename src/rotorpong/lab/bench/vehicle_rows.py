"""Are the vehicles those that were measured, and how fast do they fly?

`tum_gazebo` is compared with the step responses and the feed-forward strikes that were measured on
a replica of tum_simulator (design's facts, drone 1b), `ardrone2` with the reach and the closed
forms of the identified AR.Drone (1a). Errors are the worst of each kind, in per cent of what was
measured; tables are rounded, which is taken off first.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from statistics import median

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.lab.bench.rows import Row
from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW, ArDrone2
from rotorpong.physics.vehicle import (
    NOISE_FREE_CASCADE,
    TICK,
    TUM_GAZEBO,
    TumGazebo,
    Vehicle,
)

STEP_TARGET = 5.0  # %
CLOSED_FORM_TARGET = 2.0  # %
LEG = 33  # ticks between two frames

STEPS = (  # m/s; t10, t63, t90 s; tilt deg; peak m/s^2; way at 0.3, 0.5, 0.8, 1.0 s, m
    (0.5, (0.097, 0.37, 0.69), 6.3, 1.08, (0.033, 0.100, 0.231, 0.325)),
    (1.0, (0.098, 0.37, 0.70), 12.4, 2.16, (0.065, 0.198, 0.460, 0.648)),
    (2.0, (0.133, 0.42, 0.755), 22.9, 4.14, (0.093, 0.329, 0.836, 1.208)),
)
STRIKES = (  # way m, duration s, commands/s, cm beyond the goal for feed-forward 0, .2, .3, .4 s
    (0.3, 0.6, 30, (-20.6, -11.3, -6.7, -2.1)),
    (0.3, 0.6, 50, (-19.3, -10.1, -5.6, -1.1)),
    (0.3, 0.6, 1000, (-11.6, -2.1, 2.6, 7.3)),
    (0.5, 0.8, 30, (-29.2, -14.9, -7.8, -0.7)),
)
FEED_FORWARD = (0.0, 0.2, 0.3, 0.4)  # s
REACH = (  # tilt deg, dead time s, m at INSTANTS
    (12, 0.1, (0.041, 0.085, 0.145, 0.222, 0.314, 0.544)),
    (12, 0.2, (0.014, 0.041, 0.085, 0.145, 0.222, 0.422)),
    (20, 0.1, (0.069, 0.140, 0.240, 0.367, 0.519, 0.898)),
    (30, 0.1, (0.102, 0.208, 0.355, 0.541, 0.766, 1.322)),
    (30, 0.2, (0.036, 0.102, 0.208, 0.355, 0.541, 1.026)),
)
INSTANTS = (400, 500, 600, 700, 800, 1000)  # ms

PARTS, PART_NAMES = (0.1, 1.0 - math.exp(-1.0), 0.9), ("t10", "t63", "t90")
FORWARD, UP = 0, 2


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Return errors of both vehicles against what was measured, and the cost of a tick.

    Args:
        quick: fewer repetitions of what is timed.
    """
    return (*tum_rows(), *ardrone2_rows(), *speed_rows(quick=quick))


def tum_rows() -> tuple[Row, ...]:
    """Return how far `tum_gazebo` is from the replica, in per cent."""
    errors: dict[str, list[float]] = {}
    for step in STEPS:
        for name, error in _step_errors(*step):
            errors.setdefault(name, []).append(error)
    climb = _step(TumGazebo(NOISE_FREE_CASCADE), UP, 0.5)[1][[500, 1000]]
    errors["vertical step"] = [_off(climb[0], 0.33, 0.005), _off(climb[1], 0.45, 0.005)]
    worst = [_error_row(f"tum_gazebo, {name}", max(found)) for name, found in errors.items()]
    worst += [
        _error_row(f"tum_gazebo, strike of {way} m at {rate} commands/s", miss)
        for way, rate, miss in _strike_errors()
    ]
    published = Row("tum_gazebo, attitude error of the plugin as written", _plugin_error(), "deg")
    return (*worst, published)


def ardrone2_rows() -> tuple[Row, ...]:
    """Return how far `ardrone2` is from reach table and closed forms, in per cent."""
    table = max(
        _off(way, known, 0.0005)
        for degrees, dead_time, reach in REACH
        for way, known in zip(_reach(degrees, dead_time), reach, strict=True)
    )
    t = np.maximum(np.array(INSTANTS) * TICK - ARDRONE2.constants.dead_time, 0.0)
    c = ARDRONE2.constants
    slow, quick = 1.0 / c.drag, c.tilt_lag
    bend = slow**2 * (1.0 - np.exp(-t / slow)) - quick**2 * (1.0 - np.exp(-t / quick))
    tilted = c.pull / c.drag * math.sin(math.radians(12.0)) * (t - bend / (slow - quick))
    climbed = 2.0 * (t - (1.0 - np.exp(-c.climb_rate * t)) / c.climb_rate)
    pairs = zip(_reach(12, c.dead_time), tilted, strict=True)
    climbs = zip(_step(_quiet(), UP, 2.0)[0][list(INSTANTS)], climbed, strict=True)
    found = {
        "reach by tilt and dead time": table,
        "closed form of tilt, 12 degrees": max(_off(way, exact, 0.0) for way, exact in pairs),
        "closed form of climb": max(_off(way, exact, 0.0) for way, exact in climbs),
    }
    return tuple(
        Row(f"ardrone2, {name}", error, "%", target=CLOSED_FORM_TARGET, better="less")
        for name, error in found.items()
    )


def speed_rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Return the cost of a tick in one core, 64 drones from frame to frame, and that of a call.

    A trial has about 1000 ticks, and 5000 trials/s leave 200 us for each.
    """
    found: list[Row] = []
    for vehicle in (TUM_GAZEBO, ARDRONE2):
        leg = _seconds(vehicle, 64, LEG, repetitions=15 if quick else 60) / (64 * LEG)
        call = _seconds(vehicle, 1, 0, repetitions=15 if quick else 200)
        found.append(Row(f"{vehicle.name}, one tick of 64 in lockstep", leg * 1e9, "ns"))
        found.append(Row(f"{vehicle.name}, one call of advance", call * 1e6, "us"))
    return tuple(found)


def _error_row(name: str, error: float) -> Row:
    return Row(name, error, "%", target=STEP_TARGET, better="less")


def _off(value: float, known: float, rounding: float) -> float:
    """Return how far a value is from what is known, beyond its rounding, in per cent."""
    return 100.0 * float(max(abs(value - known) - rounding, 0.0) / abs(known))


def _step(
    vehicle: Vehicle, axis: int, size: float, ticks: int = 3000
) -> tuple[Float[ndarray, "n"], Float[ndarray, "n"], Float[ndarray, "n"], Float[ndarray, "n"]]:
    """Return way, velocity and acceleration along the axis, and the tilt in degrees."""
    state = vehicle.start(np.zeros(3), np.random.default_rng(0))
    order = np.eye(4)[axis] * size
    _, track = vehicle.advance(state, order, ticks=ticks, new_command=True)
    _, x, y, _ = track.quaternion.T
    tilt = np.degrees(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)))
    return track.position[:, axis], track.velocity[:, axis], track.acceleration[:, axis], tilt


def _step_errors(
    speed: float,
    times: tuple[float, ...],
    tilt: float,
    peak: float,
    ways: tuple[float, ...],
) -> Iterator[tuple[str, float]]:
    gone, velocity, pull, tilts = _step(TumGazebo(NOISE_FREE_CASCADE), FORWARD, speed)
    for part, name, known in zip(PARTS, PART_NAMES, times, strict=True):
        reached = float(np.argmax(velocity >= part * speed)) * TICK
        yield f"{name} of steps", _off(reached, known, 0.0005 if name == "t10" else 0.005)
    yield "largest tilt of steps", _off(float(tilts.max()), tilt, 0.05)
    yield "largest acceleration of steps", _off(float(pull.max()), peak, 0.005)
    for instant, known in zip((300, 500, 800, 1000), ways, strict=True):
        yield "way of steps", _off(float(gone[instant]), known, 0.0005)


def _strike_errors() -> Iterator[tuple[float, int, float]]:
    """Yield way, rate and the worst difference to the measured misses, in per cent of the way."""
    for way, duration, rate, misses in STRIKES:
        found = [_strike(way, duration, rate, gain) for gain in FEED_FORWARD]
        off = np.abs(np.array(found) - np.array(misses)) - 0.05
        yield way, rate, float(np.maximum(off, 0.0).max()) / way


def _strike(way: float, duration: float, rate: int, gain: float) -> float:
    """Return how far a strike ends beyond its goal, cm: constant acceleration, held commands."""
    drone = TumGazebo(NOISE_FREE_CASCADE)
    state = drone.start(np.zeros(3), np.random.default_rng(0))
    pull = 2.0 * way / duration**2
    count = math.ceil(duration * rate - 1e-9)
    edges = [*(round(i * 1000 / rate) for i in range(count)), round(duration * 1000)]
    for start, end in pairwise(edges):
        order = np.array([pull * start * TICK + gain * pull, 0.0, 0.0, 0.0])
        state, _ = drone.advance(state, order, ticks=end - start, new_command=True)
    return 100.0 * float(state.position[0] - way)


def _plugin_error(draws: int = 100_000) -> float:
    """Return the rms attitude error that tum_simulator's imu plugin publishes, in degrees.

    It turns the attitude by the quaternion (cos(a/2), n) about n = (g x e) sin(a/2) / (|g + e| |g|)
    for an accelerometer error e that tilts gravity g by a; but g x e is itself of size |g| |e|, so
    the vector part is a^2 / 2 where a turn by a needs a / 2.
    """
    rng = np.random.default_rng(0)
    gravity = np.array([0.0, 0.0, -9.8])
    error = rng.normal(size=(draws, 3)) * (0.35, 0.35, 0.3)
    sum_length = np.linalg.norm(gravity + error, axis=1) * 9.8
    cosine = ((gravity + error) @ gravity) / sum_length
    size = np.linalg.norm(np.cross(gravity, error), axis=1) / sum_length
    vector = size * np.sqrt((1.0 - cosine) / 2.0)
    angle = 2.0 * np.arctan2(vector, np.sqrt((1.0 + cosine) / 2.0))
    return float(np.degrees(np.sqrt(np.mean(angle**2))))


def _quiet() -> ArDrone2:
    noise = replace(ARDRONE2.noise, velocity_white=0.0, velocity_bias=0.0)
    return replace(ARDRONE2, noise=noise)


def _reach(degrees: float, dead_time: float) -> Float[ndarray, "n"]:
    """Return how far a raw drone gets under full tilt, m."""
    settings = ARDRONE2_RAW.settings._replace(tilt_limit=math.radians(degrees))
    constants = ARDRONE2_RAW.constants._replace(dead_time=dead_time, battery_sag=0.0)
    drone = replace(ARDRONE2_RAW, settings=settings, constants=constants)
    return _step(drone, FORWARD, 1.0)[0][list(INSTANTS)]


def _seconds(vehicle: Vehicle, count: int, ticks: int, *, repetitions: int) -> float:
    """Return the median CPU time of one call of advance, s."""
    state = vehicle.start(np.zeros((count, 3)), np.random.default_rng(0))
    order = np.tile([1.0, 0.5, 0.2, 0.0], (count, 1))

    def call() -> None:
        vehicle.advance(state, order, ticks=ticks, new_command=True)

    return _median_of(call, repetitions)


def _median_of(work: Callable[[], None], repetitions: int) -> float:
    work()
    durations = []
    for _ in range(repetitions):
        start = time.process_time()
        work()
        durations.append(time.process_time() - start)
    return median(durations)
