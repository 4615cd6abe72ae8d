import cv2
import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, Frame, Navdata, Observation
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.tracking import tracker_eyes
from rotorpong.lab.trial import Stage, new_drone
from rotorpong.physics.camera import ARDRONE2_360P, GAZEBO

PERIOD = 1.0 / 30.0
PLANE = 2.5  # m


def stage_of(camera="gazebo", vehicle="tum_gazebo", serves="human"):
    spec = Spec("hover", camera=camera, vehicle=vehicle, serves=serves)
    return Stage(spec, spec.setting(), serve_source(serves, 0), "evaluate")


def watch(stage, index, *, change=None, keep=None):
    """Return (estimate, true position, true velocity) of each answer, and the eyes.

    `change` alters a picture, `keep` tells which frames arrive.
    """
    drone, answers, number = new_drone(stage, index), [], 0
    eyes = tracker_eyes(drone.camera, stage.spec.vehicle_name, stage.spec.serves)
    while (seen := drone.observe()) is not None:
        number += 1
        drone.command(HOVER)
        if keep is not None and not keep(number):
            continue
        if change is not None:
            picture = change(seen.frame.picture.copy())
            frame = Frame(seen.frame.width, seen.frame.height, lambda p=picture: p)
            seen = Observation(frame, seen.frame_time, seen.arrival_time, seen.navdata)
        estimate = eyes.see(seen)
        if estimate is not None:
            answers.append((estimate, *drone.ball_in_camera(estimate.time)))
    return answers, eyes


def at_plane(answers):
    return next(a for a in answers if a[1][2] < PLANE)


@pytest.mark.parametrize(
    ("camera", "vehicle", "position_cm", "velocity_cm_s"),
    [
        ("gazebo", "tum_gazebo", (0.3, 0.8, 4.0), (12.0, 25.0, 60.0)),
        ("ardrone2_720p", "ardrone2", (0.2, 0.5, 3.0), (8.0, 8.0, 30.0)),
    ],
)
def test_the_ball_at_the_plane_is_known_to_centimetres(camera, vehicle, position_cm, velocity_cm_s):
    """Means of 8 serves; the bounds are twice what is measured over 30."""
    stage = stage_of(camera, vehicle)
    errors = []
    for index in range(8):
        estimate, position, velocity = at_plane(watch(stage, index)[0])
        errors.append(np.abs([estimate.position - position, estimate.velocity - velocity]))
    mean = 100.0 * np.mean(errors, axis=0)
    assert np.all(mean[0] < position_cm)
    assert np.all(mean[1] < velocity_cm_s)


def test_a_ball_is_followed_through_its_bounce():
    answers, eyes = watch(stage_of(), 1)
    times = [estimate.time for estimate, _, _ in answers]
    assert len(answers) > 15
    assert max(np.diff(times)) < 4 * PERIOD
    last, position, velocity = answers[-1]
    assert velocity @ np.array([0.0, -1.0, 0.0]) > 0.0  # it rises again
    assert last.position == pytest.approx(position, abs=0.05)
    assert np.linalg.eigvalsh(last.covariance).min() > 0.0
    assert eyes.belief is not None


def test_lost_frames_are_bridged():
    rng = np.random.default_rng(0)
    answers, _ = watch(stage_of(), 2, keep=lambda number: rng.uniform() > 0.4)
    estimate, position, _ = at_plane(answers)
    assert estimate.position == pytest.approx(position, abs=0.15)


def test_a_ball_that_hangs_in_the_air_is_not_taken_for_the_one_that_flies():
    def hang(picture):
        cv2.circle(picture, (120, 90), 9, (30, 120, 240), -1, cv2.LINE_AA)
        return picture

    answers, _ = watch(stage_of(), 3, change=hang)
    estimate, position, _ = at_plane(answers)
    assert estimate.position == pytest.approx(position, abs=0.10)


def still(picture, frames=30, camera=GAZEBO):
    """Return how often eyes answer before the same picture again and again, drone at rest."""
    eyes, told = tracker_eyes(camera, "tum_gazebo", "human"), []
    for k in range(frames):
        times = k * PERIOD + 0.005 * np.arange(1, 7)
        zero = np.zeros((6, 3))
        navdata = Navdata(times, zero, zero, zero, zero, np.full(6, 0.95), np.ones(6))
        frame = Frame(camera.width_px, camera.height_px, lambda: picture)
        seen = Observation(frame, (k + 1) * PERIOD, (k + 1) * PERIOD, navdata)
        told.append(eyes.see(seen) is not None)
    return told


def test_a_thing_that_stands_still_is_forgotten():
    """Two sights make an answer; a third or fourth shows that it does not fall."""
    picture = np.full((360, 640, 3), 90, np.uint8)
    cv2.circle(picture, (320, 150), 8, (30, 120, 240), -1, cv2.LINE_AA)
    told = still(picture)
    assert sum(told) <= len(told) / 2


@pytest.mark.parametrize("level", [0, 127, 255])
def test_nothing_is_seen_in_an_even_picture(level):
    assert not any(still(np.full((360, 640, 3), level, np.uint8), frames=5))


def test_noise_is_no_ball():
    noise = np.random.default_rng(0).integers(0, 256, (360, 640, 3), dtype=np.uint8)
    assert not any(still(noise, frames=5))


def test_a_frame_of_another_size_is_refused():
    eyes = tracker_eyes(GAZEBO, "tum_gazebo", "human")
    empty = Navdata(np.empty(0), *(np.empty((0, 3)) for _ in range(4)), np.empty(0), np.empty(0))
    frame = Frame(320, 240, lambda: np.zeros((240, 320, 3), np.uint8))
    with pytest.raises(InputError, match="320 x 240"):
        eyes.see(Observation(frame, 0.1, 0.1, empty))


def test_the_same_serve_is_seen_the_same_twice():
    first, second = (watch(stage_of(), 4)[0] for _ in range(2))
    assert len(first) == len(second)
    for (a, _, _), (b, _, _) in zip(first, second, strict=True):
        assert np.array_equal(a.position, b.position)
        assert np.array_equal(a.covariance, b.covariance)


def test_a_rolling_shutter_camera_with_a_lens_is_undone():
    answers, _ = watch(stage_of("ardrone2_360p", "ardrone2"), 5)
    estimate, position, _ = at_plane(answers)
    assert ARDRONE2_360P.readout_s > 0.0
    assert estimate.position == pytest.approx(position, abs=0.10)
