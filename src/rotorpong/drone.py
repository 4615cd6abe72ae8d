"""What a drone, its eyes, its referee and its player are to each other.

    frame + navdata -> Eyes -> BallEstimate -> Player -> VelocityCommand -> Drone
                                                 ^------ Verdict <- Referee

A player sees nothing else. The same four protocols hold on the simulator, on an emulator and on a
real drone. All times are seconds on one clock.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError, Picture

Outcome = Literal["hit", "hull", "fault", "near_hit", "unseen", "miss"]
Box = tuple[int, int, int, int]  # x0, y0, x1, y1 in pixels, the last two exclusive
OUTCOMES: tuple[Outcome, ...] = ("hit", "hull", "fault", "near_hit", "unseen", "miss")


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """Desired velocity in the level body frame, held until the next command."""

    forward: float = 0.0  # m/s
    left: float = 0.0  # m/s
    up: float = 0.0  # m/s
    yaw_rate: float = 0.0  # rad/s, counter-clockwise seen from above


HOVER = VelocityCommand()


@dataclass(slots=True)
class Frame:
    """A picture that is made or decoded when somebody looks at it.

    Rendered frames, video files, image folders and a real drone all hand out this type.
    """

    width: int
    height: int
    source: Callable[[], Picture]
    box_source: Callable[[Box], Picture] | None = None  # makes a part without the rest
    _picture: Picture | None = field(default=None, repr=False)

    @property
    def picture(self) -> Picture:
        """The whole picture, (height, width, 3) in blue, green, red."""
        if self._picture is None:
            self._picture = self.source()
        return self._picture

    def region(self, x0: int, y0: int, x1: int, y1: int) -> Picture:
        """Return the picture's columns x0 to x1 and rows y0 to y1, both ends exclusive.

        The same pixels as in the whole picture; where the source can, only they are made.

        Raises:
            InputError: the box is empty or reaches out of the picture.
        """
        if not (0 <= x0 < x1 <= self.width and 0 <= y0 < y1 <= self.height):
            raise InputError(
                f"region {(x0, y0, x1, y1)} was given; expected x0 < x1, y0 < y1 within a picture "
                f"of {self.width} x {self.height} pixels"
            )
        if self._picture is None and self.box_source is not None:
            return self.box_source((x0, y0, x1, y1))
        return self.picture[y0:y1, x0:x1]


@dataclass(frozen=True, slots=True)
class Navdata:
    """Onboard measurements since the last observation, n of them, oldest first."""

    times: Float[ndarray, "n"]
    body_rates: Float[ndarray, "n 3"]  # rad/s, gyro, body axes
    acceleration: Float[ndarray, "n 3"]  # m/s^2, specific force, body axes
    attitude: Float[ndarray, "n 3"]  # rad, roll, pitch, yaw (yaw: magnetic heading)
    velocity: Float[ndarray, "n 3"]  # m/s, level body axes: forward, left, up
    height: Float[ndarray, "n"]  # m, sonar, above what lies below
    battery: Float[ndarray, "n"]  # 0 empty .. 1 full


@dataclass(frozen=True, slots=True)
class Observation:
    """One frame and the navdata that came with it."""

    frame: Frame
    frame_time: float  # s, middle of the exposure
    arrival_time: float  # s, when the player got it
    navdata: Navdata


@dataclass(frozen=True, slots=True)
class BallEstimate:
    """Where the ball is and how it moves, in the camera frame at `time`."""

    time: float  # s
    position: Float[ndarray, "3"]  # m: right, down, depth
    velocity: Float[ndarray, "3"]  # m/s
    covariance: Float[ndarray, "6 6"]  # of (position, velocity)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a serve, as a contact sensor or the thrower can tell.

    The time of contact is part of it because the duration of a hitting point is learnt from it.
    """

    outcome: Outcome
    contact_offset: float | None = None  # sqrt((y/a)^2 + (z/b)^2) on the blade; None: not known
    contact_time: float | None = None  # s, when the blade was struck; None: it was not


@runtime_checkable
class Drone(Protocol):
    """A flying robot with a camera."""

    def observe(self) -> Observation | None:
        """Wait for the next frame; `None` when the serve is over."""
        ...

    def command(self, velocity: VelocityCommand) -> VelocityCommand:
        """Fly at `velocity` from now on; return what was really sent after clipping.

        Raises:
            InputError: a component is not finite.
        """
        ...


@runtime_checkable
class Eyes(Protocol):
    """Whatever turns observations of one serve into ball estimates."""

    def see(self, observation: Observation) -> BallEstimate | None:
        """Return the ball's state at the frame's time, `None` if it cannot be told."""
        ...


@runtime_checkable
class Referee(Protocol):
    """Whoever can tell what became of the serve that was just played."""

    def verdict(self) -> Verdict:
        """Return the verdict on the last serve."""
        ...


@runtime_checkable
class Player(Protocol):
    """A policy that plays one serve at a time."""

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play until `drone.observe()` returns `None`."""
        ...

    def learn(self, verdict: Verdict) -> None:
        """Take in what became of the serve just played; only called in training."""
        ...
