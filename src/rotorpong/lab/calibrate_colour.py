"""A ball's colour from boxes around balls in pictures: what `rotorpong calibrate colour` does.

Rows of a CSV: `picture,x0,y0,x1,y1`, the picture's path from the CSV's folder, the box in pixels
from its first column and row to one past its last; further columns are passed over. A ball's pixels
are those of the ellipse in its box but for the rim, where pixels mix; its surroundings are a ring
around the box that no box touches.
"""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from jaxtyping import UInt8
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.files import target_of, write_whole
from rotorpong.lab.number_rows import finite_number, read_lines
from rotorpong.vision.colour import Colour
from rotorpong.vision.colour_files import FIELDS, colour_text, require_name
from rotorpong.vision.colour_learning import Pixels, learn_colour
from rotorpong.vision.detect import detect
from rotorpong.vision.pictures import hush_codecs, read_picture

COLUMNS = ("picture", "x0", "y0", "x1", "y1")
MOST_BALLS = 10_000
LEAST_SIDE_PX = 3.0
BLUR_PX = 2  # around a box that is neither ball nor surroundings
LEAST_RING_PX = 6
MOST_PIXELS = 2000  # of one ball, and of one ring, evenly chosen
WITHOUT_RIM = 0.85  # of the ellipse's radii
SIZES = (0.5, 2.0)  # of a box's side, between which a ball found there is its ball

Progress = Callable[[int, int], None]


class _Box(NamedTuple):
    left: float
    top: float
    right: float  # exclusive
    bottom: float
    line: int  # of the CSV


@dataclass(slots=True)
class _Samples:
    balls: list[Pixels]
    surroundings: list[Pixels]


def calibrate_colour(
    boxes: Path, out: Path, name: str | None, progress: Progress
) -> dict[str, Any]:
    """Write the colour of the balls in boxes.

    Args:
        boxes: CSV.
        out: FILE.json.
        name: of the colour; by default `out` without its suffix.
        progress: called with (pictures done, of how many), twice through all pictures.

    Returns:
        What `calibrate colour --json` prints.

    Raises:
        InputError: a row, box or picture that is none, `out` cannot be written, or no colour tells
            the balls from their surroundings.
    """
    if out.suffix.lower() != ".json":
        raise InputError(f"out {str(out)!r}: expected a name that ends in .json")
    name = require_name(out.stem if name is None else name)
    target_of(out)  # nothing is learnt for a place that cannot be written
    by_picture = _read_boxes(boxes)
    hush_codecs()
    samples = _Samples([], [])
    for index, (path, rows) in enumerate(by_picture.items()):
        progress(index, 2 * len(by_picture))
        _sample(samples, _picture(path, rows, boxes), rows, f"{boxes}: ")
    around = np.concatenate(samples.surroundings)
    if not len(around):
        raise InputError(f"{boxes}: boxes fill their pictures; expected something around the balls")
    try:
        learnt = learn_colour(samples.balls, around, name)
    except InputError as error:
        raise InputError(f"{boxes}: {error}") from None
    found = 0
    for index, (path, rows) in enumerate(by_picture.items()):
        progress(len(by_picture) + index, 2 * len(by_picture))
        found += _found(_picture(path, rows, boxes), rows, learnt.colour)
    progress(2 * len(by_picture), 2 * len(by_picture))
    write_whole(out, colour_text(learnt.colour).encode())
    limits = {key: list(getattr(learnt.colour, key)) for key in FIELDS if key != "name"}
    return {
        "out": str(out),
        "name": name,
        **limits,
        "pictures": len(by_picture),
        "balls": len(samples.balls),
        "balls_found": found,
        "recall": learnt.recall,
        "background_pixels": learnt.surroundings,
        "background_pixels_taken": learnt.surroundings_taken,
        "hue_cut": learnt.hue_cut,
    }


def _read_boxes(path: Path) -> dict[Path, list[_Box]]:
    """Return the boxes of every picture."""
    try:
        rows = [(i, row) for i, row in enumerate(csv.reader(read_lines(path)), start=1) if any(row)]
    except csv.Error as error:
        raise InputError(f"{path}: is no CSV ({error}); expected {','.join(COLUMNS)}") from None
    if not rows:
        raise InputError(f"{path}: is empty; expected the columns {','.join(COLUMNS)}")
    header = [column.strip() for column in rows[0][1]]
    missing = [column for column in COLUMNS if column not in header]
    if missing:
        raise InputError(
            f"{path}: lacks {', '.join(missing)}; it begins with {','.join(header)[:60]!r}; "
            f"expected the columns {','.join(COLUMNS)}"
        )
    if not 1 <= len(rows) - 1 <= MOST_BALLS:
        raise InputError(f"{path}: {len(rows) - 1} boxes; expected 1 to {MOST_BALLS}")
    by_picture: dict[Path, list[_Box]] = {}
    for line, row in rows[1:]:
        picture, box = _box(f"{path}: line {line}", dict(zip(header, row, strict=False)), line)
        by_picture.setdefault(path.parent / picture, []).append(box)
    return by_picture


def _box(where: str, row: dict[str, str], line: int) -> tuple[str, _Box]:
    missing = [column for column in COLUMNS if column not in row]
    picture = row.get("picture", "").strip()
    if missing or not picture or "\0" in picture:
        raise InputError(f"{where}: expected {','.join(COLUMNS)}, with a picture's name")
    left, top, right, bottom = (finite_number(f"{where}:", row[key]) for key in COLUMNS[1:])
    if not (right - left >= LEAST_SIDE_PX and bottom - top >= LEAST_SIDE_PX):
        raise InputError(
            f"{where}: a box from ({left:g}, {top:g}) to ({right:g}, {bottom:g}); expected x0 < x1 "
            f"and y0 < y1, {LEAST_SIDE_PX:g} pixels apart or more"
        )
    return picture, _Box(left, top, right, bottom, line)


def _picture(path: Path, rows: list[_Box], boxes: Path) -> Picture:
    """Return a picture, once it is sure that its boxes lie in it."""
    where = f"{boxes}: line {rows[0].line}"
    if not path.is_file():
        raise InputError(f"{where}: {path}: no such picture (paths are from the CSV's folder)")
    try:
        picture = read_picture(path)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    height, width = picture.shape[:2]
    for box in rows:
        if not (box.left >= 0 and box.right <= width and box.top >= 0 and box.bottom <= height):
            raise InputError(
                f"{boxes}: line {box.line}: a box from ({box.left:g}, {box.top:g}) to "
                f"({box.right:g}, {box.bottom:g}) in a picture of {width} x {height} pixels; "
                "expected one within it"
            )
    return picture


def _sample(samples: _Samples, picture: Picture, rows: list[_Box], where: str) -> None:
    """Add the pixels of a picture's balls and of what is around them."""
    hsv = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)
    free = np.ones(picture.shape[:2], bool)
    for box in rows:
        free[_slices(box, BLUR_PX)] = False
    for box in rows:
        inside = _slices(box, 0)
        pixels = hsv[inside][_ellipse(box, inside)]
        if not len(pixels):
            raise InputError(f"{where}line {box.line}: a box without a pixel")
        ring = _slices(box, max(LEAST_RING_PX, round(max(_sides(box)))))
        samples.balls.append(_some(pixels))
        samples.surroundings.append(_some(hsv[ring][free[ring]]))


def _sides(box: _Box) -> tuple[float, float]:
    return box.right - box.left, box.bottom - box.top


def _slices(box: _Box, margin: int) -> tuple[slice, slice]:
    """Return the rows and columns of a box with a margin; what is negative is cut off."""
    rows = slice(max(int(box.top) - margin, 0), int(np.ceil(box.bottom)) + margin)
    columns = slice(max(int(box.left) - margin, 0), int(np.ceil(box.right)) + margin)
    return rows, columns


def _ellipse(box: _Box, inside: tuple[slice, slice]) -> ndarray:
    """Tell which pixels of a box have their centre in its ellipse, rim left out."""
    rows = np.arange(inside[0].start, inside[0].stop)[:, None] + 0.5
    columns = np.arange(inside[1].start, inside[1].stop) + 0.5
    across, down = _sides(box)
    x = (2.0 * columns - box.left - box.right) / across
    y = (2.0 * rows - box.top - box.bottom) / down
    return x**2 + y**2 <= WITHOUT_RIM**2


def _some(pixels: UInt8[ndarray, "n 3"]) -> Pixels:
    """Return at most `MOST_PIXELS` of the pixels, evenly chosen."""
    if len(pixels) <= MOST_PIXELS:
        return pixels
    return pixels[np.linspace(0, len(pixels) - 1, MOST_PIXELS).astype(int)]


def _found(picture: Picture, rows: list[_Box], colour: Colour) -> int:
    """Return how many of the boxes a ball is found in, of about their size."""
    balls = detect(picture, [colour])
    least, most = SIZES
    count = 0
    for box in rows:
        side = max(_sides(box))
        count += any(
            box.left <= ball.x_px + 0.5 <= box.right
            and box.top <= ball.y_px + 0.5 <= box.bottom
            and least * side <= ball.diameter_px <= most * side
            for ball in balls
        )
    return count
