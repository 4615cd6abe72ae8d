"""The camera is OpenCV's, and never shows what is behind it or folded back by its model."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotorpong.conventions import InputError
from rotorpong.physics.camera import (
    ARDRONE2_360P,
    ARDRONE2_720P,
    CAMERA_RANGES,
    CAMERAS,
    GAZEBO,
    camera_from_body,
    directions,
    draw_camera,
    ideal,
    in_picture,
    pixel_directions,
    project,
    require_camera,
    row_time,
)

LENSES = [
    GAZEBO,
    ARDRONE2_360P,
    ARDRONE2_720P,
    replace(GAZEBO, name="every term", distortion=(-0.3, 0.1, 0.001, -0.002, -0.01)),
]
lenses = pytest.mark.parametrize("camera", LENSES, ids=lambda camera: camera.name)


def matrix(camera):
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def points_in_view(camera, count=500):
    rng = np.random.default_rng(0)
    edges = np.abs(pixel_directions(camera)).max(axis=(0, 1))
    depth = rng.uniform(0.1, 6.0, (count, 1))
    return np.hstack([rng.uniform(-edges, edges, (count, 2)) * depth, depth])


def random_pixels(camera, count=500):
    rng = np.random.default_rng(1)
    return rng.uniform(0, [camera.width_px - 1, camera.height_px - 1], (count, 2))


@lenses
def test_projection_is_that_of_opencv(camera):
    points = points_in_view(camera)
    still = np.zeros(3)
    oracle, _ = cv2.projectPoints(points, still, still, matrix(camera), np.array(camera.distortion))
    np.testing.assert_allclose(project(camera, points), oracle[:, 0], atol=1e-6, rtol=0)


@lenses
def test_undistortion_is_that_of_opencv(camera):
    pixels = random_pixels(camera)
    strict = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 500, 1e-14)
    oracle = cv2.undistortPoints(
        pixels[:, None], matrix(camera), np.array(camera.distortion), None, None, None, strict
    )
    error_px = (directions(camera, pixels) - oracle[:, 0]) * camera.focal_length_px
    np.testing.assert_allclose(error_px, 0.0, atol=1e-6)


@lenses
def test_a_pixel_comes_back_along_its_ray(camera):
    pixels = random_pixels(camera)
    depth = np.random.default_rng(2).uniform(0.2, 5.0, (len(pixels), 1))
    points = np.hstack([directions(camera, pixels), np.ones_like(depth)]) * depth
    np.testing.assert_allclose(project(camera, points), pixels, atol=1e-8)


@lenses
def test_every_pixel_sees_inside_the_picture(camera):
    rays = pixel_directions(camera)[1:-1:7, 1:-1:7]
    points = np.concatenate([rays, np.ones_like(rays[..., :1])], axis=-1)
    assert in_picture(camera, points).all()


@lenses
def test_nothing_behind_the_camera_is_in_the_picture(camera):
    points = np.random.default_rng(3).uniform(-5, [5, 5, 0], (500, 3))
    points = np.vstack([points, -points_in_view(camera), [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]])
    assert not in_picture(camera, points).any()
    assert np.isnan(project(camera, points)).all()


@lenses
def test_nothing_beyond_the_widest_ray_is_in_the_picture(camera):
    rng = np.random.default_rng(4)
    widest = np.linalg.norm(np.abs(pixel_directions(camera)).max(axis=(0, 1)))
    angle, radius = rng.uniform(0, 2 * np.pi, 2000), widest * rng.uniform(1.01, 50.0, 2000)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.ones(2000)], axis=-1)
    assert not in_picture(camera, points).any()


def test_a_lens_model_folds_back_into_the_picture_and_is_not_believed():
    barrel = replace(GAZEBO, distortion=(-0.15, 0.0, 0.0, 0.0, 0.0))
    radius_of_return = np.sqrt(1 / 0.15)
    point = np.array([[radius_of_return, 0.0, 1.0]])
    np.testing.assert_allclose(project(barrel, point), [barrel.center_px])
    assert not in_picture(barrel, point).any()


def test_a_distant_ball_on_the_axis_is_at_the_principal_point():
    for camera in CAMERAS.values():
        np.testing.assert_allclose(project(camera, np.array([0.0, 0.0, 3.0])), camera.center_px)


def test_a_camera_pitched_up_sees_the_level_axis_lower_and_above_the_middle_less():
    pitched = replace(GAZEBO, camera_pitch_deg=15.0)
    ahead, above = np.array([2.0, 0.0, 0.0]), np.array([2.0, 0.0, 2.0 * np.tan(np.radians(15.0))])
    assert project(pitched, camera_from_body(pitched) @ ahead)[1] > GAZEBO.center_px[1] + 50
    np.testing.assert_allclose(
        project(pitched, camera_from_body(pitched) @ above), GAZEBO.center_px, atol=1e-9
    )


@given(st.floats(-90, 90))
def test_the_mount_is_a_rotation(pitch_deg):
    mount = camera_from_body(replace(GAZEBO, camera_pitch_deg=pitch_deg))
    np.testing.assert_allclose(mount @ mount.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(mount) == pytest.approx(1.0)


@lenses
def test_a_batch_projects_like_its_members(camera):
    points = points_in_view(camera, 12).reshape(3, 4, 3)
    pixels, rays = project(camera, points), directions(camera, project(camera, points))
    for i in np.ndindex(3, 4):
        np.testing.assert_array_equal(pixels[i], project(camera, points[i]))
        np.testing.assert_allclose(rays[i], directions(camera, pixels[i]), atol=1e-12)
        assert in_picture(camera, points)[i] == in_picture(camera, points[i])  # one point, too


def test_the_table_of_rays_is_shared_and_cannot_be_changed():
    assert pixel_directions(GAZEBO) is pixel_directions(replace(GAZEBO))
    with pytest.raises(ValueError, match="read-only"):
        pixel_directions(GAZEBO)[0, 0] = 0.0


def test_points_need_three_coordinates():
    with pytest.raises(Exception, match="points"):
        project(GAZEBO, np.zeros((4, 2)))


def test_every_profile_can_be_and_lies_within_what_is_not_known_of_it():
    for camera in CAMERAS.values():
        assert require_camera(camera) is camera
        if not camera.is_ideal:
            for name, (low, high) in CAMERA_RANGES.items():
                assert low <= getattr(camera, name) <= high, name


def test_a_drawn_camera_keeps_its_lens_and_gets_what_it_has_from_the_ranges():
    rng = np.random.default_rng(0)
    for _ in range(50):
        drawn = require_camera(draw_camera(ARDRONE2_360P, rng))
        assert drawn != ARDRONE2_360P
        assert ideal(drawn) == ideal(ARDRONE2_360P)
        for name, (low, high) in CAMERA_RANGES.items():
            assert low <= getattr(drawn, name) <= high
    assert draw_camera(GAZEBO, rng) == GAZEBO
    first, second = (draw_camera(ARDRONE2_360P, np.random.default_rng(1)) for _ in range(2))
    assert first == second


def test_an_ideal_camera_is_the_lens_alone():
    assert GAZEBO.is_ideal
    assert not ARDRONE2_720P.is_ideal
    assert ideal(GAZEBO) == GAZEBO
    assert ideal(ARDRONE2_720P).is_ideal
    points = points_in_view(ARDRONE2_720P)
    assert np.array_equal(
        project(ideal(ARDRONE2_720P), points), project(ARDRONE2_720P, points), equal_nan=True
    )


def test_rows_are_exposed_evenly_about_the_frame_time_and_all_at_once_without_readout():
    rows = np.arange(360.0)
    times = row_time(ARDRONE2_360P, 2.0, rows)
    np.testing.assert_allclose(times + times[::-1], 4.0)
    assert times[-1] - times[0] == pytest.approx(ARDRONE2_360P.readout_s * 359 / 360)
    np.testing.assert_array_equal(row_time(GAZEBO, 2.0, rows), 2.0)


@pytest.mark.parametrize(
    "change",
    [
        {"readout_s": -0.01},
        {"exposure_s": float("nan")},
        {"gamma": 0.0},
        {"drop_share": 1.0},
        {"blur_px": float("inf")},
        {"camera_pitch_deg": 200.0},
        {"frames_per_second": 0.0},
        {"delay_s": (0.2, 0.1)},
        {"delay_s": (float("nan"), 0.1)},
        {"focal_length_px": (0.0, 300.0)},
        {"distortion": (float("nan"), 0.0, 0.0, 0.0, 0.0)},
        {"distortion": (-0.5, 0.0, 0.0, 0.0, 0.0)},  # folds back before the corners
        {"width_px": 0},
        {"height_px": 1},
    ],
    ids=str,
)
def test_a_camera_with_impossible_constants_is_refused_by_name(change):
    (name,) = change
    word = {
        "focal_length_px": "focal length",
        "distortion": "distortion",
        "width_px": "0 x 360",
        "height_px": "640 x 1",
    }.get(name, name)
    with pytest.raises(InputError, match=word):
        require_camera(replace(GAZEBO, **change))
