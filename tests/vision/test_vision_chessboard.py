"""The lens that boards tell, against the one that they were drawn with."""

from dataclasses import replace

import numpy as np
import pytest
from calibration_scenes import PLACES, ROTATIONS, board_picture, corners_of

from rotorpong.conventions import InputError
from rotorpong.physics.camera import ARDRONE2_360P, GAZEBO, Camera, directions, ideal, project
from rotorpong.vision.chessboard import Board, field_of_view_deg, find_corners, fit_lens

BOARD = Board(9, 6, 0.025)
BLANK = Camera("blank", 640, 360, (1.0, 1.0), (0.0, 0.0))


def seen(camera, rotations, places=PLACES, noise=0.1):
    """Corners with noise, by OpenCV's projection."""
    rng = np.random.default_rng(3)
    near = camera.focal_length_px[0] / ARDRONE2_360P.focal_length_px[0]  # boards as large
    poses = [(turn, (x, y, z * near)) for turn, (x, y, z) in zip(rotations, places, strict=False)]
    corners = [corners_of(camera, *pose) for pose in poses]
    return [(c + rng.normal(0.0, noise, c.shape)).astype(np.float32) for c in corners]


def test_corners_are_found_where_opencv_projects_them():
    for rotation, place in zip(ROTATIONS[:4], PLACES, strict=False):
        found = find_corners(board_picture(ARDRONE2_360P, rotation, place), BOARD)
        assert found is not None
        wanted = corners_of(ARDRONE2_360P, rotation, place)
        apart = min(np.linalg.norm(order - wanted, axis=1).max() for order in (found, found[::-1]))
        assert apart < 0.3


def test_a_picture_without_a_board_has_no_corners():
    assert find_corners(np.full((120, 160, 3), 90, np.uint8), BOARD) is None


@pytest.mark.parametrize("camera", [ARDRONE2_360P, GAZEBO])
def test_the_lens_that_projected_the_corners_comes_back(camera):
    fit = fit_lens(seen(camera, ROTATIONS), BOARD, BLANK)
    np.testing.assert_allclose(fit.camera.focal_length_px, camera.focal_length_px, rtol=0.005)
    assert fit.camera.distortion[4] == 0.0  # which both cameras have
    grid = np.stack(np.meshgrid(np.linspace(0, 639, 9), np.linspace(0, 359, 7)), -1)
    rays = np.dstack([directions(camera, grid), np.ones(grid.shape[:2])])
    assert np.abs(project(fit.camera, rays) - grid).max() < 3.0  # px, also where no board was
    assert fit.reprojection_rms_px == pytest.approx(0.1 * np.sqrt(2.0), rel=0.15)
    errors = np.subtract(fit.camera.focal_length_px, camera.focal_length_px)
    assert np.all(np.abs(errors) < 4.0 * np.array(fit.focal_length_sd_px))
    errors = np.subtract(fit.camera.center_px, camera.center_px)
    assert np.all(np.abs(errors) < 4.0 * np.array(fit.center_sd_px))


def test_the_squares_size_does_not_change_the_lens():
    corners = seen(ARDRONE2_360P, ROTATIONS)
    small, large = (fit_lens(corners, replace(BOARD, square_m=s), BLANK) for s in (0.025, 0.1))
    np.testing.assert_allclose(
        small.camera.focal_length_px, large.camera.focal_length_px, rtol=1e-5
    )


def test_the_rest_of_the_camera_stays_as_it_was():
    fit = fit_lens(seen(GAZEBO, ROTATIONS), BOARD, replace(BLANK, frames_per_second=60.0))
    assert (fit.camera.name, fit.camera.frames_per_second) == ("blank", 60.0)


@pytest.mark.parametrize("rotation", [(0.0, 0.0, 0.0), (0.4, 0.3, 0.0)])
@pytest.mark.parametrize("noise", [0.01, 0.1, 0.3])
def test_parallel_boards_tell_no_focal_length(rotation, noise):
    with pytest.raises(InputError, match="tilted by 20 to 40 degrees"):
        fit_lens(seen(ARDRONE2_360P, [rotation] * 10, noise=noise), BOARD, BLANK)


def test_a_k3_that_the_boards_tell_stays():
    camera = replace(GAZEBO, distortion=(-0.3, 0.12, 0.0, 0.0, -0.02))
    places = [(1.3 * x, 1.3 * y, 0.9 * z) for x, y, z in PLACES]
    fit = fit_lens(seen(camera, ROTATIONS, places, noise=0.005), BOARD, BLANK)
    assert fit.camera.distortion[4] == pytest.approx(-0.02, abs=0.01)
    assert fit.distortion_sd[4] > 0.0


def test_boards_in_the_middle_only_do_not_tell_the_lens():
    places = [(0.3 * x, 0.3 * y, 2.0 * z) for x, y, z in PLACES]
    with pytest.raises(InputError, match="% of the picture's width and"):
        fit_lens(seen(ARDRONE2_360P, ROTATIONS, places), BOARD, BLANK)


def test_corners_of_another_board_leave_too_large_an_error():
    corners = [c[np.random.default_rng(0).permutation(54)] for c in seen(GAZEBO, ROTATIONS)]
    with pytest.raises(InputError, match="expected"):
        fit_lens(corners, BOARD, BLANK)


def test_two_boards_are_too_few():
    with pytest.raises(InputError, match="2 boards; expected at least 3"):
        fit_lens(seen(GAZEBO, ROTATIONS[:2]), BOARD, BLANK)


def test_the_field_of_view_of_an_ideal_camera_is_that_of_its_tangents():
    camera = replace(ideal(GAZEBO), center_px=(319.5, 179.5))
    across, down = field_of_view_deg(camera)
    assert across == pytest.approx(2.0 * np.degrees(np.arctan(320.0 / 374.7)))
    assert down == pytest.approx(2.0 * np.degrees(np.arctan(180.0 / 374.7)))
