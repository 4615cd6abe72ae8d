"""`rotorpong/Intercept-v0`, many serves at once: `gymnasium.make_vec`.

Row i is the environment `InterceptEnv` that was reset with seed S + i, trial by trial. A row whose
serve is over begins its next serve in the step that follows, whose action is not used for it
(`AutoresetMode.NEXT_STEP`).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float, Float32, Int64
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.environments.arena import Place, arena, place_of
from rotorpong.lab.environments.intercept import (
    ACTION,
    OBSERVATION,
    require_shaping,
    reward_of,
)
from rotorpong.lab.environments.spaces import action_of, box, within
from rotorpong.physics.camera import Camera
from rotorpong.physics.vehicle import Vehicle
from rotorpong.world.batch import ServeBatch

Seeds = int | Sequence[int | None] | None


class InterceptVectorEnv(VectorEnv[Float32[ndarray, "n 18"], Float32[ndarray, "n 4"], ndarray]):
    """n serves at once."""

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(  # noqa: PLR0913 - these are the keywords of gymnasium.make
        self,
        num_envs: int = 1,
        *,
        vehicle: str | Vehicle = "tum_gazebo",
        camera: str | Camera = "gazebo",
        serves: str = "human",
        racket: str = "cardboard",
        purpose: str = "evaluate",
        tell_reachable: bool = True,
        shaping: float = 0.0,
    ) -> None:
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
        self._arena = arena(
            vehicle, camera, serves, racket, purpose=purpose, tell_reachable=tell_reachable
        )
        self._shaping = shaping
        self._limits = self._arena.setting.vehicle.limits
        self._places: list[Place] = []
        self._batch: ServeBatch | None = None

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
        casts = [self._arena.cast(place.seed, place.trial) for place in self._places]
        self._batch = ServeBatch(self._arena.setting, casts)
        self._batch.advance()
        return self._observation(self._batch), {}

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
        batch = self._batch
        if batch is None:
            raise InputError("no serve is on its way: call reset() before step()")
        commands = action_of(actions, (self.num_envs, 4)) * self._limits
        anew = np.flatnonzero(batch.over)
        batch.command(commands, told=~batch.over)
        self._restart(batch, anew.tolist())
        batch.advance()
        over = batch.over
        info = self._told(batch, np.flatnonzero(over))
        rewards = np.zeros(self.num_envs)
        for row in np.flatnonzero(over):
            rewards[row] = reward_of(
                info["outcome"][row], info["miss_distance_m"][row], self._shaping
            )
        return self._observation(batch), rewards, over, np.zeros(self.num_envs, bool), info

    def _seeds(self, seed: Seeds) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise InputError(f"{len(seed)} seeds: expected one for each of {self.num_envs} rows")
        return list(seed)

    def _restart(self, batch: ServeBatch, rows: list[int]) -> None:
        for row in rows:
            self._places[row] = place = self._places[row].next()
            batch.restart([row], [self._arena.cast(place.seed, place.trial)])

    def _told(self, batch: ServeBatch, ended: Int64[ndarray, "rows"]) -> dict[str, Any]:
        """Return the info of the rows that ended, with gymnasium's masks; else nothing."""
        if not len(ended):
            return {}
        mask = batch.over
        reachable = np.full(self.num_envs, None, dtype=object)
        for row in ended.tolist():
            reachable[row] = self._arena.reachable(self._places[row])
        info: dict[str, Any] = {
            "outcome": np.array(batch.outcomes, dtype=object),
            "miss_distance_m": batch.miss_distances.copy(),
            "time_error_s": batch.time_errors,
            "reachable": reachable,
            "seed": np.array([place.seed for place in self._places]),
            "trial": np.array([place.trial for place in self._places]),
        }
        info["hit"] = info["outcome"] == "hit"
        return info | {f"_{key}": mask for key in info}

    def _observation(self, batch: ServeBatch) -> Float32[ndarray, "n 18"]:
        assert isinstance(self.single_observation_space, spaces.Box)
        return within(batch.states(), self.single_observation_space)
