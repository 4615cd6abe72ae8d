"""Frames and constants are what every part believes them to be."""

import numpy as np
import pytest

from rotorpong import conventions
from rotorpong.conventions import CAMERA_FROM_BODY_AXES


@pytest.mark.parametrize(
    ("body", "camera"),
    [([1, 0, 0], [0, 0, 1]), ([0, 1, 0], [-1, 0, 0]), ([0, 0, 1], [0, -1, 0])],
    ids=["forward is depth", "left is minus right", "up is minus down"],
)
def test_the_axis_map_names_directions(body, camera):
    np.testing.assert_array_equal(CAMERA_FROM_BODY_AXES @ body, camera)


def test_the_axis_map_is_a_rotation():
    np.testing.assert_array_equal(CAMERA_FROM_BODY_AXES @ CAMERA_FROM_BODY_AXES.T, np.eye(3))
    assert np.linalg.det(CAMERA_FROM_BODY_AXES) == pytest.approx(1.0)


def test_nobody_can_change_the_axis_map():
    with pytest.raises(ValueError, match="read-only"):
        CAMERA_FROM_BODY_AXES[0, 0] = 1.0


def test_every_error_can_be_caught_as_one():
    errors = [
        e
        for e in vars(conventions).values()
        if isinstance(e, type) and e.__module__ == conventions.__name__
    ]
    assert errors
    assert all(issubclass(error, conventions.RotorpongError) for error in errors)
    assert len(errors) <= 5
