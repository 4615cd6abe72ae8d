"""The circle of a ball's outline (section III); how it is fitted is a choice of `circles`.

The paper fits by "regularised least squares" with OpenCV, which is Kasa's circle with a ridge: it
changes nothing on a full outline, holds the centre near the points where a short arc leaves it
open, and keeps a line or a single pixel solvable.

Outlines as `cv2.findContours` returns them run through the centres of the outermost pixels inside
the ball, so the circle is too small: by about 0.37 px in radius on a sharp ball, more with gamma.
That bias is the paper's own (whole pixels on top of it reproduce Table I) and stays in
`fit_circle`; `OUTLINE_BIAS_PX` is what readers who want the ball itself add.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Int32, Shaped
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.vision.circles import FITS, CircleFit

ARC_TOLERANCE = 0.1  # of the radius
ARC_TOLERANCE_PX = 1.5  # steps between pixels
OUTLINE_BIAS_PX = 0.74  # what a sharp ball's outline lacks in diameter


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in the picture."""

    x_px: float
    y_px: float
    diameter_px: float


def fit_circle(
    outline: Shaped[ndarray, "n 2"], *, whole_pixels: bool = False, fit: CircleFit = "kasa"
) -> Circle:
    """Return the circle that fits outline points best.

    Args:
        outline: points (x, y) in pixels, in any order.
        whole_pixels: round the diameter to whole pixels, at least one: the steps of Fig. 4.
        fit: how.

    Raises:
        InputError: there is no point, or one is not finite.
    """
    points = np.asarray(outline, dtype=float)
    if len(points) == 0 or not np.isfinite(points).all():
        raise InputError(f"an outline needs at least one point, all finite; got {len(points)}")
    mean = points.mean(axis=0)
    offsets = points - mean
    scale = float(np.sqrt(np.mean(np.sum(offsets**2, axis=1)))) or 1.0
    a, b, radius = FITS[fit](offsets / scale)
    diameter = 2.0 * radius * scale
    if whole_pixels:
        diameter = float(max(1, round(diameter)))
    return Circle(float(mean[0] + a * scale), float(mean[1] + b * scale), diameter)


def outer_arc(outline: Int32[ndarray, "n 2"]) -> Int32[ndarray, "m 2"]:
    """Return the points of an outline that lie near the smallest circle around it.

    Where shade or a finger eats into a ball's colour, the rest of the outline still is its arc.
    """
    (x, y), radius = cv2.minEnclosingCircle(outline)
    distances = np.hypot(outline[:, 0] - x, outline[:, 1] - y)
    return outline[distances >= radius - max(ARC_TOLERANCE_PX, ARC_TOLERANCE * radius)]
