"""Open loop, as the paper flies: the motion's own velocity is the command (section IV.D).

A command is held until the next one, so what is sent is the motion's mean velocity over that
interval: the held commands then add up to the motion, whatever the frame rate. Motions are in
level camera axes (right, down, forward), commands in level body axes (forward, left, up).
"""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control.course import Course, Departure
from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError
from rotorpong.drone import HOVER, Navdata, VelocityCommand


def held_velocity(
    begin: Float[ndarray, "3"], end: Float[ndarray, "3"], elapsed: float
) -> VelocityCommand:
    """Return the command that, held for `elapsed` seconds, leads from `begin` to `end`.

    Args:
        begin: where the motion is now, m, level camera axes.
        end: where it is when the next command is due.
        elapsed: s.

    Raises:
        InputError: `elapsed` is not a positive number.
    """
    if not (math.isfinite(elapsed) and elapsed > 0.0):
        raise InputError(f"elapsed {elapsed} s: expected a positive number")
    forward, left, up = (CAMERA_FROM_BODY_AXES.T @ ((end - begin) / elapsed)).tolist()
    return VelocityCommand(forward, left, up)


class OpenLoop:
    """Implements Follower: knows nothing of the drone."""

    def sense(self, navdata: Navdata) -> None:
        """Look at nothing."""

    def sent(self, time: float, command: VelocityCommand) -> None:
        """Keep nothing."""

    def depart(self, now: float) -> Departure:
        """Begin at once, as the paper does."""
        return Departure.of_hover(now)

    def command(self, course: Course, now: float, interval: float) -> VelocityCommand:
        """Return what to command at `now` until the next command, `interval` later (s)."""
        begin, end = now - course.begin, min(now - course.begin + interval, course.duration)
        if end <= begin:
            return HOVER
        position, _, _ = course.sample(np.array([begin, end]))
        return held_velocity(position[0], position[1], end - begin)
