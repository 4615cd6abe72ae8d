"""From a demonstrated trajectory to a primitive, in two ways.

"position": the closed form s = g + Phi theta is linear in everything that is unknown, so the states
at both ends and theta come from one penalised least-squares fit to the positions,

    min |y - H b - Phi theta|^2 + lambda |theta|^2  with  Phi(1) theta = Phi'(1) theta = 0,

H being the quintics of unit position or velocity at either end. The constraint makes every
roll-out end exactly at its goal; lambda is that of least generalised cross-validation (Golub,
Heath, Wahba 1979), for each coordinate by itself.

"lwr" (the paper, section IV.A.2): the demonstration is differentiated twice, Eq. (4) is solved for
u, and each weight is a locally weighted regression by itself, theta_k = sum w z u / sum w z^2 with
the bell of basis k as w. It meets its goal only about, and amplifies noise.
"""

from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike

from rotorpong.conventions import InputError
from rotorpong.primitives.basis import (
    DAMPING,
    STIFFNESS,
    activations,
    phase,
    response_table,
)
from rotorpong.primitives.dmp import Dmp, Motion
from rotorpong.primitives.quintic import (
    quintic_coefficients,
    quintic_curvature,
    quintic_slope,
    quintic_value,
)

METHODS = ("position", "lwr")
BASIS_RANGE = (4, 100)
MINIMUM_SAMPLES = 5  # one more than the unknown ends
SMALLEST_FREEDOM = 0.5  # of the samples, that a fit leaves to their noise
RIDGES = np.logspace(2, -18, 81)  # relative to the largest eigenvalue; ties go to the smoother


def fit_dmp(
    times: ArrayLike,
    positions: ArrayLike,
    *,
    basis: int = 20,
    method: Literal["position", "lwr"] = "position",
    velocities: ArrayLike | None = None,
) -> Dmp:
    """Return the primitive whose roll-out between the demonstration's ends is the demonstration.

    Args:
        times: (n,) s, increasing; any origin.
        positions: (n, d) m.
        basis: how many basis functions.
        method: "position" or "lwr", see above.
        velocities: (n, d) m/s, if they were measured: "position" takes those of both ends instead
            of estimating them, "lwr" differentiates them once instead of the positions twice.

    Raises:
        InputError: times not increasing, fewer than 5 samples, a number that is not finite, shapes
            that do not agree, an unknown method or number of bases.
    """
    if method not in METHODS:
        raise InputError(f"method {method!r}: expected one of {', '.join(METHODS)}")
    if not BASIS_RANGE[0] <= basis <= BASIS_RANGE[1]:
        raise InputError(f"basis {basis}: expected {BASIS_RANGE[0]} to {BASIS_RANGE[1]}")
    t, y, v = _demonstration(times, positions, velocities)
    duration = float(t[-1] - t[0])
    x = (t - t[0]) / duration
    slopes = None if v is None else v * duration
    if method == "lwr":
        weights, ends = _force_fit(x, y, slopes, basis)
    else:
        weights, ends = _position_fit(x, y, slopes, basis)
    position, slope = ends[::2], ends[1::2]
    return Dmp(weights, ends=Motion(np.array([0.0, duration]), position, slope / duration))


def _demonstration(
    times: ArrayLike, positions: ArrayLike, velocities: ArrayLike | None
) -> tuple[ndarray, ndarray, ndarray | None]:
    t = _finite("times", times, dimensions=1)
    y = _finite("positions", positions, dimensions=2)
    if len(t) != len(y) or y.shape[1] == 0:
        raise InputError(f"positions of shape {y.shape}: expected ({len(t)}, d), one per time")
    if len(t) < MINIMUM_SAMPLES:
        raise InputError(f"{len(t)} samples: expected at least {MINIMUM_SAMPLES}")
    if not (np.diff(t) > 0.0).all():
        first = int(np.argmin(np.diff(t) > 0.0))
        raise InputError(f"times: expected increasing, sample {first + 1} does not follow {first}")
    if velocities is None:
        return t, y, None
    v = _finite("velocities", velocities, dimensions=2)
    if v.shape != y.shape:
        raise InputError(f"velocities of shape {v.shape}: expected {y.shape}, as the positions")
    return t, y, v


def _finite(name: str, values: ArrayLike, *, dimensions: int) -> ndarray:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers ({error})") from error
    if array.ndim != dimensions:
        raise InputError(f"{name} of shape {array.shape}: expected {dimensions} dimension(s)")
    if not np.isfinite(array).all():
        raise InputError(f"{name}: {(~np.isfinite(array)).sum()} not finite, expected none")
    return array


def _position_fit(
    x: Float[ndarray, "n"],
    y: Float[ndarray, "n d"],
    slopes: Float[ndarray, "n d"] | None,
    basis: int,
) -> tuple[Float[ndarray, "basis d"], Float[ndarray, "4 d"]]:
    """Return theta and the ends (position, slope, position, slope)."""
    ends = np.zeros((4, y.shape[1]))
    hermite = _end_quintics(x)
    unknown = [0, 1, 2, 3]
    if slopes is not None:
        unknown = [0, 2]
        ends[1::2] = slopes[[0, -1]]
    response = _response(x, basis)
    free = _harmless(basis)
    rest = y - hermite @ ends
    theta = free @ _ridge(hermite[:, unknown], response @ free, rest)
    ends[unknown] = np.linalg.lstsq(hermite[:, unknown], rest - response @ theta, rcond=None)[0]
    return theta, ends


def _end_quintics(x: Float[ndarray, "n"]) -> Float[ndarray, "n 4"]:
    """Return the quintics of unit start position, start slope, end position and end slope."""
    start, end = np.zeros((2, 3, 4))
    start[0, 0] = start[1, 1] = end[0, 2] = end[1, 3] = 1.0
    coefficients = quintic_coefficients(start, end)
    return quintic_value(coefficients[:, None, :], x[:, None])


def _response(x: Float[ndarray, "n"], basis: int) -> Float[ndarray, "n basis"]:
    table = response_table(basis)
    pieces = table.shape[1]
    piece = np.minimum((x * pieces).astype(np.intp), pieces - 1)
    return quintic_value(table[:, piece], (x * pieces - piece)[:, None])


def _harmless(basis: int) -> Float[ndarray, "basis free"]:
    """Return an orthonormal basis of the weights that leave the end of a motion alone."""
    last = response_table(basis)[:, -1]
    one = np.array(1.0)
    effects = np.stack([quintic_value(last, one), quintic_slope(last, one)])
    return np.linalg.svd(effects)[2][2:].T


def _ridge(
    plain: Float[ndarray, "n p"], penalised: Float[ndarray, "n q"], y: Float[ndarray, "n d"]
) -> Float[ndarray, "q d"]:
    """Return the penalised coefficients, each column of `y` with its own best ridge."""
    span = np.linalg.qr(plain)[0]
    u, s, vt = np.linalg.svd(penalised - span @ (span.T @ penalised), full_matrices=False)
    residual = y - span @ (span.T @ y)
    scores = u.T @ residual
    ridges = RIDGES[:, None] * s[0] ** 2
    lost = ridges / (s**2 + ridges)  # (ridge, q)
    outside = np.sum(residual**2, axis=0) - np.sum(scores**2, axis=0)
    errors = lost**2 @ scores**2 + np.maximum(outside, 0.0)
    freedom = len(y) - plain.shape[1] - len(s) + lost.sum(axis=1, keepdims=True)
    left = np.maximum(freedom, SMALLEST_FREEDOM)
    criterion = np.where(freedom < SMALLEST_FREEDOM, np.inf, errors / left**2)
    best = np.argmin(criterion, axis=0)
    return vt.T @ (s[:, None] / (s[:, None] ** 2 + ridges[best].T) * scores)


def _force_fit(
    x: Float[ndarray, "n"],
    y: Float[ndarray, "n d"],
    slopes: Float[ndarray, "n d"] | None,
    basis: int,
) -> tuple[Float[ndarray, "basis d"], Float[ndarray, "4 d"]]:
    """Return theta and the ends (position, slope, position, slope)."""
    slope = np.gradient(y, x, axis=0, edge_order=2) if slopes is None else slopes
    curvature = np.gradient(slope, x, axis=0, edge_order=2)
    rest = np.zeros(y.shape[1])
    target = quintic_coefficients(
        np.array([y[0], slope[0], rest]), np.array([y[-1], slope[-1], rest])
    )[:, None, :]
    lag = y - quintic_value(target, x[:, None])
    lag_slope = slope - quintic_slope(target, x[:, None])
    lag_curvature = curvature - quintic_curvature(target, x[:, None])
    u = lag_curvature + STIFFNESS * (lag_slope + DAMPING * lag)
    z = phase(x)
    bells = activations(z, basis).T
    theta = (bells * z) @ u / np.maximum((bells * z) @ z, np.finfo(float).tiny)[:, None]
    return theta, np.array([y[0], slope[0], y[-1], slope[-1]])
