"""`rotorpong/Primitive-v0`: the paper's decision, once per serve.

A contextual bandit. `reset` throws a ball and hovers until the eyes first see it nearer than the
2.5 m plane; the observation is the ball's state s then, in the camera frame. The one action is the
hitting point delta: where the body shall be, how fast, and how long after the trigger, in level
camera axes frozen at it. The library of the ten shipped demonstrations turns delta into one motion
and flies it open loop, exactly as the paper's player does; then the episode is over. The reward is
the paper player's: by how near the blade's centre the ball was struck (`cardboard`), or how deep on
the opponent's side it landed (`rubber`); 0 without a hit, or where the ball did not return.
"""

import functools
import math
from typing import Any, Unpack

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from jaxtyping import Float, Float32, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, BallEstimate, Eyes, Frame, Observation
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.environments.arena import (
    Arena,
    Game,
    Place,
    arena,
    place_of,
    require_render_mode,
    told,
)
from rotorpong.lab.environments.spaces import Quantity, action_of, box, within
from rotorpong.lab.spec import Spec
from rotorpong.physics.camera import Camera
from rotorpong.play import lessons
from rotorpong.play.odometer import Odometer
from rotorpong.play.paper import DEFAULT_INTERVAL, LONGEST, SHORTEST, PaperPlayer, Stroke
from rotorpong.world.court import TABLE_HALF_LENGTH
from rotorpong.world.simulated_drone import SimulatedDrone, Truth

AXES = ("right", "down", "forward")
OBSERVATION = (
    *(Quantity(f"ball_{axis}_m", "m", -10, 10, f"ball from the camera, {axis}") for axis in AXES),
    *(
        Quantity(f"ball_{axis}_m_s", "m/s", -30, 30, f"its velocity from the camera, {axis}")
        for axis in AXES
    ),
)
ACTION = (
    *(
        Quantity(f"position_{axis}_m", "m", -1, 1, f"displacement since the trigger, {axis}")
        for axis in AXES
    ),
    *(Quantity(f"velocity_{axis}_m_s", "m/s", -2, 2, f"velocity there, {axis}") for axis in AXES),
    Quantity("duration_s", "s", SHORTEST, LONGEST, "from the trigger to the contact"),
)
LOW = np.array([quantity.low for quantity in ACTION])
HIGH = np.array([quantity.high for quantity in ACTION])


def hitting_point_of(action: Float[ndarray, "*batch 7"]) -> Float[ndarray, "*batch 7"]:
    """Return the hitting point (m, m/s, s) that an action from -1 to 1 stands for."""
    return LOW + (np.asarray(action, dtype=np.float64) + 1.0) / 2.0 * (HIGH - LOW)


def action_for(hitting_point: Float[ndarray, "*batch 7"]) -> Float[ndarray, "*batch 7"]:
    """Return the action that stands for a hitting point (m, m/s, s)."""
    return 2.0 * (hitting_point - LOW) / (HIGH - LOW) - 1.0


def reward_of(truth: Truth, racket: str) -> float:
    """Return the reward of a serve, 0 to 1."""
    if racket == "rubber":
        return 0.0 if truth.landing_x is None else truth.landing_x / TABLE_HALF_LENGTH
    return lessons.reward_of(truth.verdict)


class PrimitiveEnv(gym.Env[Float32[ndarray, "6"], Float32[ndarray, "7"]]):
    """One decision for each serve."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 - gymnasium's own

    def __init__(
        self, *, eyes: str = "truth", render_mode: str | None = None, **game: Unpack[Game]
    ) -> None:
        """Choose what is played; see docs/environments.md.

        Raises:
            InputError: an argument is unknown.
        """
        require_render_mode(render_mode)
        self.render_mode = render_mode
        self.observation_space, self.action_space = box(OBSERVATION), spaces.Box(-1.0, 1.0, (7,))
        self._arena = arena(eyes=eyes, **game)
        self._player = player_for(self._arena)
        self._place: Place | None = None
        self._serve: _Serve | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32[ndarray, "6"], dict[str, Any]]:
        """Throw the next ball and wait for the trigger; all zeros if it never came."""
        super().reset(seed=seed)
        self._place = place_of(seed, options, self._place, self.np_random)
        drone = self._arena.drone(self._place)
        self._serve = _Serve(drone, self._arena.spec.make_eyes(drone, self._arena.setting.camera))
        estimate = self._serve.wait(self._player)
        info = told(self._place)
        return self._observation(estimate), info | {"triggered": estimate is not None}

    def step(self, action: Any) -> tuple[Float32[ndarray, "6"], float, bool, bool, dict[str, Any]]:
        """Fly to a hitting point and on to the end of the serve.

        Raises:
            InputError: the action is not seven finite numbers, or no serve is on its way.
        """
        serve, place = self._serve, self._place
        if serve is None or place is None or serve.is_played:
            raise InputError("no serve is on its way: call reset() before step()")
        serve.play(self._player, hitting_point_of(action_of(action, (7,))))
        truth = serve.drone.truth()
        unseen = truth.verdict.outcome == "miss" and not serve.has_seen
        outcome = "unseen" if unseen else truth.verdict.outcome
        reachable = self._arena.reachable(place)
        info = told(place, outcome, truth.miss_distance, truth.time_error, reachable=reachable)
        info["triggered"] = serve.estimate is not None
        reward = reward_of(truth, self._arena.spec.racket)
        return self._observation(serve.estimate), reward, True, False, info

    def render(self) -> UInt8[ndarray, "height width 3"] | None:
        """Return the onboard picture of the last frame, in red, green, blue.

        Raises:
            InputError: there was no frame yet.
        """
        if self.render_mode is None:
            return None
        if self._serve is None or self._serve.last is None:
            raise InputError("there is no picture yet: call reset() before render()")
        return np.ascontiguousarray(self._serve.last.picture[:, :, ::-1])

    def paper_action(self) -> Float[ndarray, "7"]:
        """Return what the paper's player would do now, after the ten demonstrations.

        Raises:
            InputError: the ball has not triggered.
        """
        estimate = None if self._serve is None else self._serve.estimate
        if estimate is None:
            raise InputError("no ball has triggered: there is no state to decide from")
        ball = np.concatenate([estimate.position, estimate.velocity])
        return action_for(self._player.hitting_point(ball))

    def truth(self) -> Truth:
        """Return what really happened in the serve just played, for analysis.

        Raises:
            InputError: none was played.
        """
        if self._serve is None or not self._serve.is_played:
            raise InputError("no serve was played: call reset() and step() before truth()")
        return self._serve.drone.truth()

    def _observation(self, estimate: BallEstimate | None) -> Float32[ndarray, "6"]:
        space = self.observation_space
        assert isinstance(space, spaces.Box)
        if estimate is None:
            return np.zeros(6, np.float32)
        return within(np.concatenate([estimate.position, estimate.velocity]), space)


class _Serve:
    """One serve: first the waiting, then the stroke."""

    def __init__(self, drone: SimulatedDrone, eyes: Eyes) -> None:
        self.drone, self._eyes = drone, eyes
        self._odometer = Odometer()
        self._now, self._interval = math.nan, DEFAULT_INTERVAL
        self.estimate: BallEstimate | None = None
        self.last: Frame | None = None
        self.has_seen = self.is_played = False

    def wait(self, player: PaperPlayer) -> BallEstimate | None:
        """Hover until the trigger; return the ball there."""
        while (observation := self._next()) is not None:
            estimate = self._eyes.see(observation)
            self.has_seen = self.has_seen or estimate is not None
            if estimate is not None and player.triggers(estimate):
                self.estimate = estimate
                break
            self.drone.command(HOVER)
        return self.estimate

    def play(self, player: PaperPlayer, goal: Float[ndarray, "7"]) -> None:
        """Fly the stroke towards a hitting point until the serve is over."""
        self.is_played = True
        estimate = self.estimate
        if estimate is None:
            return
        stroke: Stroke = player.stroke(estimate, goal, self._odometer.velocity(estimate.time))
        self.drone.command(stroke.command(self._now, self._interval))
        while self._next() is not None:
            self.drone.command(stroke.command(self._now, self._interval))

    def _next(self) -> Observation | None:
        """Wait for the next frame."""
        observation = self.drone.observe()
        if observation is not None:
            now = observation.arrival_time
            self._interval = DEFAULT_INTERVAL if math.isnan(self._now) else now - self._now
            self._now, self.last = now, observation.frame
            self._odometer.add(observation.navdata)
        return observation


def player_for(arena: Arena) -> PaperPlayer:
    """Return the paper's player after the ten shipped demonstrations, as these eyes see them."""
    return PaperPlayer(_lessons(arena.spec.eyes, arena.spec.camera, arena.spec.racket))


@functools.lru_cache(maxsize=8)
def _lessons(eyes: str, camera: str | Camera, racket: str) -> tuple[lessons.Lesson, ...]:
    spec = Spec(eyes=eyes, camera=camera, racket=racket)
    return lessons_of(shipped_demonstrations(), spec)
