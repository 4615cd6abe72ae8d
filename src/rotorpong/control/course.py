"""The motion to be flown, on the clock of the serve, and who flies it.

A course is asked beyond its ends as well: a command that is looked up ahead by a dead time, or
held over the end, needs what comes after. There it goes on with the acceleration of the end.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import Navdata, VelocityCommand

Sampler = Callable[
    [Float[ndarray, "n"]],
    tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"], Float[ndarray, "n 3"]],
]
"""(s since the beginning, within the duration) -> position m, velocity m/s, acceleration m/s^2."""


@dataclass(frozen=True, slots=True)
class Course:
    """A motion in level camera axes that begins at an instant."""

    begin: float  # s
    duration: float  # s
    sample: Sampler

    def __post_init__(self) -> None:
        """Refuse a motion without duration.

        Raises:
            InputError: the beginning is not finite, or the duration not positive.
        """
        if not (np.isfinite(self.begin) and np.isfinite(self.duration) and self.duration > 0.0):
            raise InputError(
                f"course from {self.begin} s for {self.duration} s: expected a finite beginning "
                "and a positive duration"
            )

    @property
    def end(self) -> float:
        """When it is over, s."""
        return self.begin + self.duration

    def at(self, times: Float[ndarray, "n"]) -> Float[ndarray, "3 n 3"]:
        """Return position, velocity and acceleration at `times` (s), also beyond the ends."""
        elapsed = np.asarray(times, dtype=float) - self.begin
        within = np.clip(elapsed, 0.0, self.duration)
        position, velocity, pull = self.sample(within)
        beyond = (elapsed - within)[:, None]
        gone = beyond * (velocity + 0.5 * beyond * pull)
        return np.stack([position + gone, velocity + beyond * pull, pull])


@dataclass(frozen=True, slots=True)
class Departure:
    """Where a drone will be when the first command of a course begins to act, and how it moves."""

    time: float  # s
    position: Float[ndarray, "3"]  # m, since the departure, level camera axes of then
    velocity: Float[ndarray, "3"]  # m/s

    @classmethod
    def of_hover(cls, time: float) -> "Departure":
        """Return that of a drone that stands still."""
        return cls(time, np.zeros(3), np.zeros(3))


@runtime_checkable
class Follower(Protocol):
    """Whoever turns a course into commands; keeps what it needs of one serve."""

    def sense(self, navdata: Navdata) -> None:
        """Take in what was measured since the last call."""
        ...

    def sent(self, time: float, command: VelocityCommand) -> None:
        """Take in what was really sent at `time` (s)."""
        ...

    def depart(self, now: float) -> Departure:
        """Take place and axes at `now` for those of the course to come.

        Returns:
            Where it has to begin, one `lead` later.
        """
        ...

    def command(self, course: Course, now: float, interval: float) -> VelocityCommand:
        """Return what to command at `now` until the next command, `interval` later (s)."""
        ...
