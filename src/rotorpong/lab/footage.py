"""A serve of an evaluation played once more, keeping what the camera saw and where the ball was.

Trials depend on seed, purpose and index alone, so the second playing is the first, frame by frame.
What is kept is for people to look at; the player gets the drone's own observations, untouched.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import (
    BallEstimate,
    Drone,
    Observation,
    Player,
)
from rotorpong.lab.oracle import Gate
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.trial import Controls, Played, Stage, encounter, play_trial
from rotorpong.physics.camera import in_picture
from rotorpong.play.paper import PaperSettings
from rotorpong.world.simulated_drone import Setting, SimulatedDrone

_Seen = list[tuple[Observation, Float[ndarray, "3"]]]

WELL_MOVED = 0.4  # m: a blade that went farther to its ball is no prettier


@dataclass(frozen=True, slots=True)
class Sight:
    """One frame, what the eyes made of it, and the truth."""

    observation: Observation
    estimate: BallEstimate | None
    ball: Float[ndarray, "3"]  # m, true, camera frame


@dataclass(frozen=True, slots=True)
class Take:
    """A serve played again."""

    played: Played
    sights: tuple[Sight, ...]
    setting: Setting  # what the serve really met
    settings: PaperSettings  # of the player: when it is set going

    @property
    def trigger(self) -> BallEstimate | None:
        """The first estimate that sets the paper's player going."""
        estimates = (sight.estimate for sight in self.sights)
        return next((one for one in estimates if one and self.settings.triggers(one)), None)


def play_again(stage: Stage, index: int, player: Player, *, look: bool = True) -> Take:
    """Play serve `index` of a stage again.

    Args:
        stage: as in the evaluation.
        index: of the serve.
        player: with what it knew then.
        look: let fresh eyes look at every frame, also those that the player did not look at.
    """
    watching: list[_Watched | _WatchedGate] = []

    def watch(drone: SimulatedDrone) -> Drone:
        door = _WatchedGate if stage.spec.player == "oracle" else _Watched
        watching.append(door(drone))
        return watching[0]

    played = play_trial(stage, index, player, watch=watch)
    watched = watching[0]
    looking = stage.spec.make_eyes(watched.drone, stage.setting.camera) if look else None
    sights = tuple(
        Sight(seen, looking.see(seen) if looking else None, ball) for seen, ball in watched.seen
    )
    generators = trial_generators(stage.spec.seed, stage.purpose, index)
    settings = stage.spec.player_settings.of_paper()
    return Take(played, sights, encounter(stage, index, generators)[0], settings)


def most_telling(stage: Stage, indices: Iterable[int], player: Player) -> int:
    """Return the serve most worth showing: hit in the middle, long in view, far to go.

    Args:
        stage: as in the evaluation.
        indices: the serves to choose from, at least one.
        player: with what it knew then.
    """
    takes = [play_again(stage, index, player, look=False) for index in indices]
    return max(takes, key=lambda take: _beauty(take)).played.index


def _beauty(take: Take) -> float:
    truth = take.played.truth
    offset = truth.verdict.contact_offset
    balls = np.stack([sight.ball for sight in take.sights])
    in_view = float(np.mean(in_picture(take.setting.camera, balls)))
    moved = float(np.linalg.norm(truth.blade_path[-1] - truth.blade_path[0]))
    central = -truth.miss_distance if offset is None else 1.0 - offset
    return central + 0.5 * in_view + 0.5 * min(moved / WELL_MOVED, 1.0)


class _Watched(Controls):
    """A drone that keeps what it handed out."""

    def __init__(self, drone: SimulatedDrone) -> None:
        super().__init__(drone)
        self.drone = drone
        self.seen: _Seen = []

    def observe(self) -> Observation | None:
        return _noted(super().observe(), self.drone, self.seen)


class _WatchedGate(Gate):
    """The same for a player that stands before a gate."""

    def __init__(self, drone: SimulatedDrone) -> None:
        super().__init__(drone)
        self.seen: _Seen = []

    def observe(self) -> Observation | None:
        return _noted(super().observe(), self.drone, self.seen)


def _noted(
    observation: Observation | None, drone: SimulatedDrone, seen: _Seen
) -> Observation | None:
    if observation is not None:
        seen.append((observation, drone.ball_in_camera(observation.frame_time)[0]))
    return observation
