"""What in a picture may be a ball of a colour, and what speaks for it.

One channel, the tint, says of every pixel how much of the ball's colour it has, 0..255:

    balls with a hue         largest - least of blue, green, red, where the hue is within the
                             colour's limits (2 more on both sides), else 0
    bright ones without      2 least - largest: pale and bright; of the picture after a blur
    dark ones without        the same of the negative

No threshold on it is right for all balls, so all are tried, 10 to 12 levels apart: every connected
patch at every level whose enclosing circle it fills well enough is a candidate. So a ball is found
many times, and once at the level that tells it from its surroundings, be they grass, a hand or a
light floor. Candidates are described by 24 features of outline, contrast, edge, size and colour
(`FEATURES`), each without unit, so that one model (`ball_model`) can judge them in any picture.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Int32, UInt8
from numpy import ndarray

from rotorpong.conventions import Picture
from rotorpong.vision import _candidate_kernels as kernels
from rotorpong.vision.colour import HUES, Colour

Tint = UInt8[ndarray, "height width"]

HUE_MARGIN = 2
HUED_LEVELS, PALE_LEVELS = range(30, 250, 12), range(60, 250, 10)
HUED_LEAST, PALE_LEAST = 4, 8  # points of an outline
HUED_FILL, PALE_FILL = 0.35, 0.45  # of the enclosing circle
LARGEST = 0.5  # of the picture
LEAST_CONTRAST = 15.0  # between core and ring
DARK = 128  # typical value below which a ball without a hue is dark
LEAST_RADIUS_PX = 1.5
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
    "second",  # and the next one
    "contrast",  # log of core less ring
    "sharpness",  # lower quartile of the falls, saturating
    "weakest",  # lowest eighth of them
    "relative sharpness",  # lower quartile over contrast
    "offset",  # mean distance of steepest falls from the circle, radii
    "spread",  # its standard deviation
    "uneven",  # standard deviation in the core over contrast
    "size",  # log of diameter over 10 px
    "size squared",
    "level",  # threshold: 0 as the ring, 1 as the core
    "level squared",
    "saturation",  # of the core, over that of a typical ball (over 100 without a hue)
    "saturation squared",
    "value",  # of the core, over that of a typical ball
    "unseen",  # share of the sides beyond the picture
)


@dataclass(frozen=True, slots=True)
class Candidates:
    """Patches of a picture that may be balls of one colour."""

    contours: list[Int32[ndarray, "_ 2"]]  # centres of their outermost pixels
    circles: Float[ndarray, "n 3"]  # around them: centre, diameter, px
    features: Float[ndarray, "n 24"]  # in the order of FEATURES


@dataclass(frozen=True, slots=True)
class _Patch:
    contour: ndarray  # as OpenCV returns it
    x_px: float
    y_px: float
    radius_px: float  # of the enclosing circle of pixel centres
    level: int
    pixels: float
    fill: float


def find_candidates(picture: Picture, colour: Colour) -> Candidates:
    """Return all that may be balls of a colour.

    Args:
        picture: 8-bit BGR.
        colour: of the balls.
    """
    tint = tint_of(picture, colour)
    patches = _patches(tint, colour)
    circles = np.array(
        [(p.x_px, p.y_px, max(p.radius_px, LEAST_RADIUS_PX)) for p in patches]
    ).reshape(-1, 3)
    measures = np.empty((len(patches), kernels.MEASURES))
    kernels.describe(measures, tint, picture, circles)
    plain = measures[:, kernels.CORE_MEAN] - measures[:, kernels.RING_MEAN] >= LEAST_CONTRAST
    kept = [patch for patch, is_plain in zip(patches, plain, strict=True) if is_plain]
    circles[:, 2] *= 2.0
    features = np.column_stack([_outlines(kept), _contrasts(measures[plain], kept, colour)])
    contours = [patch.contour[:, 0].astype(np.int32) for patch in kept]
    return Candidates(contours, circles[plain], features)


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


def _patches(tint: Tint, colour: Colour) -> list[_Patch]:
    """Return the patches of all levels that fill their circles."""
    most = int(tint.max())
    levels = HUED_LEVELS if colour.has_hue else PALE_LEVELS
    found = []
    for level in levels:
        if level > most:
            break
        _, mask = cv2.threshold(tint, level - 1, 255, cv2.THRESH_BINARY)
        contours, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        found += [_patch(contour, level, tint.size, colour) for contour in contours]
    return [patch for patch in found if patch is not None]


def _patch(contour: ndarray, level: int, size: int, colour: Colour) -> _Patch | None:
    """Return a patch, `None` if it is too small, too large or not round."""
    least, fill = (HUED_LEAST, HUED_FILL) if colour.has_hue else (PALE_LEAST, PALE_FILL)
    if len(contour) < least:
        return None
    pixels = cv2.contourArea(contour) + len(contour) / 2 + 1  # Pick
    if pixels > LARGEST * size:
        return None
    (x, y), radius = cv2.minEnclosingCircle(contour)
    filled = min(pixels / (math.pi * (radius + 0.5) ** 2), 1.0)
    return _Patch(contour, x, y, radius + 0.37, level, pixels, filled) if filled >= fill else None


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
        float(np.mean(away >= patch.radius_px - 0.37 - slack)),
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
    measures: Float[ndarray, "n _"], patches: list[_Patch], colour: Colour
) -> Float[ndarray, "n 19"]:
    """Return the features of contrast, edge, size and colour."""
    core, ring = measures[:, kernels.CORE_MEAN], measures[:, kernels.RING_MEAN]
    contrast = core - ring
    eighth, quarter = measures[:, kernels.EDGE_EIGHTH], measures[:, kernels.EDGE_QUARTER]
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
            np.clip((measures[:, kernels.RING_SECOND] - ring) / contrast, 0.0, 1.5),
            np.log(contrast / TYPICAL_CONTRAST),
            _saturating(quarter),
            _saturating(eighth),
            np.clip(quarter / contrast, -0.5, 1.5),
            measures[:, kernels.EDGE_OFFSET],
            measures[:, kernels.EDGE_SPREAD],
            np.clip(measures[:, kernels.CORE_SD] / contrast, 0.0, 1.0),
            size,
            size**2,
            level,
            level**2,
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
    """Return both of the core, over those of a typical ball."""
    pixels = measures[:, kernels.BLUE : kernels.RED + 1]
    value = pixels.max(axis=1)
    saturation = 255.0 * (value - pixels.min(axis=1)) / np.maximum(value, 1.0)
    if not colour.has_hue:
        return saturation / 100.0, np.minimum(value / max(colour.typical[2], 1), 1.1)
    typical = max(colour.typical[1], 1), max(colour.typical[2], 1)
    return np.minimum(saturation / typical[0], 1.1), np.minimum(value / typical[1], 1.1)
