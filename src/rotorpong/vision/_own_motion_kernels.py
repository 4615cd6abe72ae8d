"""The filter of `own_motion`, compiled."""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import GRAVITY, TABLE_HEIGHT
from rotorpong.kernels import kernel

FARTHEST = 0.2  # m by which sonar may differ from what is believed: else it heard something else
SPEED, TILT, OFFSET, BIAS = 0, 1, 2, 3  # of what is known along a horizontal axis
START_SPEED_SD = 0.02  # m/s, of a drone that hovers
START_HEIGHT_SD = 0.02  # m
CORRELATION_TIME = 0.2  # s, over which a wrong drag pushes the same way


class Quality(NamedTuple):
    """How good navdata are, all floats; see `own_motion.OdometryQuality` and `AttitudeQuality`."""

    flow_variance: float  # (m/s)^2, of a sample, as are the next four
    force_variance: float  # (m/s^2)^2
    rise_variance: float  # (m/s^2)^2, of its upward part
    sonar_variance: float  # m^2
    bias_variance: float  # (m/s)^2, constant, of the flow
    reading_variance: float  # rad^2
    offset_variance: float  # rad^2, constant
    tilt_variance: float  # rad^2, at the start
    walk: float  # rad/sqrt(s)
    drag: float  # 1/s
    drag_sd: float  # 1/s
    thrust_sd: float  # relative
    flow_delay: float  # s


class Samples(NamedTuple):
    """Navdata, a row a sample."""

    times: np.ndarray  # (n,) s
    rates: np.ndarray  # (n, 3) rad/s, body axes
    forces: np.ndarray  # (n, 3) m/s^2, body axes
    flows: np.ndarray  # (n, 3) m/s, level axes
    heights: np.ndarray  # (n,) m above what lies below
    readings: np.ndarray  # (n, 2) rad, roll and pitch


class Path(NamedTuple):
    """What is known after each sample."""

    places: np.ndarray  # (n, 3) m
    velocities: np.ndarray  # (n, 3) m/s
    quaternions: np.ndarray  # (n, 4) body to frame, by the gyro
    errors: np.ndarray  # (n, 2, 3) along x, y: tilt that pulls there, offset of its readings (rad),
    # bias of the flow (m/s)
    across: np.ndarray  # (n, 4, 4) covariance of speed and these along x as along y
    upward: np.ndarray  # (n, 2, 2) covariance of height and climb


@kernel
def turn_on(quaternion, rates, dt):
    """Turn a unit quaternion (w, x, y, z), in place, by body rates over dt (a rotation vector)."""
    x, y, z = rates[0] * dt, rates[1] * dt, rates[2] * dt
    angle = math.sqrt(x * x + y * y + z * z)
    c = math.cos(0.5 * angle)
    s = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    x, y, z = s * x, s * y, s * z
    qw, qx, qy, qz = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    quaternion[0] = qw * c - qx * x - qy * y - qz * z
    quaternion[1] = qw * x + qx * c + qy * z - qz * y
    quaternion[2] = qw * y - qx * z + qy * c + qz * x
    quaternion[3] = qw * z + qx * y - qy * x + qz * c


@kernel
def middle(a, b, c):
    """Return the median of three numbers."""
    return max(min(a, b), min(max(a, b), c))


@kernel
def smooth_rate(rates, i, axis):
    """Return a rate without spikes: the median of three samples about it, at the end the last."""
    n = rates.shape[0]
    if n < 3:
        return rates[i, axis]
    j = min(max(i, 1), n - 2)
    return middle(rates[j - 1, axis], rates[j, axis], rates[j + 1, axis])


@kernel
def begin(path, quality):
    """Write what is known at the first sample of a drone that hovers."""
    path.across[0] = 0.0
    path.across[0, SPEED, SPEED] = START_SPEED_SD**2
    path.across[0, TILT, TILT] = quality.tilt_variance
    path.across[0, OFFSET, OFFSET] = quality.offset_variance
    path.across[0, BIAS, BIAS] = quality.bias_variance
    path.upward[0] = 0.0
    path.upward[0, 0, 0], path.upward[0, 1, 1] = START_HEIGHT_SD**2, START_SPEED_SD**2
    path.velocities[0], path.errors[0] = 0.0, 0.0


@kernel
def follow(first, samples, quality, path):
    """Carry all that is known on from sample first - 1 to the last one.

    Args:
        first: sample to begin with, at least 1.
        samples: all of them.
        quality: of theirs.
        path: written from `first` on.
    """
    rate, pull = np.empty(3), np.empty(3)
    for i in range(first, samples.times.shape[0]):
        dt = samples.times[i] - samples.times[i - 1]
        for axis in range(3):
            a, b = smooth_rate(samples.rates, i - 1, axis), smooth_rate(samples.rates, i, axis)
            rate[axis] = 0.5 * (a + b)
        path.quaternions[i] = path.quaternions[i - 1]
        turn_on(path.quaternions[i], rate, dt)
        noise = push(i, samples, quality, path, pull)
        carry_across(i, dt, pull, noise, quality, path)
        carry_upward(i, dt, pull[2], quality.rise_variance * dt, path)
        take_flow(i, samples, quality, path)
        take_reading(i, samples.readings[i], quality, path)
        take_sonar(i, samples.heights[i], quality.sonar_variance, path)


@kernel
def heading_of(q):
    """Return cosine and sine of a quaternion's yaw."""
    yaw = math.atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]))
    return math.cos(yaw), math.sin(yaw)


@kernel
def push(i, samples, quality, path, pull):
    """Write the acceleration (m/s^2) from sample i - 1 to i; return its noise, (m/s)^2/s.

    Rotors pull along the body's z only; what else acts is drag. That and the accelerometer, each as
    noisy as it is, are averaged.
    """
    q, v = path.quaternions[i], path.velocities[i - 1]
    w, x, y, z = q[0], q[1], q[2], q[3]
    dt = samples.times[i] - samples.times[i - 1]
    fx = 0.5 * (samples.forces[i - 1, 0] + samples.forces[i, 0])
    fy = 0.5 * (samples.forces[i - 1, 1] + samples.forces[i, 1])
    fz = 0.5 * (samples.forces[i - 1, 2] + samples.forces[i, 2])
    ax, ay = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    unsure = (quality.thrust_sd * GRAVITY) ** 2 * (ax * ax + ay * ay)
    unsure += quality.drag_sd**2 * (v[0] * v[0] + v[1] * v[1])
    model, felt = 2.0 * CORRELATION_TIME * unsure, quality.force_variance * dt
    share = model / (model + felt)
    mx = (1 - 2 * (y * y + z * z)) * fx + 2 * (x * y - w * z) * fy
    my = 2 * (x * y + w * z) * fx + (1 - 2 * (x * x + z * z)) * fy
    pull[0] = ax * fz + share * mx - (1.0 - share) * quality.drag * v[0]
    pull[1] = ay * fz + share * my - (1.0 - share) * quality.drag * v[1]
    pull[2] = 2 * (x * z - w * y) * fx + 2 * (y * z + w * x) * fy
    pull[2] += (1 - 2 * (x * x + y * y)) * fz - GRAVITY
    return model * (1.0 - share) + felt * (ax * ax + ay * ay)


@kernel
def carry_across(i, dt, pull, noise, quality, path):
    """Predict speed, tilt and offset along x and y."""
    slide = GRAVITY * dt
    for axis in range(2):
        tilt = path.errors[i - 1, axis, 0]
        path.errors[i, axis] = path.errors[i - 1, axis]
        path.velocities[i, axis] = path.velocities[i - 1, axis] + dt * pull[axis] + slide * tilt
        middle_speed = 0.5 * (path.velocities[i, axis] + path.velocities[i - 1, axis])
        path.places[i, axis] = path.places[i - 1, axis] + dt * middle_speed
    onward = np.eye(4)
    onward[SPEED, TILT] = slide
    path.across[i] = onward @ path.across[i - 1] @ onward.T
    path.across[i, SPEED, SPEED] += noise * dt
    path.across[i, TILT, TILT] += quality.walk**2 * dt


@kernel
def carry_upward(i, dt, pull, noise, path):
    """Predict height and climb."""
    path.velocities[i, 2] = path.velocities[i - 1, 2] + dt * pull
    path.places[i, 2] = path.places[i - 1, 2] + dt * (path.velocities[i - 1, 2] + 0.5 * dt * pull)
    onward = np.eye(2)
    onward[0, 1] = dt
    path.upward[i] = onward @ path.upward[i - 1] @ onward.T
    path.upward[i, 1, 1] += noise * dt


@kernel
def take_flow(i, samples, quality, path):
    """Take in what the optical flow says of a moment that is past by its delay."""
    c, s = heading_of(path.quaternions[i])
    forward, left = samples.flows[i, 0], samples.flows[i, 1]
    then = i
    while then > 0 and samples.times[then] > samples.times[i] - quality.flow_delay + 1e-9:
        then -= 1
    seen = np.zeros(4)
    seen[SPEED] = seen[BIAS] = 1.0
    gain = gain_of(path.across[i], seen, quality.flow_variance)
    for axis in range(2):
        flow = c * forward - s * left if axis == 0 else s * forward + c * left
        error = flow - path.velocities[then, axis] - path.errors[i, axis, BIAS - 1]
        correct(i, axis, gain, error, path)


@kernel
def take_reading(i, reading, quality, path):
    """Take in roll and pitch: what they are beyond the gyro's is tilt and offset."""
    roll, pitch = beyond(reading, path.quaternions[i])
    c, s = heading_of(path.quaternions[i])
    seen = np.zeros(4)
    seen[TILT] = seen[OFFSET] = 1.0
    gain = gain_of(path.across[i], seen, quality.reading_variance)
    for axis in range(2):
        along = c * pitch + s * roll if axis == 0 else s * pitch - c * roll
        error = along - path.errors[i, axis, TILT - 1] - path.errors[i, axis, OFFSET - 1]
        correct(i, axis, gain, error, path)


@kernel
def gain_of(covariance, seen, variance):
    """Return the gain of a sum of states that is seen, and take it in the covariance, in place."""
    shared = covariance @ seen
    gain = shared / (seen @ shared + variance)
    for j in range(gain.shape[0]):
        for k in range(gain.shape[0]):
            covariance[j, k] -= gain[j] * shared[k]
    return gain


@kernel
def correct(i, axis, gain, error, path):
    """Move what is known along an axis."""
    path.velocities[i, axis] += gain[SPEED] * error
    for k in range(3):
        path.errors[i, axis, k] += gain[k + 1] * error


@kernel
def take_sonar(i, height, variance, path):
    """Take in a height above floor or table, whichever is nearer to what is believed."""
    z = path.places[i, 2]
    over_floor = height - TABLE_HEIGHT
    error = (height if abs(height - z) < abs(over_floor - z) else over_floor) - z
    if abs(error) < FARTHEST:
        seen = np.zeros(2)
        seen[0] = 1.0
        gain = gain_of(path.upward[i], seen, variance)
        path.places[i, 2] += gain[0] * error
        path.velocities[i, 2] += gain[1] * error


@kernel
def beyond(reading, q):
    """Return roll and pitch of a reading, less those of an attitude."""
    roll = math.atan2(2.0 * (q[0] * q[1] + q[2] * q[3]), 1.0 - 2.0 * (q[1] ** 2 + q[2] ** 2))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (q[0] * q[2] - q[3] * q[1]))))
    return reading[0] - roll, reading[1] - pitch


@kernel
def beyond_level(attitudes, quaternions):
    """Return the mean of roll and pitch readings, less those of the gyro's attitudes, (2,)."""
    total = np.zeros(2)
    for i in range(attitudes.shape[0]):
        roll, pitch = beyond(attitudes[i], quaternions[i])
        total[0] += roll
        total[1] += pitch
    return total / max(1, attitudes.shape[0])
