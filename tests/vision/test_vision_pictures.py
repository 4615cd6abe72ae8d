import json
import logging

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from vision_drawing import plain, with_ball

from rotorpong.conventions import InputError
from rotorpong.physics.camera import GAZEBO, Camera
from rotorpong.vision.detect import detect
from rotorpong.vision.marks import annotate, write_annotated
from rotorpong.vision.pictures import as_json, detect_pictures, read_pictures

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
