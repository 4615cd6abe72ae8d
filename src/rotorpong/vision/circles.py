"""Four ways to put a circle through points, for outlines that are not full.

A circle is A (x^2 + y^2) + B x + C y + D = 0 with radius sqrt(B^2 + C^2 - 4 A D) / 2 |A|. With z =
x^2 + y^2 in coordinates centred on the mean point and scaled by the rms distance from it, all
least squares over the points:

    kasa       A = 1, the rest free, with a ridge on the centre          sum (z + B x + C y + D)^2
    pratt      the same sum, with A free, over B^2 + C^2 - 4 A D
    taubin     the same sum, over its mean squared gradient
    geometric  sum (distance to the circle)^2, by Gauss-Newton steps from Taubin's circle

On a full outline they agree to hundredths of a pixel. Of a short arc Kasa's circle comes out too
small, for its sum weighs points by the radius; the others do not have that bias (Chernov, "Circular
and linear regression", 2010). A line, a point or two have no circle by the last three: they get
Kasa's, which its ridge keeps finite.
"""

from collections.abc import Callable, Mapping
from typing import Literal

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray

CircleFit = Literal["kasa", "pratt", "taubin", "geometric"]
Points = Float[ndarray, "n 2"]  # centred and scaled
Found = tuple[float, float, float]  # centre and radius

RIDGE = 1e-6  # per point
LARGEST = 1e3  # radius, in rms distances: straighter is a line
STEPS, CONVERGED = 30, 1e-12


def kasa(points: Points) -> Found:
    """Return Kasa's circle, with a ridge."""
    design = np.column_stack([2.0 * points, np.ones(len(points))])
    squares = np.sum(points**2, axis=1)
    ridge = len(points) * RIDGE * np.diag([1.0, 1.0, 0.0])
    moments = (design.T @ squares)[:, None]
    _, solution = cv2.solve(design.T @ design + ridge, moments, flags=cv2.DECOMP_CHOLESKY)
    a, b, c = (float(value) for value in solution[:, 0])
    return a, b, float(np.sqrt(max(c + a * a + b * b, 0.0)))


def pratt(points: Points) -> Found:
    """Return Pratt's circle."""
    design = np.column_stack([np.sum(points**2, axis=1), points, np.ones(len(points))])
    constraint = np.zeros((4, 4))
    constraint[1, 1] = constraint[2, 2] = 1.0
    constraint[0, 3] = constraint[3, 0] = -2.0
    return _smallest(design, constraint) or kasa(points)


def taubin(points: Points) -> Found:
    """Return Taubin's circle."""
    squares = np.sum(points**2, axis=1)
    design = np.column_stack([squares, points, np.ones(len(points))])
    x, y = points.mean(axis=0)
    constraint = np.array(
        [
            [4.0 * squares.mean(), 2.0 * x, 2.0 * y, 0.0],
            [2.0 * x, 1.0, 0.0, 0.0],
            [2.0 * y, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0],
        ]
    )
    return _smallest(design, constraint) or kasa(points)


def geometric(points: Points) -> Found:
    """Return the circle nearest to the points."""
    a, b, radius = taubin(points)
    for _ in range(STEPS):
        away = points - [a, b]
        distances = np.maximum(np.linalg.norm(away, axis=1), 1e-12)
        slopes = np.column_stack([-away / distances[:, None], -np.ones(len(points))])
        step = np.linalg.lstsq(slopes, radius - distances, rcond=1e-9)[0]
        a, b, radius = a + float(step[0]), b + float(step[1]), radius + float(step[2])
        if step @ step < CONVERGED:
            break
    return (a, b, radius) if np.isfinite(radius) and 0.0 <= radius < LARGEST else kasa(points)


FITS: Mapping[CircleFit, Callable[[Points], Found]] = {
    "kasa": kasa,
    "pratt": pratt,
    "taubin": taubin,
    "geometric": geometric,
}


def _smallest(design: Float[ndarray, "n 4"], constraint: Float[ndarray, "4 4"]) -> Found | None:
    """Return the circle q with the least q' M q at q' N q = 1; `None` if that is a line.

    The generalised eigenvalue problem M q = e N q; N is indefinite, so it is solved as one of
    1 / e: M is positive where there is noise.
    """
    moments = design.T @ design / len(design) + 1e-15 * np.eye(4)
    values, vectors = np.linalg.eig(np.linalg.solve(moments, constraint))
    k = int(np.argmax(np.real(values)))
    a, b, c, d = np.real(vectors[:, k])
    if np.real(values[k]) <= 0.0 or abs(a) < 1e-12:
        return None
    x, y = -b / (2.0 * a), -c / (2.0 * a)
    radius = float(np.sqrt(max(b * b + c * c - 4.0 * a * d, 0.0)) / (2.0 * abs(a)))
    return (float(x), float(y), radius) if radius < LARGEST else None
