"""Pictures with boxes around what they show: one YOLO label file beside each.

`NAME.txt` beside `NAME.jpg` (or another picture) has a line `class x y width height` per box: a
whole number, then its centre and size in shares of the picture. It is empty where the picture shows
nothing. Other text files are passed over.
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.lab.number_rows import finite_number, read_lines
from rotorpong.vision.pictures import PICTURE_SUFFIXES, read_picture

COLUMNS = "class x y width height"


@dataclass(frozen=True, slots=True)
class LabelledPicture:
    """A picture file and the balls in it."""

    path: Path
    shares: Float[ndarray, "n 4"]  # centre, width and height of each box, in shares of the picture

    def read(self) -> tuple[Picture, Float[ndarray, "n 4"]]:
        """Return the picture and its boxes: left, top, right, bottom, px.

        The first pixel goes from 0 to 1, so its centre is at 0.5.

        Raises:
            InputError: the picture is damaged.
        """
        picture = read_picture(self.path)
        height, width = picture.shape[:2]
        center, half = self.shares[:, :2], self.shares[:, 2:] / 2.0
        return picture, np.hstack([center - half, center + half]) * [width, height, width, height]


@dataclass(frozen=True, slots=True)
class PictureSet:
    """Pictures of one folder, by name."""

    name: str
    pictures: tuple[LabelledPicture, ...]

    @property
    def balls(self) -> int:
        """How many balls are labelled."""
        return sum(len(picture.shares) for picture in self.pictures)


def read_picture_sets(folder: Path, ball_class: int | None = None) -> tuple[PictureSet, ...]:
    """Return the set in a folder, or one for each of its subfolders that holds pictures.

    Args:
        folder: of pictures and labels, or of such folders.
        ball_class: class of a ball where labels are of several; where they are of one, that is it.

    Raises:
        InputError: no picture, a picture without labels, a line that is no label, no box at all,
            or nothing tells which class is the ball.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of pictures with labels")
    try:
        folders = [folder, *sorted(path for path in folder.iterdir() if path.is_dir())]
        holding = [one for one in folders if _pictures_of(one)]
    except OSError as error:
        raise InputError(f"{folder}: cannot be read ({error.strerror})") from None
    if not holding:
        raise InputError(
            f"{folder}: no picture in it or in its folders; expected "
            f"{' '.join(sorted(PICTURE_SUFFIXES))}"
        )
    return tuple(_read_set(one, ball_class) for one in holding)


def _pictures_of(folder: Path) -> list[Path]:
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in PICTURE_SUFFIXES)


def _read_set(folder: Path, ball_class: int | None) -> PictureSet:
    paths = _pictures_of(folder)
    boxes = {path: _read_boxes(path) for path in paths}
    ball = _ball_class(folder, Counter(int(c) for b in boxes.values() for c in b[:, 0]), ball_class)
    pictures = (LabelledPicture(path, boxes[path][boxes[path][:, 0] == ball, 1:]) for path in paths)
    return PictureSet(folder.resolve().name, tuple(pictures))


def _ball_class(folder: Path, counts: Counter[int], given: int | None) -> int:
    if not counts:
        raise InputError(f"{folder}: no label holds a box; expected lines {COLUMNS!r}")
    if len(counts) == 1:
        return next(iter(counts))
    known = ", ".join(f"{number} ({counts[number]} boxes)" for number in sorted(counts))
    if given is None:
        raise InputError(f"{folder}: labels of classes {known}; expected the ball's, --ball-class")
    if given not in counts:
        raise InputError(f"{folder}: ball class {given}; its labels are of classes {known}")
    return given


def _read_boxes(picture: Path) -> Float[ndarray, "n 5"]:
    """Return class, centre and size of each box of a picture."""
    path = picture.with_suffix(".txt")
    if not path.is_file():
        raise InputError(
            f"{picture}: no labels {path.name} beside it; expected one, empty where no ball is"
        )
    rows = [
        _box(f"{path}: line {number}:", line)
        for number, line in enumerate(read_lines(path), start=1)
        if line
    ]
    return np.array(rows, dtype=float).reshape(-1, 5)


def _box(where: str, line: str) -> list[float]:
    fields = line.split()
    if len(fields) != len(COLUMNS.split()):
        raise InputError(f"{where} {len(fields)} fields; expected {COLUMNS!r}")
    row = [finite_number(where, field) for field in fields]
    if row[0] < 0 or row[0] != int(row[0]):
        raise InputError(f"{where} class {fields[0]}; expected a whole number from 0 up")
    if not (0 <= row[1] <= 1 and 0 <= row[2] <= 1 and 0 < row[3] <= 1 and 0 < row[4] <= 1):
        raise InputError(f"{where} a box {' '.join(fields[1:])}; expected shares of the picture")
    return row
