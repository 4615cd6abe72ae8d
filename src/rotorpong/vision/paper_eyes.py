"""The paper's own eyes (section III): one circle a frame, Eqs. (1) and (2), finite differences.

    largest plausible blob -> circle (whole pixels) -> position_k
    velocity_k = (position_k - position_{k-1}) / (t_k - t_{k-1})

No model of the ball, none of the drone's own motion: what the camera moves and turns between two
frames counts as motion of the ball. Camera frame throughout.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_DIAMETER, InputError
from rotorpong.drone import BallEstimate, Observation
from rotorpong.physics.camera import Camera
from rotorpong.vision.circles import CircleFit
from rotorpong.vision.colour import Colour
from rotorpong.vision.detect import as_picture, find_blobs
from rotorpong.vision.locate import position_and_covariance
from rotorpong.vision.measure import Circle, fit_circle

PLAUSIBLE_SCORE = 0.1
LONGEST_GAP = 0.2  # s, between the two sights of a finite difference
CENTER_SD_PX = 0.13  # a contour's, at 3 DN of noise
DIAMETER_SD_PX = 0.80  # the outline's bias of 0.74 and the steps of whole pixels, 1/sqrt(12)


@dataclass(frozen=True, slots=True)
class _Sight:
    """The ball in one frame."""

    time: float
    position: Float[ndarray, "3"]
    covariance: Float[ndarray, "3 3"]


class PaperEyes:
    """Eyes for one serve, as the paper built them."""

    def __init__(
        self,
        camera: Camera,
        ball_diameter: float = BALL_DIAMETER,
        *,
        whole_pixels: bool = True,
        fit: CircleFit = "kasa",
        colour: Colour | str = "orange",
    ) -> None:
        """Look through `camera` for a ball of `ball_diameter` metres.

        Args:
            camera: whose frames these are.
            ball_diameter: of the real ball, m.
            whole_pixels: round its diameter in the picture to whole pixels, as in Fig. 4.
            fit: how a circle is put through its outline.
            colour: of the ball, by name or as a `Colour`.
        """
        self._camera = camera
        self._ball_diameter = ball_diameter
        self._whole_pixels = whole_pixels
        self._fit: CircleFit = fit
        self._colours = (colour,)
        self._previous: _Sight | None = None

    def see(self, observation: Observation) -> BallEstimate | None:
        """Return the ball in the camera frame; `None` before a second sight within 0.2 s.

        Raises:
            InputError: the picture is not of this camera's size.
        """
        circle = self._circle(observation.frame.picture)
        if circle is None:
            return None
        before, now = self._previous, self._sight(circle, float(observation.frame_time))
        self._previous = now
        if before is None or not 0.0 < now.time - before.time <= LONGEST_GAP:
            return None
        return _estimate(before, now)

    def _circle(self, picture: ndarray) -> Circle | None:
        """Return the largest plausible ball whose centre is in the picture."""
        width, height = self._camera.width_px, self._camera.height_px
        if picture.shape[:2] != (height, width):
            raise InputError(
                f"a picture of {picture.shape[1]} x {picture.shape[0]} pixels; "
                f"camera {self._camera.name} has {width} x {height}"
            )
        blobs = find_blobs(as_picture(picture), self._colours)
        plausible = [b for b in blobs if b.score >= PLAUSIBLE_SCORE]
        circles = [
            fit_circle(b.contour, whole_pixels=self._whole_pixels, fit=self._fit) for b in plausible
        ]
        inside = [c for c in circles if 0 <= c.x_px <= width - 1 and 0 <= c.y_px <= height - 1]
        return max(inside, key=lambda circle: circle.diameter_px, default=None)

    def _sight(self, circle: Circle, time: float) -> _Sight:
        pixel, diameter = np.array([circle.x_px, circle.y_px]), np.array(circle.diameter_px)
        position, covariance = position_and_covariance(
            self._camera,
            pixel,
            diameter,
            center_sd_px=CENTER_SD_PX,
            diameter_sd_px=DIAMETER_SD_PX,
            ball_diameter=self._ball_diameter,
        )
        return _Sight(time, position, covariance)


def _estimate(before: _Sight, now: _Sight) -> BallEstimate:
    """Return the later position and the difference, with the covariance of both."""
    elapsed = now.time - before.time
    cross = now.covariance / elapsed
    spread = (now.covariance + before.covariance) / elapsed**2
    covariance = np.block([[now.covariance, cross], [cross, spread]])
    velocity = (now.position - before.position) / elapsed
    return BallEstimate(now.time, now.position, velocity, covariance)
