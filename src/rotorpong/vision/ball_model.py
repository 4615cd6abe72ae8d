"""How sure it is that a candidate is a ball: logistic regression on its features.

    probability = 1 / (1 + exp(-(intercept + weights . features)))

One model for balls that have a hue, one for those that have none (white, grey, black).
`benchmarks/fit_ball_model.py` fits both to any folder of labelled pictures and prints them as they
stand here. These were fitted to about 300 balls in real pictures: on grass, on the carpet of robot
football among its crowd, on the floor of an office and in hands.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.vision.candidates import FEATURES


@dataclass(frozen=True, slots=True)
class BallModel:
    """A logistic model of a ball."""

    intercept: float
    weights: Mapping[str, float]  # of FEATURES; those left out weigh nothing


def probability(features: Float[ndarray, "n k"], model: BallModel) -> Float[ndarray, "n"]:
    """Return how sure it is that candidates are balls, 0 to 1.

    Args:
        features: in the order of FEATURES.
        model: of the ball.
    """
    weights = np.array([model.weights.get(name, 0.0) for name in FEATURES])
    return 1.0 / (1.0 + np.exp(-np.clip(model.intercept + features @ weights, -500.0, 500.0)))


HUED = BallModel(
    -3.981,
    {
        "fill": 2.144,
        "axes": -1.5,
        "arc": 1.429,
        "solid": 0.371,
        "corners": 1.586,
        "outside": -0.063,
        "sides": 2.161,
        "worst": 1.114,
        "contrast": 0.845,
        "sharpness": 5.106,
        "relative sharpness": -3.139,
        "offset": 2.773,
        "uneven": 0.726,
        "size": 0.651,
        "size squared": -0.547,
        "size x arc": 1.805,
        "size x corners": 1.036,
        "level": -3.132,
        "saturation": -4.903,
        "saturation squared": -9.406,
        "value": 1.026,
        "unseen": -1.047,
    },
)
PALE = BallModel(
    5.971,
    {
        "fill": 5.396,
        "axes": -10.43,
        "arc": -0.442,
        "solid": -0.93,
        "corners": 3.621,
        "outside": -0.838,
        "sides": -0.159,
        "worst": -1.354,
        "contrast": -1.639,
        "sharpness": 5.147,
        "relative sharpness": -3.77,
        "offset": -13.497,
        "uneven": -4.439,
        "size": 0.826,
        "size squared": -1.028,
        "size x arc": 5.739,
        "size x corners": 1.441,
        "level": -2.884,
        "saturation": 6.226,
        "saturation squared": -17.806,
        "value": -1.778,
        "unseen": -6.979,
    },
)
