"""What a learner is taught: a hitting motion, what the ball did, where and when it was hit."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import Verdict
from rotorpong.play.odometer import Path

UNKNOWN_OFFSET_REWARD = 1.0
SMALLEST_REWARD = 0.05


@dataclass(frozen=True, slots=True)
class Lesson:
    """One demonstrated hit, as the pupil's own eyes and navdata tell it."""

    ball: Float[ndarray, "6"]  # camera frame at the trigger: position m, velocity m/s
    path: Path  # of the body from the trigger to the contact
    reward: float

    @property
    def hitting_point(self) -> Float[ndarray, "7"]:
        """The label: displacement and velocity at the contact, and how long it took."""
        return hitting_point(self.path)


def hitting_point(path: Path) -> Float[ndarray, "7"]:
    """Return the hitting point at the end of a path: position m, velocity m/s, duration s."""
    elapsed = path.times[-1] - path.times[0]
    return np.concatenate([path.positions[-1], path.velocities[-1], [elapsed]])


def reward_of(verdict: Verdict) -> float:
    """Return the reward of a serve: 1 in the middle of the blade, 0.5 at its rim, 0 for a miss."""
    if verdict.outcome != "hit":
        return 0.0
    if verdict.contact_offset is None:
        return UNKNOWN_OFFSET_REWARD
    return 1.0 - 0.5 * min(verdict.contact_offset, 1.0)  # an edge is the rim, to rounding


def cost_of(reward: float) -> float:
    """Return the cost c of Eq. (6): inversely proportional to the reward."""
    return 1.0 / max(reward, SMALLEST_REWARD)
