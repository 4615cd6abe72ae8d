"""The player with one motor primitive: the paper's, without the mixture of section IV.C.

CrKR gives the hitting point as in the paper; every motion is the primitive of one demonstration:
the one asked for, as in the paper's first test on the robot, or that which was rewarded best. What
it hits less than the paper's player is what the mixture is worth.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import BallEstimate, Drone, Eyes, Outcome, Verdict
from rotorpong.experience import Attempt
from rotorpong.play.lessons import Lesson
from rotorpong.play.paper import PaperPlayer, PaperSettings, Stroke


class SinglePlayer:
    """Plays serve after serve with what it has learnt so far."""

    def __init__(
        self,
        lessons: Sequence[Lesson],
        settings: PaperSettings | None = None,
        *,
        explore: bool = False,
    ) -> None:
        """Take in the demonstrations; arguments are those of `PaperPlayer`.

        Raises:
            InputError: fewer than two lessons, or none of that number.
        """
        self._body = PaperPlayer(lessons, settings, explore=explore)
        self.primitive = _primitive(lessons, None if settings is None else settings.primitive)
        self._weights = np.eye(len(lessons))[self.primitive]

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve."""

        def choose(estimate: BallEstimate, velocity: Float[ndarray, "3"]) -> Stroke:
            goal = self._body.aim(estimate, rng)
            return self._body.stroke(estimate, goal, velocity, weights=self._weights)

        self._body.strike(drone, eyes, choose)

    def learn(self, verdict: Verdict) -> None:
        """Learn from the serve just played, if it was a hit."""
        self._body.learn(verdict)

    def attempt(self, verdict: Verdict) -> Attempt | None:
        """Return what was tried in the serve just played, labelled; `None` if nothing was."""
        return self._body.attempt(verdict)

    def recall(self, outcome: Outcome, attempt: Attempt | None, reward: float) -> None:
        """Learn what a serve teaches that was played now or in an earlier run."""
        self._body.recall(outcome, attempt, reward)


def _primitive(lessons: Sequence[Lesson], asked: int | None) -> int:
    """Return whose primitive is flown, by the number of the lesson."""
    if asked is None:
        return int(np.argmax([lesson.reward for lesson in lessons]))
    if not 0 <= asked < len(lessons):
        raise InputError(f"primitive {asked}: expected a whole number from 0 to {len(lessons) - 1}")
    return asked
