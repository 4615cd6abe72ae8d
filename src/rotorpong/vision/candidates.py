"""What in a picture may be a ball of a colour, and what speaks for it.

One channel, the tint, says of every pixel how much of the ball's colour it has, 0..255:

    balls with a hue         largest - least of blue, green, red, where the hue is within the
                             colour's limits (2 more on both sides), else 0
    bright ones without      2 least - largest: pale and bright; of the picture after a blur
    dark ones without        the same of the negative

No threshold on it is right for all balls, so all are tried, 10 to 12 levels apart: every connected
patch at every level whose enclosing circle it fills well enough, and with a pixel of the colour's
core, is a candidate. So a ball is found many times, and once at the level that tells it from its
surroundings, be they grass, a hand or a light floor. Only the box around all cores is searched, and
as much around it as a ball may go on. Candidates are described by 22 features of outline, contrast,
edge, size and colour (`FEATURES`), each without unit, so that one model (`ball_model`) can judge
them in any picture.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Int32, UInt8
from numpy import ndarray

from rotorpong.conventions import Picture
from rotorpong.vision import _candidate_kernels as kernels
from rotorpong.vision._search_kernels import find_reach
from rotorpong.vision.colour import HUES, Colour

Tint = UInt8[ndarray, "height width"]

HUE_MARGIN = 2
HUED_LEVELS, PALE_LEVELS = range(30, 250, 12), range(60, 250, 10)
HUED_LEAST, PALE_LEAST = 4, 8  # points of an outline
HUED_FILL, PALE_FILL = 0.35, 0.45  # least share of the enclosing circle
LARGEST = 0.5  # of the picture
LEAST_CONTRAST = 15.0  # between core and ring
DARK = 128  # typical value below which a ball without a hue is dark
LEAST_RADIUS_PX = 1.5
BEYOND_PX = 0.37  # beyond the centres of its outermost pixels, a patch goes on
LEAST_ROOM_PX = 64  # around cores
ON_CIRCLE, ON_CIRCLE_PX = 0.1, 1.0  # within so much of the enclosing circle: of its radius, px
CORNER, CORNER_PX = 0.12, 0.7  # what a polygon may leave out: of the radius, px
MOST_CORNERS = 9
SIZE_PX = 10.0
STEEP = 20.0  # fall over two pixels at which an edge is half as good as it can be
TYPICAL_CONTRAST = 60.0
PIXEL_VARIANCE = 1.0 / 12.0

FEATURES = (
    "fill",  # log of the share of the enclosing circle
    "axes",  # shorter over longer axis of the outline
    "arc",  # share of the outline near the enclosing circle
    "solid",  # log of (1.03 - share of the convex hull)
    "corners",  # of a polygon that follows the outline, over 9
    "outside",  # log of (1.03 - share of sides that are below the middle outside)
    "sides",  # share of the sides that the outline parts
    "worst",  # ring's sector most like the core: 0 as the ring, 1 as the core
    "contrast",  # log of core less ring
    "sharpness",  # lower quartile of the falls, saturating
    "relative sharpness",  # lower quartile over contrast
    "offset",  # mean distance of the steepest falls from the circle, radii
    "uneven",  # standard deviation in the core over contrast
    "size",  # log of diameter over 10 px
    "size squared",
    "size x arc",  # outlines tell more of large balls
    "size x corners",
    "level",  # threshold: 0 as the ring, 1 as the core
    "saturation",  # of the core: log of that over a typical ball's (over 100 without a hue)
    "saturation squared",
    "value",  # of the core, over that of a typical ball
    "unseen",  # share of the sides beyond the picture
)


@dataclass(frozen=True, slots=True)
class Candidates:
    """Patches of a picture that may be balls of one colour."""

    contours: list[Int32[ndarray, "_ 2"]]  # centres of their outermost pixels
    circles: Float[ndarray, "n 3"]  # around them: centre, diameter, px
    features: Float[ndarray, "n 22"]  # in the order of FEATURES


@dataclass(frozen=True, slots=True)
class _Patch:
    contour: ndarray  # as OpenCV returns it
    x_px: float
    y_px: float
    radius_px: float  # of the enclosing circle
    level: int
    pixels: float
    fill: float

    @property
    def box(self) -> tuple[slice, slice]:
        """Its rows and columns."""
        left, top, across, down = cv2.boundingRect(self.contour)
        return slice(top, top + down), slice(left, left + across)


def find_candidates(picture: Picture, colour: Colour) -> Candidates:
    """Return all that may be balls of a colour.

    Args:
        picture: 8-bit BGR.
        colour: of the balls.
    """
    left, top, right, bottom = _region(picture, colour)
    part = np.ascontiguousarray(picture[top:bottom, left:right])
    if not part.size:
        return Candidates([], np.empty((0, 3)), np.empty((0, len(FEATURES))))
    tint = tint_of(part, colour)
    patches = _patches(tint, _core(part, colour), colour)
    circles = np.array(
        [(p.x_px, p.y_px, max(p.radius_px, LEAST_RADIUS_PX)) for p in patches]
    ).reshape(-1, 3)
    measures = np.empty((len(patches), kernels.MEASURES))
    kernels.describe(measures, tint, part, circles)
    plain = measures[:, kernels.CORE_MEAN] - measures[:, kernels.RING_MEAN] >= LEAST_CONTRAST
    kept = [patch for patch, is_plain in zip(patches, plain, strict=True) if is_plain]
    outlines = _outlines(kept)
    features = np.column_stack([outlines, _contrasts(measures[plain], outlines, kept, colour)])
    corner = np.array((left, top), np.int32)
    contours = [patch.contour[:, 0] + corner for patch in kept]
    return Candidates(contours, circles[plain] * (1, 1, 2) + (left, top, 0), features)


def _region(picture: Picture, colour: Colour) -> tuple[int, int, int, int]:
    """Return the box (x0, y0, x1, y1) around all cores, with room for the rest of the balls."""
    height, width = picture.shape[:2]
    reach = np.empty(4, np.int64)
    limits = np.array([colour.core, colour.upper], np.float32)
    find_reach(reach, picture.reshape(height, 3 * width), limits[0], limits[1])
    left, top, right, bottom = reach.tolist()
    if left >= right:
        return 0, 0, 0, 0
    room = max(LEAST_ROOM_PX, right - left, bottom - top)
    return max(left - room, 0), max(top - room, 0), right + room, bottom + room


def _core(picture: Picture, colour: Colour) -> Tint:
    """Return 255 where a pixel is of a colour's core."""
    return cv2.inRange(cv2.cvtColor(picture, cv2.COLOR_BGR2HSV), colour.core, colour.upper)


def tint_of(picture: Picture, colour: Colour) -> Tint:
    """Return how much of a colour each pixel has."""
    if colour.has_hue:
        tint = np.empty(picture.shape[:2], np.uint8)
        lowest = (colour.lower[0] - HUE_MARGIN) % HUES
        width = colour.upper[0] - colour.lower[0] + 2 * HUE_MARGIN
        kernels.write_tint(tint, picture, float(lowest), float(width))
        return tint
    blurred = cv2.GaussianBlur(picture, (3, 3), 0)
    blue, green, red = cv2.split(blurred if colour.typical[2] >= DARK else cv2.bitwise_not(blurred))
    least = cv2.min(cv2.min(blue, green), red)
    return cv2.subtract(least, cv2.subtract(cv2.max(cv2.max(blue, green), red), least))


def _patches(tint: Tint, core: Tint, colour: Colour) -> list[_Patch]:
    """Return the patches of all levels that fill their circles and have a pixel of the core."""
    most = int(tint.max())
    levels = HUED_LEVELS if colour.has_hue else PALE_LEVELS
    least, fill = (HUED_LEAST, HUED_FILL) if colour.has_hue else (PALE_LEAST, PALE_FILL)
    found = []
    for level in levels:
        if level > most:
            break
        _, mask = cv2.threshold(tint, level - 1, 255, cv2.THRESH_BINARY)
        contours, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        enough = [contour for contour in contours if len(contour) >= least]
        patches = [_patch(contour, level, tint.size, fill) for contour in enough]
        cv2.bitwise_and(mask, core, mask)
        found += [p for p in patches if p is not None and cv2.countNonZero(mask[p.box])]
    return found


def _patch(contour: ndarray, level: int, size: int, least_fill: float) -> _Patch | None:
    """Return a patch, `None` if it is too large or not round."""
    pixels = cv2.contourArea(contour) + len(contour) / 2 + 1  # Pick
    _, _, across, down = cv2.boundingRect(contour)
    if pixels > LARGEST * size or _fill(pixels, max(across, down) / 2) < least_fill:
        return None  # the circle is no smaller than the box
    (x, y), radius = cv2.minEnclosingCircle(contour)
    fill = _fill(pixels, radius + 0.5)
    if fill < least_fill:
        return None
    return _Patch(contour, x, y, radius + BEYOND_PX, level, pixels, fill)


def _fill(pixels: float, radius: float) -> float:
    return min(pixels / (math.pi * radius**2), 1.0)


def _outlines(patches: list[_Patch]) -> Float[ndarray, "n 5"]:
    """Return the features of outlines."""
    return np.array([_outline(patch) for patch in patches]).reshape(-1, 5)


def _outline(patch: _Patch) -> tuple[float, float, float, float, float]:
    points = patch.contour[:, 0].astype(float)
    away = np.hypot(points[:, 0] - patch.x_px, points[:, 1] - patch.y_px)
    slack = max(ON_CIRCLE_PX, ON_CIRCLE * patch.radius_px)
    hull = cv2.contourArea(cv2.convexHull(patch.contour)) + len(points) / 2 + 1
    tolerance = max(CORNER * patch.radius_px, CORNER_PX)
    corners = min(len(cv2.approxPolyDP(patch.contour, tolerance, True)), MOST_CORNERS)  # noqa: FBT003
    return (
        math.log(patch.fill),
        _axes(points),
        float(np.mean(away >= patch.radius_px - BEYOND_PX - slack)),
        math.log(1.03 - min(patch.pixels / hull, 1.0)),
        corners / MOST_CORNERS,
    )


def _axes(points: Float[ndarray, "n 2"]) -> float:
    """Return the shorter over the longer axis of points, each a pixel wide."""
    x, y = (points - points.mean(axis=0)).T
    xx, yy, xy = x @ x / len(x), y @ y / len(x), x @ y / len(x)
    mean, half = (xx + yy) / 2.0 + PIXEL_VARIANCE, math.hypot((xx - yy) / 2.0, xy)
    return math.sqrt(max(mean - half, 0.0) / (mean + half))


def _contrasts(
    measures: Float[ndarray, "n _"],
    outlines: Float[ndarray, "n 5"],
    patches: list[_Patch],
    colour: Colour,
) -> Float[ndarray, "n 17"]:
    """Return the features of contrast, edge, size and colour."""
    core, ring = measures[:, kernels.CORE_MEAN], measures[:, kernels.RING_MEAN]
    contrast = core - ring
    quarter = measures[:, kernels.EDGE_QUARTER]
    levels = np.array([patch.level for patch in patches], float)
    radii = np.array([patch.radius_px for patch in patches], float)
    size = np.log(2.0 * radii / SIZE_PX)
    level = np.clip((levels - ring) / contrast, -0.5, 1.5)
    saturation, value = _saturation_and_value(measures, colour)
    return np.column_stack(
        [
            np.log(1.03 - measures[:, kernels.OUTSIDE_BELOW]),
            measures[:, kernels.BOTH_SIDES],
            np.clip((measures[:, kernels.RING_WORST] - ring) / contrast, 0.0, 1.5),
            np.log(contrast / TYPICAL_CONTRAST),
            _saturating(quarter),
            np.clip(quarter / contrast, -0.5, 1.5),
            measures[:, kernels.EDGE_OFFSET],
            np.clip(measures[:, kernels.CORE_SD] / contrast, 0.0, 1.0),
            size,
            size**2,
            size * outlines[:, FEATURES.index("arc")],
            size * outlines[:, FEATURES.index("corners")],
            level,
            saturation,
            saturation**2,
            value,
            1.0 - measures[:, kernels.SEEN],
        ]
    )


def _saturating(fall: Float[ndarray, "n"]) -> Float[ndarray, "n"]:
    fall = np.maximum(fall, 0.0)
    return fall / (fall + STEEP)


def _saturation_and_value(
    measures: Float[ndarray, "n _"], colour: Colour
) -> tuple[Float[ndarray, "n"], Float[ndarray, "n"]]:
    """Return the features of both, of the core."""
    pixels = measures[:, kernels.BLUE : kernels.RED + 1]
    value = pixels.max(axis=1)
    saturation = 255.0 * (value - pixels.min(axis=1)) / np.maximum(value, 1.0)
    if not colour.has_hue:
        return saturation / 100.0, np.minimum(value / max(colour.typical[2], 1), 1.1)
    typical = max(colour.typical[1], 1), max(colour.typical[2], 1)
    saturation = np.log(np.clip(saturation / typical[0], 0.1, 1.1))
    return saturation, np.minimum(value / typical[1], 1.1)
