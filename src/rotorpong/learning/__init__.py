"""Learning: from a ball to a hitting point, and from rewards to the primitives worth trusting."""

from rotorpong.learning.bayesian import BayesianLinearRegression
from rotorpong.learning.crkr import CrKR
from rotorpong.learning.mixture import Mixture, Selection
from rotorpong.learning.nystroem import NystroemCrKR
from rotorpong.learning.self_tuning import SelfTuningCrKR
from rotorpong.learning.tuning import Tuned, tune

__all__ = [
    "BayesianLinearRegression",
    "CrKR",
    "Mixture",
    "NystroemCrKR",
    "Selection",
    "SelfTuningCrKR",
    "Tuned",
    "tune",
]
