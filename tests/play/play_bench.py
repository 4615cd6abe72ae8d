"""A drone and eyes of pure kinematics: it flies exactly as commanded, the ball exactly as told."""

from dataclasses import astuple

import numpy as np

from rotorpong.drone import HOVER, BallEstimate, Frame, Navdata, Observation, VelocityCommand

PERIOD = 1.0 / 30.0
FRAME = Frame(1, 1, lambda: np.zeros((1, 1, 3), np.uint8))


class BenchDrone:
    """Implements Drone: frames 1/30 s apart, `delay` late; it moves as commanded, at once."""

    def __init__(self, frames=60, delay=0.0, start=HOVER):
        self.frames, self.delay = frames, delay
        self.commands = []  # (time, command)
        self.seen = 0
        self._flown = start

    def observe(self):
        if self.seen == self.frames:
            return None
        now = self.seen * PERIOD
        self.seen += 1
        return Observation(FRAME, now - self.delay, now, self._navdata(now))

    def command(self, velocity):
        self.commands.append(((self.seen - 1) * PERIOD, velocity))
        self._flown = velocity
        return velocity

    def _navdata(self, now):
        nothing = np.zeros((4, 3))
        times = now - PERIOD * np.array([0.75, 0.5, 0.25, 0.0])
        velocity = np.tile(astuple(self._flown)[:3], (4, 1)).astype(float)
        return Navdata(times, nothing, nothing, nothing, velocity, np.ones(4), np.ones(4))


class BallEyes:
    """Implements Eyes: the ball is at `place(time)`, seen between `first` and `last`."""

    def __init__(self, place, first=0.0, last=np.inf):
        self._place, self._first, self._last = place, first, last
        self.asked = []

    def see(self, observation):
        time = observation.frame_time
        self.asked.append(time)
        if not self._first <= time <= self._last:
            return None
        position = self._place(time)
        velocity = (self._place(time + 1e-4) - self._place(time - 1e-4)) / 2e-4
        return BallEstimate(time, position, velocity, np.zeros((6, 6)))


def straight(right=0.3, down=0.1, depth=4.0, speed=6.0, sideways=0.0):
    """A ball that comes straight on, right and down of the camera."""
    return lambda time: np.array([right + sideways * time, down, depth - speed * time])


def play(player, drone, eyes, seed=0):
    """Play one serve; return the commands."""
    player.play(drone, eyes, np.random.default_rng(seed))
    return [command for _, command in drone.commands]


def mirrored(command):
    return VelocityCommand(command.forward, -command.left, command.up, -command.yaw_rate)
