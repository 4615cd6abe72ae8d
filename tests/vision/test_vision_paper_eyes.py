import numpy as np
import pytest
from vision_drawing import WHITE, plain, with_ball

from rotorpong.conventions import InputError
from rotorpong.drone import Eyes, Frame, Navdata, Observation
from rotorpong.physics.camera import GAZEBO
from rotorpong.vision.paper_eyes import PaperEyes

EMPTY, EMPTY_3 = np.zeros(0), np.zeros((0, 3))
NOTHING = Navdata(EMPTY, EMPTY_3, EMPTY_3, EMPTY_3, EMPTY_3, EMPTY, EMPTY)
BLACK = np.zeros((360, 640, 3), np.uint8)
FOCAL = 374.7


def picture_of(position):
    """Return the picture of a ball at a position of the camera frame, by a pinhole of its own."""
    x, y, z = position
    center = (FOCAL * x / z + 320.5, FOCAL * y / z + 180.5)
    return with_ball(plain((360, 640)), center, FOCAL * 0.04 / np.linalg.norm(position))


def observation(picture, time):
    frame = Frame(picture.shape[1], picture.shape[0], lambda: picture)
    return Observation(frame, time, time + 0.01, NOTHING)


def test_paper_eyes_are_eyes():
    assert isinstance(PaperEyes(GAZEBO), Eyes)


def test_two_sights_give_position_and_velocity():
    eyes = PaperEyes(GAZEBO, whole_pixels=False)
    start, velocity = np.array([0.1, -0.1, 1.5]), np.array([0.3, 0.6, -4.0])
    assert eyes.see(observation(picture_of(start), 0.0)) is None
    estimate = eyes.see(observation(picture_of(start + velocity / 10), 0.1))
    assert estimate is not None
    assert estimate.time == 0.1
    nearer = 1.0 + 0.74 / (FOCAL * 0.04 / 1.1)  # the outline's bias makes the ball look farther
    assert estimate.position[2] == pytest.approx(1.1 * nearer, abs=0.03)
    assert np.all(np.abs(estimate.velocity - velocity) < [0.15, 0.15, 0.8])


def test_position_comes_from_the_current_frame_only():
    now = observation(picture_of([0.2, 0.1, 1.2]), 0.1)
    estimates = []
    for before in ([0.2, 0.1, 1.4], [-0.5, 0.2, 2.0]):
        eyes = PaperEyes(GAZEBO)
        eyes.see(observation(picture_of(before), 0.05))
        estimates.append(eyes.see(now))
    np.testing.assert_array_equal(estimates[0].position, estimates[1].position)
    assert not np.allclose(estimates[0].velocity, estimates[1].velocity)


def test_whole_pixels_make_the_depth_move_in_steps():
    depths = np.linspace(1.5, 1.6, 12)
    eyes = {whole: PaperEyes(GAZEBO, whole_pixels=whole) for whole in (True, False)}
    seen = {whole: [] for whole in eyes}
    for k, depth in enumerate(depths):
        for whole, these in eyes.items():
            estimate = these.see(observation(picture_of([0.0, 0.0, depth]), k / 30))
            if estimate is not None:
                distance = np.linalg.norm(estimate.position)
                seen[whole].append(FOCAL * 0.04 / distance)
    np.testing.assert_allclose(seen[True], np.round(seen[True]), atol=1e-9)
    assert np.abs(np.array(seen[False]) - np.round(seen[False])).max() > 0.05


def test_black_frames_show_nothing_and_keep_the_last_sight():
    eyes = PaperEyes(GAZEBO)
    assert all(eyes.see(observation(BLACK, t)) is None for t in (0.0, 0.03, 0.06))
    assert eyes.see(observation(picture_of([0, 0, 1.5]), 0.09)) is None
    assert eyes.see(observation(BLACK, 0.12)) is None
    assert eyes.see(observation(picture_of([0, 0, 1.4]), 0.15)) is not None


@pytest.mark.parametrize("second", [0.0, -1.0, 0.21, 5.0, float("nan"), float("inf")])
def test_no_velocity_from_equal_backward_or_distant_times(second):
    eyes = PaperEyes(GAZEBO)
    eyes.see(observation(picture_of([0, 0, 1.5]), 0.0))
    assert eyes.see(observation(picture_of([0, 0, 1.4]), second)) is None


def test_two_sights_later_all_is_well_again():
    eyes = PaperEyes(GAZEBO)
    for time in (5.0, float("nan"), 1.0):
        assert eyes.see(observation(picture_of([0, 0, 1.5]), time)) is None
    assert eyes.see(observation(picture_of([0, 0, 1.4]), 1.05)) is not None


def test_the_covariance_is_symmetric_and_covers_the_errors():
    rng = np.random.default_rng(0)
    scores = []
    for _ in range(60):
        start = rng.uniform([-0.4, -0.2, 1.0], [0.4, 0.2, 2.5])
        eyes = PaperEyes(GAZEBO)
        eyes.see(observation(picture_of(start + np.array([0.01, 0.02, 0.13])), 0.0))
        estimate = eyes.see(observation(picture_of(start), 1 / 30))
        np.testing.assert_array_equal(estimate.covariance, estimate.covariance.T)
        assert np.linalg.eigvalsh(estimate.covariance).min() > 0.0
        error = estimate.position - start
        scores.append(error @ np.linalg.solve(estimate.covariance[:3, :3], error))
    assert 0.3 < np.mean(scores) < 6.0  # 3 if the stated pixel errors were Gaussian and all


def test_the_largest_ball_is_taken():
    both = with_ball(picture_of([0.3, 0.0, 1.0]), (100.0, 100.0), 8.0)
    eyes = PaperEyes(GAZEBO)
    eyes.see(observation(both, 0.0))
    assert eyes.see(observation(both, 0.03)).position[0] > 0.2


def test_a_picture_of_another_size_is_refused():
    with pytest.raises(InputError, match="64 x 48 pixels; camera gazebo has 640 x 360"):
        PaperEyes(GAZEBO).see(observation(plain((48, 64)), 0.0))


def test_a_ball_of_another_colour_is_seen_by_eyes_that_look_for_it():
    dark = plain((360, 640), (70, 60, 50))
    shown = [with_ball(dark, (320.0, 180.0), d, WHITE) for d in (10.0, 11.0)]
    orange, white = PaperEyes(GAZEBO), PaperEyes(GAZEBO, colour="white")
    found = [
        [eyes.see(observation(picture, k / 30)) for k, picture in enumerate(shown)][-1]
        for eyes in (orange, white)
    ]
    assert found[0] is None
    assert found[1].position[2] == pytest.approx(FOCAL * 0.04 / 11.0, rel=0.1)
