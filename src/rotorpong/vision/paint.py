"""What a colour that is looked for means to the measurement of a ball.

`detect` looks for a range of hue, saturation and value; `matte` measures with the direction of the
ball's colour in linear light, which here is that of the typical ball. A ball without a hue differs
from much of its background in brightness only, so its shading is taken as better known, as for a
white ball.
"""

import math

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.vision.detect import COLOURS, Colour
from rotorpong.vision.matte import BALL_COLOURS, WHITE_BALL, BallColour

GAMMA = 2.2  # of pictures that colours are learnt from
PALE = 35  # saturation below which a ball has no hue
FARTHEST = 0.3  # rad, of colours that can be measured as the nearest known ball


def paint_of(colour: Colour) -> BallColour:
    """Return how balls of a colour are measured."""
    if COLOURS.get(colour.name) == colour:
        return BALL_COLOURS[colour.name]
    levels = _levels(colour)
    if colour.typical[1] < PALE:
        return BallColour(colour.name, levels, WHITE_BALL.tolerance, WHITE_BALL.shading)
    return BallColour(colour.name, levels)


def nearest_paint(colour: Colour) -> BallColour:
    """Return the known ball whose colour is the nearest in direction.

    Raises:
        InputError: none is near enough to be measured as.
    """
    ours = paint_of(colour)
    angles = {name: _angle(ours, known) for name, known in BALL_COLOURS.items()}
    nearest = min(angles, key=lambda name: angles[name])
    if angles[nearest] > FARTHEST:
        raise InputError(
            f"colour {colour.name!r}: the tracker follows balls that are nearly "
            f"{' or '.join(BALL_COLOURS)}; typical hue, saturation and value are {colour.typical}"
        )
    return BALL_COLOURS[nearest]


def _levels(colour: Colour) -> tuple[float, float, float]:
    """Return blue, green and red of the typical ball, 0 to 255."""
    pixel = cv2.cvtColor(np.array([[colour.typical]], np.uint8), cv2.COLOR_HSV2BGR)
    blue, green, red = (float(level) for level in pixel[0, 0])
    return blue, green, red


def _angle(one: BallColour, other: BallColour) -> float:
    cosine = float(_direction(one) @ _direction(other))
    return math.acos(min(cosine, 1.0))


def _direction(paint: BallColour) -> Float[ndarray, "3"]:
    light = np.array(paint.levels_bgr) ** GAMMA
    return light / np.linalg.norm(light)
