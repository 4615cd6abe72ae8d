"""Closed loop: feed-forward, plus what brings the drone back to its course.

With x = (p, v) or (p, v, v') of the course and x^ of the observer, both when a command sent now
begins to act (one dead time ahead), w^ the offset that commands are seen to meet,

    u = feed-forward + K (x - x^) - w^

As x^ already holds all commands on their way, delay leaves the loop (Smith): each axis is
x_(k+1) = Phi x_k + Gamma u_k, and K = (0 .. 0 1) C^-1 chi(Phi), C = (Gamma, Phi Gamma, ..), chi the
wanted characteristic polynomial, by Ackermann's formula. Poles faster than omega = 5 /s are left
alone, the others go to exp(-omega h): of a displacement (1 + omega t) exp(-omega t) is left, 9 %
after the 0.8 s that a stroke takes, and with a lag of 0.4 s the loop asks for omega^2 tau = 10
times a displacement, 0.1 m/s for 1 cm.

What the limits cut is not owed here: the observer is told what was really sent, so the error that a
cut leaves is seen as any other, and nothing winds up.
"""

import math
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control.course import Course, Departure
from rotorpong.control.feed_forward import command_of, feed_forward, velocity_of
from rotorpong.control.identification import Identification, Record
from rotorpong.control.observer import Observer, turn
from rotorpong.control.plant import Axis, Plant
from rotorpong.drone import HOVER, Navdata, VelocityCommand

PACE = 5.0  # 1/s, omega


def gains(axis: Axis, interval: float) -> Float[ndarray, "n"]:
    """Return K for commands held over `interval` (s)."""
    return _gains(axis, round(interval, 4))


@lru_cache(maxsize=64)
def _gains(axis: Axis, interval: float) -> ndarray:
    phi, gamma = axis.transition(interval)
    n = len(gamma)
    reached = np.column_stack([np.linalg.matrix_power(phi, k) @ gamma for k in range(n)])
    own = np.linalg.eigvals(phi)
    poles = np.where(np.abs(own) < math.exp(-PACE * interval), own, math.exp(-PACE * interval))
    wanted = np.eye(n)
    for coefficient in np.poly(poles).real[1:]:
        wanted = wanted @ phi + coefficient * np.eye(n)
    return np.linalg.solve(reached.T, np.eye(n)[n - 1]) @ wanted


class ClosedLoop:
    """Implements Follower: looks where the drone is in navdata."""

    def __init__(self, plant: Plant) -> None:
        """Start a serve on a drone known as `plant`, and learn its constants while it flies."""
        self._plant = plant
        self._identification = Identification.prior(plant)
        self._record = Record(plant)
        self._observer = Observer(plant)
        self._origin, self._turned = np.zeros(3), 0.0

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """How the drone answers, as far as it is known by now."""
        return self._identification.axes

    def sense(self, navdata: Navdata) -> None:
        """Take in what was measured since the last call."""
        self._identification = self._record.learnt(self._identification, navdata)
        self._observer.sense(navdata, self.axes)

    def sent(self, time: float, command: VelocityCommand) -> None:
        """Take in what was really sent at `time` (s)."""
        velocity = velocity_of(command)
        self._record.add(time, velocity)
        self._observer.sent(time, turn(self._observer.turned) @ velocity)

    def depart(self, now: float) -> Departure:
        """Begin after the dead time, where the drone will be then."""
        if not self._observer.is_begun:
            return Departure.of_hover(now + self._plant.dead_time)
        here, begin = self._state(now)[0], now + self._plant.dead_time
        position, velocity = self._state(begin)
        self._origin, self._turned = here, self._observer.turned
        back = turn(self._turned).T
        return Departure(begin, back @ (position - here), back @ velocity)

    def command(self, course: Course, now: float, interval: float) -> VelocityCommand:
        """Return what to command at `now` until the next command, `interval` later (s)."""
        if now >= course.end:
            return HOVER
        placed, axes = self._placed(course), self.axes
        wanted = feed_forward(placed, axes, now, interval).wanted
        if self._observer.is_begun:
            wanted = wanted + self._correction(placed, axes, now, interval)
        within = turn(self._observer.turned).T @ wanted
        return command_of(np.clip(within, -self._plant.limits, self._plant.limits))

    def _state(self, time: float) -> tuple[Float[ndarray, "3"], Float[ndarray, "3"]]:
        """Return position and velocity at `time` (s), in the observer's axes."""
        beliefs = self._observer.at(np.full(3, time), self.axes)
        both = np.array([belief.mean[:2] for belief in beliefs])
        return both[:, 0], both[:, 1]

    def _placed(self, course: Course) -> Course:
        """Return the course in the observer's axes and from its origin."""
        back = turn(self._turned).T

        def sample(elapsed: Float[ndarray, "n"]) -> tuple[ndarray, ndarray, ndarray]:
            position, velocity, pull = course.sample(elapsed)
            return position @ back + self._origin, velocity @ back, pull @ back

        return Course(course.begin, course.duration, sample)

    def _correction(
        self, course: Course, axes: tuple[Axis, Axis, Axis], now: float, interval: float
    ) -> Float[ndarray, "3"]:
        """Return K (x - x^) - w^ of each axis."""
        found, ahead = np.empty(3), now + np.array([axis.dead_time for axis in axes])
        wanted, beliefs = course.at(ahead), self._observer.at(ahead, axes)
        for i, axis in enumerate(axes):
            n, mean = axis.order, beliefs[i].mean
            error = wanted[:n, i, i] - mean[:n]
            found[i] = gains(axis, interval) @ error - mean[n]
        return found
