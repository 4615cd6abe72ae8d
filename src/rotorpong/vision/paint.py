"""What a colour that is looked for means to the measurement of a ball.

`detect` looks for a range of hue, saturation and value; `matte` measures with the direction of the
ball's colour in linear light, which here is that of the typical ball. A ball without a hue differs
from much of its background in brightness only, so its shading is taken as better known, as for a
white ball.
"""

import functools

import cv2
import numpy as np

from rotorpong.vision.colour import COLOURS, Colour
from rotorpong.vision.matte import BALL_COLOURS, WHITE_BALL, BallColour


@functools.lru_cache(maxsize=8)
def paint_of(colour: Colour) -> BallColour:
    """Return how balls of a colour are measured."""
    if COLOURS.get(colour.name) == colour:
        return BALL_COLOURS[colour.name]
    levels = _levels(colour)
    if not colour.has_hue:
        return BallColour(colour.name, levels, WHITE_BALL.tolerance, WHITE_BALL.shading)
    return BallColour(colour.name, levels)


def _levels(colour: Colour) -> tuple[float, float, float]:
    """Return blue, green and red of the typical ball, 0 to 255."""
    pixel = cv2.cvtColor(np.array([[colour.typical]], np.uint8), cv2.COLOR_HSV2BGR)
    blue, green, red = (float(level) for level in pixel[0, 0])
    return blue, green, red
