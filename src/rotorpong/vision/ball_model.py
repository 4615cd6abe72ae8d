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
    -3.201,
    {
        "fill": 2.823,
        "axes": -1.12,
        "arc": 1.093,
        "solid": 0.343,
        "corners": 1.63,
        "outside": -0.076,
        "sides": 1.874,
        "worst": 0.894,
        "contrast": 1.077,
        "sharpness": 4.347,
        "relative sharpness": -2.574,
        "offset": 1.448,
        "uneven": 0.703,
        "size": 2.398,
        "size squared": -0.52,
        "level": -2.801,
        "saturation": -4.892,
        "saturation squared": -9.862,
        "value": 0.657,
        "unseen": -1.141,
    },
)
PALE = BallModel(
    7.938,
    {
        "fill": 7.938,
        "axes": -11.633,
        "arc": -0.237,
        "solid": -0.534,
        "corners": 3.472,
        "outside": -0.837,
        "sides": -0.201,
        "worst": -2.346,
        "contrast": -0.728,
        "sharpness": 4.517,
        "relative sharpness": -3.964,
        "offset": -14.056,
        "uneven": -3.159,
        "size": 3.647,
        "size squared": -1.036,
        "level": -3.046,
        "saturation": 11.07,
        "saturation squared": -22.318,
        "value": 0.057,
        "unseen": -8.468,
    },
)
