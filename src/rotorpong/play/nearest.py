"""The player that repeats the demonstration whose ball was most like this one.

Likeness is Euclidean distance of (position, velocity) at the trigger, in standard deviations of the
demonstrated balls. Hitting point, duration and primitive are that demonstration's, unchanged: what
memory alone hits, against which generalising has to pay.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import BallEstimate, Drone, Eyes, Verdict
from rotorpong.play.lessons import Lesson
from rotorpong.play.paper import PaperPlayer, PaperSettings, Stroke, ball_of


class NearestPlayer:
    """Remembers demonstrations; never learns."""

    def __init__(self, lessons: Sequence[Lesson], settings: PaperSettings | None = None) -> None:
        """Take in the demonstrations.

        Args:
            lessons: at least two demonstrated hits.
            settings: of which trigger, control and plant have an effect.

        Raises:
            InputError: fewer than two lessons.
        """
        self._body = PaperPlayer(lessons, settings)
        self._goals = np.stack([lesson.hitting_point for lesson in lessons])
        self._balls = np.stack([self._body.standardised(lesson.ball) for lesson in lessons])

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve."""
        self._body.strike(drone, eyes, self._choose)

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing."""

    def nearest(self, ball: Float[ndarray, "6"]) -> int:
        """Return which lesson's ball is nearest to this one; of equals the first."""
        away = self._balls - self._body.standardised(ball)
        return int(np.argmin(np.linalg.norm(away, axis=1)))

    def _choose(self, estimate: BallEstimate, velocity: Float[ndarray, "3"]) -> Stroke:
        k = self.nearest(ball_of(estimate))
        own = np.eye(len(self._goals))[k]
        return self._body.stroke(estimate, self._goals[k], velocity, weights=own)
