"""A real camera's frame is the ideal one, moved, blurred, lit and noisy as its equations say."""

from dataclasses import fields, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from rotorpong.conventions import InputError
from rotorpong.physics.camera import (
    ARDRONE2_360P,
    GAZEBO,
    camera_from_body,
    ideal,
    row_time,
)
from rotorpong.world.exposure import Motion, expose
from rotorpong.world.render import Scene, render

GOLDEN = Path(__file__).parent / "golden"
LENS = ideal(ARDRONE2_360P)
SMALL = replace(
    ARDRONE2_360P,
    name="small",
    width_px=192,
    height_px=108,
    focal_length_px=(168.6, 168.5),
    center_px=(92.2, 57.0),
)
STEP, COUNT = 0.001, 41
TIMES = (np.arange(COUNT) - COUNT // 2) * STEP
NOWHERE = np.array([-4.0, 0.0, 2.0])  # behind the camera
FLAT = Scene(opponent=False, texture_contrast=0.0)
DIM = Scene(brightness=0.7)  # nothing saturates


def turning(rates=(0.3, -0.8, 0.6), speed=(0.4, 0.1, -0.2)):
    """Body rotations and positions at TIMES."""
    turns = Rotation.from_rotvec(TIMES[:, None] * np.array(rates))
    return turns, np.array([-1.9, 0.0, 0.19]) + TIMES[:, None] * np.array(speed)


def motion(camera, *, ball=(-0.9, 0.1, 0.3), velocity=(-7.0, 0.6, -1.0), still=False):
    turns, places = turning() if not still else turning((0, 0, 0), (0, 0, 0))
    axes = turns.as_matrix() @ camera_from_body(camera).T
    eyes = places + turns.apply(np.array(camera.position_m))
    balls = np.array(ball) + TIMES[:, None] * np.array(velocity)
    return Motion(TIMES[0], STEP, eyes, axes, balls)


def at(camera, time, *, ball=(-0.9, 0.1, 0.3), velocity=(-7.0, 0.6, -1.0)):
    """Eye, axes and ball at one time, interpolated along the great circle."""
    turns, places = turning()
    turn = Slerp(TIMES, turns)(time)
    place = [np.interp(time, TIMES, places[:, k]) for k in range(3)]
    eye = place + turn.apply(np.array(camera.position_m))
    axes = np.ascontiguousarray(turn.as_matrix() @ camera_from_body(camera).T)
    return eye, axes, np.array(ball) + time * np.array(velocity)


def middle(moving):
    k = COUNT // 2
    return moving.positions[k], np.ascontiguousarray(moving.rotations[k]), moving.balls[k]


@pytest.mark.parametrize("camera", [GAZEBO, LENS], ids=lambda camera: camera.name)
def test_an_ideal_sensor_gives_the_sharp_picture(camera):
    moving = motion(camera)
    frame = expose(camera, moving, 0.0, Scene(), key=(0,)).astype(int)
    sharp = render(camera, *middle(moving), Scene()).astype(int)
    assert np.abs(frame - sharp).max() <= 1  # a sixteenth of a level is rounded first
    assert np.abs(frame - sharp).mean() < 0.05


def test_each_row_shows_the_world_at_its_own_time():
    camera = replace(LENS, readout_s=0.030)
    frame = expose(camera, motion(camera), 0.002, Scene(), key=(0,)).astype(int)
    frozen = render(camera, *middle(motion(camera)), Scene()).astype(int)
    errors, effects = [], []
    for row in range(0, camera.height_px, 9):
        time = row_time(camera, 0.002, np.array(float(row)))
        line = (0, row, camera.width_px, row + 1)
        reference = render(camera, *at(camera, float(time)), Scene(), region=line).astype(int)
        errors.append(np.abs(frame[row] - reference[0]))
        effects.append(np.abs(frozen[row] - reference[0]))
    assert np.mean(errors) < 0.06
    assert np.quantile(errors, 0.999) <= 2
    assert np.mean(effects) > 10 * np.mean(errors)


def test_the_middle_of_the_picture_is_exposed_at_the_frame_time():
    rows = np.arange(SMALL.height_px, dtype=float)
    times = row_time(SMALL, 0.5, rows)
    assert np.mean(times) == pytest.approx(0.5, abs=1e-12)
    assert np.diff(times) == pytest.approx(SMALL.readout_s / SMALL.height_px)


def test_a_moving_ball_is_the_average_of_many_sharp_ones():
    """Before black, where rounding to levels moves no centre."""
    camera, velocity = replace(LENS, exposure_s=0.008), np.array([-3.0, 2.5, -1.0])
    moving = motion(camera, velocity=tuple(velocity), still=True)
    eye, axes, ball = middle(moving)
    x0, y0, x1, y1 = box = (240, 80, 480, 240)
    black = {
        field.name: (0.0, 0.0, 0.0) for field in fields(Scene) if isinstance(field.default, tuple)
    }
    scene = Scene(**black | {"ball": (250.0, 250.0, 250.0)}, opponent=False)
    instants = (np.arange(128) + 0.5) / 128 * 0.008 - 0.004
    sharp = [render(camera, eye, axes, ball + t * velocity, scene, region=box) for t in instants]
    reference = np.mean(sharp, axis=0)[..., 0]
    frame = expose(camera, moving, 0.0, scene, key=(0,)).astype(float)[y0:y1, x0:x1, 0]
    streak = reference > 0.5
    assert 250 < streak.sum() < 5000
    assert np.abs(frame - reference)[streak].mean() < 3.0  # eight instants show as steps
    places = np.mgrid[y0:y1, x0:x1]
    centers = [
        [(axis * light).sum() / light.sum() for axis in places] for light in (frame, reference)
    ]
    assert np.abs(np.subtract(*centers)).max() < 0.02
    assert frame.sum() / reference.sum() == pytest.approx(1.0, abs=0.005)


def test_the_lens_blurs_as_opencv_does():
    camera = replace(LENS, blur_px=0.7)
    moving = motion(camera, still=True)
    frame = expose(camera, moving, 0.0, DIM, key=(0,)).astype(float)
    sharp = expose(LENS, moving, 0.0, DIM, key=(0,)).astype(np.float32)
    side = np.exp(-0.5 / 0.7**2)
    taps = np.array([side, 1.0, side]) / (1.0 + 2.0 * side)
    reference = cv2.sepFilter2D(sharp, -1, taps, taps, borderType=cv2.BORDER_REPLICATE)
    assert np.abs(frame - reference).max() < 1.3  # both are rounded
    assert np.abs(frame - reference).mean() < 0.35


def test_the_response_turns_twice_the_light_into_two_to_the_inverse_gamma():
    camera = replace(LENS, gamma=2.2)
    moving = motion(camera, still=True)
    bright, dim = (
        expose(camera, moving, 0.0, replace(FLAT, brightness=light), key=(0,)).astype(float)
        for light in (0.8, 0.4)
    )
    clear = (bright > 60.0) & (bright < 250.0)
    ratio = bright[clear] / dim[clear]
    assert ratio.mean() == pytest.approx(2.0 ** (1 / 2.2), abs=0.004)
    assert ratio.std() < 0.02


def test_the_noise_is_that_of_photons_and_electronics_within_five_sigma():
    camera = replace(LENS, shot_noise=0.2, read_noise=1.5)
    moving = motion(camera, ball=tuple(NOWHERE), velocity=(0, 0, 0), still=True)
    clean = expose(LENS, moving, 0.0, FLAT, key=(0,)).astype(float)
    frames = [expose(camera, moving, 0.0, FLAT, key=(7, k)).astype(float) for k in range(24)]
    excess = np.array(frames) - clean
    for low, high in ((20, 60), (90, 130), (150, 190)):
        there = (clean > low) & (clean < high)
        samples = excess[:, there]
        model = 1.5**2 + 0.2 * clean[there].mean() + 2 / 12  # both pictures are rounded
        n = samples.size
        assert n > 50_000
        assert abs(samples.var() / model - 1.0) < 5 * np.sqrt(2 / n) + 0.01
        assert abs(samples.mean()) < 5 * np.sqrt(model / n) + 0.05


def test_the_noise_of_neighbours_of_colours_and_of_frames_is_unrelated_within_five_sigma():
    camera = replace(LENS, read_noise=4.0)
    moving = motion(camera, still=True)
    dim = replace(FLAT, brightness=0.6)
    clean = expose(LENS, moving, 0.0, dim, key=(0,)).astype(float)
    one, two = (expose(camera, moving, 0.0, dim, key=(3, k)).astype(float) - clean for k in (0, 1))
    pairs = {
        "right": (one[:, 1:], one[:, :-1]),
        "down": (one[1:], one[:-1]),
        "colours": (one[..., 0], one[..., 1]),
        "frames": (one, two),
    }
    for name, (a, b) in pairs.items():
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 5 / np.sqrt(a.size), name


@pytest.mark.parametrize("camera", [ARDRONE2_360P, SMALL], ids=lambda camera: camera.name)
def test_a_region_has_the_pixels_of_the_whole_frame(camera):
    rng, moving = np.random.default_rng(4), motion(camera)
    whole = expose(camera, moving, 0.0, Scene(), key=(1, 2))
    width, height = camera.width_px, camera.height_px
    boxes = [(0, 0, 1, 1), (width - 1, height - 1, width, height), (0, height - 1, width, height)]
    for _ in range(15):
        x0, x1 = np.sort(rng.choice(width + 1, 2, replace=False)).tolist()
        y0, y1 = np.sort(rng.choice(height + 1, 2, replace=False)).tolist()
        boxes.append((x0, y0, x1, y1))
    for x0, y0, x1, y1 in boxes:
        part = expose(camera, moving, 0.0, Scene(), key=(1, 2), region=(x0, y0, x1, y1))
        np.testing.assert_array_equal(part, whole[y0:y1, x0:x1])


def test_the_same_key_gives_the_same_frame_and_another_other_noise():
    moving = motion(SMALL)
    first, again, other = (
        expose(SMALL, moving, 0.0, Scene(), key=key) for key in ((1, 2), (1, 2), (1, 3))
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).mean() > 0.5


GOLDEN_FRAMES = {
    "gazebo": (replace(ideal(SMALL), distortion=(0.0,) * 5), Scene()),
    "ardrone2": (SMALL, Scene()),
    "white_ball": (SMALL, Scene(ball=(238.0, 242.0, 245.0), brightness=0.8, opponent=False)),
}


@pytest.mark.parametrize("name", GOLDEN_FRAMES)
def test_frames_are_those_on_file_to_a_level_or_two(name):
    """Other processors may round the last bit of a sine or of a root otherwise."""
    camera, scene = GOLDEN_FRAMES[name]
    frame = expose(camera, motion(camera), 0.0, scene, key=(5, 6)).astype(int)
    golden = cv2.imread(str(GOLDEN / f"{name}.png")).astype(int)
    assert np.abs(frame - golden).mean() < 0.02
    assert np.quantile(np.abs(frame - golden), 0.9999) <= 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": np.full((COUNT, 3), np.nan)}, "camera position"),
        ({"balls": np.full((COUNT, 3), np.inf)}, "ball position"),
        ({"rotations": np.full((COUNT, 3, 3), 1.0)}, "no rotation"),
        ({"step": 0.0}, "in time's order"),
        ({"start": np.nan}, "expected finite"),
    ],
)
def test_a_motion_that_is_none_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        expose(SMALL, replace(motion(SMALL), **change), 0.0, Scene(), key=(0,))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gamma": 0.0}, "gamma"),
        ({"width_px": 0}, "0 x 108"),
        ({"exposure_s": np.nan}, "exposure_s"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        expose(replace(SMALL, **change), motion(SMALL), 0.0, Scene(), key=(0,))
