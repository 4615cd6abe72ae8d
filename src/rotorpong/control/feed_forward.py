"""Feed-forward: u = v + tau v', looked up ahead by the dead time.

A command is held over an interval h. Integrating g u(t - D) = v + tau v' + kappa v'' over it,

    g h u = (p + tau v + kappa v')(t + D + h) - (p + tau v + kappa v')(t + D),

so a motion whose differences are put on the right has its p + tau v + kappa v' met exactly at every
command, whatever the frame rate: u is the mean of v + tau v' + kappa v'' over the interval. What is
left of p obeys tau e' + e = d with d = 0 at every command and |d| <= h^2 max |v' + tau v''| / 8 in
between. (Meeting v itself at every command, u = (v_1 - a v_0) / (1 - a), a = exp(-h / tau), lets p
drift instead.)

A command beyond the limits is cut, each axis by itself, and what the cut took of p + tau v is owed:
the next commands make up for it as soon as the limits leave room.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control.course import Course, Departure
from rotorpong.control.identification import Identification, Record
from rotorpong.control.plant import Axis, Plant
from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError
from rotorpong.drone import HOVER, Navdata, VelocityCommand


@dataclass(frozen=True, slots=True)
class Demand:
    """What a motion asks for, and what of it can be sent."""

    wanted: Float[ndarray, "3"]  # m/s: right, down, forward
    velocity: Float[ndarray, "3"]  # the same within the limits

    @property
    def is_cut(self) -> bool:
        """Tell whether the limits do not allow what is wanted."""
        return bool((self.wanted != self.velocity).any())


def feed_forward(
    course: Course,
    axes: tuple[Axis, Axis, Axis],
    now: float,
    interval: float,
    limits: Float[ndarray, "3"] | None = None,
    *,
    owed: Float[ndarray, "3"] | None = None,
) -> Demand:
    """Return the command that, held for `interval` from `now` on, makes a drone follow a course.

    Args:
        course: what to follow.
        axes: how the drone answers: right, down, forward.
        now: s.
        interval: s.
        limits: largest magnitudes, m/s; none by default.
        owed: of (p + tau v + kappa v') / g, m, from commands that were cut.

    Raises:
        InputError: the interval is not a positive number.
    """
    if not (math.isfinite(interval) and interval > 0.0):
        raise InputError(f"interval {interval} s: expected a positive number")
    wanted = np.empty(3)
    for i, axis in enumerate(axes):
        edges = now + axis.dead_time + np.array([0.0, interval])
        p, v, a = course.at(edges)[:, :, i]
        reach = p + axis.lag * v + axis.bend * a
        wanted[i] = (reach[1] - reach[0]) / (axis.gain * interval)
    if owed is not None:
        wanted = wanted + owed / interval
    most = np.full(3, np.inf) if limits is None else limits
    return Demand(wanted, np.clip(wanted, -most, most))


def command_of(velocity: Float[ndarray, "3"]) -> VelocityCommand:
    """Return a velocity in level camera axes as a command."""
    return VelocityCommand(*(CAMERA_FROM_BODY_AXES.T @ velocity).tolist())


def velocity_of(command: VelocityCommand) -> Float[ndarray, "3"]:
    """Return what a command asks for in level camera axes."""
    return CAMERA_FROM_BODY_AXES @ np.array([command.forward, command.left, command.up])


class FeedForward:
    """Implements Follower: never looks where the drone is, only how it answers."""

    def __init__(self, plant: Plant) -> None:
        """Start a serve on a drone known as `plant`, and learn its constants while it flies."""
        self._plant = plant
        self._identification = Identification.prior(plant)
        self._record = Record(plant)
        self._owed, self._wanted = np.zeros(3), np.zeros(3)
        self._due: tuple[float, float] | None = None  # of the last demand: when, how long

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """How the drone answers, as far as it is known by now."""
        return self._identification.axes

    def sense(self, navdata: Navdata) -> None:
        """Learn from what was measured since the last call."""
        self._identification = self._record.learnt(self._identification, navdata)

    def sent(self, time: float, command: VelocityCommand) -> None:
        """Take in what was really sent at `time` (s), and what is owed now."""
        self._record.add(time, velocity_of(command))
        if self._due is not None and self._due[0] == time:
            self._owed = (self._wanted - velocity_of(command)) * self._due[1]

    def depart(self, now: float) -> Departure:
        """Begin after the dead time, owing nothing."""
        self._owed = np.zeros(3)
        return Departure.of_hover(now + self._plant.dead_time)

    def command(self, course: Course, now: float, interval: float) -> VelocityCommand:
        """Return what to command at `now` until the next command, `interval` later (s)."""
        if now >= course.end:
            return HOVER
        demand = feed_forward(course, self.axes, now, interval, self._plant.limits, owed=self._owed)
        self._wanted, self._due = demand.wanted, (now, interval)
        return command_of(demand.velocity)
