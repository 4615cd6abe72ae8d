"""What the flight filter and a picture say to each other.

A measured disc becomes a sight: exact direction and angular radius (`sphere`) with their
covariance,

    (X/Z, Y/Z, asin(R / d)),   J C J^T,   J = d angles / d position (d disc / d position)^-1

A belief becomes an aim: the disc of the ball where it must be, how fast that moves over the
picture, and how sure it is, by the slopes of the sight.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.physics.camera import Camera
from rotorpong.vision import _sight_kernels as kernels
from rotorpong.vision.flight_filter import Belief
from rotorpong.vision.sphere import lens_of

SURE = 1.0 / 3.0  # sd of an aim over its radius

Pose = Float[ndarray, "12"]  # camera's place (m), and rows of the rotation to it from the frame


@dataclass(frozen=True, slots=True)
class Aim:
    """Where in a picture a ball must be."""

    x_px: float
    y_px: float
    radius_px: float
    velocity_px_s: tuple[float, float]  # right, down
    sd_px: tuple[float, float, float]  # of x, y, radius
    falling_sd_px_s: float  # of the velocity downwards

    @property
    def is_sure(self) -> bool:
        """Whether it is good enough to measure the ball there without looking for it."""
        return max(self.sd_px) < SURE * self.radius_px


def aim_at(camera: Camera, belief: Belief, now: Pose, before: Pose, lag: float) -> Aim | None:
    """Return where a believed ball must be in the picture; `None` if not before the camera.

    Args:
        camera: whose picture it is.
        belief: at the time of the picture.
        now: of the camera at that time.
        before: of the camera a moment before.
        lag: that moment, s.
    """
    out = np.empty(9)
    poses = np.stack([now, before])
    if not kernels.aim(lens_of(camera), belief.mean, belief.covariance, poses, lag, out):
        return None
    x, y, radius, across, down, sd_x, sd_y, sd_radius, sd_down = out.tolist()
    return Aim(x, y, radius, (across, down), (sd_x, sd_y, sd_radius), sd_down)


def angles_of_disc(
    camera: Camera, measured: Float[ndarray, "3"], covariance: Float[ndarray, "3 3"]
) -> tuple[Float[ndarray, "3"], Float[ndarray, "3 3"]] | None:
    """Return X/Z, Y/Z and angular radius of a ball, and their covariance, from its disc.

    `None` if no ball before the camera looks like this.
    """
    seen, noise = np.empty(3), np.empty((3, 3))
    found = kernels.sight_of_disc(lens_of(camera), measured, covariance, seen, noise)
    return (seen, noise) if found else None
