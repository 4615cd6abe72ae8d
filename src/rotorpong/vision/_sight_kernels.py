"""Discs to sights and back, compiled; see `sights`."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.vision._flight_filter_kernels import SIZE, TILT, look
from rotorpong.vision._sphere_kernels import FOUND, disc, positions_of


@kernel
def sight_of_disc(lens, measured, covariance, seen, noise):
    """Write (X/Z, Y/Z, angular radius) and its covariance of a disc; False if no ball looks so.

    Args:
        lens: as `_sphere_kernels.discs` takes it.
        measured: (3,) x, y, radius, px.
        covariance: (3, 3) px^2.
        seen: (3,), written.
        noise: (3, 3), written.
    """
    place, spread = np.empty((1, 3)), np.empty((1, 3, 3))
    seen_disc, spreads = measured.reshape(1, 3), covariance.reshape(1, 3, 3)
    if positions_of(lens, seen_disc, spreads, BALL_RADIUS, place, spread) != FOUND:
        return False
    x, y, z = place[0, 0], place[0, 1], place[0, 2]
    squared = x * x + y * y + z * z
    if not (z > 0.0 and squared > 4.0 * BALL_RADIUS**2):
        return False
    sine = BALL_RADIUS / math.sqrt(squared)
    falling = -sine / (squared * math.sqrt(1.0 - sine * sine))
    angles = np.array([[1.0 / z, 0.0, -x / z**2], [0.0, 1.0 / z, -y / z**2],
                       [falling * x, falling * y, falling * z]])  # fmt: skip
    noise[:] = angles @ spread[0] @ angles.T
    seen[0], seen[1], seen[2] = x / z, y / z, math.asin(sine)
    return True


@kernel
def disc_of_view(lens, place, tilt, pose, out):
    """Write the disc of a ball that a camera sees from a pose, its attitude off by a tilt."""
    rx, ry, rz = place[0] - pose[0], place[1] - pose[1], place[2] - pose[2]
    wx = rx - (tilt[1] * rz - tilt[2] * ry)
    wy = ry - (tilt[2] * rx - tilt[0] * rz)
    wz = rz - (tilt[0] * ry - tilt[1] * rx)
    out[0], out[1], out[2] = disc(
        lens,
        pose[3] * wx + pose[4] * wy + pose[5] * wz,
        pose[6] * wx + pose[7] * wy + pose[8] * wz,
        pose[9] * wx + pose[10] * wy + pose[11] * wz,
        BALL_RADIUS,
    )


@kernel
def aim(lens, mean, covariance, poses, lag, out):
    """Write where a ball must be in a picture; False if it is not before the camera.

    Args:
        lens: as above.
        mean: (16,) of the flight filter.
        covariance: (16, 16).
        poses: (2, 12) of the camera, as `_flight_filter_kernels.look` takes them: now, and before.
        lag: s between them.
        out: (9,), written: disc, its velocity in px/s, standard deviations of the disc (px) and of
            the velocity downwards (px/s).
    """
    expected, slopes, before = np.empty(3), np.empty((3, SIZE)), np.empty(3)
    if not look(mean, poses[0], expected, slopes):
        return False
    tilt = mean[TILT : TILT + 3]
    disc_of_view(lens, mean[:3], tilt, poses[0], out[:3])
    disc_of_view(lens, mean[:3] - lag * mean[3:6], tilt, poses[1], before)
    out[3], out[4] = (out[0] - before[0]) / lag, (out[1] - before[1]) / lag
    spread = slopes @ covariance @ slopes.T
    for k in range(3):
        out[5 + k] = lens[min(k, 1)] * math.sqrt(max(spread[k, k], 0.0))
    falling = 0.0
    for i in range(3):
        for j in range(3):
            falling += slopes[1, i] * covariance[3 + i, 3 + j] * slopes[1, j]
    out[8] = lens[1] * math.sqrt(max(falling, 0.0))
    return bool(np.isfinite(out).all())
