"""The circle of a ball's outline, by regularised least squares solved with OpenCV (section III).

A circle with centre (a, b) and radius r satisfies, in coordinates centred on the outline's mean
point and scaled by its rms distance from it,

    x^2 + y^2 = 2 a x + 2 b y + c,    c = r^2 - a^2 - b^2

which is linear in (a, b, c). Least squares over all outline points with a ridge on (a, b) gives
the circle: the ridge changes nothing on a full outline, holds the centre near the points where a
short arc leaves it open, and keeps a line or a single pixel solvable.

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

RIDGE = 1e-6  # per point, against coordinates of unit rms distance
ARC_TOLERANCE = 0.1  # of the radius
ARC_TOLERANCE_PX = 1.5  # steps between pixels
OUTLINE_BIAS_PX = 0.74  # what a sharp ball's outline lacks in diameter


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in the picture."""

    x_px: float
    y_px: float
    diameter_px: float


def fit_circle(outline: Shaped[ndarray, "n 2"], *, whole_pixels: bool = False) -> Circle:
    """Return the circle that fits outline points best.

    Args:
        outline: points (x, y) in pixels, in any order.
        whole_pixels: round the diameter to whole pixels, at least one: the steps of Fig. 4.

    Raises:
        InputError: there is no point, or one is not finite.
    """
    points = np.asarray(outline, dtype=float)
    if len(points) == 0 or not np.isfinite(points).all():
        raise InputError(f"an outline needs at least one point, all finite; got {len(points)}")
    mean = points.mean(axis=0)
    offsets = points - mean
    scale = float(np.sqrt(np.mean(np.sum(offsets**2, axis=1)))) or 1.0
    a, b, radius = _solve(offsets / scale)
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


def _solve(points: Shaped[ndarray, "n 2"]) -> tuple[float, float, float]:
    design = np.column_stack([2.0 * points, np.ones(len(points))])
    squares = np.sum(points**2, axis=1)
    ridge = len(points) * RIDGE * np.diag([1.0, 1.0, 0.0])
    moments = (design.T @ squares)[:, None]
    _, solution = cv2.solve(design.T @ design + ridge, moments, flags=cv2.DECOMP_CHOLESKY)
    a, b, c = (float(value) for value in solution[:, 0])
    return a, b, float(np.sqrt(max(c + a * a + b * b, 0.0)))
