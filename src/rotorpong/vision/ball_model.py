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
    -5.112,
    {
        "fill": 2.949,
        "axes": -2.03,
        "arc": 1.795,
        "solid": 0.252,
        "corners": 1.191,
        "outside": -0.17,
        "sides": 1.585,
        "worst": -0.2,
        "second": 2.762,
        "contrast": 1.222,
        "sharpness": 3.888,
        "weakest": 3.311,
        "relative sharpness": -4.1,
        "offset": 2.593,
        "spread": 0.444,
        "uneven": 1.61,
        "size": 2.38,
        "size squared": -0.416,
        "level": -2.03,
        "level squared": -0.167,
        "saturation": 2.92,
        "saturation squared": -3.083,
        "value": -0.433,
        "unseen": -1.331,
    },
)
PALE = BallModel(
    5.435,
    {
        "fill": 5.792,
        "axes": -11.066,
        "arc": 0.32,
        "solid": -0.601,
        "corners": 3.794,
        "outside": -0.898,
        "sides": -0.286,
        "worst": -1.495,
        "second": -1.389,
        "contrast": -0.338,
        "sharpness": 5.961,
        "weakest": -2.537,
        "relative sharpness": -2.564,
        "offset": -15.51,
        "spread": -2.267,
        "uneven": -3.486,
        "size": 3.918,
        "size squared": -0.973,
        "level": -3.666,
        "level squared": -1.117,
        "saturation": 10.484,
        "saturation squared": -17.858,
        "value": 0.747,
        "unseen": -9.551,
    },
)
