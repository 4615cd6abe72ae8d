import numpy as np
import pytest

from rotorpong.drone import HOVER
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.paper.trajectory import (
    FLOAT,
    TRACKER,
    WHOLE,
    mean_errors,
    told,
    true_state,
    watched,
)
from rotorpong.physics.camera import GAZEBO
from rotorpong.world.simulated_drone import eye_of

STAGE = stage_of(Spec("hover"))


def hovering():
    """The drone of serve 0 after it hovered through it."""
    drone = new_drone(STAGE, 0)
    while drone.observe() is not None:
        drone.command(HOVER)
    return drone


@pytest.fixture(scope="module")
def seen():
    return {label: told(rows) for label, rows in watched(STAGE, 0).items()}


def test_all_eyes_are_compared_with_the_ball_s_path_in_the_camera_frame(seen):
    truth = hovering().truth()
    for one in seen.values():
        ticks = np.rint(1000.0 * one.time).astype(int)
        poses = np.concatenate([truth.body_path[ticks], truth.attitude_path[ticks]], axis=1)
        eye, axes = eye_of(GAZEBO, poses)
        expected = np.einsum("nij,ni->nj", axes, truth.ball_path[ticks] - eye)
        np.testing.assert_allclose(one.truth[:, :3], expected, rtol=0, atol=1e-9)


def test_the_paper_s_eyes_answer_in_the_same_frames_with_and_without_whole_pixels(seen):
    np.testing.assert_array_equal(seen[WHOLE].time, seen[FLOAT].time)
    rays = [one.estimate[:, :2] / one.estimate[:, 2:3] for one in (seen[WHOLE], seen[FLOAT])]
    np.testing.assert_allclose(*rays, rtol=0, atol=1e-12)


def test_only_the_whole_diameter_is_whole(seen):
    distances = {k: np.linalg.norm(seen[k].estimate[:, :3], axis=1) for k in (WHOLE, FLOAT)}
    diameters = {k: GAZEBO.focal_length_px[0] * 0.04 / d for k, d in distances.items()}
    np.testing.assert_allclose(diameters[WHOLE], np.rint(diameters[FLOAT]), rtol=0, atol=1e-9)


def test_eyes_that_are_left_out_are_not_asked():
    assert list(watched(STAGE, 1, (FLOAT,))) == [FLOAT]


def test_the_tracker_is_nearer_to_the_truth_than_the_circle_in_whole_pixels(seen):
    assert np.all(mean_errors(seen[TRACKER])[[2, 5]] < 0.2 * mean_errors(seen[WHOLE])[[2, 5]])


def test_truth_between_ticks_lies_on_the_line_between_them():
    drone = hovering()
    before, between, after = (true_state(drone, time) for time in (0.2, 0.2004, 0.201))
    np.testing.assert_array_equal(between[3:], before[3:])
    line = before[:3] + 0.4 * (after[:3] - before[:3])
    np.testing.assert_allclose(between[:3], line, rtol=0, atol=1e-12)
    assert np.abs(before[:3] - line).max() > 1e-3


def test_mean_errors_are_absolute_and_in_centimetres():
    truth = [0.1, 0.2, 3.0, 0.0, 0.0, -7.0]
    rows = [[0.0, *(np.add(truth, sign * 0.01 * np.arange(1.0, 7.0))), *truth] for sign in (1, -1)]
    np.testing.assert_allclose(mean_errors(told(rows)), np.arange(1.0, 7.0), atol=1e-9)


def test_eyes_that_told_nothing_have_no_error():
    assert np.isnan(mean_errors(told([]))).all()


def test_eyes_that_do_not_exist_are_no_eyes():
    with pytest.raises(KeyError, match="glasses"):
        watched(STAGE, 0, ("glasses",))
