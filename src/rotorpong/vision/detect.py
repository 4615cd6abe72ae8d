"""One picture in, candidate balls out, best first: a thorough search and a quick one.

`detect` tries all thresholds of a colour and asks a model of a ball (`candidates`, `ball_model`);
its score is how sure that model is. Outlines of one ball overlap: the best one's score counts, and
their mean circle, weighed by squared score.

`find_balls` is for pictures in which little else has the colour, or for the tracker, which knows
where the ball is. It segments in HSV (section III of the paper; OpenCV's scale: hue 0..180, the
others 0..255) at one threshold, takes connected blobs by their outer contours, and scores each from
nothing but the blob, so that scores compare between pictures:

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
from jaxtyping import Bool, Float, Int32, Int64, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.vision._search_kernels import find_reach
from rotorpong.vision.ball_model import HUED, PALE, probability
from rotorpong.vision.candidates import find_candidates
from rotorpong.vision.circles import CircleFit
from rotorpong.vision.colour import ORANGE, Colour, as_colour
from rotorpong.vision.measure import OUTLINE_BIAS_PX, Circle, fit_circle, outer_arc

LARGE_PICTURE_PIXELS = 640 * 480  # above this the search runs at half the size
MINIMUM_BLOB_PIXELS = 4  # half of a ball 3 px wide
MAXIMUM_BLOBS = 32  # per colour and picture, the largest
SIZE_SCALE_PX = 3.0
MINIMUM_ROUNDNESS = 0.2
MINIMUM_ARC_POINTS = 8
BOX_MARGIN_PX = 6  # around a core, and half its size
WIDTH_BIAS_PX = 0.5  # half a pixel on either side is the ball's as well, less what blur adds
LEAST_SCORE = 0.01  # of a ball that `detect` reports
MOST_BALLS = 64  # that it reports
SAME_OVERLAP, SAME_SCORE = 0.4, 0.05  # of outlines of one ball: with the best, over its score
CLEAR_OVERLAP = 0.15  # of different balls

Mask = UInt8[ndarray, "height width"]


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


@dataclass(frozen=True, slots=True)
class _Guesses:
    """Candidates of all colours, best first; several may be outlines of the same ball."""

    contours: list[Int32[ndarray, "_ 2"]]
    circles: Float[ndarray, "n 3"]
    scores: Float[ndarray, "n"]
    colours: list[str]


def detect(picture: ndarray, colours: Sequence[Colour | str] = (ORANGE,)) -> list[Detection]:
    """Return the candidate balls whose centre is in the picture, best first.

    The thorough search; `find_balls` is the quick one.

    Args:
        picture: (height, width) grey, (height, width, 3) BGR or (height, width, 4) BGRA; 8 or 16
            bits.
        colours: to look for, by name or as a `Colour`.

    Raises:
        InputError: not such a picture, or an unknown name of a colour.
    """
    wanted = [as_colour(colour) for colour in colours]
    pixels = as_picture(picture)
    guesses = _guesses(pixels, wanted)
    free = np.ones(len(guesses.scores), bool)
    balls: list[Detection] = []
    while free.any() and len(balls) < MOST_BALLS:
        best = int(np.argmax(free))
        overlap, near = _overlaps(guesses.circles, best)
        balls.append(_ball(guesses, best, overlap, pixels.shape[:2]))
        free &= (overlap < CLEAR_OVERLAP) & ~near
    return [ball for ball in balls if _is_inside(ball, pixels)]


def outline_circle(contour: Int32[ndarray, "n 2"], shape: tuple[int, ...]) -> Circle:
    """Return the circle of a candidate: around its outer arc's centre, as wide as the outline.

    A ball in shade or hand, or blurred, leaves its outer arc in pieces; how far its outermost
    pixels are apart holds on.

    Args:
        contour: centres of its outermost pixels.
        shape: height and width of the picture.
    """
    fitted = fit_outline(contour, shape)
    if not _inner(contour, shape).all():
        return fitted
    _, radius = cv2.minEnclosingCircle(contour - contour.min(axis=0))  # same wherever it lies
    return Circle(fitted.x_px, fitted.y_px, 2.0 * radius + WIDTH_BIAS_PX)


def find_balls(picture: ndarray, colours: Sequence[Colour | str] = (ORANGE,)) -> list[Detection]:
    """Return the blobs that could be balls as `detect` does, from one threshold: quick.

    For pictures where nothing else has the colour, or where what is known of the ball tells which
    it is. Scores are those of blobs, not of `detect`.

    Args:
        picture: see `detect`.
        colours: see `detect`.

    Raises:
        InputError: see `detect`.
    """
    pixels = as_picture(picture)
    balls = []
    for blob in find_blobs(pixels, colours):
        circle = fit_outline(blob.contour, pixels.shape[:2])
        place = (circle.x_px, circle.y_px, circle.diameter_px)
        balls.append(Detection(*place, blob.score, blob.colour))
    return [ball for ball in balls if _is_inside(ball, pixels)]


def find_blobs(picture: Picture, colours: Sequence[Colour | str] = (ORANGE,)) -> list[Blob]:
    """Return the blobs that could be balls, best first."""
    wanted = [as_colour(colour) for colour in colours]
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


def _guesses(picture: Picture, colours: Sequence[Colour]) -> _Guesses:
    """Return what the model of a ball believes in, best first."""
    contours, circles, scores, names = [], [np.empty((0, 3))], [np.empty(0)], []
    for colour in colours:
        found = find_candidates(picture, colour)
        contours += found.contours
        circles.append(found.circles)
        scores.append(probability(found.features, HUED if colour.has_hue else PALE))
        names += [colour.name] * len(found.contours)
    score = np.concatenate(scores)
    order = np.argsort(-score, kind="stable")
    order = order[score[order] >= LEAST_SCORE]
    chosen = [contours[i] for i in order], [names[i] for i in order]
    return _Guesses(chosen[0], np.concatenate(circles)[order], score[order], chosen[1])


def _overlaps(
    circles: Float[ndarray, "n 3"], best: int
) -> tuple[Float[ndarray, "n"], Bool[ndarray, "n"]]:
    """Return how far the squares around circles overlap with one's, and whose centre is near."""
    away = np.abs(circles[:, :2] - circles[best, :2])
    sides, side = circles[:, 2], circles[best, 2]
    shared = np.minimum(np.minimum(sides, side)[:, None], (sides[:, None] + side) / 2 - away)
    both = np.prod(np.maximum(shared, 0.0), axis=1)
    near = np.hypot(*away.T) <= np.maximum(sides, side) / 2
    return both / (sides**2 + side**2 - both), near


def _ball(
    guesses: _Guesses, best: int, overlap: Float[ndarray, "n"], shape: tuple[int, ...]
) -> Detection:
    """Return the ball of a guess: the mean circle of its outlines, weighed by squared score."""
    score, colour = float(guesses.scores[best]), guesses.colours[best]
    same = (overlap > SAME_OVERLAP) & (guesses.scores >= SAME_SCORE * score)
    chosen = [i for i in np.flatnonzero(same) if guesses.colours[i] == colour]
    fits = [outline_circle(guesses.contours[i], shape) for i in chosen]
    circles = np.array([(fit.x_px, fit.y_px, fit.diameter_px) for fit in fits])
    x, y, diameter = np.average(circles, axis=0, weights=guesses.scores[chosen] ** 2).tolist()
    return Detection(x, y, diameter, score, colour)


def fit_outline(
    contour: Int32[ndarray, "n 2"], shape: tuple[int, ...], fit: CircleFit = "kasa"
) -> Circle:
    """Return the circle of a blob's outer arc, or of what the border left of it.

    Args:
        contour: centres of its outermost pixels.
        shape: height and width of the picture.
        fit: how a circle is put through points.
    """
    inner, points = _inner(contour, shape), contour
    if inner.all():
        points = outer_arc(points)
    elif inner.sum() >= MINIMUM_ARC_POINTS:
        points = points[inner]
    circle = fit_circle(points, fit=fit)
    return Circle(circle.x_px, circle.y_px, circle.diameter_px + OUTLINE_BIAS_PX)


def _inner(contour: Int32[ndarray, "n 2"], shape: tuple[int, ...]) -> Bool[ndarray, "n"]:
    """Tell which points are not on the picture's border."""
    return np.all((contour > 0) & (contour < (shape[1] - 1, shape[0] - 1)), axis=1)


def _is_inside(ball: Detection, picture: Picture) -> bool:
    height, width = picture.shape[:2]
    return 0 <= ball.x_px <= width - 1 and 0 <= ball.y_px <= height - 1
