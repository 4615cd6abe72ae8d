"""One picture in, candidate balls out, best first.

Colour segmentation in HSV (section III of the paper; OpenCV's scale: hue 0..180, the others
0..255), connected blobs by their outer contours, and a score per blob that needs nothing but the
blob, so that scores compare between pictures:

    score = likeness x roundness x size, each in 0..1
    likeness   exp(-2 |(mean hsv - typical) / (upper - lower)|^2)
    roundness  (pixels of the blob / area of the circle around it)^2; below 0.2, which a streak
               2.5 balls long and most floors and walls stay under, it is no candidate
    size       1 - exp(-(diameter / 3 px)^2), for a few pixels are round whatever they show

The whole picture is searched for a ball's strongest pixels only, large ones at half the size,
averaged 2 x 2; around those its weaker ones count too (shade, blur), which alone are wood or skin.
OpenCV's HSV is taken only of the box around all pixels that may be of the colour, which a coarser
test finds first. No blur, no labelled components: both cost more than all the rest.
Pixel centres have whole coordinates.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Int32, Int64, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.vision._search_kernels import find_reach
from rotorpong.vision.measure import OUTLINE_BIAS_PX, fit_circle, outer_arc

LARGE_PICTURE_PIXELS = 640 * 480  # above this the search runs at half the size
MINIMUM_BLOB_PIXELS = 4  # half of a ball 3 px wide
MAXIMUM_BLOBS = 32  # per colour and picture, the largest
SIZE_SCALE_PX = 3.0
MINIMUM_ROUNDNESS = 0.2
MINIMUM_ARC_POINTS = 8
BOX_MARGIN_PX = 6  # around a core, and half its size

Mask = UInt8[ndarray, "height width"]


@dataclass(frozen=True, slots=True)
class Colour:
    """A ball's colour in OpenCV's HSV: limits of its pixels, and the mean of a typical ball."""

    name: str
    core: tuple[int, int, int]  # lower limits that at least one pixel of a ball keeps
    lower: tuple[int, int, int]  # and all of its pixels
    upper: tuple[int, int, int]
    typical: tuple[int, int, int]


ORANGE = Colour("orange", (0, 140, 90), (0, 110, 80), (24, 255, 255), (11, 200, 215))
WHITE = Colour("white", (0, 0, 200), (0, 0, 175), (180, 60, 255), (90, 20, 235))
COLOURS = {colour.name: colour for colour in (ORANGE, WHITE)}


@dataclass(frozen=True, slots=True)
class Blob:
    """A connected patch of a ball's colour."""

    contour: Int32[ndarray, "n 2"]  # centres of its outermost pixels
    colour: str
    score: float  # 0..1
    on_border: bool  # the picture cuts it


@dataclass(frozen=True, slots=True)
class Detection:
    """A candidate ball in a picture."""

    x_px: float
    y_px: float
    diameter_px: float
    score: float  # 0..1, comparable between pictures
    colour: str


def detect(picture: ndarray, colours: Sequence[Colour | str] = (ORANGE,)) -> list[Detection]:
    """Return the candidate balls whose centre is in the picture, best first.

    Args:
        picture: (height, width) grey, (height, width, 3) BGR or (height, width, 4) BGRA; 8 or 16
            bits.
        colours: to look for, by name or as a `Colour`.

    Raises:
        InputError: not such a picture, or an unknown name of a colour.
    """
    pixels = as_picture(picture)
    height, width = pixels.shape[:2]
    balls = [_measured(blob, pixels.shape[:2]) for blob in find_blobs(pixels, colours)]
    return [b for b in balls if 0 <= b.x_px <= width - 1 and 0 <= b.y_px <= height - 1]


def find_blobs(picture: Picture, colours: Sequence[Colour | str] = (ORANGE,)) -> list[Blob]:
    """Return the blobs that could be balls, best first."""
    wanted = [_colour(colour) for colour in colours]
    blobs = [blob for colour in wanted for blob in _blobs_of(picture, colour)]
    return sorted(blobs, key=lambda blob: -blob.score)


def as_picture(picture: ndarray) -> Picture:
    """Return any 8- or 16-bit grey, BGR or BGRA array as an 8-bit BGR picture.

    Raises:
        InputError: not such an array.
    """
    known = picture.dtype in (np.uint8, np.uint16) and picture.ndim in (2, 3)
    channels = picture.shape[2] if picture.ndim == 3 else 1
    if not known or channels not in (1, 3, 4) or picture.size == 0:
        raise InputError(
            f"a picture of shape {picture.shape} and type {picture.dtype}; expected at least one "
            "pixel, 1, 3 or 4 channels, uint8 or uint16"
        )
    eight_bits = (picture >> 8).astype(np.uint8) if picture.dtype == np.uint16 else picture
    if channels == 1:
        return cv2.cvtColor(eight_bits, cv2.COLOR_GRAY2BGR)
    return np.ascontiguousarray(eight_bits[..., :3])


def _colour(colour: Colour | str) -> Colour:
    if isinstance(colour, Colour):
        return colour
    if colour not in COLOURS:
        raise InputError(f"unknown colour {colour!r}; available: {', '.join(COLOURS)}")
    return COLOURS[colour]


def _blobs_of(picture: Picture, colour: Colour) -> list[Blob]:
    mask = _mask(picture, colour)
    blobs = [_blob(picture, mask, contour, colour) for contour in _contours(mask)]
    return [blob for blob in blobs if blob is not None]


def _mask(picture: Picture, colour: Colour) -> Mask:
    """Return 255 where the colour lies around a core of it, found in a coarse search."""
    height, width = picture.shape[:2]
    large = height * width > LARGE_PICTURE_PIXELS and min(height, width) > 1
    size = (width // 2, height // 2)
    search = cv2.resize(picture, size, interpolation=cv2.INTER_AREA) if large else picture
    mask = np.zeros((height, width), dtype=np.uint8)
    for rows, columns in _boxes(_core_boxes(search, colour) * (2 if large else 1)):
        mask[rows, columns] = _within(_hsv(picture[rows, columns]), colour.lower, colour)
    return mask


def _core_boxes(picture: Picture, colour: Colour) -> Int64[ndarray, "n 4"]:
    """Return the boxes (x, y, width, height) around all cores."""
    height, width = picture.shape[:2]
    reach = np.empty(4, np.int64)
    limits = np.array([colour.core, colour.upper], np.float32)
    find_reach(reach, picture.reshape(height, 3 * width), limits[0], limits[1])
    left, top, right, bottom = reach.tolist()
    if left >= right:
        return np.empty((0, 4), np.int64)
    cores = _within(_hsv(picture[top:bottom, left:right]), colour.core, colour)
    contours, _ = cv2.findContours(
        cores, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE, offset=(left, top)
    )
    boxes = [cv2.boundingRect(contour) for contour in contours]
    return np.array(boxes, np.int64).reshape(-1, 4)


def _boxes(cores: Int64[ndarray, "n 4"]) -> list[tuple[slice, slice]]:
    """Return where the largest cores lie, with room for the rest of their blobs."""
    largest = cores[np.argsort(cores[:, 2] * cores[:, 3])[-2 * MAXIMUM_BLOBS :]]
    boxes = []
    for left, top, across, down in largest.tolist():
        room = BOX_MARGIN_PX + max(across, down) // 2
        rows = slice(max(top - room, 0), top + down + room)
        boxes.append((rows, slice(max(left - room, 0), left + across + room)))
    return boxes


def _hsv(picture: Picture) -> Picture:
    return cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)


def _within(hsv: Picture, lower: tuple[int, int, int], colour: Colour) -> Mask:
    return cv2.inRange(hsv, lower, colour.upper)


def _contours(mask: Mask) -> list[ndarray]:
    """Return the outer contours of the largest blobs."""
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    enough = [contour for contour in contours if len(contour) >= MINIMUM_BLOB_PIXELS]
    return sorted(enough, key=len)[-MAXIMUM_BLOBS:]


def _blob(picture: Picture, mask: Mask, contour: ndarray, colour: Colour) -> Blob | None:
    """Return a contour's blob with its score, `None` where it cannot be a ball."""
    left, top, across, down = cv2.boundingRect(contour)
    count = _pixels_inside(contour)
    _, radius = cv2.minEnclosingCircle(contour)
    roundness = min(count / (math.pi * (radius + 0.5) ** 2), 1.0) ** 2
    height, width = mask.shape
    if roundness < MINIMUM_ROUNDNESS or across == width or down == height:
        return None
    box = (slice(top, top + down), slice(left, left + across))
    likeness = _likeness(_hsv(picture[box]), mask[box], colour)
    size = 1.0 - math.exp(-4.0 * count / math.pi / SIZE_SCALE_PX**2)
    cut = left == 0 or top == 0 or left + across == width or top + down == height
    points = contour[:, 0].astype(np.int32)
    return Blob(points, colour.name, likeness * roundness * size, cut) if likeness else None


def _pixels_inside(contour: ndarray) -> float:
    """Return how many pixels a contour of unit steps encloses, itself included (Pick)."""
    return cv2.contourArea(contour) + len(contour) / 2 + 1


def _likeness(hsv: Picture, inside: Mask, colour: Colour) -> float:
    """Return how like a ball's the mean colour inside is; 0 if no pixel is of the core."""
    if not cv2.countNonZero(cv2.bitwise_and(_within(hsv, colour.core, colour), inside)):
        return 0.0
    mean = np.array(cv2.mean(hsv, inside)[:3])
    width = np.subtract(colour.upper, colour.lower)
    return math.exp(-2.0 * float(np.sum(((mean - colour.typical) / width) ** 2)))


def _measured(blob: Blob, shape: tuple[int, ...]) -> Detection:
    """Return the ball of a blob: the circle of its outer arc, or of what the border left of it."""
    points = blob.contour
    if blob.on_border:
        inside = np.all((points > 0) & (points < (shape[1] - 1, shape[0] - 1)), axis=1)
        points = points[inside] if inside.sum() >= MINIMUM_ARC_POINTS else points
    else:
        points = outer_arc(points)
    circle = fit_circle(points)
    diameter = circle.diameter_px + OUTLINE_BIAS_PX
    return Detection(circle.x_px, circle.y_px, diameter, blob.score, blob.colour)
