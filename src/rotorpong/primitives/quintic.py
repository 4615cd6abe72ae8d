"""Polynomials of fifth order through two states, Eq. (5).

    g(x) = sum_i c_i x^i, i = 0..5, x in [0, 1]                             Eq. (5)

A state is a stack (position, velocity, acceleration) of derivatives with respect to x; for a motion
of duration T multiply a velocity in m/s by T and an acceleration in m/s^2 by T^2. Any shape may
follow the first axis.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray


def quintic_coefficients(
    start: Float[ndarray, "3 *shape"], end: Float[ndarray, "3 *shape"]
) -> Float[ndarray, "6 *shape"]:
    """Return c_0..c_5 of the quintic that leaves `start` at x = 0 and meets `end` at x = 1."""
    p0, v0, a0 = start
    p1, v1, a1 = end
    d = p1 - p0
    c3 = 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    c5 = 6 * d - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1
    return np.stack([p0, v0, 0.5 * a0, c3, c4, c5])


def quintic_value(
    coefficients: Float[ndarray, "6 *shape"], x: Float[ndarray, "..."]
) -> Float[ndarray, "..."]:
    """Return g(x); `x` broadcasts against the coefficients' trailing shape."""
    c0, c1, c2, c3, c4, c5 = coefficients
    return c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))


def quintic_slope(
    coefficients: Float[ndarray, "6 *shape"], x: Float[ndarray, "..."]
) -> Float[ndarray, "..."]:
    """Return dg/dx."""
    _, c1, c2, c3, c4, c5 = coefficients
    return c1 + x * (2 * c2 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5)))


def quintic_curvature(
    coefficients: Float[ndarray, "6 *shape"], x: Float[ndarray, "..."]
) -> Float[ndarray, "..."]:
    """Return d^2 g/dx^2."""
    _, _, c2, c3, c4, c5 = coefficients
    return 2 * c2 + x * (6 * c3 + x * (12 * c4 + x * 20 * c5))
