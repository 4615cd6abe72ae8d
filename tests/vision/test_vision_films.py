"""Films come back as they were written, or are not there."""

import contextlib
import os
import resource

import cv2
import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.vision.films import film


def picture(k, size=(64, 48)):
    shown = np.full((size[1], size[0], 3), 40 + 10 * k, np.uint8)
    cv2.circle(shown, (10 + 3 * k, size[1] // 2), 6, (20, 115, 245), -1)
    return shown


def write(path, rate=30.0, size=(64, 48), frames=7):
    with film(path, rate) as made:
        for k in range(frames):
            made.write(picture(k, size))
    return path


def written(path, pictures):
    """Write a film of these, up to one that is an error."""
    with film(path, 30.0) as made:
        for shown in pictures:
            if isinstance(shown, BaseException):
                raise shown
            made.write(shown)


def read(path):
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    pictures = []
    while (got := capture.read())[0]:
        pictures.append(got[1])
    return pictures, capture.get(cv2.CAP_PROP_FPS)


@pytest.mark.parametrize("name", ["a.mp4", "a.MP4", "a.mkv", "a.mov", "a.m4v", "a.avi"])
def test_every_kind_of_film_comes_back_frame_by_frame(tmp_path, name):
    pictures, rate = read(write(tmp_path / name))
    assert len(pictures) == 7
    assert rate == pytest.approx(30.0)
    for k, shown in enumerate(pictures):
        assert np.abs(shown.astype(int) - picture(k)).mean() < 6.0


@pytest.mark.parametrize(
    "rate", [0.5, 7.4925, 14.985, 24000 / 1001, 30000 / 1001, 65.123, 119.88, 239.811, 1000.0]
)
def test_any_frame_rate_is_kept_to_a_thousandth(tmp_path, rate):
    pictures, kept = read(write(tmp_path / "a.mp4", rate))
    assert len(pictures) == 7
    assert kept == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (7, 5), (65, 48), (64, 49), (1920, 1080)])
def test_any_size_is_kept_and_odd_ones_repeat_their_last_line(tmp_path, size):
    pictures, _ = read(write(tmp_path / "a.mp4", size=size, frames=2))
    even = (size[0] + size[0] % 2, size[1] + size[1] % 2)
    assert [shown.shape for shown in pictures] == [(even[1], even[0], 3)] * 2


@contextlib.contextmanager
def full_after(size):
    """A disk on which no file grows beyond `size` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_is_one_error_and_what_was_there_stays(tmp_path):
    path = tmp_path / "a.mp4"
    path.write_text("old")
    rng = np.random.default_rng(0)
    pictures = rng.integers(0, 255, (8, 240, 320, 3), np.uint8)
    with full_after(2**15), pytest.raises(InputError, match="broke off there; is the disk full"):
        written(path, pictures)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.mp4"]


def test_an_error_on_the_way_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        written(tmp_path / "a.mp4", [picture(0), KeyboardInterrupt()])
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "size", "says"),
    [
        ("a.txt", (64, 48), "expected a name that ends with .mp4"),
        ("a", (64, 48), "expected a name that ends with .mp4"),
        ("gone/a.mp4", (64, 48), "does not exist"),
        ("folder.mp4", (64, 48), "is a folder"),
        ("a.mp4", (8200, 2), "8200 x 2 pixels; expected at most 8190"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path, name, size, says):
    (tmp_path / "folder.mp4").mkdir()
    with pytest.raises(InputError, match=says):
        write(tmp_path / name, size=size)
    assert os.listdir(tmp_path) == ["folder.mp4"]


def test_frames_of_another_size_are_refused(tmp_path):
    with pytest.raises(InputError, match="a frame of 32 x 32 after frames of 64 x 48"):
        written(tmp_path / "a.mp4", [picture(0), picture(1, (32, 32))])
    assert os.listdir(tmp_path) == []
