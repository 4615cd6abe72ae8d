"""A ball's picture, exactly: from position to disc and back.

A sphere of radius R at distance d is seen within the cone of half-angle rho about the unit
direction n, sin rho = R / d. On the plane Z = 1 its outline is an ellipse with

    centre      n_xy n_z / (n_z^2 - sin^2 rho)                                       Eq. (1)
    semi-axes   sin rho cos rho / (n_z^2 - sin^2 rho)  away from the axis,           Eq. (2)
                sin rho / sqrt(n_z^2 - sin^2 rho)      across
    area        pi sin^2 rho cos rho / (n_z^2 - sin^2 rho)^1.5                       Eq. (3)

The lens bends this ellipse. What is called the disc here is the centroid (x, y) of the bent
outline and the radius of the circle with its area, in pixels: what blur and pixels leave unchanged.
It is computed by Green's theorem over the outline, with a periodic quadrature that is exact up to
rounding for any lens a camera has.

The way back starts from the lens' local Jacobian at the centroid: its inverse takes the centroid,
its determinant the area to the plane Z = 1, and (1) and (3) are solved by a fixed point. Without
distortion that is exact. With it, what the Jacobian leaves (the curvature of the lens across the
ball shifts the centroid by about 3 |k1| r^2 tan(theta) / (4 f): 0.05 px for a ball of 45 px, 20
degrees off the AR.Drone's axis) is removed by Newton's method on the exact disc.

Camera frame: X right, Y down, Z depth, metres. Any leading batch shape.
"""

import functools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError, Vector3
from rotorpong.physics.camera import Camera, Pixels
from rotorpong.vision._sphere_kernels import (
    NO_DISC,
    NO_SPHERE,
    discs,
    positions_of,
    shapes,
    symmetric,
)

Disc = Float[ndarray, "*batch 3"]  # centroid x, y and area radius, px


@dataclass(frozen=True, slots=True)
class SpherePositions:
    """Where spheres are, in the camera frame."""

    position: Vector3  # m
    covariance: Float[ndarray, "*batch 3 3"]  # m^2


def disc_of_sphere(camera: Camera, positions: Vector3, *, radius: float = BALL_RADIUS) -> Disc:
    """Return centroid and area radius, in pixels, of spheres in the camera frame.

    nan for a sphere that is behind the camera, around it, or reaches past 88 degrees off its axis.
    """
    flat = np.ascontiguousarray(positions, dtype=np.float64).reshape(-1, 3)
    out = np.empty_like(flat)
    discs(lens_of(camera), flat, float(radius), out)
    return out.reshape(positions.shape)


def sphere_of_disc(
    camera: Camera,
    measured: Disc,
    covariance: Float[ndarray, "*#batch 3 3"],
    *,
    radius: float = BALL_RADIUS,
) -> SpherePositions:
    """Return where spheres are that appear as these discs.

    Args:
        camera: whose picture it is.
        measured: centroids x, y and area radii in pixels.
        covariance: of the measured, px^2.
        radius: of the sphere, m.

    Raises:
        InputError: a disc is not finite, has no area, or no sphere looks like it.
    """
    flat = np.ascontiguousarray(measured, dtype=np.float64).reshape(-1, 3)
    spread = _flat(covariance, measured.shape[:-1])
    position, spreads = np.empty_like(flat), np.empty((len(flat), 3, 3))
    outcome = positions_of(lens_of(camera), flat, spread, float(radius), position, spreads)
    if outcome == NO_DISC:
        raise InputError("discs need finite numbers and a radius above 0 px")
    if outcome == NO_SPHERE:
        raise InputError(f"camera {camera.name}: no sphere in front of it looks like this disc")
    return SpherePositions(position.reshape(measured.shape), spreads.reshape(*measured.shape, 3))


def outline_shape(camera: Camera, pixels: Pixels) -> Float[ndarray, "*batch 2 2"]:
    """Return the shape of a small ball's outline at these pixels: symmetric, of determinant 1.

    The outline is  centre + radius * shape @ u  over all unit vectors u, radius that of the area.
    """
    flat = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 2)
    out = np.empty((len(flat), 2, 2))
    shapes(lens_of(camera), flat, out)
    return out.reshape(*pixels.shape, 2)


def symmetric_shape(matrix: Float[ndarray, "*batch 2 2"]) -> Float[ndarray, "*batch 2 2"]:
    """Return the symmetric matrix of determinant 1 that draws the same ellipse, but for its size.

    sqrt(M M^T) = (M M^T + |det M| 1) / sqrt(tr M M^T + 2 |det M|), by Cayley and Hamilton.
    """
    flat = np.ascontiguousarray(matrix, dtype=np.float64).reshape(-1, 2, 2)
    out = np.empty_like(flat)
    symmetric(flat, out)
    return out.reshape(matrix.shape)


def _flat(
    covariance: Float[ndarray, "*#batch 3 3"], batch: tuple[int, ...]
) -> Float[ndarray, "n 3 3"]:
    """Return a covariance for each of a batch, or one for all of it."""
    if covariance.ndim > 2 and covariance.shape[:-2] != batch:
        covariance = np.broadcast_to(covariance, (*batch, 3, 3))
    return np.ascontiguousarray(covariance, dtype=np.float64).reshape(-1, 3, 3)


@functools.lru_cache(maxsize=8)
def lens_of(camera: Camera) -> Float[ndarray, "9"]:
    """Return focal lengths, centre and distortion as the kernels take them."""
    return np.array([*camera.focal_length_px, *camera.center_px, *camera.distortion])
