import math
from dataclasses import replace

import numpy as np
import pytest

from rotorpong.conventions import BALL_RADIUS
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO, camera_from_body
from rotorpong.vision.flight_filter import HUMAN_PRIOR, ground
from rotorpong.vision.sights import aim_at, angles_of_disc
from rotorpong.vision.sphere import disc_of_sphere

EYE = np.array([-1.69, 0.0, 0.20])
LAG = 0.005
CAMERAS = pytest.mark.parametrize("camera", [GAZEBO, ARDRONE2_720P], ids=lambda c: c.name)


def pose_of(camera, eye=EYE):
    return np.concatenate([eye, camera_from_body(camera).ravel()])


def believed(position, velocity, sds):
    start = ground(HUMAN_PRIOR, 0.0)
    mean, covariance = np.zeros(16), np.zeros((16, 16))
    mean[:3], mean[3:6] = position, velocity
    covariance[np.arange(6), np.arange(6)] = np.square(sds)
    return replace(start, mean=mean, covariance=covariance)


@CAMERAS
def test_a_disc_is_the_angle_that_made_it(camera):
    ball = np.array([0.3, -0.2, 2.6])
    seen, _ = angles_of_disc(camera, disc_of_sphere(camera, ball), 1e-4 * np.eye(3))
    x, y, z = ball
    angle = math.asin(BALL_RADIUS / np.linalg.norm(ball))
    assert seen == pytest.approx([x / z, y / z, angle], abs=1e-8)


@CAMERAS
def test_the_covariance_of_a_sight_is_that_of_many_discs(camera):
    """4,000 discs: a variance errs by 2.2 %, 4 sigma are 9 %."""
    ball, rng = np.array([0.3, -0.2, 2.6]), np.random.default_rng(0)
    disc = disc_of_sphere(camera, ball)
    spread = np.array([[4e-4, 1e-4, 0.0], [1e-4, 2e-4, 1e-4], [0.0, 1e-4, 3e-4]])
    _, told = angles_of_disc(camera, disc, spread)
    drawn = rng.multivariate_normal(disc, spread, 4000)
    seen = np.array([angles_of_disc(camera, one, spread)[0] for one in drawn])
    found = np.cov(seen.T)
    scale = np.sqrt(np.outer(np.diag(told), np.diag(told)))
    assert np.abs((found - told) / scale).max() < 0.09


def test_no_ball_looks_like_a_disc_without_size():
    disc = np.array([GAZEBO.center_px[0], GAZEBO.center_px[1], 5000.0])
    assert angles_of_disc(GAZEBO, disc, np.eye(3)) is None


@CAMERAS
def test_an_aim_is_the_disc_of_the_ball_and_how_it_moves(camera):
    position, velocity = np.array([1.0, 0.2, 0.5]), np.array([-6.0, 0.5, -1.0])
    aim = aim_at(camera, believed(position, velocity, [0.01] * 6), *2 * [pose_of(camera)], LAG)
    turned = camera_from_body(camera)
    now, before = (
        disc_of_sphere(camera, turned @ (position - k * LAG * velocity - EYE)) for k in (0, 1)
    )
    assert [aim.x_px, aim.y_px, aim.radius_px] == pytest.approx(now, abs=1e-9)
    assert aim.velocity_px_s == pytest.approx((now - before)[:2] / LAG, abs=1e-6)


def test_a_camera_that_flies_along_sees_no_motion():
    velocity = np.array([-6.0, 0.5, -1.0])
    belief = believed(np.array([1.0, 0.2, 0.5]), velocity, [0.01] * 6)
    before = pose_of(GAZEBO, EYE - LAG * velocity)
    aim = aim_at(GAZEBO, belief, pose_of(GAZEBO), before, LAG)
    assert aim.velocity_px_s == pytest.approx([0.0, 0.0], abs=1e-6)


def test_the_spread_of_an_aim_is_that_of_many_balls():
    """2,000 balls: a standard deviation errs by 1.6 %, 4 sigma are 7 %; the lens bends another."""
    position, rng = np.array([1.0, 0.1, 0.3]), np.random.default_rng(0)
    sds = np.array([0.05, 0.01, 0.02, 0.0, 0.0, 0.0])
    aim = aim_at(GAZEBO, believed(position, np.zeros(3), sds), *2 * [pose_of(GAZEBO)], LAG)
    places = position + sds[:3] * rng.standard_normal((2000, 3))
    discs = disc_of_sphere(GAZEBO, (places - EYE) @ camera_from_body(GAZEBO).T)
    assert aim.sd_px == pytest.approx(discs.std(axis=0), rel=0.08)
    assert aim.is_sure == (max(aim.sd_px) < aim.radius_px / 3.0)


def test_a_ball_behind_the_camera_is_no_aim():
    belief = believed(np.array([-3.0, 0.0, 0.2]), np.zeros(3), [0.01] * 6)
    assert aim_at(GAZEBO, belief, *2 * [pose_of(GAZEBO)], LAG) is None
