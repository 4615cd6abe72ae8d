"""Rotations and rigid transforms: pure functions, any leading batch shape.

A unit quaternion q = (w, x, y, z) rotates body vectors into the world; Euler angles are roll,
pitch, yaw about x, y, z in the order R = Rz(yaw) Ry(pitch) Rx(roll). With y left, a positive pitch
lowers the nose.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rotorpong.conventions import Quaternion, Rotation, Vector3


def rotation_from_quaternion(quaternion: Quaternion) -> Rotation:
    """Return the matrix that takes body vectors to the world."""
    w, x, y, z = _parts(quaternion)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrix = np.array(rows)
    return matrix if matrix.ndim == 2 else matrix.transpose(*range(2, matrix.ndim), 0, 1)


def quaternion_from_euler(angles: Vector3) -> Quaternion:
    """Return the quaternion of (roll, pitch, yaw) in radians."""
    half = np.asarray(angles) / 2
    cosines, sines = np.cos(half), np.sin(half)
    cr, cp, cy = cosines[..., 0], cosines[..., 1], cosines[..., 2]
    sr, sp, sy = sines[..., 0], sines[..., 1], sines[..., 2]
    parts = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
    return np.stack(parts, axis=-1)


def euler_from_quaternion(quaternion: Quaternion) -> Vector3:
    """Return (roll, pitch, yaw) in radians, pitch within +-pi/2."""
    w, x, y, z = (quaternion[..., k] for k in range(4))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=-1)


def level_from_body(angles: Vector3) -> Rotation:
    """Return the matrix from body axes to the level axes of the same heading.

    Args:
        angles: (roll, pitch, yaw) in radians; yaw is ignored.
    """
    heading_free = np.array(angles, dtype=float)
    heading_free[..., 2] = 0.0
    return rotation_from_quaternion(quaternion_from_euler(heading_free))


def _parts(quaternion: Quaternion) -> Sequence[Any]:
    """Return w, x, y, z; of one quaternion plain floats: the same arithmetic, faster."""
    if quaternion.ndim == 1:
        return quaternion.tolist()
    return [quaternion[..., k] for k in range(4)]
