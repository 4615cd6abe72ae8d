import json
import logging
import os
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image
from vision_drawing import GREY, ORANGE, WHITE, plain, with_ball

from rotorpong.conventions import InputError
from rotorpong.physics.camera import GAZEBO, Camera
from rotorpong.vision.detect import detect
from rotorpong.vision.located import StillEyes
from rotorpong.vision.marks import annotate, write_annotated
from rotorpong.vision.pictures import (
    PictureBalls,
    as_json,
    detect_pictures,
    follows,
    read_pictures,
)

BALL = with_ball(plain(), (80.3, 60.4), 20.0)
SMALL = Camera("small", 160, 120, (150.0, 150.0), (79.5, 59.5))


def write(path, picture=BALL):
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), picture)
    return path


def write_video(path, frames):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (160, 120))
    for x in frames:
        writer.write(with_ball(plain(), (x, 60.0), 20.0))
    writer.release()
    return path


def test_a_picture_file_gives_what_its_array_gives(tmp_path):
    path = write(tmp_path / "ball.png")
    (result,) = detect_pictures([path])
    assert (result.path, result.frame) == (path, 0)
    (ball,), (expected,) = result.balls, detect(BALL)
    assert (ball.x_px, ball.diameter_px, ball.score) == (
        expected.x_px,
        expected.diameter_px,
        expected.score,
    )
    assert ball.position_m is None
    assert ball.covariance_m2 is None


def test_with_a_camera_the_ball_has_a_place(tmp_path):
    (result,) = detect_pictures([write(tmp_path / "ball.png")], camera=SMALL)
    ball = result.balls[0]
    assert ball.position_m is not None
    np.testing.assert_allclose(ball.position_m, [0.0016, 0.0018, 0.3], atol=0.006)
    assert np.linalg.eigvalsh(ball.covariance_m2).min() > 0.0
    (other,) = detect_pictures([result.path], camera=SMALL, ball_diameter=0.08)
    np.testing.assert_allclose(other.balls[0].position_m, 2 * ball.position_m)


@pytest.mark.parametrize(
    ("name", "picture"),
    [
        ("grey.png", BALL[..., 2]),
        ("sixteen.png", BALL.astype(np.uint16) * 257),
        ("sixteen.tiff", BALL[..., 0].astype(np.uint16)),
        ("alpha.png", np.dstack([BALL, np.zeros_like(BALL[..., 0])])),
        ("one.png", BALL[:1, :1]),
    ],
)
def test_every_kind_of_picture_file_is_read_as_eight_bit_colour(tmp_path, name, picture):
    ((_, _, read),) = read_pictures([write(tmp_path / name, picture)])
    assert read.dtype == np.uint8
    assert read.shape == (*picture.shape[:2], 3)


def test_a_folder_gives_its_pictures_by_name_and_counts_the_rest(tmp_path, caplog):
    for name in ("b.png", "a.jpg"):
        write(tmp_path / name)
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "below").mkdir()
    (tmp_path / "c.png").write_bytes(b"damaged")
    with caplog.at_level(logging.WARNING):
        names = [path.name for path, _, _ in read_pictures([tmp_path])]
    assert names == ["a.jpg", "b.png"]
    assert "passed over 2, dropped 1 damaged" in caplog.text


def test_json_is_plain_and_has_exactly_the_stated_keys(tmp_path):
    paths = [write(tmp_path / "ball.png"), write(tmp_path / "none.png", plain())]
    data = json.loads(json.dumps(as_json(detect_pictures(paths, camera=SMALL))))
    assert list(data) == ["pictures"]
    first, second = data["pictures"]
    assert list(first) == ["path", "frame", "balls"]
    keys = ["x_px", "y_px", "diameter_px", "score", "colour", "position_m", "covariance_m2"]
    assert list(first["balls"][0]) == keys
    assert np.shape(first["balls"][0]["position_m"]) == (3,)
    assert np.shape(first["balls"][0]["covariance_m2"]) == (3, 3)
    assert second["balls"] == []
    without = as_json(detect_pictures(paths))["pictures"][0]["balls"][0]
    assert without["position_m"] is without["covariance_m2"] is None


def test_a_minimum_score_drops_the_lesser_balls(tmp_path):
    path = write(tmp_path / "two.png", with_ball(BALL, (20.0, 20.0), 3.0))
    every = next(detect_pictures([path])).balls
    assert len(every) == 2
    assert next(detect_pictures([path], min_score=0.5)).balls == every[:1]


def test_a_video_gives_every_frame_and_follows_the_ball(tmp_path):
    path = write_video(tmp_path / "flight.avi", np.linspace(30, 120, 7))
    results = list(detect_pictures([path]))
    assert [result.frame for result in results] == list(range(7))
    found = [result.balls[0].x_px for result in results]
    np.testing.assert_allclose(found, np.linspace(30, 120, 7), atol=0.7)


def test_a_video_that_breaks_off_gives_its_frames_so_far_and_then_an_error(tmp_path):
    path = write_video(tmp_path / "flight.avi", np.linspace(30, 120, 30))
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    frames = []
    with pytest.raises(InputError, match=r"breaks off after \d+ of 30 frames"):
        frames.extend(read_pictures([path]))
    assert 5 < len(frames) < 25


@pytest.mark.parametrize("suffix", ["avi", "mp4", "mkv"])
@pytest.mark.parametrize("data", [b"", b"RIFF", b"\x00\x00\x00\x18ftypmp42" + bytes(64)])
def test_a_video_without_frames_is_refused(tmp_path, suffix, data):
    path = tmp_path / f"flight.{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError, match="not a video"):
        list(read_pictures([path]))


def frames_or_complaint(path):
    try:
        return list(read_pictures([path]))
    except InputError as error:
        return str(error)


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.sampled_from([".png", ".jpg", ".bmp", ".tiff"]), st.data())
def test_damaged_picture_bytes_give_a_picture_or_one_clear_error(tmp_path, suffix, data):
    whole = cv2.imencode(suffix, BALL[40:80, 60:100])[1].tobytes()
    at = data.draw(st.integers(0, len(whole)))
    path = tmp_path / f"damaged{suffix}"
    path.write_bytes(whole[:at] + data.draw(st.binary(max_size=12)))
    result = frames_or_complaint(path)
    if isinstance(result, str):
        assert str(path) in result
    else:
        assert result[0][2].dtype == np.uint8


def test_paths_that_lead_nowhere_are_refused(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "notes.txt").write_text("hello")
    for paths, says in (
        ([], "no path"),
        ([tmp_path / "gone.png"], "no such file"),
        (["http://127.0.0.1/x.avi"], "no such file"),
        ([tmp_path / "empty"], "holds no readable"),
        ([tmp_path], "2 other entries"),
        ([tmp_path / "notes.txt"], "not a picture"),
    ):
        with pytest.raises(InputError, match=says):
            list(read_pictures(paths))


def test_wrong_sizes_scores_colours_and_diameters_are_refused(tmp_path):
    path = write(tmp_path / "ball.png")
    for options, says in (
        ({"camera": GAZEBO}, "160 x 120 pixels; camera gazebo"),
        ({"min_score": 1.5}, "minimum score"),
        ({"min_score": float("nan")}, "minimum score"),
        ({"colours": ("mauve",)}, "available: orange, white"),
        ({"camera": SMALL, "ball_diameter": 40.0}, "ball diameter"),
    ):
        with pytest.raises(InputError, match=says):
            list(detect_pictures([path], **options))


def test_marks_surround_the_ball_and_leave_the_picture_alone(tmp_path):
    before = BALL.copy()
    result = next(detect_pictures([write(tmp_path / "ball.png")]))
    marked = annotate(result.picture, result.balls)
    changed = np.argwhere(np.any(marked != BALL, axis=2))
    np.testing.assert_array_equal(BALL, before)
    assert changed[:, 1].min() == pytest.approx(80 - 11, abs=1.5)
    path = write_annotated(result, tmp_path / "out", index=3)
    assert path.name == "00003-ball.png"
    np.testing.assert_array_equal(cv2.imread(str(path)), marked)


def test_a_folder_that_cannot_be_written_is_one_clear_error(tmp_path):
    result = next(detect_pictures([write(tmp_path / "ball.png")]))
    with pytest.raises(InputError, match="cannot be made"):
        write_annotated(result, tmp_path / "ball.png", index=0)


@pytest.mark.parametrize("shape", [(1, 1), (1, 60), (60, 1), (2, 2), (3, 200)])
@pytest.mark.parametrize("fine", [False, True])
def test_the_smallest_pictures_show_nothing_and_break_nothing(shape, fine):
    eyes = StillEyes(colours=("orange", "white"), fine=fine)
    for levels in (ORANGE, WHITE, GREY):
        assert eyes.look(plain(shape, levels)) == ()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 40), st.integers(1, 60), st.booleans())
def test_noise_of_any_size_gives_only_whole_numbers_and_poor_scores(seed, height, width, fine):
    picture = np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)
    for ball in StillEyes(colours=("orange", "white"), fine=fine).look(picture):
        numbers = (ball.x_px, ball.y_px, ball.diameter_px, ball.score)
        assert np.isfinite(numbers).all()
        assert 0.0 <= ball.x_px <= width - 1
        assert 0.0 <= ball.y_px <= height - 1
        assert ball.score < 0.6


def pillow(picture):
    return Image.fromarray(picture[..., ::-1].copy())


def test_cmyk_grey_palette_and_turned_pictures_are_read_as_they_are_shown(tmp_path):
    image, exif = pillow(BALL), Image.Exif()
    exif[274] = 6  # turned by a quarter
    image.convert("CMYK").save(tmp_path / "cmyk.jpg", quality=95)
    image.save(tmp_path / "progressive.jpg", progressive=True, quality=95)
    image.quantize(64).save(tmp_path / "palette.png")
    image.save(tmp_path / "turned.jpg", exif=exif, quality=95)
    for name, place in (
        ("cmyk.jpg", (80.3, 60.4)),
        ("progressive.jpg", (80.3, 60.4)),
        ("palette.png", (80.3, 60.4)),
        ("turned.jpg", (119 - 60.4, 80.3)),
    ):
        (ball, *_) = next(detect_pictures([tmp_path / name])).balls
        assert (ball.x_px, ball.y_px) == pytest.approx(place, abs=0.6), name


def test_floating_point_pictures_are_refused_not_guessed(tmp_path):
    cv2.imwrite(str(tmp_path / "float.tiff"), BALL.astype(np.float32) / 255.0)
    with pytest.raises(InputError, match="not a picture that OpenCV can decode"):
        list(read_pictures([tmp_path / "float.tiff"]))


def test_an_animation_is_a_video_and_other_pages_are_told(tmp_path, caplog):
    frames = [pillow(with_ball(plain(), (40.0 + 10 * k, 60.0), 20.0)) for k in range(5)]
    for name in ("a.gif", "a.webp", "a.tiff", "a.png"):
        frames[0].save(tmp_path / name, save_all=True, append_images=frames[1:], duration=40)
    results = list(detect_pictures([tmp_path / "a.gif"]))
    assert [result.frame for result in results] == list(range(5))
    found = [result.balls[0].x_px for result in results]
    np.testing.assert_allclose(found, 40.0 + 10.0 * np.arange(5), atol=0.7)
    assert caplog.text == ""
    for name in ("a.webp", "a.tiff", "a.png"):
        caplog.clear()
        assert len(list(read_pictures([tmp_path / name]))) == 1
        assert f"{name}: holds 5 pictures; only the first is looked at" in caplog.text


def test_what_is_no_file_is_refused_by_what_it_is(tmp_path):
    (tmp_path / "folder.jpg").mkdir()
    (tmp_path / "loop.png").symlink_to(tmp_path / "loop.png")
    (tmp_path / "zero.jpg").touch()
    os.mkfifo(tmp_path / "pipe.png")
    for name, says in (
        ("folder.jpg", "holds no readable picture"),
        ("loop.png", "cannot be read"),
        ("pipe.png", "neither a file nor a folder"),
        ("zero.jpg", "not a picture that OpenCV can decode"),
        ("zero.jpg/below.png", "no such file"),
        (300 * "x" + ".png", "cannot be read"),
    ):
        with pytest.raises(InputError, match=says):
            list(read_pictures([tmp_path / name]))


@pytest.mark.parametrize("name", ["new\nline", "päß 球", "%d", "a;b", "-x"])
def test_names_may_be_anything_that_is_text(tmp_path, name):
    path = write(tmp_path / f"{name}.png")
    assert [found.path for found in detect_pictures([path])] == [path]
    video = write_video(tmp_path / f"{name}.avi", [40.0, 50.0])
    assert len(list(read_pictures([video]))) == 2


def test_a_name_that_is_no_text_is_read_as_a_picture_and_refused_as_a_video(tmp_path):
    picture = tmp_path / os.fsdecode(b"b\xff.png")
    picture.write_bytes(write(tmp_path / "a.png").read_bytes())
    assert len(list(read_pictures([picture]))) == 1
    video = tmp_path / os.fsdecode(b"b\xff.avi")
    video.write_bytes(write_video(tmp_path / "a.avi", [40.0, 50.0]).read_bytes())
    with pytest.raises(InputError, match="OpenCV needs names in UTF-8"):
        list(read_pictures([video]))


@pytest.fixture(scope="module")
def videos(tmp_path_factory):
    """Whole videos in several containers, as bytes."""
    folder, whole = tmp_path_factory.mktemp("videos"), {}
    for suffix, code in ((".avi", "MJPG"), (".mp4", "mp4v"), (".mkv", "mp4v")):
        path = folder / f"whole{suffix}"
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 30.0, (64, 48))
        for k in range(10):
            writer.write(with_ball(plain((48, 64)), (12.0 + 4 * k, 24.0), 12.0))
        writer.release()
        whole[suffix] = path.read_bytes()
    return whole


@settings(
    max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.data())
def test_damaged_video_bytes_give_frames_and_then_at_most_one_clear_error(tmp_path, videos, data):
    suffix = data.draw(st.sampled_from(sorted(videos)))
    garbled = bytearray(videos[suffix])
    for at in data.draw(st.lists(st.integers(0, len(garbled) - 1), max_size=20)):
        garbled[at] = data.draw(st.integers(0, 255))
    path = tmp_path / f"garbled{suffix}"
    path.write_bytes(garbled[: data.draw(st.integers(0, len(garbled)))])
    result = frames_or_complaint(path)
    if isinstance(result, str):
        assert str(path) in result
    else:
        assert all(picture.dtype == np.uint8 for _, _, picture in result)


@pytest.mark.parametrize(
    ("one", "two", "follow"),
    [
        ("a_08.png", "a_09.png", True),
        ("a_09.png", "a_10.png", True),
        ("7.png", "8.png", True),
        ("a1.png", "a3.png", False),
        ("a2.png", "a1.png", False),
        ("a1.png", "b2.png", False),
        ("a1.png", "a2.jpg", False),
        ("a.png", "b.png", False),
        ("a1.mp4", "a2.mp4", False),
        ("a1.png", "a2.mp4", False),
        ("a" + 30 * "9" + ".png", "a1" + 30 * "0" + ".png", False),
    ],
)
def test_what_follows_is_numbered_one_higher(tmp_path, one, two, follow):
    first, second = (PictureBalls(tmp_path / name, 0, (), BALL) for name in (one, two))
    assert follows(first, second) is follow
    assert not follows(first, replace(second, picture=BALL[:50]))
