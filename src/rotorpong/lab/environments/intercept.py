"""`rotorpong/Intercept-v0`: bring the blade onto the ball, told the exact state at every frame.

One episode is one serve, one step is the time from one frame to the next (1/30 s). The state is
that of `rotorpong.world.batch.STATE`. The reward comes at the end and depends on nothing else than
what became of the serve:

    hit                  1
    fault                0        the vehicle touched table, net or floor
    any other end        shaping * exp(-miss distance / 0.1 m)

With `shaping` below 1 nothing that is not a hit is ever worth as much as a hit, there is nothing to
collect on the way, and ending early by a crash is worth nothing.
"""

import math
from typing import Any, Unpack

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from jaxtyping import Float32, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import Outcome
from rotorpong.lab.environments.arena import (
    Game,
    Place,
    arena,
    place_of,
    require_render_mode,
    told,
)
from rotorpong.lab.environments.spaces import Quantity, action_of, box, within
from rotorpong.world.batch import STATE, ServeBatch

SHAPING_LENGTH = 0.1  # m
RANGES = (
    (10.0, "m", "ball from the centre of mass, forward (level body axes), at the exposure"),
    (10.0, "m", "the same, left"),
    (10.0, "m", "the same, up"),
    (30.0, "m/s", "velocity of the ball relative to the centre of mass, forward"),
    (30.0, "m/s", "the same, left"),
    (30.0, "m/s", "the same, up"),
    (10.0, "m/s", "own velocity, forward (level body axes), now"),
    (10.0, "m/s", "the same, left"),
    (10.0, "m/s", "the same, up"),
    (10.0, "m", "centre of mass above the table's surface, now"),
    (math.pi, "rad", "roll, now"),
    (math.pi, "rad", "pitch, now; positive: nose down"),
    (math.pi, "rad", "yaw, now; 0: towards the opponent"),
    (50.0, "rad/s", "body rate about the forward axis, now"),
    (50.0, "rad/s", "the same, left axis"),
    (50.0, "rad/s", "the same, up axis"),
    (4.0, "s", "time since the release"),
    (4.0, "s", "time since the exposure of the frame: the camera's delay"),
)
OBSERVATION = tuple(
    Quantity(name, unit, 0.0 if unit == "s" else -limit, limit, meaning)
    for name, (limit, unit, meaning) in zip(STATE, RANGES, strict=True)
)
ACTION = tuple(
    Quantity(name, "of the vehicle's limit", -1.0, 1.0, meaning)
    for name, meaning in (
        ("forward", "commanded velocity, forward (level body axes)"),
        ("left", "the same, left"),
        ("up", "the same, up"),
        ("yaw_rate", "commanded turn, counter-clockwise seen from above"),
    )
)


def reward_of(outcome: Outcome, miss_distance: float, shaping: float) -> float:
    """Return what a serve that is over pays."""
    if outcome == "fault":
        return 0.0
    return 1.0 if outcome == "hit" else shaping * math.exp(-miss_distance / SHAPING_LENGTH)


def require_shaping(shaping: float) -> None:
    """Raise InputError unless a miss is worth less than a hit."""
    if not 0.0 <= shaping < 1.0:
        raise InputError(f"shaping {shaping}: expected a number from 0 to below 1")


class InterceptEnv(gym.Env[Float32[ndarray, "18"], Float32[ndarray, "4"]]):
    """One serve after the other."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 - gymnasium's own

    def __init__(
        self, *, shaping: float = 0.0, render_mode: str | None = None, **game: Unpack[Game]
    ) -> None:
        """Choose what is played; see docs/environments.md.

        Raises:
            InputError: an argument is unknown or out of range.
        """
        require_shaping(shaping)
        require_render_mode(render_mode)
        self.render_mode = render_mode
        self.observation_space = box(OBSERVATION)
        self.action_space = box(ACTION)
        self._arena = arena(**game)
        self._shaping = shaping
        self._limits = self._arena.setting.vehicle.limits
        self._place: Place | None = None
        self._batch: ServeBatch | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32[ndarray, "18"], dict[str, Any]]:
        """Throw the next ball and wait for the first frame."""
        super().reset(seed=seed)
        self._place = place_of(seed, options, self._place, self.np_random)
        setting, cast = self._arena.meet(self._place)
        if self._batch is None or self._batch.setting is not setting:
            self._batch = ServeBatch(setting, [cast])
        else:
            self._batch.restart([0], [cast])
        self._batch.advance()
        return self._observation(self._batch), told(self._place)

    def step(self, action: Any) -> tuple[Float32[ndarray, "18"], float, bool, bool, dict[str, Any]]:
        """Command a velocity and wait for the next frame.

        Raises:
            InputError: the action is not four finite numbers, or no serve is on its way.
        """
        batch, place = self._batch, self._place
        if batch is None or place is None or batch.over[0]:
            raise InputError("no serve is on its way: call reset() before step()")
        batch.command(action_of(action, (4,))[None] * self._limits)
        batch.advance()
        outcome = batch.outcomes[0]
        if outcome is None:
            return self._observation(batch), 0.0, False, False, told(place)
        miss, late = float(batch.miss_distances[0]), float(batch.time_errors[0])
        reachable = self._arena.reachable(place)
        late = None if math.isnan(late) else late
        info = told(place, outcome, miss, late, reachable=reachable)
        reward = reward_of(outcome, miss, self._shaping)
        return self._observation(batch), reward, True, False, info

    def render(self) -> UInt8[ndarray, "height width 3"] | None:
        """Return the onboard picture of the last frame, in red, green, blue.

        Raises:
            InputError: there was no frame yet.
        """
        if self.render_mode is None:
            return None
        if self._batch is None:
            raise InputError("there is no picture yet: call reset() before render()")
        return np.ascontiguousarray(self._batch.picture(0)[:, :, ::-1])

    def _observation(self, batch: ServeBatch) -> Float32[ndarray, "18"]:
        space = self.observation_space
        assert isinstance(space, spaces.Box)
        return within(batch.states()[0], space)
