"""What `detect` takes and refuses, and that its answer is plain JSON."""

import json

import cv2
import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.detect import Search, detect_all
from rotorpong.physics.camera import GAZEBO

BALL_KEYS = {"x_px", "y_px", "diameter_px", "score", "colour", "position_m", "covariance_m2"}


def scene(shift=0):
    """A grey picture with one orange ball of 24 px at (300 + shift, 180)."""
    picture = np.full((360, 640, 3), 120, np.uint8)
    cv2.circle(picture, (300 + shift, 180), 12, (0, 120, 255), -1, cv2.LINE_AA)
    return picture


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "ball.png"
    cv2.imwrite(str(path), scene())
    return path


def found(*paths, out=None, progress=lambda done, total: None, **search):
    return detect_all(paths, Search(**search), out, progress)


def test_a_ball_is_found_and_the_answer_is_json(picture):
    told = []
    answer = found(picture, progress=lambda *done: told.append(done))
    assert json.loads(json.dumps(answer, allow_nan=False)) == answer
    assert list(answer) == ["pictures"]
    (entry,) = answer["pictures"]
    assert set(entry) == {"path", "frame", "balls"}
    assert (entry["path"], entry["frame"]) == (str(picture), 0)
    (ball,) = entry["balls"]
    assert set(ball) == BALL_KEYS
    assert (ball["x_px"], ball["y_px"]) == pytest.approx((300.0, 180.0), abs=0.5)
    assert ball["diameter_px"] == pytest.approx(24.0, abs=2.0)
    assert ball["position_m"] is ball["covariance_m2"] is None
    assert told == [(1, 1)]


def test_a_camera_adds_metres_that_grow_with_the_real_ball(picture):
    small, large = (
        found(picture, camera="gazebo", ball_diameter=size)["pictures"][0]["balls"][0]
        for size in (0.04, 0.08)
    )
    np.testing.assert_allclose(large["position_m"], 2.0 * np.array(small["position_m"]))
    depth = GAZEBO.focal_length_px[0] * 0.04 / small["diameter_px"]
    assert small["position_m"][2] == pytest.approx(depth, rel=0.01)
    covariance = np.array(small["covariance_m2"])
    assert np.all(np.linalg.eigvalsh(covariance) > 0.0)


def test_annotated_pictures_are_written_one_for_each(picture, tmp_path):
    out = tmp_path / "new" / "marked"
    found(picture, picture, out=out)
    assert [path.name for path in sorted(out.iterdir())] == ["00000-ball.png", "00001-ball.png"]
    marked = cv2.imread(str(out / "00000-ball.png"))
    assert marked.shape == scene().shape
    assert np.any(marked != scene())


@pytest.mark.parametrize(
    ("search", "said"),
    [
        ({"eyes": "truth"}, "unknown eyes 'truth': expected one of paper, tracker"),
        ({"colours": ("pink",)}, "unknown colour 'pink': expected one of orange, white"),
        ({"colours": ("orange", "")}, "unknown colour ''"),
        ({"camera": "nikon"}, "camera 'nikon': expected one of gazebo, ardrone2_360p"),
        ({"camera": "ardrone2_720p"}, "calibrated for 1280 x 720"),
        ({"min_score": 1.5}, "minimum score 1.5; expected 0 to 1"),
        ({"min_score": float("nan")}, "minimum score nan"),
        ({"ball_diameter": 0.0}, "ball diameter 0 mm: expected above 0 and below 1000 mm"),
        ({"ball_diameter": -0.04}, "ball diameter -40 mm"),
        ({"ball_diameter": 40.0}, "ball diameter 40000 mm"),
        ({"ball_diameter": float("nan")}, "ball diameter nan mm"),
        ({"ball_diameter": float("inf")}, "ball diameter inf mm"),
    ],
)
def test_a_search_for_nonsense_is_refused_with_and_without_a_camera(picture, search, said):
    with pytest.raises(InputError) as refusal:
        found(picture, **search)
    assert said in str(refusal.value)


def test_nothing_to_look_at_is_refused(tmp_path):
    with pytest.raises(InputError, match="no path given"):
        found()
    with pytest.raises(InputError, match="no such file or folder"):
        found(tmp_path / "gone.png")
    with pytest.raises(InputError, match="holds no readable picture or video: 0 other"):
        found(tmp_path)


def test_a_file_is_no_folder_for_annotated_pictures(picture):
    with pytest.raises(InputError, match="is a file: expected a folder"):
        found(picture, out=picture)
    with pytest.raises(InputError, match="cannot be made"):
        found(picture, out=picture / "below")


def video(path, code):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), 30, (640, 360))
    for frame in range(20):
        writer.write(scene(4 * frame))
    writer.release()
    return path


@pytest.mark.parametrize("name", ["truncated.png", "zero.png", "text.png"])
def test_damaged_files_are_one_clear_error_and_no_chatter(tmp_path, picture, name, capfd):
    whole = picture.read_bytes()
    contents = {"truncated": whole[: len(whole) // 2], "zero": b"", "text": b"hello"}
    damaged = tmp_path / name
    damaged.write_bytes(contents[name[:-4]])
    capfd.readouterr()
    with pytest.raises(InputError, match=f"{name}: not a .*, or damaged"):
        found(damaged)
    assert capfd.readouterr() == ("", "")


def test_a_folder_of_damaged_pictures_is_one_error_and_nothing_in_the_log(tmp_path, caplog):
    (tmp_path / "damaged.png").write_bytes(b"nothing")
    (tmp_path / "notes.txt").write_text("notes")
    with pytest.raises(InputError, match="1 other entries, 1 damaged"):
        found(tmp_path)
    assert caplog.text == ""


def test_every_frame_of_a_video_is_looked_at_in_order(tmp_path):
    answer = found(video(tmp_path / "ball.avi", "MJPG"))
    assert [entry["frame"] for entry in answer["pictures"]] == list(range(20))
    x = [entry["balls"][0]["x_px"] for entry in answer["pictures"]]
    np.testing.assert_allclose(x, 300.0 + 4.0 * np.arange(20), atol=1.0)


def test_a_colour_asked_for_twice_is_found_once(picture):
    once, twice = (found(picture, colours=c) for c in (("orange",), ("orange", "orange")))
    assert once == twice
