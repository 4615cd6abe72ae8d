"""Phase stopping: a motion waits for a robot that lags behind it.

    tau dz/dt = -alpha_z z / (1 + k |error|)                                Eq. (3a), slowed down

With z = exp(-alpha_z m / tau) this is a clock of the motion's own,

    dm/dt = 1 / (1 + k |error|),

and with target, response and phase all on that clock, the path of a motion stays what it is: it is
only flown later. Its velocity is ds/dm dm/dt. The clock is exact where the error is constant from
one reading to the next. The goal is met, late; who must be there in time turns to it again, with
the time that is left: `Flight.regoal(clock.motion_time, goal, clock.motion_time + left)`.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rotorpong.conventions import InputError
from rotorpong.primitives.dmp import Motion
from rotorpong.primitives.regoal import Flight


@dataclass(frozen=True, slots=True)
class WarpedClock:
    """The time of a motion that waits, a value: `advance` returns the next."""

    gain: float  # k, 1/m: at an error of 1/k the motion is half as fast
    motion_time: float = 0.0  # m, s
    rate: float = 1.0  # dm/dt, since the last reading

    def __post_init__(self) -> None:
        """Check what the user gave."""
        if not (math.isfinite(self.gain) and self.gain >= 0.0):
            raise InputError(f"gain {self.gain}: expected a number of 1/m, 0 or more")
        if not math.isfinite(self.motion_time):
            raise InputError(f"motion_time {self.motion_time} s: expected a finite number")

    def advance(self, elapsed: float, error: float) -> "WarpedClock":
        """Return the clock `elapsed` seconds later, while the robot was `error` (m) away.

        Raises:
            InputError: one of them is negative or not finite.
        """
        for name, value in (("elapsed", elapsed), ("error", error)):
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} {value}: expected a number, 0 or more")
        rate = 1.0 / (1.0 + self.gain * error)
        return replace(self, motion_time=self.motion_time + rate * elapsed, rate=rate)

    def sample(self, flight: Flight) -> Motion:
        """Return where the robot should be now, one instant; after the arrival, the goal.

        Velocity and acceleration are those in real time while the rate is what it is. `times` is
        the motion's own.

        Raises:
            InputError: the clock stands before the beginning of the flight's leg.
        """
        motion = flight.at(np.array([min(self.motion_time, flight.arrival)]))
        acceleration = motion.acceleration
        if acceleration is not None:
            acceleration = self.rate**2 * acceleration
        return replace(motion, velocity=self.rate * motion.velocity, acceleration=acceleration)
