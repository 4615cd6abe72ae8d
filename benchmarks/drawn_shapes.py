"""Pictures of what has a ball's colour and is none, drawn: real ones show too little of it."""

import cv2
import numpy as np

from rotorpong.conventions import Picture
from rotorpong.vision.colour import Colour

HEIGHT, WIDTH = 240, 320
SHAPES = {  # corners around the middle
    "rectangle": np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]),
    "triangle": np.array([(-1.0, 0.9), (1.0, 0.9), (0.0, -1.0)]),
    "half": np.array([(np.cos(a), np.sin(a)) for a in np.linspace(0.0, np.pi, 24)]),
}
PLACES = ((80.0, 60.0), (240.0, 60.0), (80.0, 180.0), (240.0, 180.0))
SMALLEST, LARGEST = 3.0, 60.0  # px from the middle
GROUND = ((60, 120, 30), (110, 100, 90), (20, 20, 20), (150, 90, 40))  # blue, green, red


def draw(rng: np.random.Generator, colour: Colour) -> Picture:
    """Return a picture of four shapes of a ball's colour, sharp or blurred."""
    picture = np.empty((HEIGHT, WIDTH, 3))
    picture[:] = GROUND[rng.integers(len(GROUND))]
    for place in PLACES:
        size = np.exp(rng.uniform(np.log(SMALLEST), np.log(LARGEST), 2))
        size[1] = np.clip(size[1], size[0] / 2.0, size[0] * 2.0)
        angle = rng.uniform(0.0, np.pi)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        corners = SHAPES[str(rng.choice(list(SHAPES)))] * size @ turn.T + place
        hsv = np.array([[colour.typical]], np.uint8)
        filled = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0] * rng.uniform(0.8, 1.1)
        cv2.fillPoly(
            picture, [np.round(corners).astype(np.int32)], np.minimum(filled, 255).tolist()
        )
    picture = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.3, 1.2))
    return np.clip(picture + rng.normal(0.0, 2.0, picture.shape), 0, 255).astype(np.uint8)
