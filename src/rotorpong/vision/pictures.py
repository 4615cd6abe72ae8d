"""Picture files, folders and videos: where they come from, which balls they show, how to mark them.

A folder gives its pictures and videos by name; other files and subfolders are passed over, a
damaged one is dropped, both counted in the log. A file named by itself must be readable. A video
that breaks off gives its frames up to there and is then an error.
"""

import logging
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_DIAMETER, InputError, Picture
from rotorpong.files import write_whole
from rotorpong.physics.camera import Camera
from rotorpong.vision.detect import Colour, Detection, detect
from rotorpong.vision.locate import ball_position, position_covariance

PICTURE_SUFFIXES = {".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"}
VIDEO_SUFFIXES = {".mp4", ".avi", ".mov", ".mkv", ".m4v", ".webm", ".mpg", ".mpeg"}
CENTER_SD_PX = 0.15  # real footage, compressed
DIAMETER_SD_PX = 0.4  # the threshold's bias depends on exposure and encoding
MARK = (255, 0, 255)  # blue, green, red: magenta, which no ball has

FRAMES_MISCOUNTED = 2  # some containers only estimate how many frames they hold
SHARE_MISCOUNTED = 0.02

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class LocatedBall:
    """A candidate ball in a picture and, where the camera is known, in the camera frame."""

    x_px: float
    y_px: float
    diameter_px: float
    score: float
    colour: str
    position_m: Float[ndarray, "3"] | None = None
    covariance_m2: Float[ndarray, "3 3"] | None = None


@dataclass(frozen=True, slots=True)
class PictureBalls:
    """The candidate balls of one picture, best first."""

    path: Path
    frame: int  # in its video; 0 for a picture
    balls: tuple[LocatedBall, ...]
    picture: Picture = field(repr=False, compare=False)


def detect_pictures(
    paths: Sequence[str | Path],
    *,
    camera: Camera | None = None,
    colours: Sequence[Colour | str] = ("orange",),
    ball_diameter: float = BALL_DIAMETER,
    min_score: float = 0.0,
) -> Iterator[PictureBalls]:
    """Find the balls in pictures, folders and videos, one picture at a time.

    Args:
        paths: of pictures, folders or videos.
        camera: that took them; without it balls have no position.
        colours: to look for, by name or as a `Colour`.
        ball_diameter: of the real balls, m.
        min_score: of a ball worth reporting, 0..1.

    Raises:
        InputError: nothing to read, a damaged file, or a picture of another size than the camera's.
    """
    if not 0.0 <= min_score <= 1.0:
        raise InputError(f"minimum score {min_score}; expected 0 to 1")
    for path, frame, picture in read_pictures(paths):
        if camera is not None:
            _check_size(picture, camera, path)
        found = [ball for ball in detect(picture, colours) if ball.score >= min_score]
        balls = tuple(_located(ball, camera, ball_diameter) for ball in found)
        yield PictureBalls(path, frame, balls, picture)


def as_json(results: Iterable[PictureBalls]) -> dict[str, list[dict[str, Any]]]:
    """Return detections as plain numbers and lists, in the layout of `rotorpong detect --json`."""
    return {
        "pictures": [
            {
                "path": str(result.path),
                "frame": result.frame,
                "balls": [_ball_json(ball) for ball in result.balls],
            }
            for result in results
        ]
    }


def read_pictures(paths: Sequence[str | Path]) -> Iterator[tuple[Path, int, Picture]]:
    """Return path, frame number and picture of everything that `paths` name.

    Raises:
        InputError: no path, a path that is missing or damaged, or a folder without pictures.
    """
    if not paths:
        raise InputError("no path given; expected pictures, folders or videos")
    for path in map(Path, paths):
        if path.is_dir():
            yield from _read_folder(path)
        elif path.is_file():
            yield from _read_file(path)
        else:
            raise InputError(f"{path}: no such file or folder")


def read_picture(path: Path) -> Picture:
    """Return a picture file as 8-bit BGR: OpenCV widens grey, narrows 16 bits, drops alpha.

    Raises:
        InputError: it cannot be read, or is no picture.
    """
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
        picture = cv2.imdecode(data, cv2.IMREAD_COLOR) if data.size else None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except cv2.error:
        picture = None
    if picture is None:
        raise InputError(f"{path}: not a picture that OpenCV can decode, or damaged")
    return picture


def annotate(picture: Picture, balls: Sequence[LocatedBall | Detection]) -> Picture:
    """Return a copy of a picture with each ball circled and labelled by colour and score."""
    marked = picture.copy()
    for ball in balls:
        center = (round(ball.x_px), round(ball.y_px))
        radius = max(2, round(ball.diameter_px / 2) + 1)
        cv2.circle(marked, center, radius, MARK, 1, cv2.LINE_AA)
        text = f"{ball.colour} {ball.score:.2f}"
        corner = (center[0] + radius + 2, center[1])
        cv2.putText(marked, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.4, MARK, 1, cv2.LINE_AA)
    return marked


def write_annotated(result: PictureBalls, folder: Path, *, index: int) -> Path:
    """Write a marked picture as `<index>-<name>.png` and return its path.

    Args:
        result: picture and balls.
        folder: made if it is not there.
        index: of the picture in this run; keeps equal names from different folders apart.

    Raises:
        InputError: the file cannot be written.
    """
    path = folder / f"{index:05d}-{result.path.stem}.png"
    _, data = cv2.imencode(".png", annotate(result.picture, result.balls))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    write_whole(path, data.tobytes())
    return path


def hush_codecs() -> None:
    """Keep OpenCV's and FFmpeg's own complaints off stderr: ours name the file."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)


def _read_folder(folder: Path) -> Iterator[tuple[Path, int, Picture]]:
    entries = sorted(folder.iterdir())
    known = [path for path in entries if path.is_file() and _is_known(path)]
    passed_over, dropped, pictures = len(entries) - len(known), [], 0
    for path in known:
        try:
            for item in _read_file(path):
                pictures += 1
                yield item
        except InputError as error:
            dropped.append(error)
    if not pictures:
        raise InputError(
            f"folder {folder} holds no readable picture or video: {passed_over} other entries, "
            f"{len(dropped)} damaged; expected "
            f"{' '.join(sorted(PICTURE_SUFFIXES | VIDEO_SUFFIXES))}"
        )
    for error in dropped:
        log.warning("dropped: %s", error)
    if passed_over or dropped:
        log.warning("%s: passed over %d, dropped %d damaged", folder, passed_over, len(dropped))


def _is_known(path: Path) -> bool:
    return path.suffix.lower() in PICTURE_SUFFIXES | VIDEO_SUFFIXES


def _read_file(path: Path) -> Iterator[tuple[Path, int, Picture]]:
    if path.suffix.lower() in VIDEO_SUFFIXES:
        yield from _read_video(path)
    else:
        yield path, 0, read_picture(path)


def _read_video(path: Path) -> Iterator[tuple[Path, int, Picture]]:
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    try:
        promised = int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if capture.isOpened() else 0
        frames = 0
        while capture.isOpened():
            read, picture = capture.read()
            if not read:
                break
            yield path, frames, picture
            frames += 1
    finally:
        capture.release()
    if not frames:
        raise InputError(f"{path}: not a video that OpenCV can decode, or damaged")
    if promised - frames > max(FRAMES_MISCOUNTED, SHARE_MISCOUNTED * promised):
        raise InputError(f"{path}: breaks off after {frames} of {promised} frames: damaged")


def _check_size(picture: Picture, camera: Camera, path: Path) -> None:
    height, width = picture.shape[:2]
    if (width, height) != (camera.width_px, camera.height_px):
        raise InputError(
            f"{path}: {width} x {height} pixels; camera {camera.name} is calibrated for "
            f"{camera.width_px} x {camera.height_px}"
        )


def _located(ball: Detection, camera: Camera | None, ball_diameter: float) -> LocatedBall:
    seen = (ball.x_px, ball.y_px, ball.diameter_px, ball.score, ball.colour)
    if camera is None:
        return LocatedBall(*seen)
    pixel, diameter = np.array([ball.x_px, ball.y_px]), np.array(ball.diameter_px)
    position = ball_position(camera, pixel, diameter, ball_diameter=ball_diameter, eq1=False)
    covariance = position_covariance(
        camera,
        pixel,
        diameter,
        center_sd_px=CENTER_SD_PX,
        diameter_sd_px=DIAMETER_SD_PX,
        ball_diameter=ball_diameter,
    )
    return LocatedBall(*seen, position, covariance)


def _ball_json(ball: LocatedBall) -> dict[str, Any]:
    return {
        "x_px": ball.x_px,
        "y_px": ball.y_px,
        "diameter_px": ball.diameter_px,
        "score": ball.score,
        "colour": ball.colour,
        "position_m": None if ball.position_m is None else ball.position_m.tolist(),
        "covariance_m2": None if ball.covariance_m2 is None else ball.covariance_m2.tolist(),
    }
