"""How a drone answers velocity commands, as its controller has it in mind: one line per axis.

    g u(t - D) = v(t) + tau v'(t) + kappa v''(t)

with gain g, dead time D, lag tau and, where acceleration itself takes time to build up, kappa. For
commands that are held, the state (p, v) or (p, v, v') goes exactly on by the matrix exponential of
its companion matrix. Axes are the level camera axes: right, down, forward.

The constants of known drones follow from their equations (`physics`), in the power series of the
inverse 1 / G(s) = (v + tau v' + kappa v'' + ...):

    tum_gazebo   with H = (D_t s + P_t) / (s^2 + D_t s + P_t), v' (1 + D H) = P H (u - v), so that
                 1/G = 1 + s (1/H + D) / P: tau = (1 + D) / P, kappa = 0, what is left is
                 s^3 / (P P_t) and less. State is seen 5 ms late on average; the kick that a new
                 command gives makes up for that, D = 0. Learning its constants needs all of G:
                 `answer`. Up has H = 1; there D acts on an acceleration 10 ms old, which leaves an
                 alternation undamped: a single step is up to 0.2 of its size off for a second.
    ardrone2     its loop: tau = (1 + L drag) / gain, kappa = L / gain, L the tilt's lag; up L = 0
    ardrone2_raw tilt itself: g = pull sin(limit) / drag, tau = L + 1 / drag, kappa = L / drag

Any other is taken for a lag of 0.4 s, the pace of both.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import expm

from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError
from rotorpong.physics.ardrone2 import ArDrone2
from rotorpong.physics.cascade import Cascade
from rotorpong.physics.vehicle import TumGazebo, Vehicle

UNKNOWN_LAG = 0.4  # s
COMMAND_WHITE = 0.05 / math.sqrt(3.0)  # m/s, sd; tum_gazebo's, and assumed of others


Answer = tuple[tuple[float, ...], tuple[float, ...]]
"""Numerator and denominator in s, highest power first, both 1 at s = 0."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a drone that is told velocities."""

    lag: float  # s, tau
    bend: float = 0.0  # s^2, kappa
    gain: float = 1.0
    dead_time: float = 0.0  # s, D
    answer: Answer | None = None  # G / g without D, where lag and bend are not all of it

    def __post_init__(self) -> None:
        """Refuse what cannot be flown.

        Raises:
            InputError: a number is not finite, negative, or zero where it may not be.
        """
        for name in ("lag", "bend", "gain", "dead_time"):
            number, least = getattr(self, name), name in ("bend", "dead_time")
            if not (math.isfinite(number) and (number > 0.0 or (least and number == 0.0))):
                wanted = "a number from 0" if least else "a positive number"
                raise InputError(f"{name} {number} of an axis: expected {wanted}")

    @property
    def order(self) -> int:
        """How many numbers its state has: position, velocity and, with kappa, acceleration."""
        return 3 if self.bend > 0.0 else 2

    def transition(self, elapsed: float) -> tuple[Float[ndarray, "n n"], Float[ndarray, "n"]]:
        """Return Phi, Gamma of x(t + elapsed) = Phi x(t) + Gamma u under a held command (s)."""
        plain = replace(self, dead_time=0.0, answer=None)
        return _transition(plain, round(elapsed, 9))

    def scaled(self, lag: float, gain: float, dead_time: float) -> "Axis":
        """Return an axis of the same shape at another pace: kappa / tau^2 stays."""
        return Axis(lag, self.bend * (lag / self.lag) ** 2, gain, dead_time, self.answer_at(lag))

    def answer_at(self, lag: float) -> Answer:
        """Return the answer at another pace."""
        plain = ((1.0,), (self.bend, self.lag, 1.0) if self.bend > 0.0 else (self.lag, 1.0))
        numerator, denominator = (
            tuple(c * (lag / self.lag) ** (len(part) - 1 - k) for k, c in enumerate(part))
            for part in self.answer or plain
        )
        return numerator, denominator


@lru_cache(maxsize=64)
def _transition(axis: Axis, elapsed: float) -> tuple[ndarray, ndarray]:
    n = axis.order
    rates = np.zeros((n + 1, n + 1))  # of the state and the held command
    rates[range(n - 1), range(1, n)] = 1.0
    if n == 2:
        rates[1] = np.array([0.0, -1.0, axis.gain]) / axis.lag
    else:
        rates[2] = np.array([0.0, -1.0, -axis.lag, axis.gain]) / axis.bend
    whole = expm(rates * elapsed)
    phi, gamma = whole[:n, :n], whole[:n, n]
    for array in (phi, gamma):
        array.setflags(write=False)
    return phi, gamma


@dataclass(frozen=True, slots=True)
class Plant:
    """What is known of a drone before it flies; noise as standard deviations."""

    axes: tuple[Axis, Axis, Axis]  # right, down, forward
    limits: Float[ndarray, "3"]  # largest magnitudes of a command, m/s (of raw drones: fractions)
    command_white: float = COMMAND_WHITE  # m/s asked for, of each message
    command_offset: float = 0.0  # m/s asked for, constant per serve
    velocity_white: float = 0.1  # m/s, of each message of navdata
    velocity_bias: float = 0.0  # m/s, constant per serve
    velocity_delay: float = 0.0  # s, by which the velocity in navdata is older than its stamp

    @property
    def dead_time(self) -> float:
        """The longest of the three, s: what is sent now has begun to act in every axis by then."""
        return max(axis.dead_time for axis in self.axes)


UNKNOWN = Axis(UNKNOWN_LAG)
UNKNOWN_PLANT = Plant((UNKNOWN, UNKNOWN, UNKNOWN), np.full(3, np.inf))


def plant_of(vehicle: Vehicle) -> Plant:
    """Return the plant that a vehicle's equations and constants make."""
    limits = np.abs(CAMERA_FROM_BODY_AXES) @ vehicle.limits[:3]
    white = vehicle.sensor_noise.velocity_white
    if isinstance(vehicle, TumGazebo):
        c = vehicle.constants
        lag = (1.0 + c.horizontal_d) / c.horizontal_p
        across = Axis(lag, answer=_cascaded(c))
        up = Axis((1.0 + c.vertical_d) / c.vertical_p)
        return Plant(
            (across, up, across),
            limits,
            command_white=c.command_white / math.sqrt(3.0),
            command_offset=c.command_offset / math.sqrt(3.0),
            velocity_white=white,
            velocity_bias=vehicle.sensor_noise.velocity_bias,
        )
    if isinstance(vehicle, ArDrone2):
        across, up = _raw_axes(vehicle) if vehicle.raw else _looped_axes(vehicle)
        late = vehicle.constants.velocity_delay
        return Plant((across, up, across), limits, velocity_white=white, velocity_delay=late)
    return replace(UNKNOWN_PLANT, limits=limits, velocity_white=white)


def _cascaded(c: Cascade) -> Answer:
    """Return P H / (s (1 + D H) + P H) with H = (D_t s + P_t) / (s^2 + D_t s + P_t)."""
    p, d, tilt = c.horizontal_p, c.horizontal_d, np.array([c.tilt_d, c.tilt_p])
    whole = np.polymul([1.0, 0.0], np.polyadd([1.0, c.tilt_d, c.tilt_p], d * tilt))
    numerator, denominator = p * tilt, np.polyadd(whole, p * tilt)
    unit = p * c.tilt_p
    return tuple((numerator / unit).tolist()), tuple((denominator / unit).tolist())


def _looped_axes(drone: ArDrone2) -> tuple[Axis, Axis]:
    loop, c = drone.loop, drone.constants
    lag = (1.0 + loop.tilt_lag * loop.drag) / loop.gain
    across = Axis(lag, loop.tilt_lag / loop.gain, dead_time=c.dead_time)
    return across, Axis(1.0 / loop.gain, dead_time=c.dead_time)


def _raw_axes(drone: ArDrone2) -> tuple[Axis, Axis]:
    c, s = drone.constants, drone.settings
    across = Axis(
        c.tilt_lag + 1.0 / c.drag,
        c.tilt_lag / c.drag,
        c.pull * math.sin(s.tilt_limit) / c.drag,
        c.dead_time,
    )
    return across, Axis(1.0 / c.climb_rate, 0.0, s.climb_limit * c.climb_gain, c.dead_time)
