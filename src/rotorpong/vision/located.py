"""The candidate balls of one picture, in pixels and, where the camera is known, in metres.

Both ways begin with `detect`; where another circle or whole pixels are asked for, with the outlines
of the quick search, as the paper's eyes. The paper's way keeps its circle: least squares through
the outline, the distance by Eq. (1) corrected off the axis. The tracker's goes on, ball by ball:

    circle -> matte, sub-pixel disc with its covariance -> exact sphere

What the matte cannot measure (too small, too little seen, hardly a ball) keeps its circle, and the
circle's larger covariance. Camera frame; where a camera's lens cannot be undone there is no place.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_DIAMETER, InputError, Picture
from rotorpong.physics.camera import Camera
from rotorpong.vision.circles import CircleFit
from rotorpong.vision.colour import COLOURS, Colour
from rotorpong.vision.detect import Blob, Detection, detect, find_blobs, fit_outline
from rotorpong.vision.locate import ball_position, position_covariance
from rotorpong.vision.matte import BallDisc, Guess, measure_ball, region_around
from rotorpong.vision.paint import paint_of
from rotorpong.vision.sphere import outline_shape, sphere_of_disc

CENTER_SD_PX = 0.15  # of a circle: real footage, compressed
DIAMETER_SD_PX = 0.4  # the threshold's bias depends on exposure and encoding
DISC_FACTOR, DISC_SD_PX, DISC_SD = 2.0, 0.15, 0.02
"""What a disc's covariance leaves out in footage: edges behind the ball, compression, rolling
shutter (px, and of the radius). Of 154 balls rendered at 720p with the AR.Drone's sensor and sent
as MPEG-4, the radius then errs by 0.5 sd in median, 68 % of them by less than 0.7, 1 % by more than
3: those that something of their own colour touches."""
TRUSTED = 3.0  # sd between area and edge; what is more counts against the disc
PICTURE_GAMMA = 2.2  # of picture files whose camera is not known: sRGB


@dataclass(frozen=True, slots=True)
class LocatedBall:
    """A candidate ball in a picture and, where the camera is known, in the camera frame."""

    x_px: float
    y_px: float
    diameter_px: float
    score: float
    colour: str
    position_m: Float[ndarray, "3"] | None = None
    covariance_m2: Float[ndarray, "3 3"] | None = None


@dataclass(frozen=True, slots=True)
class StillEyes:
    """What is looked for in single pictures, and how it is measured."""

    camera: Camera | None = None  # that took them; None: balls have no position
    colours: tuple[Colour | str, ...] = ("orange",)
    ball_diameter: float = BALL_DIAMETER  # m
    min_score: float = 0.0  # 0 to 1
    fine: bool = False  # as the tracker measures
    fit: CircleFit = "kasa"
    whole_pixels: bool = False

    def look(self, picture: Picture) -> tuple[LocatedBall, ...]:
        """Return the balls in a picture, best first."""
        found = [ball for ball in self._circles(picture) if ball.score >= self.min_score]
        located = self._measured if self.fine else self._located
        return tuple(located(ball, picture) for ball in found)

    def _circles(self, picture: Picture) -> list[Detection]:
        if self.fit == "kasa" and not self.whole_pixels:
            return detect(picture, self.colours)
        height, width = picture.shape[:2]
        blobs = find_blobs(picture, self.colours)
        circles = [self._circle(blob, picture.shape[:2]) for blob in blobs]
        return [c for c in circles if 0 <= c.x_px <= width - 1 and 0 <= c.y_px <= height - 1]

    def _circle(self, blob: Blob, shape: tuple[int, ...]) -> Detection:
        circle = fit_outline(blob.contour, shape, self.fit)
        diameter = circle.diameter_px
        if self.whole_pixels:
            diameter = float(max(1, round(diameter)))
        return Detection(circle.x_px, circle.y_px, diameter, blob.score, blob.colour)

    def _located(self, ball: Detection, picture: Picture) -> LocatedBall:
        """Return a ball where its circle has it."""
        seen = (ball.x_px, ball.y_px, ball.diameter_px, ball.score, ball.colour)
        if self.camera is None:
            return LocatedBall(*seen)
        pixel, diameter = np.array([ball.x_px, ball.y_px]), np.array(ball.diameter_px)
        size = self.ball_diameter
        try:
            position = ball_position(self.camera, pixel, diameter, ball_diameter=size, eq1=False)
            covariance = position_covariance(
                self.camera,
                pixel,
                diameter,
                center_sd_px=CENTER_SD_PX,
                diameter_sd_px=DIAMETER_SD_PX,
                ball_diameter=size,
            )
        except InputError:  # outside of what the lens shows
            return LocatedBall(*seen)
        return LocatedBall(*seen, position, covariance)

    def _measured(self, ball: Detection, picture: Picture) -> LocatedBall:
        """Return a ball as the tracker measures it, where it can be."""
        disc = self._disc(ball, picture)
        if disc is None:
            return self._located(ball, picture)
        seen = (disc.x_px, disc.y_px, 2.0 * disc.radius_px, ball.score, ball.colour)
        if self.camera is None:
            return LocatedBall(*seen)
        measured = np.array([disc.x_px, disc.y_px, disc.radius_px])
        spread = _spread(disc)
        try:
            sphere = sphere_of_disc(self.camera, measured, spread, radius=0.5 * self.ball_diameter)
        except InputError:  # outside of what the lens shows
            return LocatedBall(*seen)
        return LocatedBall(*seen, sphere.position, sphere.covariance)

    def _disc(self, ball: Detection, picture: Picture) -> BallDisc | None:
        height, width = picture.shape[:2]
        camera, center = self.camera, np.array([ball.x_px, ball.y_px])
        shape = None if camera is None else outline_shape(camera, center)
        if shape is not None and not np.isfinite(shape).all():
            return None
        guess = Guess(ball.x_px, ball.y_px, ball.diameter_px, shape=shape)
        x0, y0, x1, y1 = region_around(guess, width, height)
        region = picture[y0:y1, x0:x1]
        if not region.size:
            return None
        gamma = PICTURE_GAMMA if camera is None else camera.gamma
        paint = paint_of(self._colour(ball.colour))
        disc = measure_ball(region, guess, paint, offset=(x0, y0), gamma=gamma)
        within = disc is not None and 0 <= disc.x_px <= width - 1 and 0 <= disc.y_px <= height - 1
        return disc if within else None

    def _colour(self, name: str) -> Colour:
        """Return the colour of this name among those looked for."""
        own = {colour.name: colour for colour in self.colours if isinstance(colour, Colour)}
        return own.get(name) or COLOURS[name]


def _spread(disc: BallDisc) -> Float[ndarray, "3 3"]:
    """Return the covariance of a disc in footage, px^2."""
    doubt = max(1.0, (disc.disagreement or 0.0) / TRUSTED)
    model = DISC_SD_PX**2 + (DISC_SD * disc.radius_px) ** 2
    return doubt**2 * (DISC_FACTOR * disc.covariance + model * np.eye(3))
