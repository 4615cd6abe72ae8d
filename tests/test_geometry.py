"""Rotations form a group and agree with scipy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation as Oracle

from rotorpong.geometry import (
    euler_from_quaternion,
    level_from_body,
    quaternion_from_euler,
    rotation_from_quaternion,
)

angles = arrays(float, (3,), elements=st.floats(-3.1, 3.1))
quaternions = arrays(float, (4,), elements=st.floats(-1, 1)).filter(
    lambda q: np.linalg.norm(q) > 0.1
)


def unit(quaternion):
    return quaternion / np.linalg.norm(quaternion)


def product(a, b):
    """Hamilton's product, the rotation b followed by a."""
    w, v, u, r = a[0], a[1:], b[0], b[1:]
    return np.array([w * u - v @ r, *(w * r + u * v + np.cross(v, r))])


@given(quaternions)
def test_a_rotation_keeps_lengths_and_handedness(quaternion):
    rotation = rotation_from_quaternion(unit(quaternion))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_the_neutral_quaternion_turns_nothing():
    np.testing.assert_array_equal(rotation_from_quaternion(np.array([1.0, 0, 0, 0])), np.eye(3))


@given(quaternions)
def test_the_conjugate_is_the_inverse(quaternion):
    q = unit(quaternion)
    back = rotation_from_quaternion(q * [1, -1, -1, -1])
    np.testing.assert_allclose(back @ rotation_from_quaternion(q), np.eye(3), atol=1e-14)


@given(quaternions, quaternions)
def test_the_matrix_of_a_product_is_the_product_of_the_matrices(a, b):
    a, b = unit(a), unit(b)
    chained = rotation_from_quaternion(a) @ rotation_from_quaternion(b)
    np.testing.assert_allclose(rotation_from_quaternion(product(a, b)), chained, atol=1e-14)


@given(quaternions)
def test_matrices_agree_with_scipy(quaternion):
    w, x, y, z = q = unit(quaternion)
    np.testing.assert_allclose(
        rotation_from_quaternion(q), Oracle.from_quat([x, y, z, w]).as_matrix(), atol=1e-14
    )


@given(angles)
def test_euler_angles_agree_with_scipy(roll_pitch_yaw):
    roll, pitch, yaw = roll_pitch_yaw
    np.testing.assert_allclose(
        rotation_from_quaternion(quaternion_from_euler(roll_pitch_yaw)),
        Oracle.from_euler("ZYX", [yaw, pitch, roll]).as_matrix(),
        atol=1e-14,
    )


@given(angles)
def test_angles_come_back_when_the_pitch_is_below_a_right_angle(roll_pitch_yaw):
    wanted = roll_pitch_yaw * [1.0, 0.49, 1.0]
    found = euler_from_quaternion(quaternion_from_euler(wanted))
    np.testing.assert_allclose(found, wanted, atol=1e-6)


@given(angles, st.sampled_from([-1.0, 1.0]))
def test_near_the_pole_the_angles_still_name_the_same_rotation(roll_pitch_yaw, side):
    roll, _, yaw = roll_pitch_yaw
    steep = quaternion_from_euler(np.array([roll, side * (np.pi / 2 - 1e-4), yaw]))
    again = quaternion_from_euler(euler_from_quaternion(steep))
    np.testing.assert_allclose(
        rotation_from_quaternion(again), rotation_from_quaternion(steep), atol=1e-6
    )


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_at_the_pole_the_pitch_is_a_right_angle(side):
    found = euler_from_quaternion(quaternion_from_euler(np.array([0.3, side * np.pi / 2, 0.5])))
    assert found[1] == pytest.approx(side * np.pi / 2, abs=1e-7)
    assert np.all(np.isfinite(found))


def test_with_y_left_a_positive_pitch_lowers_the_nose():
    forward = rotation_from_quaternion(quaternion_from_euler(np.array([0.0, 0.1, 0.0])))[:, 0]
    np.testing.assert_allclose(forward, [np.cos(0.1), 0.0, -np.sin(0.1)], atol=1e-15)


def test_level_axes_keep_the_tilt_and_forget_the_heading():
    tilted = np.array([0.2, -0.1, 1.3])
    world_from_body = Oracle.from_euler("ZYX", tilted[::-1]).as_matrix()
    world_from_level = Oracle.from_euler("Z", tilted[2]).as_matrix()
    np.testing.assert_allclose(
        level_from_body(tilted), world_from_level.T @ world_from_body, atol=1e-15
    )
    assert tilted[2] == 1.3


def test_a_batch_turns_like_its_members():
    many = np.random.default_rng(0).uniform(-1.5, 1.5, (2, 3, 3))
    quaternion = quaternion_from_euler(many)
    for i in np.ndindex(2, 3):
        np.testing.assert_array_equal(quaternion[i], quaternion_from_euler(many[i]))
        np.testing.assert_array_equal(
            rotation_from_quaternion(quaternion)[i], rotation_from_quaternion(quaternion[i])
        )
        np.testing.assert_array_equal(
            euler_from_quaternion(quaternion)[i], euler_from_quaternion(quaternion[i])
        )
        np.testing.assert_array_equal(level_from_body(many)[i], level_from_body(many[i]))


def test_shapes_must_fit():
    with pytest.raises(Exception, match="quaternion"):
        rotation_from_quaternion(np.zeros(3))
