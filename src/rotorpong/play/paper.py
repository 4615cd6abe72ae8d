"""The paper's player: trigger, hitting point, mixture of primitives, open loop, learning from hits.

1. It hovers until its eyes first see the ball nearer than the 2.5 m plane (Fig. 6). That instant is
   t_i, and the ball's state then is s.
2. CrKR (6) gives the hitting point delta(s): displacement, velocity, duration.
3. gamma_k = exp(V_k(s, delta)) weighs the primitives of the library into one.
4. The motion's velocities are the commands, until the duration is over; then it hovers. That is
   the paper's open loop; feed-forward or closed loop, the motion begins where and when the first
   command acts, and arrives at the same time.
5. From a hit it learns (s, delta) with cost 1/r and updates the V_k, each as far as it took part.

s is the state in the camera frame; delta is in level axes aligned with the camera and frozen at
t_i. Mean and deviation are those of the demonstrations, frozen: s is standardised by them, delta
for the V_k too, while CrKR takes it with its mean removed. What delta is learnt from is a choice:
`commanded` (where it meant to be, exploration included; the duration as measured) or `achieved`
(where navdata say it was: the paper's text).

Beyond the paper, off unless asked for: other rules of selection, learning from misses (with reward
0, in the V_k only: where it should have hit is not known), and a CrKR that tunes its own length
scales and lambda.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control import Control, Course, Departure, Follower, Plant, follower
from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, BallEstimate, Drone, Eyes, Outcome, VelocityCommand, Verdict
from rotorpong.experience import Attempt
from rotorpong.learning import CrKR, Mixture, Selection, SelfTuningCrKR
from rotorpong.learning.mixture import PAPER
from rotorpong.play.lessons import Lesson, cost_of, hitting_point, reward_of
from rotorpong.play.odometer import Odometer
from rotorpong.primitives import Dmp, Library, State, fit_dmp

SHORTEST, LONGEST = 0.2, 1.5  # s: durations that a motion is given
DEFAULT_INTERVAL = 1.0 / 30.0  # s, between commands as long as only one frame was seen
SMALLEST_SD = 1e-3  # of a standardised quantity that hardly varies in the demonstrations

Labels = Literal["commanded", "achieved"]
Trigger = Literal["plane", "distance"]


@dataclass(frozen=True, slots=True)
class PaperSettings:
    """The choices that the paper leaves open."""

    plane_distance: float = 2.5  # m
    trigger: Trigger = "plane"
    labels: Labels = "commanded"
    exploration_sd: float = 0.10  # m, each axis of the hitting point's position, in training
    length_scale: float = 3.0  # of CrKR, in standard deviations of the demonstrations
    regularization: float = 0.1  # lambda of Eq. (6)
    selection: Selection = PAPER
    learn_from_misses: bool = False
    tune: bool = False  # length scales and lambda by marginal likelihood, these to begin with
    primitive: int | None = None  # of which lesson, for the player with one; None: rewarded best
    control: Control = "open"  # how motions are flown
    plant: Plant | None = None  # what control knows of the drone; None: a lag of 0.4 s

    def estimator(self) -> CrKR | SelfTuningCrKR:
        """Return the regression of hitting points, before any sample."""
        kind = SelfTuningCrKR if self.tune else CrKR
        return kind(np.full(6, self.length_scale), self.regularization)

    def triggers(self, estimate: BallEstimate) -> bool:
        """Tell whether the ball has come nearer than the plane, or than that distance."""
        place = estimate.position
        near = place[2] if self.trigger == "plane" else np.linalg.norm(place)
        return bool(near < self.plane_distance)


@dataclass(frozen=True, slots=True)
class Stroke:
    """A motion towards a hitting point."""

    begin: float  # s, t_i
    ball: Float[ndarray, "6"]  # s
    goal: Float[ndarray, "7"]  # delta
    weights: Float[ndarray, "k"]  # gamma
    dmp: Dmp
    start: State

    @property
    def course(self) -> Course:
        """The motion as a follower takes it."""
        goal, duration = State(self.goal[:3], self.goal[3:6]), float(self.goal[6])

        def sample(elapsed: Float[ndarray, "n"]) -> tuple[ndarray, ndarray, ndarray]:
            motion = self.dmp.roll_out(self.start, goal, duration, elapsed)
            assert motion.acceleration is not None, "a rolled out motion has one"
            return motion.position, motion.velocity, motion.acceleration

        return Course(self.begin, duration, sample)

    def departing(self, departure: Departure, gone: Float[ndarray, "3"]) -> "Stroke":
        """Return the stroke that begins where the drone can, without a jerk, to arrive as this.

        Args:
            departure: when, where and how fast.
            gone: how far it went from the beginning of this stroke to the departure, m.
        """
        late = departure.time - self.begin
        duration = max(float(self.goal[6]) - late, SHORTEST)
        goal = np.concatenate([self.goal[:3] - gone, self.goal[3:6], [duration]])
        start = State(departure.position, departure.velocity, np.zeros(3))
        return replace(self, begin=departure.time, goal=goal, start=start)

    def command(self, now: float, interval: float) -> VelocityCommand:
        """Return what to command, open loop, at `now` until the next, `interval` later (s)."""
        return follower("open").command(self.course, now, interval)


Choice = Callable[[BallEstimate, Float[ndarray, "3"]], Stroke]
"""From the ball at the trigger and the body's velocity (level camera axes, m/s) to a stroke."""


def ball_of(estimate: BallEstimate) -> Float[ndarray, "6"]:
    """Return s: position (m) and velocity (m/s) of an estimated ball, camera frame."""
    return np.concatenate([estimate.position, estimate.velocity])


@dataclass(frozen=True, slots=True)
class _Scale:
    """Mean and standard deviation of the demonstrations, frozen."""

    mean: Float[ndarray, "d"]
    sd: Float[ndarray, "d"]

    @classmethod
    def of(cls, rows: Float[ndarray, "n d"]) -> "_Scale":
        return cls(rows.mean(axis=0), np.maximum(rows.std(axis=0), SMALLEST_SD))

    def standard(self, row: Float[ndarray, "d"]) -> Float[ndarray, "d"]:
        return (row - self.mean) / self.sd


class PaperPlayer:
    """Plays serve after serve with what it has learnt so far."""

    def __init__(
        self,
        lessons: Sequence[Lesson],
        settings: PaperSettings | None = None,
        *,
        explore: bool = False,
    ) -> None:
        """Take in the demonstrations.

        Args:
            lessons: at least two demonstrated hits.
            settings: what the paper leaves open.
            explore: vary the hitting points, as in training.

        Raises:
            InputError: fewer than two lessons.
        """
        if len(lessons) < 2:
            raise InputError(f"{len(lessons)} demonstrations: expected at least 2 to learn from")
        self._settings = settings or PaperSettings()
        self._explore = explore
        self.library = Library(tuple(_primitive(lesson) for lesson in lessons))
        self._ball_scale = _Scale.of(np.stack([lesson.ball for lesson in lessons]))
        self._goal_scale = _Scale.of(np.stack([lesson.hitting_point for lesson in lessons]))
        self._crkr = self._settings.estimator()
        self._mixture = Mixture.prior(len(lessons), features=14)
        self._stroke: Stroke | None = None
        self._odometer = Odometer()
        for k, lesson in enumerate(lessons):
            credit = np.eye(len(lessons))[k]
            self.remember(Attempt(lesson.ball, lesson.hitting_point, credit), lesson.reward)

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve."""
        self.strike(
            drone,
            eyes,
            lambda seen, velocity: self.stroke(seen, self.aim(seen, rng), velocity, rng),
        )

    def strike(self, drone: Drone, eyes: Eyes, choose: Choice) -> None:
        """Play one serve with the stroke that `choose` returns for the ball at the trigger."""
        self._stroke, self._odometer = None, Odometer()
        flown, course = follower(self._settings.control, self._settings.plant), None
        interval, before = DEFAULT_INTERVAL, math.nan
        while (observation := drone.observe()) is not None:
            self._odometer.add(observation.navdata)
            flown.sense(observation.navdata)
            now = observation.arrival_time
            interval = interval if math.isnan(before) else now - before
            before = now
            if self._stroke is None:
                self._stroke = self._begun(eyes.see(observation), choose)
                course = None if self._stroke is None else self._course(self._stroke, flown, now)
            command = HOVER if course is None else flown.command(course, now, interval)
            flown.sent(now, drone.command(command))

    def learn(self, verdict: Verdict) -> None:
        """Learn from the serve just played, if it was a hit or misses are learnt from."""
        self.recall(verdict.outcome, self.attempt(verdict), reward_of(verdict))

    def recall(self, outcome: Outcome, attempt: Attempt | None, reward: float) -> None:
        """Learn what a serve teaches that was played now or in an earlier run."""
        if attempt is None:
            return
        if outcome == "hit":
            self.remember(attempt, reward)
        elif self._settings.learn_from_misses and outcome != "fault":  # a fault is the thrower's
            self._reward(attempt, 0.0)

    def attempt(self, verdict: Verdict) -> Attempt | None:
        """Return what was tried in the serve just played, labelled; `None` if nothing was."""
        if self._stroke is None:
            return None
        stroke, goal = self._stroke, self._stroke.goal
        if verdict.contact_time is not None and verdict.contact_time > stroke.begin:
            if self._settings.labels == "achieved":
                goal = hitting_point(self._odometer.path(stroke.begin, verdict.contact_time))
            else:
                goal = np.append(goal[:6], verdict.contact_time - stroke.begin)
        return Attempt(stroke.ball, goal, stroke.weights)

    def remember(self, attempt: Attempt, reward: float) -> None:
        """Add one success to the estimator and the mixture."""
        ball, goal = attempt.state, attempt.hitting_point
        self._crkr.partial_fit(
            self._ball_scale.standard(ball)[None],
            (goal - self._goal_scale.mean)[None],
            cost=np.array([cost_of(reward)]),
        )
        self._reward(attempt, reward)

    def hitting_point(self, ball: Float[ndarray, "6"]) -> Float[ndarray, "7"]:
        """Return delta(s) of Eq. (6) for a ball at the plane."""
        standard = self._ball_scale.standard(ball)[None]
        return self._crkr.predict(standard)[0] + self._goal_scale.mean

    def aim(self, estimate: BallEstimate, rng: np.random.Generator) -> Float[ndarray, "7"]:
        """Return the hitting point for the ball at the trigger, varied where this player explores.

        `rng` is left alone where it does not.
        """
        goal = self.hitting_point(ball_of(estimate))
        if self._explore:
            goal[:3] += rng.normal(0.0, self._settings.exploration_sd, size=3)
        return goal

    def standardised(self, ball: Float[ndarray, "6"]) -> Float[ndarray, "6"]:
        """Return a ball in standard deviations of the demonstrated balls from their mean."""
        return self._ball_scale.standard(ball)

    def triggers(self, estimate: BallEstimate) -> bool:
        """Tell whether a ball is so near that the stroke begins."""
        return self._settings.triggers(estimate)

    def stroke(
        self,
        estimate: BallEstimate,
        goal: Float[ndarray, "7"],
        velocity: Float[ndarray, "3"],
        rng: np.random.Generator | None = None,
        *,
        weights: Float[ndarray, "k"] | None = None,
    ) -> Stroke:
        """Return the motion that the library mixes for a hitting point.

        Args:
            estimate: the ball at the trigger.
            goal: delta: displacement (m) and velocity (m/s) in level camera axes, duration (s),
                which is kept within what a motion may take.
            velocity: of the body at the trigger, level camera axes, m/s.
            rng: throws the dice of the rule of selection, if it needs any.
            weights: of the primitives; None: those of the mixture.
        """
        ball = ball_of(estimate)
        goal = np.append(goal[:6], np.clip(goal[6], SHORTEST, LONGEST))
        if weights is None:
            features = self._features(ball, goal)
            weights = self._mixture.select(features, self._settings.selection, rng)
        start = State(np.zeros(3), velocity)
        return Stroke(estimate.time, ball, goal, weights, self.library.mix(weights), start)

    def _begun(self, estimate: BallEstimate | None, choose: Choice) -> Stroke | None:
        if estimate is None or not self.triggers(estimate):
            return None
        return choose(estimate, self._odometer.velocity(estimate.time))

    def _reward(self, attempt: Attempt, reward: float) -> None:
        features = self._features(attempt.state, attempt.hitting_point)
        self._mixture = self._mixture.update(features, reward, attempt.mixture_weights)

    def _course(self, stroke: Stroke, flown: Follower, now: float) -> Course:
        if self._settings.control == "open":
            return stroke.course
        late = now > stroke.begin
        gone = self._odometer.path(stroke.begin, now).positions[-1] if late else np.zeros(3)
        return stroke.departing(flown.depart(now), gone).course

    def _features(
        self, ball: Float[ndarray, "6"], goal: Float[ndarray, "7"]
    ) -> Float[ndarray, "14"]:
        parts = [[1.0], self._ball_scale.standard(ball), self._goal_scale.standard(goal)]
        return np.concatenate(parts)


def _primitive(lesson: Lesson) -> Dmp:
    path = lesson.path
    return fit_dmp(path.times, path.positions, velocities=path.velocities)
