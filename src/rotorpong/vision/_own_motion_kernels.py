"""The sums of `own_motion`, compiled."""

import math

import numpy as np

from rotorpong.conventions import TABLE_HEIGHT
from rotorpong.kernels import kernel

FARTHEST = 0.2  # m by which sonar may differ from what is believed: else it heard something else


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
def integrate(first, times, rates, velocities, heights, gain, places, quaternions):
    """Carry place and attitude on from sample first - 1 to the last one.

    The height is pulled towards what sonar says, above the floor or above the table, whichever is
    nearer to what is believed.

    Args:
        first: sample to begin with, at least 1.
        times: (n,) s.
        rates: (n, 3) body rates, rad/s.
        velocities: (n, 3) forward, left, up in level axes, m/s.
        heights: (n,) m above what lies below.
        gain: 1/s, of the pull.
        places: (n, 3), m, written from `first` on.
        quaternions: (n, 4), body to frame, written from `first` on.
    """
    rate = np.empty(3)
    for i in range(first, times.shape[0]):
        dt = times[i] - times[i - 1]
        for axis in range(3):
            rate[axis] = 0.5 * (smooth_rate(rates, i - 1, axis) + smooth_rate(rates, i, axis))
        quaternions[i] = quaternions[i - 1]
        turn_on(quaternions[i], rate, dt)
        w, x, y, z = quaternions[i, 0], quaternions[i, 1], quaternions[i, 2], quaternions[i, 3]
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        c, s = math.cos(yaw), math.sin(yaw)
        forward = 0.5 * (velocities[i - 1, 0] + velocities[i, 0])
        left = 0.5 * (velocities[i - 1, 1] + velocities[i, 1])
        places[i, 0] = places[i - 1, 0] + dt * (c * forward - s * left)
        places[i, 1] = places[i - 1, 1] + dt * (s * forward + c * left)
        z = places[i - 1, 2] + dt * 0.5 * (velocities[i - 1, 2] + velocities[i, 2])
        over = (
            heights[i]
            if abs(heights[i] - z) < abs(heights[i] - TABLE_HEIGHT - z)
            else (heights[i] - TABLE_HEIGHT)
        )
        if abs(over - z) < FARTHEST:
            z += min(1.0, gain * dt) * (over - z)
        places[i, 2] = z


@kernel
def beyond_level(attitudes, quaternions):
    """Return the mean of roll and pitch readings, less those of the gyro's attitudes, (2,)."""
    total = np.zeros(2)
    for i in range(attitudes.shape[0]):
        w, x, y, z = quaternions[i, 0], quaternions[i, 1], quaternions[i, 2], quaternions[i, 3]
        total[0] += attitudes[i, 0] - math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        total[1] += attitudes[i, 1] - math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    return total / max(1, attitudes.shape[0])
