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


def flight(path, shifts, code="mp4v", size=(640, 360), rate=30.0):
    """A film of a ball at (300 + shift, 180), one frame for each shift."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), rate, size)
    for shift in shifts:
        writer.write(cv2.resize(scene(shift), size))
    writer.release()
    return path


def frames_of(path):
    capture, frames = cv2.VideoCapture(str(path)), []
    while (got := capture.read())[0]:
        frames.append(got[1])
    return frames, capture.get(cv2.CAP_PROP_FPS)


def test_the_tracker_measures_and_numbers_the_ball_of_a_video(tmp_path):
    answer = found(flight(tmp_path / "ball.mkv", range(0, 100, 5), "FFV1"), eyes="tracker")
    assert json.loads(json.dumps(answer, allow_nan=False)) == answer
    balls = [entry["balls"] for entry in answer["pictures"]]
    assert [len(these) for these in balls] == [1] * 20
    assert {ball["track"] for (ball,) in balls} == {1}
    assert set(balls[0][0]) == BALL_KEYS | {"track"}
    x = [ball["x_px"] for (ball,) in balls]
    np.testing.assert_allclose(x, 300.0 + 5.0 * np.arange(20), atol=0.05)


def test_the_tracker_places_a_still_ball_to_a_millimetre(tmp_path):
    """Eight times as large, then averaged: covered as exactly as its area was drawn."""
    big = np.full((360 * 8, 640 * 8, 3), 120, np.uint8)
    cv2.circle(big, (2560, 1440), 98, (0, 120, 255), -1)
    radius = np.sqrt(np.sum(big[..., 2] == 255) / np.pi) / 8
    shown = cv2.resize(big, (640, 360), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(tmp_path / "ball.png"), shown)
    answer = found(tmp_path / "ball.png", eyes="tracker", camera="gazebo")
    (ball,) = answer["pictures"][0]["balls"]
    distance = 0.02 / np.sin(np.arctan(radius / 374.7))  # of a sphere on the axis
    assert np.linalg.norm(ball["position_m"]) == pytest.approx(distance, abs=0.001)
    assert np.sqrt(ball["covariance_m2"][2][2]) < 0.02


def test_pictures_numbered_one_after_the_other_are_a_sequence_and_others_are_not(tmp_path):
    for folder, names in (
        ("frames", [f"frame_{k:04d}.png" for k in range(8, 13)]),
        ("album", ["a.png", "b.png", "c.png", "d.png", "e.png"]),
        ("holes", [f"frame_{k}.png" for k in (1, 3, 5, 7, 9)]),
    ):
        (tmp_path / folder).mkdir()
        for k, name in enumerate(names):
            cv2.imwrite(str(tmp_path / folder / name), scene(4 * k))
    tracks = {
        folder: [
            p["balls"][0]["track"] for p in found(tmp_path / folder, eyes="tracker")["pictures"]
        ]
        for folder in ("frames", "album", "holes")
    }
    assert tracks == {"frames": [1] * 5, "album": [None] * 5, "holes": [None] * 5}


def test_every_video_has_tracks_of_its_own(tmp_path):
    paths = [flight(tmp_path / f"{k}.mp4", range(0, 40, 5)) for k in range(2)]
    answer = found(*paths, eyes="tracker")
    tracks = [entry["balls"][0]["track"] for entry in answer["pictures"]]
    assert tracks == [1] * 8 + [2] * 8


def test_a_film_shows_where_the_ball_is_and_where_it_came_from(tmp_path):
    source = flight(tmp_path / "ball.mp4", range(0, 100, 5), rate=25.0)
    out = tmp_path / "marked.mp4"
    plain = found(source, eyes="tracker")
    assert found(source, eyes="tracker", out=out) == plain
    (before, _), (after, rate) = frames_of(source), frames_of(out)
    assert len(after) == len(before) == 20
    assert rate == 25.0
    assert after[0].shape == before[0].shape

    def magenta(frame, x, y):
        blue, green, red = frame[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3).mean(axis=0)
        return min(blue, red) - green > 60

    assert magenta(after[19], 395 - 13, 180)  # the circle
    assert magenta(after[19], 340, 180)  # the trail
    assert not magenta(before[19], 340, 180)


def test_a_folder_takes_films_of_videos_and_pictures_of_pictures(tmp_path, picture):
    source = flight(tmp_path / "ball.mp4", range(0, 30, 5))
    found(picture, source, picture, eyes="tracker", out=tmp_path / "out")
    names = ["00000-ball.png", "00001-ball.mp4", "00007-ball.png"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == names
    assert len(frames_of(tmp_path / "out" / "00001-ball.mp4")[0]) == 6


@pytest.mark.parametrize("size", [(161, 91), (320, 240), (1280, 720)])
@pytest.mark.parametrize("rate", [24.0, 59.94, 240.0])
def test_a_film_has_the_size_and_the_rate_of_its_video(tmp_path, size, rate):
    source = flight(tmp_path / "a.avi", range(3), "MJPG", size, rate)
    found(source, out=tmp_path / "b.mp4")
    (before, kept), (after, shown) = frames_of(source), frames_of(tmp_path / "b.mp4")
    assert [frame.shape for frame in after] == [frame.shape for frame in before]
    assert shown == pytest.approx(kept, rel=1e-3)


def test_a_video_that_breaks_off_leaves_no_film(tmp_path):
    source = flight(tmp_path / "a.avi", range(30), "MJPG")
    source.write_bytes(source.read_bytes()[: source.stat().st_size // 2])
    (tmp_path / "out.mp4").write_text("old")
    with pytest.raises(InputError, match="breaks off"):
        found(source, out=tmp_path / "out.mp4")
    assert (tmp_path / "out.mp4").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.avi", "out.mp4"]


def test_a_film_is_of_one_video_and_never_the_video_itself(tmp_path, picture):
    source = flight(tmp_path / "a.mp4", range(3))
    whole = source.read_bytes()
    for paths, out, says in (
        ((picture,), "b.mp4", "is one film: expected one video"),
        ((source, source), "b.mp4", "is one film"),
        ((tmp_path,), "b.mp4", "is one film"),
        ((source,), "a.mp4", "is the video that is looked at"),
        ((source,), "gone/b.mp4", "does not exist"),
        ((source,), "ball.png", "is a file: expected a folder"),
    ):
        with pytest.raises(InputError, match=says):
            found(*paths, out=tmp_path / out)
    (tmp_path / "link.mp4").symlink_to(source)
    with pytest.raises(InputError, match="is the video that is looked at"):
        found(source, out=tmp_path / "link.mp4")
    assert source.read_bytes() == whole


@pytest.mark.parametrize(
    ("search", "said"),
    [
        ({"eyes": "tracker", "circle_fit": "pratt"}, "--circle-fit pratt with eyes 'tracker'"),
        ({"eyes": "tracker", "diameter": "float"}, "--diameter float with eyes 'tracker'"),
        ({"circle_fit": "ransac"}, "unknown circle fit 'ransac': expected one of kasa, pratt"),
        ({"diameter": "half"}, "unknown diameter 'half': expected one of whole, float"),
    ],
)
def test_what_has_no_effect_or_no_meaning_is_refused(picture, search, said):
    with pytest.raises(InputError) as refusal:
        found(picture, **search)
    assert said in str(refusal.value)


def test_the_papers_circle_can_be_chosen_and_rounded(picture):
    ball = found(picture, circle_fit="taubin", diameter="whole")["pictures"][0]["balls"][0]
    assert ball["diameter_px"] in (24.0, 25.0, 26.0)
    assert "track" not in ball
    exact = found(picture, diameter="float")
    assert exact == found(picture)


def test_ten_balls_are_all_found(tmp_path):
    shown = np.full((480, 640, 3), (90, 100, 110), np.uint8)
    centers = [(60 + 125 * (k % 5), 120 + 220 * (k // 5)) for k in range(10)]
    for k, center in enumerate(centers):
        cv2.circle(shown, center, 6 + 3 * k, (20, 115, 245), -1, cv2.LINE_AA)
    cv2.imwrite(str(tmp_path / "ten.png"), shown)
    for eyes in ("paper", "tracker"):
        balls = found(tmp_path / "ten.png", eyes=eyes)["pictures"][0]["balls"]
        assert len(balls) == 10
        assert min(ball["score"] for ball in balls) > 0.5
        nearest = [min(np.hypot(b["x_px"] - x, b["y_px"] - y) for b in balls) for x, y in centers]
        assert max(nearest) < 0.3


SKINS = [(120, 155, 215), (140, 170, 220), (90, 130, 200), (70, 110, 180), (60, 90, 140)]


@pytest.mark.parametrize("skin", SKINS)
@pytest.mark.parametrize("eyes", ["paper", "tracker"])
def test_a_face_is_less_like_a_ball_than_a_ball_is(tmp_path, skin, eyes):
    shown = np.full((480, 640, 3), (90, 100, 110), np.uint8)
    cv2.ellipse(shown, (320, 240), (90, 120), 0, 0, 360, skin, -1, cv2.LINE_AA)
    for x in (285, 355):
        cv2.circle(shown, (x, 210), 8, (40, 30, 20), -1)
    cv2.ellipse(shown, (320, 300), (35, 12), 0, 0, 180, (80, 80, 170), -1)
    cv2.imwrite(str(tmp_path / "face.png"), shown)
    balls = found(tmp_path / "face.png", eyes=eyes, colours=("orange", "white"))["pictures"][0]
    assert max((ball["score"] for ball in balls["balls"]), default=0.0) < 0.5


@pytest.mark.parametrize("eyes", ["paper", "tracker"])
def test_a_picture_of_nothing_has_no_ball(tmp_path, eyes):
    for k, levels in enumerate([(0, 0, 0), (255, 255, 255), (20, 115, 245), (90, 100, 110)]):
        cv2.imwrite(str(tmp_path / f"{k}-.png"), np.full((90, 160, 3), levels, np.uint8))
    answer = found(tmp_path, eyes=eyes, colours=("orange", "white"))
    assert [entry["balls"] for entry in answer["pictures"]] == [[]] * 4


def test_a_frame_of_8k_is_searched_as_any_other(tmp_path):
    shown = np.full((4320, 7680, 3), 110, np.uint8)
    cv2.circle(shown, (4000, 2000), 60, (20, 115, 245), -1, cv2.LINE_AA)
    cv2.imwrite(str(tmp_path / "8k.bmp"), shown)
    (ball,) = found(tmp_path / "8k.bmp", eyes="tracker")["pictures"][0]["balls"]
    assert (ball["x_px"], ball["y_px"]) == pytest.approx((4000.0, 2000.0), abs=0.1)
