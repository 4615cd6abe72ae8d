"""From a ball's pixel and diameter to its position in the camera frame.

    d = (f/m) h_world / h_image                                   Eq. (1)
    x = (f/m_x) X/Z + p_x/m_x,  y = (f/m_y) Y/Z + p_y/m_y         Eqs. (2a), (2b)
    d = sqrt(X^2 + Y^2 + Z^2)                                     Eq. (2c)

The lens' distortion is removed first: (2a, 2b) are solved for X/Z and Y/Z with it, and
(f/m) / h_image is taken as one over the area-true size of the picture of the ball on the plane
Z = 1. Eq. (1) holds on the axis only. At the angle theta from it a sphere's picture is an ellipse,
larger by 1/cos^1.5 in mean radius, and (1) puts the ball too near: 2.28 m for 2.5 m at 20 degrees.
`eq1=False` divides that out: d = R / (radius cos^1.5 theta), to first order in (R/d)^2.

Camera frame: X right, Y down, Z depth, metres. Any leading batch shape.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_DIAMETER, InputError, Vector3
from rotorpong.physics.camera import Camera, Pixels, directions, project

PIXEL_STEP = 0.5  # px, to either side
ROUND_TRIP_PX = 0.1  # a pixel undistorted and projected again
DIFFERENCE_STEP = 1e-3  # px, for the Jacobian
CROSS = PIXEL_STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
STEPS = DIFFERENCE_STEP * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])


def ball_position(
    camera: Camera,
    pixels: Pixels,
    diameters_px: Float[ndarray, "*batch"],
    *,
    ball_diameter: float = BALL_DIAMETER,
    eq1: bool = True,
) -> Vector3:
    """Return where balls are, from where and how large they appear.

    Args:
        camera: whose picture it is.
        pixels: centres (x, y) in pixels.
        diameters_px: diameters in pixels.
        ball_diameter: of the real ball, m.
        eq1: take Eq. (1) as the paper does; otherwise allow for the ellipse off the axis.

    Raises:
        InputError: a value is not finite, a diameter is not positive, or a pixel lies where the
            camera's distortion cannot be undone.
    """
    _check(pixels, diameters_px, ball_diameter)
    rays, side = _ray_and_side(camera, pixels)
    lengths = np.linalg.norm(rays, axis=-1)
    distances = ball_diameter / (diameters_px * side)
    if not eq1:
        distances = distances * lengths**1.5
    positions = rays * (distances / lengths)[..., None]
    error = np.abs(project(camera, positions) - pixels)
    if not np.all(error < ROUND_TRIP_PX):
        raise InputError(f"camera {camera.name}: its distortion cannot be undone at these pixels")
    return positions


def position_and_covariance(
    camera: Camera,
    pixels: Pixels,
    diameters_px: Float[ndarray, "*batch"],
    *,
    center_sd_px: float,
    diameter_sd_px: float,
    ball_diameter: float = BALL_DIAMETER,
) -> tuple[Vector3, Float[ndarray, "*batch 3 3"]]:
    """Return `ball_position` by Eq. (1) and its covariance in m^2, to first order.

    Args:
        camera: whose picture it is.
        pixels: centres (x, y) in pixels.
        diameters_px: diameters in pixels.
        center_sd_px: standard deviation of each coordinate of a centre.
        diameter_sd_px: standard deviation of a diameter.
        ball_diameter: of the real ball, m.

    Raises:
        InputError: as `ball_position`.
    """
    measured = np.concatenate([pixels, np.asarray(diameters_px)[..., None]], axis=-1)
    moved = measured[..., None, :] + STEPS
    ends = ball_position(camera, moved[..., :2], moved[..., 2], ball_diameter=ball_diameter)
    slopes = (ends[..., 1:4, :] - ends[..., 4:, :]) / (2 * DIFFERENCE_STEP)
    scaled = slopes * np.array([center_sd_px, center_sd_px, diameter_sd_px])[:, None]
    return ends[..., 0, :], np.swapaxes(scaled, -1, -2) @ scaled


def position_covariance(
    camera: Camera,
    pixels: Pixels,
    diameters_px: Float[ndarray, "*batch"],
    *,
    center_sd_px: float,
    diameter_sd_px: float,
    ball_diameter: float = BALL_DIAMETER,
) -> Float[ndarray, "*batch 3 3"]:
    """Return the covariance of `ball_position` in m^2, to first order.

    Args:
        camera: whose picture it is.
        pixels: centres (x, y) in pixels.
        diameters_px: diameters in pixels.
        center_sd_px: standard deviation of each coordinate of a centre.
        diameter_sd_px: standard deviation of a diameter.
        ball_diameter: of the real ball, m.

    Raises:
        InputError: as `ball_position`.
    """
    _, covariance = position_and_covariance(
        camera,
        pixels,
        diameters_px,
        center_sd_px=center_sd_px,
        diameter_sd_px=diameter_sd_px,
        ball_diameter=ball_diameter,
    )
    return covariance


def _ray_and_side(camera: Camera, pixels: Pixels) -> tuple[Vector3, Float[ndarray, "*batch"]]:
    """Return the ray (X/Z, Y/Z, 1) and, on the plane Z = 1, a square's side of a pixel's area."""
    rays = directions(camera, pixels[..., None, :] + CROSS)
    across, down = rays[..., 1, :] - rays[..., 2, :], rays[..., 3, :] - rays[..., 4, :]
    area = across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0]
    with np.errstate(invalid="ignore"):
        side = np.asarray(np.sqrt(area / (2 * PIXEL_STEP) ** 2))
    middle = rays[..., 0, :]
    return np.concatenate([middle, np.ones_like(middle[..., :1])], axis=-1), side


def _check(pixels: ndarray, diameters_px: ndarray, ball_diameter: float) -> None:
    if not (np.isfinite(pixels).all() and np.isfinite(diameters_px).all()):
        raise InputError("the pixels and diameters of balls must be finite numbers")
    if not np.all(np.asarray(diameters_px) > 0.0):
        raise InputError(f"diameters must be above 0 px; the least is {np.min(diameters_px)}")
    if not (np.isfinite(ball_diameter) and 0.0 < ball_diameter < 1.0):
        raise InputError(f"ball diameter {ball_diameter} m; expected above 0 and below 1 m")
