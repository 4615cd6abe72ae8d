"""Pictures of what has a ball's colour and is none, drawn: real ones show too little of it."""

import cv2
import numpy as np
from numpy import ndarray

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
HEADS = (40.0, 110.0)  # px, half their height
SKIN = ((4, 14), (80, 175), (110, 235))  # hue, saturation, value
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
    return _taken(rng, picture)


def draw_head(rng: np.random.Generator) -> Picture:
    """Return a picture of a face, as far as colour and outline go."""
    picture = np.empty((HEIGHT, WIDTH, 3))
    picture[:] = GROUND[rng.integers(len(GROUND))]
    tall = rng.uniform(*HEADS)
    axes = (round(tall * rng.uniform(0.62, 0.85)), round(tall))
    hsv = np.array([[[rng.integers(*limits) for limits in SKIN]]], np.uint8)
    skin = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0].tolist()
    middle = (round(rng.uniform(100.0, 220.0)), HEIGHT // 2)
    cv2.ellipse(picture, middle, axes, rng.uniform(-20.0, 20.0), 0, 360, skin, -1, cv2.LINE_AA)
    for side in (-1, 1):
        eye = (middle[0] + round(side * 0.4 * axes[0]), middle[1] - round(0.25 * tall))
        white = (round(0.16 * tall), round(0.1 * tall))
        cv2.ellipse(picture, eye, white, 0, 0, 360, (235, 235, 235), -1, cv2.LINE_AA)
        cv2.circle(picture, eye, round(0.08 * tall), (40, 30, 20), -1, cv2.LINE_AA)
    mouth = (middle[0], middle[1] + round(0.5 * tall))
    lips = (round(0.4 * axes[0]), round(0.1 * tall))
    cv2.ellipse(picture, mouth, lips, 0, 0, 180, (80, 80, 170), -1, cv2.LINE_AA)
    return _taken(rng, picture)


def _taken(rng: np.random.Generator, picture: ndarray) -> Picture:
    """Return what a camera makes of it."""
    picture = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.3, 1.2))
    return np.clip(picture + rng.normal(0.0, 2.0, picture.shape), 0, 255).astype(np.uint8)
