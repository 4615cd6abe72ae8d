from dataclasses import replace

import numpy as np
import pytest

from rotorpong.lab.bench.eyes_rows import views
from rotorpong.physics.camera import ARDRONE2_720P, ideal, project
from rotorpong.vision.matte import WHITE_BALL, Guess, area_and_edge, measure_ball
from rotorpong.vision.sphere import disc_of_sphere, outline_shape, sphere_of_disc

STILL = replace(ARDRONE2_720P, exposure_s=0.0)
BALLS = 25


def measured(camera, seen, rng):
    truth = disc_of_sphere(camera, seen.ball)
    x, y = truth[:2] + rng.normal(0.0, 0.4, 2)
    guess = Guess(x, y, 1.93 * truth[2], shape=outline_shape(camera, truth[:2]))
    area, edge = area_and_edge(seen.region, guess, offset=seen.offset, gamma=camera.gamma)
    return area, edge, truth


@pytest.mark.parametrize(("depth", "goal_cm"), [(1.0, 0.2), (2.5, 1.5), (4.0, 5.0)])
@pytest.mark.parametrize("camera", [STILL, ideal(STILL)], ids=["whole sensor", "ideal"])
def test_balls_before_the_hall_are_measured_to_the_goal_and_the_covariance_is_honest(
    camera, depth, goal_cm
):
    """25 balls: the median NEES of a chi-square of 3 is 2.4 +- 0.5; allowed up to 8."""
    rng, errors, scores, centers = np.random.default_rng(1), [], [], []
    for seen in views(camera, depth, BALLS, textured=True):
        _, edge, truth = measured(camera, seen, rng)
        disc = np.array([edge.x_px, edge.y_px, edge.radius_px])
        found = sphere_of_disc(camera, disc, edge.covariance)
        errors.append(100.0 * (found.position[2] - seen.ball[2]))
        centers.append(disc[:2] - truth[:2])
        scores.append((disc - truth) @ np.linalg.solve(edge.covariance, disc - truth))
    assert np.sqrt(np.mean(np.square(errors))) < goal_cm
    assert np.sqrt(np.mean(np.square(centers))) < 0.05
    assert np.median(scores) < 8.0


def test_a_ball_that_crosses_before_grey_is_measured_to_the_goal_by_edge_and_area():
    camera = replace(ARDRONE2_720P, exposure_s=1 / 60, readout_s=0.0)
    rng, errors, streaks = np.random.default_rng(2), [], []
    for seen in views(camera, 2.5, BALLS, textured=False, speed=3.0):
        area, edge, truth = measured(camera, seen, rng)
        errors.append([disc.radius_px / truth[2] - 1.0 for disc in (area, edge)])
        half = seen.velocity * camera.exposure_s / 2
        streak = project(camera, seen.ball + half) - project(camera, seen.ball - half)
        streaks.append(min(np.linalg.norm(edge.streak_px - s * streak) for s in (-1, 1)))
    by_area, by_edge = 250.0 * np.sqrt(np.mean(np.square(errors), axis=0))
    assert by_edge < 1.5
    assert by_area < 3.0
    assert np.median(streaks) < 0.5


def test_no_ball_is_found_where_the_hall_shows_none():
    for seen in views(STILL, 2.5, 10, textured=True):
        height, width = seen.region.shape[:2]
        empty = np.ascontiguousarray(np.flip(seen.region[: height // 4]))
        assert measure_ball(empty, Guess(width / 2, height / 8, 9.0), gamma=STILL.gamma) is None
        assert (
            measure_ball(seen.region, Guess(*np.add(seen.offset, 12.0), 17.0), WHITE_BALL) is None
        )


def test_views_are_the_same_every_time():
    first, again = (next(views(STILL, 2.5, 1, textured=True)) for _ in range(2))
    np.testing.assert_array_equal(first.region, again.region)
    np.testing.assert_array_equal(first.ball, again.ball)
