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
    -3.842,
    {
        "fill": 1.854,
        "axes": -1.185,
        "arc": 1.463,
        "solid": 0.416,
        "corners": 1.325,
        "outside": -0.078,
        "sides": 2.114,
        "worst": 1.159,
        "contrast": 0.964,
        "sharpness": 4.862,
        "relative sharpness": -3.368,
        "offset": 2.723,
        "uneven": 0.719,
        "size": 0.689,
        "size squared": -0.656,
        "size x arc": 1.775,
        "size x corners": 1.067,
        "level": -3.182,
        "saturation": -4.863,
        "saturation squared": -9.336,
        "value": 1.103,
        "unseen": -1.271,
    },
)
PALE = BallModel(
    5.778,
    {
        "fill": 4.688,
        "axes": -9.741,
        "arc": -0.179,
        "solid": -0.808,
        "corners": 3.178,
        "outside": -0.876,
        "sides": -0.338,
        "worst": -1.272,
        "contrast": -1.433,
        "sharpness": 4.927,
        "relative sharpness": -4.055,
        "offset": -14.113,
        "uneven": -4.896,
        "size": 0.827,
        "size squared": -0.979,
        "size x arc": 5.921,
        "size x corners": 1.31,
        "level": -3.173,
        "saturation": 7.406,
        "saturation squared": -18.664,
        "value": -1.27,
        "unseen": -7.35,
    },
)
