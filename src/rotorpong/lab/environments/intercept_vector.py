"""`rotorpong/Intercept-v0`, many serves at once: `gymnasium.make_vec`.

Row i is the environment `InterceptEnv` that was reset with seed S + i, trial by trial. A row whose
serve is over begins its next serve in the step that follows, whose action is not used for it
(`AutoresetMode.NEXT_STEP`).
"""

from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float, Float32
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.environments.arena import Game, Place, arena, place_of
from rotorpong.lab.environments.flights import Flights
from rotorpong.lab.environments.intercept import (
    ACTION,
    OBSERVATION,
    require_shaping,
    reward_of,
)
from rotorpong.lab.environments.spaces import action_of, box, within

Seeds = int | Sequence[int | None] | None


class InterceptVectorEnv(VectorEnv[Float32[ndarray, "n 18"], Float32[ndarray, "n 4"], ndarray]):
    """n serves at once."""

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(self, num_envs: int = 1, *, shaping: float = 0.0, **game: Unpack[Game]) -> None:
        """Choose what is played; see docs/environments.md.

        Raises:
            InputError: an argument is unknown or out of range.
        """
        if num_envs < 1:
            raise InputError(f"num_envs {num_envs}: expected at least 1")
        require_shaping(shaping)
        self.num_envs = num_envs
        self.single_observation_space, self.single_action_space = box(OBSERVATION), box(ACTION)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._arena = arena(**game)
        self._shaping = shaping
        self._limits = self._arena.setting.vehicle.limits
        self._places: list[Place] = []
        self._flights: Flights | None = None

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32[ndarray, "n 18"], dict[str, Any]]:
        """Throw the next ball in every row and wait for its first frame.

        Args:
            seed: of row 0, each row's is one more than that of the row before; or one for each.
            options: `trial`: which trial every row begins.
        """
        seeds = self._seeds(seed)
        super().reset(seed=next((s for s in seeds if s is not None), None))
        before = self._places or [None] * self.num_envs
        self._places = [
            place_of(s, options, b, self.np_random) for s, b in zip(seeds, before, strict=True)
        ]
        self._flights = Flights(self._arena, self._places)
        self._flights.advance()
        return self._observation(self._flights), {}

    def step(
        self, actions: Any
    ) -> tuple[
        Float32[ndarray, "n 18"],
        Float[ndarray, "n"],
        Bool[ndarray, "n"],
        Bool[ndarray, "n"],
        dict[str, Any],
    ]:
        """Command velocities and wait for every row's next frame.

        Raises:
            InputError: the actions are not finite or of another shape, or there was no reset.
        """
        flights = self._flights
        if flights is None:
            raise InputError("no serve is on its way: call reset() before step()")
        commands = action_of(actions, (self.num_envs, 4)) * self._limits
        ended = flights.over
        flights.command(commands, told=~ended)
        for row in np.flatnonzero(ended).tolist():
            self._places[row] = self._places[row].next()
            flights.restart(row, self._places[row])
        flights.advance()
        over = flights.over
        info = self._told(flights, over)
        rewards = np.zeros(self.num_envs)
        for row in np.flatnonzero(over):
            rewards[row] = reward_of(
                info["outcome"][row], info["miss_distance_m"][row], self._shaping
            )
        return self._observation(flights), rewards, over, np.zeros(self.num_envs, bool), info

    def _seeds(self, seed: Seeds) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise InputError(f"{len(seed)} seeds: expected one for each of {self.num_envs} rows")
        return list(seed)

    def _told(self, flights: Flights, over: Bool[ndarray, "n"]) -> dict[str, Any]:
        """Return the info of the rows that ended, with gymnasium's masks; else nothing."""
        if not over.any():
            return {}
        reachable = np.full(self.num_envs, None, dtype=object)
        for row in np.flatnonzero(over).tolist():
            reachable[row] = self._arena.reachable(self._places[row])
        info: dict[str, Any] = {
            "outcome": np.array(flights.outcomes, dtype=object),
            "miss_distance_m": flights.miss_distances,
            "time_error_s": flights.time_errors,
            "reachable": reachable,
            "seed": np.array([place.seed for place in self._places]),
            "trial": np.array([place.trial for place in self._places]),
        }
        info["hit"] = info["outcome"] == "hit"
        return info | {f"_{key}": over for key in info}

    def _observation(self, flights: Flights) -> Float32[ndarray, "n 18"]:
        assert isinstance(self.single_observation_space, spaces.Box)
        return within(flights.states(), self.single_observation_space)
