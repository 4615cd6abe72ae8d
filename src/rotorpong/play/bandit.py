"""A contextual bandit on the hitting point: it searches about CrKR's answer, and from misses too.

The context is the ball s at the trigger, an arm is a hitting point: CrKR's, with its position moved
right and down by one of 49 offsets, so far as the demonstrations show that the drone can get there
in time. The reward of (s, x), x = (right, down), is believed to be

    r(s, x) = m(x - CrKR(s)) + f(s, x),   m(d) = 0.3 exp(-|d|^2 / (2 (0.15 m)^2))

f a Gaussian process (kernel and Cholesky factor are CrKR's, noise as large as the signal): CrKR's
answer is the best guess until rewards speak against it. In training it takes the arm of the
greatest mean + sd of r (UCB), else that of the greatest mean. Every serve but a fault teaches f;
hits teach CrKR too.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import BallEstimate, Drone, Eyes, Outcome, Verdict
from rotorpong.experience import Attempt
from rotorpong.learning import CrKR
from rotorpong.play.lessons import Lesson, reward_of
from rotorpong.play.paper import PaperPlayer, PaperSettings, Stroke, ball_of

STEP, STEPS = 0.05, 3  # m between neighbouring arms, arms on each side
HOPE, WIDTH = 0.3, 0.15  # of m: reward at CrKR's answer, m
BALL_SCALE, ARM_SCALE = 3.0, 0.10  # of f: standard deviations of the demonstrations, m
NOISE = 1.0  # variance of a reward over that of f
DEVIATION = 0.3  # of f
CURIOSITY = 1.0  # standard deviations of r that an arm is worth trying for

_AXIS = STEP * np.arange(-STEPS, STEPS + 1)
OFFSETS = np.stack(np.meshgrid(_AXIS, _AXIS, indexing="ij"), axis=-1).reshape(-1, 2)


class BanditPlayer:
    """Plays serve after serve with what it has learnt so far."""

    def __init__(
        self,
        lessons: Sequence[Lesson],
        settings: PaperSettings | None = None,
        *,
        explore: bool = False,
    ) -> None:
        """Take in the demonstrations; arguments and errors are those of `PaperPlayer`.

        But labels are `commanded` always, for an arm is what was tried, and who explores tries
        uncertain arms.
        """
        self._body = PaperPlayer(lessons, replace(settings or PaperSettings(), labels="commanded"))
        self._curiosity = CURIOSITY if explore else 0.0
        self._fastest = np.max([np.abs(one.path.velocities).max(axis=0) for one in lessons], axis=0)
        self._process = CrKR(np.array([BALL_SCALE] * 6 + [ARM_SCALE] * 2), NOISE)
        for lesson in lessons:
            self._judge(lesson.ball, lesson.hitting_point, lesson.reward)

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve; `rng` is for the rule by which primitives are selected."""

        def choose(estimate: BallEstimate, velocity: Float[ndarray, "3"]) -> Stroke:
            goal = self.hitting_point(ball_of(estimate))
            return self._body.stroke(estimate, goal, velocity, rng)

        self._body.strike(drone, eyes, choose)

    def learn(self, verdict: Verdict) -> None:
        """Learn from the serve just played, hit or not."""
        self.recall(verdict.outcome, self.attempt(verdict), reward_of(verdict))

    def attempt(self, verdict: Verdict) -> Attempt | None:
        """Return what was tried in the serve just played; `None` if nothing was."""
        return self._body.attempt(verdict)

    def recall(self, outcome: Outcome, attempt: Attempt | None, reward: float) -> None:
        """Learn what a serve teaches that was played now or in an earlier run."""
        if attempt is None or outcome == "fault":  # a fault is the thrower's
            return
        self._judge(attempt.state, attempt.hitting_point, reward)
        self._body.recall(outcome, attempt, reward)

    def hitting_point(self, ball: Float[ndarray, "6"]) -> Float[ndarray, "7"]:
        """Return the hitting point of the arm that is taken for a ball at the plane."""
        middle = self._body.hitting_point(ball)
        arms = self._within_reach(middle)
        mean, deviation = self._believed(ball, middle, arms)
        best = int(np.argmax(mean + self._curiosity * deviation))
        return np.concatenate([arms[best], middle[2:]])

    def _within_reach(self, middle: Float[ndarray, "7"]) -> Float[ndarray, "49 2"]:
        """Return the arms, m right and down; CrKR's own answer is one, however far it is."""
        farthest = np.maximum(self._fastest[:2] * max(middle[6], 0.0), np.abs(middle[:2]))
        return np.clip(middle[:2] + OFFSETS, -farthest, farthest)

    def _believed(
        self, ball: Float[ndarray, "6"], middle: Float[ndarray, "7"], arms: Float[ndarray, "n 2"]
    ) -> tuple[Float[ndarray, "n"], Float[ndarray, "n"]]:
        """Return mean and standard deviation of the reward of arms."""
        standard = np.tile(self._body.standardised(ball), (len(arms), 1))
        mean, noisy = self._process.predict(np.hstack([standard, arms]), return_std=True)
        deviation = np.sqrt(np.maximum(noisy**2 - NOISE, 0.0))
        return hoped(arms - middle[:2]) + mean, DEVIATION * deviation

    def _judge(self, ball: Float[ndarray, "6"], goal: Float[ndarray, "7"], reward: float) -> None:
        """Add one reward to f: what it was beyond what was hoped for."""
        surprise = reward - hoped(goal[:2] - self._body.hitting_point(ball)[:2])
        row = np.append(self._body.standardised(ball), goal[:2])
        self._process.partial_fit(row[None], np.array([surprise]))


def hoped(offsets: Float[ndarray, "*n 2"]) -> Float[ndarray, "*n"]:
    """Return m: the reward expected so far (m) from CrKR's answer before any serve."""
    return np.asarray(HOPE * np.exp(-0.5 * np.sum(offsets**2, axis=-1) / WIDTH**2))
