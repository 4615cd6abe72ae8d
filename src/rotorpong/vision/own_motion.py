"""How the drone itself moved and turned, from its gyro and its odometry.

    q_i = q_{i-1} * exp(w dt / 2)                   attitude, body to frame, from body rates
    p_i = p_{i-1} + Rz(yaw_i) v dt                  place, from velocity in level axes;
                                                    its height follows sonar

with w and v the means of both ends of the step. A gyro that is read at an instant shows kicks of a
millisecond as if they had lasted for a whole step; the median of three samples leaves them out.

The frame has z up; the drone starts in it where it is told to be, level, with yaw 0. What the start
was not level by stays in the attitude as one constant small rotation, for the gyro only adds; the
readings of roll and pitch, noisy but without drift, tell it little by little (`flight_filter`):
their mean over the n samples since the last look, less the gyro's own roll and pitch.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import Rotation, Vector3
from rotorpong.drone import Navdata
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.vision import _own_motion_kernels as kernels

SONAR_GAIN = 10.0  # 1/s, at which sonar holds the height
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True)
class Reading:
    """Roll and pitch beyond the gyro's, averaged."""

    angles: Float[ndarray, "2"]  # rad
    heading: float  # rad, by the gyro
    duration: float  # s that were averaged


class OwnMotion:
    """Adds up the navdata of one serve."""

    def __init__(self, start: Vector3) -> None:
        """Begin at `start` (3,), m, level, with yaw 0."""
        self._start = np.array(start, dtype=float)
        self._times, self._rates, self._velocities = np.empty(0), np.empty((0, 3)), np.empty((0, 3))
        self._heights = np.empty(0)
        self._places, self._quaternions = np.empty((0, 3)), np.empty((0, 4))

    def add(self, navdata: Navdata) -> Reading | None:
        """Take in what was measured since the last call; return its mean reading of the level.

        What followed from the last sample before is done again, now that its spikes can be seen.
        """
        count, known = len(navdata.times), len(self._times)
        if count == 0:
            return None
        self._times = np.concatenate([self._times, navdata.times])
        self._rates = np.concatenate([self._rates, navdata.body_rates])
        self._velocities = np.concatenate([self._velocities, navdata.velocity])
        self._heights = np.concatenate([self._heights, navdata.height])
        places, quaternions = np.empty((known + count, 3)), np.empty((known + count, 4))
        places[:known], quaternions[:known] = self._places, self._quaternions
        if known == 0:
            places[0], quaternions[0] = self._start, LEVEL
        kernels.integrate(
            max(1, known - 1),
            self._times,
            self._rates,
            self._velocities,
            self._heights,
            SONAR_GAIN,
            places,
            quaternions,
        )
        self._places, self._quaternions = places, quaternions
        angles = kernels.beyond_level(navdata.attitude, quaternions[known:])
        w, x, y, z = quaternions[-1]
        heading = float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        duration = float(navdata.times[-1] - self._times[max(known - 1, 0)])
        return Reading(angles, heading, duration)

    def pose(self, time: float) -> tuple[Vector3, Rotation]:
        """Return place (m) and rotation from body to frame at a time (s), by the gyro.

        Between two samples both are interpolated; before the first and after the last, these hold.
        """
        if not len(self._times):
            return self._start, rotation_from_quaternion(LEVEL)
        at = int(np.searchsorted(self._times, time))
        if at == 0 or at == len(self._times):
            at = min(at, len(self._times) - 1)
            return self._places[at], rotation_from_quaternion(self._quaternions[at])
        before, after = self._times[at - 1], self._times[at]
        share = (time - before) / (after - before)
        quaternion = (1.0 - share) * self._quaternions[at - 1] + share * self._quaternions[at]
        place = (1.0 - share) * self._places[at - 1] + share * self._places[at]
        return place, rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))

    def velocity(self, time: float, over: float = 0.05) -> Vector3:
        """Return the mean velocity over an interval (s) about a time, m/s."""
        if len(self._times) < 2:
            return np.zeros(3)
        low, high = self._times[0], self._times[-1]
        begin, end = np.clip([time - over / 2, time + over / 2], low, high)
        if end <= begin:
            begin, end = max(low, high - over), high
        return (self.pose(float(end))[0] - self.pose(float(begin))[0]) / (end - begin)
