import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotorpong.conventions import InputError
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO
from rotorpong.vision.locate import ball_position, position_covariance

CAMERAS = [GAZEBO, ARDRONE2_720P]


def matrix_of(camera):
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def project_with_opencv(camera, points):
    distortion = np.array(camera.distortion)
    pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix_of(camera), distortion)
    return pixels[:, 0]


def silhouette(center, radius, count=720):
    """Return points of a sphere where lines from the origin touch it."""
    distance = np.linalg.norm(center)
    axis = center / distance
    sideways = np.cross(axis, [0.3, 1.0, 0.2])
    sideways /= np.linalg.norm(sideways)
    other = np.cross(axis, sideways)
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    ring = np.cos(angles) * sideways + np.sin(angles) * other
    reach = radius * math.sqrt(1 - (radius / distance) ** 2)
    return axis * (distance - radius**2 / distance) + reach * ring


def picture_of_sphere(camera, center):
    outline = project_with_opencv(camera, silhouette(center, 0.02)).astype(np.float32)
    area = cv2.contourArea(outline)
    return project_with_opencv(camera, center[None])[0], np.array(2 * math.sqrt(area / math.pi))


def test_equations_1_and_2_on_numbers_worked_by_hand():
    pixel = np.array([320.5 + 374.7 * 0.75, 180.5])
    position = ball_position(GAZEBO, pixel, np.array(374.7 * 0.04 / 2.5))
    np.testing.assert_allclose(position, [1.5, 0.0, 2.0], rtol=1e-9)


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_position_projects_back_onto_its_pixel_by_opencv(camera):
    rng = np.random.default_rng(0)
    pixels = rng.uniform([5, 5], [camera.width_px - 5, camera.height_px - 5], (50, 2))
    positions = ball_position(camera, pixels, rng.uniform(3, 60, 50))
    np.testing.assert_allclose(project_with_opencv(camera, positions), pixels, atol=1e-5)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("center", [[0.0, 0.0, 2.5], [0.3, -0.2, 1.0], [-0.8, 0.3, 2.0]])
def test_without_eq1_the_true_outline_of_a_sphere_gives_its_true_place(camera, center):
    center = np.array(center)
    pixel, diameter = picture_of_sphere(camera, center)
    found = ball_position(camera, pixel, diameter, eq1=False)
    np.testing.assert_allclose(found, center, atol=3e-3 * np.linalg.norm(center))


def test_eq1_is_exact_on_the_axis_and_too_near_off_it():
    at_20_degrees = 2.5 * np.array([math.sin(math.radians(20)), 0.0, math.cos(math.radians(20))])
    for center, distance in ((np.array([0.0, 0.0, 2.5]), 2.5), (at_20_degrees, 2.28)):
        pixel, diameter = picture_of_sphere(GAZEBO, center)
        found = ball_position(GAZEBO, pixel, diameter)
        assert np.linalg.norm(found) == pytest.approx(distance, abs=0.005)


@given(st.floats(1.0, 200.0), st.floats(1.1, 5.0))
def test_distance_falls_with_the_diameter_and_grows_with_the_ball(diameter, factor):
    pixel = np.array([400.0, 100.0])
    once = ball_position(GAZEBO, pixel, np.array(diameter))
    np.testing.assert_allclose(
        ball_position(GAZEBO, pixel, np.array(diameter * factor)), once / factor, rtol=1e-9
    )
    np.testing.assert_allclose(
        ball_position(GAZEBO, pixel, np.array(diameter), ball_diameter=0.08), 2 * once, rtol=1e-9
    )


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_batch_is_its_members_one_by_one(camera):
    rng = np.random.default_rng(1)
    pixels, diameters = rng.uniform(100, 300, (2, 3, 2)), rng.uniform(4, 40, (2, 3))
    together = ball_position(camera, pixels, diameters)
    spread = position_covariance(camera, pixels, diameters, center_sd_px=0.1, diameter_sd_px=0.5)
    for index in np.ndindex(2, 3):
        one, size = pixels[index], np.array(diameters[index])
        np.testing.assert_allclose(together[index], ball_position(camera, one, size), rtol=1e-9)
        alone = position_covariance(camera, one, size, center_sd_px=0.1, diameter_sd_px=0.5)
        np.testing.assert_allclose(spread[index], alone, rtol=1e-5)


def test_the_covariance_is_that_of_many_noisy_measurements():
    rng = np.random.default_rng(2)
    pixel, diameter, n = np.array([200.0, 90.0]), np.array(17.0), 40_000
    noisy = pixel + 0.3 * rng.standard_normal((n, 2))
    sizes = diameter + 0.2 * rng.standard_normal(n)
    sampled = np.cov(ball_position(GAZEBO, noisy, sizes).T)
    stated = position_covariance(GAZEBO, pixel, diameter, center_sd_px=0.3, diameter_sd_px=0.2)
    np.testing.assert_allclose(stated, sampled, atol=0.03 * sampled.max())  # 3 % is 4 sigma


@pytest.mark.parametrize(
    ("pixel", "diameter", "ball"),
    [
        ([np.nan, 0.0], 5.0, 0.04),
        ([0.0, 0.0], 0.0, 0.04),
        ([0.0, 0.0], -3.0, 0.04),
        ([0.0, 0.0], np.inf, 0.04),
        ([0.0, 0.0], 5.0, 40.0),
        ([0.0, 0.0], 5.0, 0.0),
    ],
)
def test_measurements_that_are_no_ball_are_refused(pixel, diameter, ball):
    with pytest.raises(InputError):
        ball_position(GAZEBO, np.array(pixel), np.array(diameter), ball_diameter=ball)


def test_pixels_beyond_the_lens_model_are_refused():
    folding = replace(ARDRONE2_720P, distortion=(-0.5, 0.0, 0.0, 0.0, 0.0))
    assert ball_position(folding, np.array([1000.0, 400.0]), np.array(5.0))[2] > 0.0
    with pytest.raises(InputError, match="distortion"):
        ball_position(folding, np.array([1400.0, 400.0]), np.array(5.0))
