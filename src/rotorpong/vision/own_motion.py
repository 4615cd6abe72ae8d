"""How the drone itself moved and turned, from its navdata: gyro, accelerometer, flow, sonar.

    q_i = q_{i-1} * exp(w dt / 2)                   attitude, body to frame, from body rates

with w the mean of both ends of the step. A gyro that is read at an instant shows kicks of a
millisecond as if they had lasted for a whole step; the median of three samples leaves them out.

Place and velocity are those of a Kalman filter. Rotors pull along the body's z only, so attitude
tells how a multirotor accelerates, drag apart (Martin and Salauen, ICRA 2010):

    v' = R (-d v_x, -d v_y, f_z) - g + g e,    e' = walk,    o' = c' = 0     across
    z' = v_z,   v_z' = f_z - g                                               upward

with e the tilt that the gyro's attitude lacks along an axis, o the constant error of readings of
roll and pitch, c that of the flow, f the accelerometer. Where drag is not known well enough, for
the drone is fast, the accelerometer's horizontal part takes over. Seen are v + c by optical flow,
white and a moment late; e + o by roll and pitch; z by sonar, above the floor or above the table,
whichever is nearer to what is believed. The covariance along x is that along y. The drone hovers at
first. What is wrong with v from the start stays as it is: a frame that moves evenly is as good, and
a ball that is seen from it loses nothing. Flow alone would make the place walk by 7 mm in a second
and its speed uncertain by centimetres a second, and the ball's with it.

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
from rotorpong.vision.flight_filter import AttitudeQuality

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
SAMPLE_RATE = 200.0  # Hz, of navdata


@dataclass(frozen=True, slots=True)
class OdometryQuality:
    """How well a drone measures its velocity; standard deviations, white, of a sample."""

    flow_sd: float = 0.1  # m/s
    flow_bias_sd: float = 0.03  # m/s, constant
    flow_delay: float = 0.0  # s, by which it is late
    acceleration_sd: float = 0.35  # m/s^2
    rise_sd: float = 0.35  # m/s^2, of its upward part, with what it misses between two samples
    sonar_sd: float = 0.01  # m
    drag: float = 0.3  # 1/s: deceleration over speed
    drag_sd: float = 0.3  # 1/s
    thrust_sd: float = 0.05  # relative, of the pull sideways


@dataclass(frozen=True, slots=True)
class Reading:
    """Roll and pitch beyond the gyro's, averaged."""

    angles: Float[ndarray, "2"]  # rad
    heading: float  # rad, by the gyro
    duration: float  # s that were averaged


class OwnMotion:
    """Follows the drone through one serve."""

    def __init__(
        self, start: Vector3, attitude: AttitudeQuality, odometry: OdometryQuality
    ) -> None:
        """Begin at `start` (3,), m, hovering, level, with yaw 0."""
        self._start = np.array(start, dtype=float)
        self._quality = _quality(attitude, odometry)
        shapes = ((0,), (0, 3), (0, 3), (0, 3), (0,), (0, 2))
        self._samples = kernels.Samples(*map(np.empty, shapes))
        self._path = _room(0)

    def add(self, navdata: Navdata) -> Reading | None:
        """Take in what was measured since the last call; return its mean reading of the level.

        What followed from the last sample before is done again, now that its spikes can be seen.
        """
        count, known = len(navdata.times), len(self._samples.times)
        if count == 0:
            return None
        new = (navdata.times, navdata.body_rates, navdata.acceleration, navdata.velocity)
        new = (*new, navdata.height, navdata.attitude[:, :2])
        pairs = zip(self._samples, new, strict=True)
        samples = kernels.Samples(*(np.concatenate(pair) for pair in pairs))
        path = _room(known + count)
        for old, longer in zip(self._path, path, strict=True):
            longer[:known] = old
        if known == 0:
            path.places[0], path.quaternions[0] = self._start, LEVEL
            kernels.begin(path, self._quality)
        kernels.follow(max(1, known - 1), samples, self._quality, path)
        self._samples, self._path = samples, path
        angles = kernels.beyond_level(navdata.attitude, path.quaternions[known:])
        w, x, y, z = path.quaternions[-1]
        heading = float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        duration = float(navdata.times[-1] - samples.times[max(known - 1, 0)])
        return Reading(angles, heading, duration)

    def pose(self, time: float) -> tuple[Vector3, Rotation]:
        """Return place (m) and rotation from body to frame at a time (s), by the gyro.

        Between two samples both are interpolated; before the first and after the last, these hold.
        """
        if not len(self._samples.times):
            return self._start, rotation_from_quaternion(LEVEL)
        at, share = self._between(time)
        quaternion = _mixed(self._path.quaternions, at, share)
        place = _mixed(self._path.places, at, share)
        return place, rotation_from_quaternion(quaternion / np.linalg.norm(quaternion))

    def velocity(self, time: float, lever: Vector3) -> Vector3:
        """Return the velocity of a point of the body, m/s, at a time (s).

        Args:
            time: s.
            lever: where the point is in the body, m.
        """
        if not len(self._samples.times):
            return np.zeros(3)
        at, share = self._between(time)
        return _mixed(self._path.velocities, at, share) + self._swing(at) @ lever

    def velocity_variance(self, time: float) -> Vector3:
        """Return the variances of the velocity at a time (s), (m/s)^2."""
        if not len(self._samples.times):
            return np.zeros(3)
        at, _ = self._between(time)
        across = self._path.across[at, 0, 0]
        return np.array([across, across, self._path.upward[at, 1, 1]])

    def _swing(self, at: int) -> Float[ndarray, "3 3"]:
        """Return how fast the rotation from body to frame changes, 1/s, kicks left out."""
        times, turns = self._samples.times, self._path.quaternions
        if at + 1 == len(times):
            return np.zeros((3, 3))
        before, after = rotation_from_quaternion(turns[at : at + 2])
        return (after - before) / (times[at + 1] - times[at])

    def _between(self, time: float) -> tuple[int, float]:
        """Return the sample before a time, and the share of the way to the next."""
        times = self._samples.times
        if time <= times[0] or len(times) == 1:
            return 0, 0.0
        at = min(int(np.searchsorted(times, time)), len(times) - 1) - 1
        return at, min(1.0, float((time - times[at]) / (times[at + 1] - times[at])))


def _mixed(rows: Float[ndarray, "n k"], at: int, share: float) -> Float[ndarray, "k"]:
    if share == 0.0:
        return rows[at].copy()
    return (1.0 - share) * rows[at] + share * rows[at + 1]


def _room(count: int) -> kernels.Path:
    shapes = ((3,), (3,), (4,), (2, 3), (4, 4), (2, 2))
    return kernels.Path(*(np.empty((count, *shape)) for shape in shapes))


def _quality(attitude: AttitudeQuality, odometry: OdometryQuality) -> kernels.Quality:
    """Return both as the kernel takes them; readings that are held for long count once."""
    held = max(1.0, SAMPLE_RATE / attitude.reading_rate)
    return kernels.Quality(
        odometry.flow_sd**2, odometry.acceleration_sd**2, odometry.rise_sd**2,
        odometry.sonar_sd**2, odometry.flow_bias_sd**2, held * attitude.reading_sd**2,
        attitude.reading_offset_sd**2, attitude.start_sd**2, attitude.walk,
        odometry.drag, odometry.drag_sd, odometry.thrust_sd,
        odometry.flow_delay,
    )  # fmt: skip
