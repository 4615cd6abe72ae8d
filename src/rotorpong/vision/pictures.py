"""Picture files, folders and videos: where they come from, and which balls they show.

A folder gives its pictures and videos by name; other files and subfolders are passed over, a
damaged one is dropped, both counted in the log. A file named by itself must be readable. A video
that breaks off gives its frames up to there and is then an error. An animation (.gif) is a video;
of other files with several pictures the first is taken, which the log says.
"""

import logging
import os
import stat
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rotorpong.conventions import BALL_DIAMETER, InputError, Picture
from rotorpong.physics.camera import Camera
from rotorpong.vision.colour import Colour
from rotorpong.vision.linking import Linker, Track
from rotorpong.vision.located import LocatedBall, StillEyes

PICTURE_SUFFIXES = {".jpg", ".jpeg", ".png", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm"}
VIDEO_SUFFIXES = {".mp4", ".avi", ".mov", ".mkv", ".m4v", ".webm", ".mpg", ".mpeg", ".gif"}
USUAL_FPS = 30.0  # frames per second, of what does not say
FPS_RANGE = (0.1, 1000.0)
LONGEST_NUMBER = 18  # digits, in the name of a numbered picture
FRAMES_MISCOUNTED = 2  # some containers only estimate how many frames they hold
SHARE_MISCOUNTED = 0.02

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PictureBalls:
    """The candidate balls of one picture, best first."""

    path: Path
    frame: int  # in its video; 0 for a picture
    balls: tuple[LocatedBall, ...]
    picture: Picture = field(repr=False, compare=False)
    tracks: tuple[Track | None, ...] | None = None  # of each ball; None: they are not linked


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
    yield from look_at(paths, StillEyes(camera, tuple(colours), ball_diameter, min_score))


def look_at(paths: Sequence[str | Path], eyes: StillEyes) -> Iterator[PictureBalls]:
    """Look at pictures, folders and videos, one picture at a time.

    Args:
        paths: of pictures, folders or videos.
        eyes: what to look for, and how.

    Raises:
        InputError: as `detect_pictures`.
    """
    if not 0.0 <= eyes.min_score <= 1.0:
        raise InputError(f"minimum score {eyes.min_score}; expected 0 to 1")
    if not 0.0 < eyes.ball_diameter < 1.0:
        raise InputError(f"ball diameter {eyes.ball_diameter} m; expected above 0 and below 1 m")
    for path, frame, picture in read_pictures(paths):
        if eyes.camera is not None:
            _check_size(picture, eyes.camera, path)
        yield PictureBalls(path, frame, eyes.look(picture), picture)


def linked(found: Iterable[PictureBalls], ball_diameter: float) -> Iterator[PictureBalls]:
    """Return the same with the tracks of balls, linked over the frames of every sequence.

    Args:
        found: pictures, in order.
        ball_diameter: of the real balls, m.
    """
    linker, before = Linker(USUAL_FPS, ball_diameter), None
    for result in found:
        if before is None or not follows(before, result):
            rate = frame_rate(result.path) if is_video(result.path) else USUAL_FPS
            linker = Linker(rate, ball_diameter, first=linker.next_number)
        yield replace(result, tracks=linker.add(result.balls))
        before = result


def as_json(results: Iterable[PictureBalls]) -> dict[str, list[dict[str, Any]]]:
    """Return detections as plain numbers and lists, in the layout of `rotorpong detect --json`.

    Where balls are linked, each has the number of its track, or null.
    """
    pictures: list[dict[str, Any]] = []
    of_balls: list[tuple[dict[str, Any], Track | None]] = []
    for result in results:
        balls = [_ball_json(ball) for ball in result.balls]
        if result.tracks is not None:
            of_balls.extend(zip(balls, result.tracks, strict=True))
        pictures.append({"path": str(result.path), "frame": result.frame, "balls": balls})
    for ball, track in of_balls:  # now that it is known which were confirmed
        ball["track"] = None if track is None else track.number
    return {"pictures": pictures}


def read_pictures(paths: Sequence[str | Path]) -> Iterator[tuple[Path, int, Picture]]:
    """Return path, frame number and picture of everything that `paths` name.

    Raises:
        InputError: no path, a path that is missing or damaged, or a folder without pictures.
    """
    if not paths:
        raise InputError("no path given; expected pictures, folders or videos")
    for path in map(Path, paths):
        if _kind_of(path) == stat.S_IFDIR:
            yield from _read_folder(path)
        else:
            yield from _read_file(path)


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


def frame_rate(path: Path) -> float:
    """Return how many frames per second a video says it has; 30 where it says nothing sensible."""
    capture = cv2.VideoCapture(name_for_opencv(path), cv2.CAP_FFMPEG)
    try:
        said = float(capture.get(cv2.CAP_PROP_FPS)) if capture.isOpened() else 0.0
    finally:
        capture.release()
    return said if FPS_RANGE[0] <= said <= FPS_RANGE[1] else USUAL_FPS


def is_video(path: Path) -> bool:
    """Tell whether a file is taken for a video, by its name."""
    return path.suffix.lower() in VIDEO_SUFFIXES


def follows(before: PictureBalls, after: PictureBalls) -> bool:
    """Tell whether a picture is the frame after another.

    In a video it is; so are pictures of one size whose names differ in a number that goes up by
    one (`frame_0041.png`, `frame_0042.png`).
    """
    if before.picture.shape != after.picture.shape:
        return False
    if is_video(after.path) or is_video(before.path):
        return after.path == before.path and after.frame == before.frame + 1
    kept, number = _numbered(before.path)
    return number is not None and _numbered(after.path) == (kept, number + 1)


def name_for_opencv(path: Path) -> str:
    """Return the name of a file as OpenCV can take it: from any other text it crashes.

    Raises:
        InputError: it is no UTF-8.
    """
    try:
        str(path).encode()
    except UnicodeEncodeError:
        name = str(path).encode(errors="replace").decode()
        raise InputError(f"{name}: OpenCV needs names in UTF-8; expected another name") from None
    return str(path)


def hush_codecs() -> None:
    """Keep OpenCV's and FFmpeg's own complaints off stderr: ours name the file."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)


def _kind_of(path: Path) -> int:
    """Return whether a path is a folder or a file, S_IFDIR or S_IFREG of `stat`."""
    try:
        kind = stat.S_IFMT(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"{path}: no such file or folder") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    if kind not in (stat.S_IFDIR, stat.S_IFREG):
        raise InputError(f"{path}: neither a file nor a folder; expected pictures or videos")
    return kind


def _read_folder(folder: Path) -> Iterator[tuple[Path, int, Picture]]:
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise InputError(f"{folder}: cannot be read ({error.strerror})") from None
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


def _numbered(path: Path) -> tuple[Path, int | None]:
    """Return a path without the number that its name ends with, and the number."""
    stem = path.stem.rstrip("0123456789")
    digits = path.stem[len(stem) :]
    usable = digits.isascii() and 0 < len(digits) <= LONGEST_NUMBER
    return path.with_name(f"{stem}.{path.suffix}"), int(digits) if usable else None


def _read_file(path: Path) -> Iterator[tuple[Path, int, Picture]]:
    if is_video(path):
        yield from _read_video(path)
    else:
        picture = read_picture(path)
        _tell_pages(path)
        yield path, 0, picture


def _tell_pages(path: Path) -> None:
    """Say so where a file holds more pictures than the first."""
    try:
        pages = cv2.imcount(name_for_opencv(path))
    except (cv2.error, InputError):  # what cannot be counted was read all the same
        pages = 1
    if pages > 1:
        log.warning("%s: holds %d pictures; only the first is looked at", path, pages)


def _read_video(path: Path) -> Iterator[tuple[Path, int, Picture]]:
    capture = cv2.VideoCapture(name_for_opencv(path), cv2.CAP_FFMPEG)
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
