"""Balls marked in their pictures: a circle, what it is, where it is, and where it came from."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from rotorpong.conventions import InputError, Picture
from rotorpong.files import write_whole
from rotorpong.vision.detect import Detection
from rotorpong.vision.linking import Track
from rotorpong.vision.located import LocatedBall
from rotorpong.vision.pictures import PictureBalls

Bgr = tuple[int, int, int]

MARK = (255, 0, 255)  # blue, green, red: magenta, which no ball has
TRAILS = ((255, 0, 255), (255, 255, 0), (0, 255, 0), (255, 64, 64), (128, 0, 255))  # by number
USUAL_HEIGHT_PX = 720  # up to which letters and lines are of one size
LETTERS = 0.4  # size
FONT = cv2.FONT_HERSHEY_SIMPLEX
GROUND = (40, 40, 40)  # of letters
LINE_PX = 15  # from one line of text to the next


def annotate(
    picture: Picture,
    balls: Sequence[LocatedBall | Detection],
    tracks: Sequence[Track | None] = (),
) -> Picture:
    """Return a copy of a picture with each ball circled and labelled: colour, score, place.

    Args:
        picture: 8-bit BGR.
        balls: in it.
        tracks: of each ball, if they were linked; gives the circles' colours.
    """
    marked = picture.copy()
    size = _size(picture)
    for ball, track in zip(balls, tracks or [None] * len(balls), strict=True):
        colour = _colour(track)
        center = (round(ball.x_px), round(ball.y_px))
        radius = max(2, round(ball.diameter_px / 2) + 1)
        cv2.circle(marked, center, radius, colour, size, cv2.LINE_AA)
        for line, text in enumerate(_label(ball, track)):
            sides = (center[0] - radius - 2, center[0] + radius + 2)
            _write(marked, text, sides, center[1] + line * LINE_PX * size, colour)
    return marked


def draw_trails(picture: Picture, tracks: Sequence[Track], frames: int) -> None:
    """Draw into a picture where confirmed tracks were in their last frames.

    Args:
        picture: changed in place.
        tracks: to draw.
        frames: how far back.
    """
    for track in tracks:
        oldest = track.sights[-1][0] - frames
        places = [(x, y) for frame, x, y in track.sights if frame >= oldest]
        points = np.rint(places).astype(np.int32).reshape(-1, 1, 2)
        closed, size = False, _size(picture)
        cv2.polylines(picture, [points], closed, _colour(track), size, cv2.LINE_AA)


def write_annotated(
    result: PictureBalls, folder: Path, *, index: int, tracks: Sequence[Track | None] = ()
) -> Path:
    """Write a marked picture as `<index>-<name>.png` and return its path.

    Args:
        result: picture and balls.
        folder: made if it is not there.
        index: of the picture in this run; keeps equal names from different folders apart.
        tracks: of each ball, if they were linked.

    Raises:
        InputError: the file cannot be written.
    """
    path = make_folder(folder) / f"{index:05d}-{result.path.stem}.png"
    _, data = cv2.imencode(".png", annotate(result.picture, result.balls, tracks))
    write_whole(path, data.tobytes())
    return path


def make_folder(folder: Path) -> Path:
    """Return the folder, made if it is not there.

    Raises:
        InputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    return folder


def _write(picture: Picture, text: str, sides: tuple[int, int], y: int, colour: Bgr) -> None:
    """Write on a dark ground right of a ball, or left of it where the picture ends."""
    size = _size(picture)
    (width, height), below = cv2.getTextSize(text, FONT, LETTERS * size, size)
    left, right = sides
    x = right if right + width + 2 <= picture.shape[1] else max(0, left - width)
    cv2.rectangle(picture, (x - 1, y - height - 1), (x + width + 1, y + below // 2), GROUND, -1)
    cv2.putText(picture, text, (x, y), FONT, LETTERS * size, colour, size, cv2.LINE_AA)


def _label(ball: LocatedBall | Detection, track: Track | None) -> list[str]:
    number = "" if track is None or track.number is None else f" #{track.number}"
    lines = [f"{ball.colour} {ball.score:.2f}{number}"]
    if isinstance(ball, LocatedBall) and ball.position_m is not None:
        lines.append(" ".join(f"{metres:.2f}" for metres in ball.position_m) + " m")
    return lines


def _colour(track: Track | None) -> Bgr:
    if track is None or track.number is None:
        return MARK
    return TRAILS[(track.number - 1) % len(TRAILS)]


def _size(picture: Picture) -> int:
    """Return how many times larger than usual marks are, so that they show in large pictures."""
    return max(1, round(picture.shape[0] / USUAL_HEIGHT_PX))
