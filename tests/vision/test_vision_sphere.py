import cv2
import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.physics.camera import ARDRONE2_360P, ARDRONE2_720P, GAZEBO, project
from rotorpong.vision.locate import ball_position
from rotorpong.vision.sphere import (
    disc_of_sphere,
    outline_shape,
    sphere_of_disc,
    symmetric_shape,
)

RADIUS = 0.02
CAMERAS = (GAZEBO, ARDRONE2_360P, ARDRONE2_720P)


def random_ball(rng, half_angles=(0.25, 3.0), off_axis=30.0):
    """Return a ball seen under a half angle of 0.25 to 3 degrees, up to 30 degrees off the axis."""
    tilt, turn = np.radians(rng.uniform(0, off_axis)), rng.uniform(0, 2 * np.pi)
    distance = RADIUS / np.sin(np.radians(rng.uniform(*half_angles)))
    direction = [np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)]
    return distance * np.array(direction)


def opencv_outline(camera, ball, points=20_000):
    """Return where cv2.projectPoints puts the circle along which lines of sight touch the ball."""
    squared = ball @ ball
    along = ball / np.sqrt(squared)
    side = np.cross(along, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    angle = np.linspace(0.0, 2 * np.pi, points, endpoint=False)[:, None]
    shrink = 1.0 - RADIUS**2 / squared
    ring = np.cos(angle) * side + np.sin(angle) * np.cross(along, side)
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    matrix, still = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]), np.zeros(3)
    touched = ball * shrink + RADIUS * np.sqrt(shrink) * ring
    return cv2.projectPoints(touched, still, still, matrix, np.array(camera.distortion))[0][:, 0]


def disc_of_polygon(polygon):
    after = np.roll(polygon, -1, axis=0)
    cross = polygon[:, 0] * after[:, 1] - after[:, 0] * polygon[:, 1]
    center = ((polygon + after) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return np.array([*center, np.sqrt(abs(cross.sum()) / 2 / np.pi)])


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.name)
def test_the_disc_is_that_of_a_dense_outline_through_opencv(camera):
    rng = np.random.default_rng(1)
    balls = [random_ball(rng) for _ in range(40)]
    expected = [disc_of_polygon(opencv_outline(camera, ball)) for ball in balls]
    np.testing.assert_allclose(disc_of_sphere(camera, np.array(balls)), expected, atol=2e-6)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.name)
def test_the_way_back_from_opencvs_outline_is_good_to_a_millionth(camera):
    rng = np.random.default_rng(2)
    balls = np.array([random_ball(rng) for _ in range(40)])
    discs = np.array([disc_of_polygon(opencv_outline(camera, ball)) for ball in balls])
    found = sphere_of_disc(camera, discs, np.zeros((40, 3, 3))).position
    errors = np.linalg.norm(found - balls, axis=-1) / np.linalg.norm(balls, axis=-1)
    assert errors.max() < 1e-6


def test_the_ellipse_on_the_plane_z_1_is_that_of_the_equations():
    focal, ball = GAZEBO.focal_length_px[0], np.array([0.3, -0.2, 0.9])
    sine = RADIUS / np.linalg.norm(ball)
    n = ball / np.linalg.norm(ball)
    depth = n[2] ** 2 - sine**2
    center = n[:2] * n[2] / depth
    area = np.pi * sine**2 * np.sqrt(1 - sine**2) / depth**1.5
    x, y, radius = disc_of_sphere(GAZEBO, ball)
    np.testing.assert_allclose((np.array([x, y]) - GAZEBO.center_px) / focal, center, rtol=1e-12)
    assert np.pi * (radius / focal) ** 2 == pytest.approx(area, rel=1e-12)


def test_on_the_axis_it_is_eq_1_of_the_paper_but_for_the_spheres_roundness():
    ball = np.array([0.0, 0.0, 2.0])
    x, y, radius = disc_of_sphere(GAZEBO, ball)
    np.testing.assert_allclose([x, y], GAZEBO.center_px, atol=1e-9)
    by_eq1 = ball_position(GAZEBO, np.array([x, y]), np.array(2 * radius))
    np.testing.assert_allclose(by_eq1, ball, atol=2.0 * (RADIUS / 2.0) ** 2)


def test_a_batch_is_what_its_balls_are_one_by_one():
    rng = np.random.default_rng(3)
    balls = np.array([random_ball(rng) for _ in range(6)]).reshape(2, 3, 3)
    discs = disc_of_sphere(ARDRONE2_720P, balls)
    assert discs.shape == (2, 3, 3)
    covariance = np.diag([1e-4, 2e-4, 3e-4])
    all_at_once = sphere_of_disc(ARDRONE2_720P, discs, covariance)
    one = sphere_of_disc(ARDRONE2_720P, discs[1, 2], covariance)
    np.testing.assert_array_equal(all_at_once.position[1, 2], one.position)
    np.testing.assert_allclose(all_at_once.covariance[1, 2], one.covariance, rtol=1e-12)


def test_the_covariance_is_that_of_many_noisy_discs():
    """1,000 draws: sd good to 2.2 % each, correlations to 0.03; bounds are 4 sigma."""
    rng = np.random.default_rng(4)
    spread = np.array([[4e-4, 1e-4, 0.0], [1e-4, 2e-4, 5e-5], [0.0, 5e-5, 1e-4]])
    disc = disc_of_sphere(ARDRONE2_720P, np.array([0.5, 0.3, 1.5]))
    noisy = disc + rng.multivariate_normal(np.zeros(3), spread, 1000)
    found = sphere_of_disc(ARDRONE2_720P, noisy, spread)
    expected = sphere_of_disc(ARDRONE2_720P, disc, spread).covariance
    root = np.linalg.inv(np.linalg.cholesky(expected))
    np.testing.assert_allclose(root @ np.cov(found.position.T) @ root.T, np.eye(3), atol=0.18)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.name)
def test_the_shape_makes_a_circle_of_the_outline(camera):
    rng = np.random.default_rng(5)
    for _ in range(20):
        ball = random_ball(rng, half_angles=(0.2, 0.5))
        outline, disc = opencv_outline(camera, ball, 360), disc_of_sphere(camera, ball)
        shape = outline_shape(camera, disc[:2])
        radii = np.linalg.norm(np.linalg.solve(shape, (outline - disc[:2]).T), axis=0)
        np.testing.assert_allclose(radii, disc[2], rtol=5e-3)
        assert np.linalg.det(shape) == pytest.approx(1.0)


def test_a_symmetric_shape_draws_the_same_ellipse():
    matrix = np.array([[2.0, 0.7], [-0.4, 1.5]])
    shape = symmetric_shape(matrix)
    np.testing.assert_allclose(shape, shape.T)
    np.testing.assert_allclose(
        shape @ shape.T, matrix @ matrix.T / np.linalg.det(matrix), rtol=1e-12
    )


def test_behind_around_or_beside_the_camera_there_is_no_disc():
    balls = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.01], [1.0, 0.0, 0.01]])
    assert np.isnan(disc_of_sphere(GAZEBO, balls)).all()


@pytest.mark.parametrize("disc", [[1.0, 2.0, 0.0], [np.nan, 0.0, 1.0], [5000.0, 5000.0, 4.0]])
def test_discs_that_no_sphere_makes_are_refused(disc):
    with pytest.raises(InputError):
        sphere_of_disc(ARDRONE2_720P, np.array(disc), np.eye(3))


def test_the_centroid_is_not_where_the_centre_appears():
    ball = np.array([0.45, 0.0, 0.9])
    disc = disc_of_sphere(ARDRONE2_720P, ball)
    assert abs(disc[0] - project(ARDRONE2_720P, ball)[0]) > 0.05
