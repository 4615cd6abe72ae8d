"""`rotorpong/InterceptVision-v0`: the same game, told what a real drone would tell.

The observation holds the frame and the navdata that came with it, averaged over the samples since
the frame before; delays and noise are those of the vehicle and the camera. At the end of a serve
there is no further frame: the last one is shown again.
"""

import math
from typing import Any, Unpack

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from jaxtyping import Float32, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import Navdata, Observation, VelocityCommand
from rotorpong.lab.environments.arena import (
    Game,
    Place,
    arena,
    place_of,
    require_render_mode,
    told,
)
from rotorpong.lab.environments.intercept import ACTION, require_shaping, reward_of
from rotorpong.lab.environments.spaces import Quantity, action_of, box, within
from rotorpong.world.simulated_drone import SimulatedDrone

AXES = ("forward", "left", "up")
NAVDATA = (
    *(Quantity(f"rate_{axis}_rad_s", "rad/s", -50, 50, f"gyro, {axis} axis") for axis in AXES),
    *(
        Quantity(f"force_{axis}_m_s2", "m/s²", -100, 100, f"accelerometer, {axis} axis")
        for axis in AXES
    ),
    *(
        Quantity(f"{angle}_rad", "rad", -math.pi, math.pi, f"{angle}")
        for angle in ("roll", "pitch", "yaw")
    ),
    *(
        Quantity(f"own_{axis}_m_s", "m/s", -10, 10, f"velocity by optical flow, {axis}")
        for axis in AXES
    ),
    Quantity("height_m", "m", -10, 10, "sonar, above what lies below"),
    Quantity("battery", "1", 0, 1, "charge"),
    Quantity("time_s", "s", 0, 4, "since the release, when the frame arrived"),
    Quantity("sight_age_s", "s", 0, 4, "since the middle of the frame's exposure"),
)

Seen = dict[str, Any]


class InterceptVisionEnv(gym.Env[Seen, Float32[ndarray, "4"]]):
    """One serve after the other, seen through the onboard camera."""

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
        self._arena = arena(**game)
        eye = self._arena.setting.camera
        self._navdata_space = box(NAVDATA)
        self.observation_space = spaces.Dict(
            {
                "frame": spaces.Box(0, 255, (eye.height_px, eye.width_px, 3), np.uint8),
                "navdata": self._navdata_space,
            }
        )
        self.action_space = box(ACTION)
        self._shaping = shaping
        self._limits = self._arena.setting.vehicle.limits
        self._place: Place | None = None
        self._drone: SimulatedDrone | None = None
        self._seen: Seen = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Seen, dict[str, Any]]:
        """Throw the next ball and wait for the first frame."""
        super().reset(seed=seed)
        self._place = place_of(seed, options, self._place, self.np_random)
        self._drone = self._arena.drone(self._place)
        observation = self._drone.observe()
        if observation is None:
            raise InputError(f"trial {self._place.trial}: the serve ended before the first frame")
        self._seen = self._seen_in(observation)
        return self._seen, told(self._place)

    def step(self, action: Any) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        """Command a velocity and wait for the next frame.

        Raises:
            InputError: the action is not four finite numbers, or no serve is on its way.
        """
        drone, place = self._drone, self._place
        if drone is None or place is None or drone.is_over:
            raise InputError("no serve is on its way: call reset() before step()")
        commands = action_of(action, (4,)) * self._limits
        drone.command(VelocityCommand(*commands.tolist()))
        observation = drone.observe()
        if observation is not None:
            self._seen = self._seen_in(observation)
            return self._seen, 0.0, False, False, told(place)
        truth = drone.truth()
        outcome, miss = truth.verdict.outcome, truth.miss_distance
        reachable = self._arena.reachable(place)
        info = told(place, outcome, miss, truth.time_error, reachable=reachable)
        self._seen = {name: part.copy() for name, part in self._seen.items()}
        return self._seen, reward_of(outcome, miss, self._shaping), True, False, info

    def render(self) -> UInt8[ndarray, "height width 3"] | None:
        """Return the last frame, in red, green, blue.

        Raises:
            InputError: there was no frame yet.
        """
        if self.render_mode is None:
            return None
        if not self._seen:
            raise InputError("there is no picture yet: call reset() before render()")
        return self._seen["frame"].copy()

    def _seen_in(self, observation: Observation) -> Seen:
        times = [observation.arrival_time, observation.arrival_time - observation.frame_time]
        numbers = np.concatenate([mean_of(observation.navdata), times])
        return {
            "frame": np.ascontiguousarray(observation.frame.picture[:, :, ::-1]),
            "navdata": within(numbers, self._navdata_space),
        }


def mean_of(navdata: Navdata) -> ndarray:
    """Return the mean of some samples, 14 numbers; zeros if there are none."""
    if not len(navdata.times):
        return np.zeros(14)
    parts = (navdata.body_rates, navdata.acceleration, navdata.attitude, navdata.velocity)
    ends = (navdata.height[:, None], navdata.battery[:, None])
    return np.concatenate([part.mean(axis=0) for part in (*parts, *ends)])
