"""What the kernel regressions share: samples checked at the door, their kernel and its factor."""

# ruff: noqa: N803  (X is scikit-learn's name)

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, cholesky
from scipy.spatial.distance import cdist

from rotorpong.conventions import InputError

NOISE_FLOOR = 1e-10  # least lambda c_n: duplicated samples still factorise at N = 2000
JITTERS = (0.0, *(10.0**k for k in range(-9, 1)))  # added to the noise until it factorises


def gaussian_kernel(
    a: Float[ndarray, "n m"], b: Float[ndarray, "k m"], length_scales: Float[ndarray, "m"]
) -> Float[ndarray, "n k"]:
    """Return exp(-|a - b|^2 / 2) of every row of `a` with every row of `b`."""
    return np.exp(-0.5 * cdist(a / length_scales, b / length_scales, "sqeuclidean"))


def checked_samples(
    X: ArrayLike, y: ArrayLike, cost: ArrayLike | None
) -> tuple[Float[ndarray, "n m"], Float[ndarray, "n *k"], Float[ndarray, "n"]]:
    """Return samples, labels and costs as arrays.

    Raises:
        InputError: no samples, what is no number or not finite, shapes that do not agree, a
            negative cost.
    """
    samples, labels = matrix("X", X), finite("y", y)
    if not len(samples):
        raise InputError("X has no samples: expected at least one")
    if labels.ndim not in (1, 2) or len(labels) != len(samples) or labels.size == 0:
        raise InputError(
            f"y of shape {labels.shape}: expected ({len(samples)},) or ({len(samples)}, outputs)"
        )
    return samples, labels, column("cost", cost, len(samples))


def matrix(name: str, values: ArrayLike) -> Float[ndarray, "n m"]:
    """Return `values` as an array (samples, features)."""
    array = finite(name, values)
    if array.ndim != 2 or array.shape[1] == 0:
        raise InputError(f"{name} of shape {array.shape}: expected (samples, features)")
    return array


def column(name: str, values: ArrayLike | None, n: int) -> Float[ndarray, "n"]:
    """Return `values` as a vector of n numbers, none negative; 1 each if there are none."""
    if values is None:
        return np.ones(n)
    array = finite(name, values)
    if array.shape != (n,):
        raise InputError(f"{name} of shape {array.shape}: expected ({n},), one per sample")
    if (array < 0.0).any():
        raise InputError(f"{name} {array.min()}: expected none negative")
    return array


def finite(name: str, values: ArrayLike) -> ndarray:
    """Return `values` as an array of finite floats, copied."""
    try:
        given = np.asarray(values)
        array = given.astype(float, casting="unsafe" if given.dtype == object else "same_kind")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers ({error})") from error
    if not np.isfinite(array).all():
        raise InputError(f"{name}: {(~np.isfinite(array)).sum()} not finite, expected none")
    return array


def checked_length_scales(values: ArrayLike, features: int) -> Float[ndarray, "m"]:
    """Return one length scale per feature."""
    scales = finite("length_scales", values)
    if scales.shape not in ((), (features,)) or not (scales > 0.0).all():
        raise InputError(f"length_scales {values}: expected 1 or {features} positive numbers")
    return np.broadcast_to(scales, (features,))


def checked_regularization(value: float) -> float:
    """Return lambda."""
    number = finite("regularization", value)
    if number.shape != () or number < 0.0:
        raise InputError(f"regularization {value}: expected a number, not negative")
    return float(number)


def checked_output_scales(values: ArrayLike, outputs: tuple[int, ...]) -> Float[ndarray, "*k"]:
    """Return one scale per output, not negative; `outputs` is () for a vector of labels."""
    scales = finite("output_scales", values)
    if scales.shape not in {(), outputs} or (scales < 0.0).any():
        wanted = " or ".join(["1", *map(str, outputs)])
        raise InputError(f"output_scales {values}: expected {wanted} numbers, none negative")
    return np.broadcast_to(scales, outputs)


def noise_of(costs: Float[ndarray, "n"], lam: float) -> Float[ndarray, "n"]:
    """Return the variances lambda c of the labels' noise, in units of k(s, s)."""
    return np.maximum(lam * costs, NOISE_FLOOR)


def factorised(
    kernel: Float[ndarray, "n n"], noise: Float[ndarray, "n"]
) -> tuple[Float[ndarray, "n n"], float]:
    """Return the Cholesky factor of kernel + diag(noise), and what had to be added to the noise.

    Raises:
        InputError: there is no factor, however much is added.
    """
    for jitter in JITTERS:
        try:
            return cholesky(
                kernel + np.diag(noise + jitter), lower=True, check_finite=False
            ), jitter
        except LinAlgError:
            continue
    raise InputError(f"{len(kernel)} samples: their kernel has no Cholesky factor")
