"""A drone whose axes are exactly those of `plant`, flown by scipy: truth for controls."""

import numpy as np
from scipy.signal import cont2discrete

from rotorpong.control import Course
from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import HOVER, Navdata, VelocityCommand
from rotorpong.primitives.quintic import (
    quintic_coefficients,
    quintic_curvature,
    quintic_slope,
    quintic_value,
)

TICK = 0.001
INTERVAL = 0.033


def rates_of(axis):
    """A, B of x' = A x + B u for x = (p, v) or (p, v, v')."""
    if axis.bend == 0.0:
        rates = np.array([[0.0, 1.0], [0.0, -1.0 / axis.lag]])
        return rates, np.array([[0.0], [axis.gain / axis.lag]])
    rates = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, -axis.lag]])
    rates[2] /= axis.bend
    return rates, np.array([[0.0], [0.0], [axis.gain / axis.bend]])


class LaggingDrone:
    """Flies a millisecond at a time, without noise unless asked; level camera axes."""

    def __init__(self, axes, limits=np.inf, offset=0.0, heading=0.0, noise=None):
        self._steps = []
        for axis in axes:
            rates, push = rates_of(axis)
            n = len(rates)
            phi, gamma, *_ = cont2discrete((rates, push, np.eye(n), np.zeros((n, 1))), TICK)
            self._steps.append((phi, gamma[:, 0]))
        self._dead = [round(axis.dead_time / TICK) for axis in axes]
        self.states = [np.zeros(axis.order) for axis in axes]
        self._sent = []  # one row per tick
        self._limits, self._heading, self._noise = limits, heading, noise
        self._offset = offset
        self.path, self.speeds = [np.zeros(3)], [np.zeros(3)]

    @property
    def time(self):
        return len(self._sent) * TICK

    def command(self, velocity, interval=INTERVAL):
        """Fly under a command; return what was sent and the navdata of the interval."""
        level = np.array([velocity.forward, velocity.left, velocity.up])
        within = np.clip(CAMERA_FROM_BODY_AXES @ level, -self._limits, self._limits)
        for _ in range(round(interval / TICK)):
            self._sent.append(within + self._offset)
            k = len(self._sent) - 1
            for i, (phi, gamma) in enumerate(self._steps):
                u = self._sent[k - self._dead[i]][i] if k >= self._dead[i] else 0.0
                self.states[i] = phi @ self.states[i] + gamma * u
            self.path.append(np.array([x[0] for x in self.states]))
            self.speeds.append(np.array([x[1] for x in self.states]))
        sent = VelocityCommand(*(CAMERA_FROM_BODY_AXES.T @ within).tolist())
        return sent, self._navdata(round(interval / TICK))

    def _navdata(self, ticks):
        moved = np.array(self.speeds[-ticks:]) @ CAMERA_FROM_BODY_AXES
        if self._noise is not None:
            moved = moved + 0.1 * self._noise.normal(size=moved.shape)
        times = self.time - TICK * np.arange(ticks)[::-1]
        attitude = np.tile([0.0, 0.0, self._heading], (ticks, 1))
        nothing = np.zeros((ticks, 3))
        return Navdata(times, nothing, nothing, attitude, moved, np.ones(ticks), np.ones(ticks))


def quintic_course(begin, duration, goal, start=(0.0, 0.0, 0.0)):
    """A minimum-jerk motion from rest to rest."""
    nothing = np.zeros(3)
    first, last = (np.stack([np.array(x), nothing, nothing]) for x in (start, goal))
    target = quintic_coefficients(first, last)

    def sample(elapsed):
        x = elapsed[:, None] / duration
        return (
            quintic_value(target, x),
            quintic_slope(target, x) / duration,
            quintic_curvature(target, x) / duration**2,
        )

    return Course(begin, duration, sample)


def flown(follower, drone, course, hover=0):
    """Fly a course to its end; return error at each tick of it."""
    for _ in range(hover):
        _fly(follower, drone, HOVER)
    while drone.time < course.end - 1e-9:
        _fly(follower, drone, follower.command(course, drone.time, INTERVAL))
    ticks = np.arange(round(course.begin / TICK), round(course.end / TICK) + 1)
    return np.array(drone.path)[ticks] - course.at(ticks * TICK)[0]


def _fly(follower, drone, command):
    now = drone.time
    sent, navdata = drone.command(command)
    follower.sent(now, sent)
    follower.sense(navdata)
