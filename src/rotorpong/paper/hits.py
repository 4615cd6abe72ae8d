"""The hits of a training run, played again for what their records do not hold.

A learner that learns from hits only is a function of the hits before, and a trial's generators
depend on (seed, trial) alone: so its hits, played again in their order, come out as they did. This
time a witness sits beside the player, keeps its navdata and asks the world where the ball went.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS
from rotorpong.drone import HOVER, Drone, Observation
from rotorpong.experience import Attempt, Trial
from rotorpong.lab.evaluate import Knowledge, make_player
from rotorpong.lab.reachable import free_path
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Controls, new_drone, play_trial, stage_of
from rotorpong.play.lessons import hitting_point
from rotorpong.play.odometer import Odometer
from rotorpong.play.paper import PaperSettings, ball_of
from rotorpong.world.contact import TICK
from rotorpong.world.simulated_drone import SimulatedDrone


@dataclass(frozen=True, slots=True)
class Hit:
    """One own hit, with both labels."""

    trial: Trial  # as it was kept: labelled `commanded`
    achieved: Float[ndarray, "7"]  # where navdata say the body was, as a hitting point

    def attempt(self, labels: str) -> Attempt:
        """Return what was tried, labelled so."""
        tried = self.trial.attempt
        assert tried is not None, "a hit of a moving player was tried"
        if labels == "commanded":
            return tried
        return Attempt(tried.state, self.achieved, tried.mixture_weights)


@dataclass(frozen=True, slots=True)
class Serve:
    """One serve as a hovering drone meets it."""

    ball: Float[ndarray, "6"]  # as the eyes tell at the trigger
    need: Float[ndarray, "2"]  # m right and down, from the blade there to where the ball passes


class Witness(Controls):
    """The controls of a drone, with the navdata that went through them."""

    __slots__ = ("odometer",)

    def __init__(self, drone: SimulatedDrone) -> None:
        """Sit beside the player of this drone."""
        super().__init__(drone)
        self.odometer = Odometer()

    def observe(self) -> Observation | None:
        """Hand on an observation, keeping its navdata."""
        observation = super().observe()
        if observation is not None:
            self.odometer.add(observation.navdata)
        return observation


def hits_again(spec: Spec, known: Knowledge) -> Iterator[Hit]:
    """Play the hits of a training run again, in their order.

    Args:
        spec: of the run; its player learns from hits only, labelled `commanded`.
        known: what the run kept.
    """
    player = make_player(spec, Knowledge(known.demonstrations), explore=True)
    stage = stage_of(spec, "train")
    for trial in known.trials:
        if trial.outcome != "hit" or trial.attempt is None:
            continue
        seats: list[Witness] = []
        verdict = play_trial(stage, trial.index, player, watch=_seated(seats)).verdict
        assert player.attempt(verdict) == trial.attempt, "a trial depends on seed and hits alone"
        yield Hit(trial, _achieved(seats[0].odometer, trial, trial.attempt))
        player.recall(trial.outcome, trial.attempt, trial.reward)


def serves_seen(spec: Spec, serves: int) -> Sequence[Serve]:
    """Return what a hovering drone's eyes tell of serves at the trigger, and what each would need.

    Serves that never trigger or never pass the blade are left out.
    """
    stage, settings = stage_of(spec), spec.player_settings.of_paper()
    met = (_met(spec, settings, new_drone(stage, index)) for index in range(serves))
    return [serve for serve in met if serve is not None]


def _seated(seats: list[Witness]) -> Callable[[SimulatedDrone], Drone]:
    """Return what seats a witness beside the player, and keeps it."""

    def watch(drone: SimulatedDrone) -> Drone:
        seats.append(Witness(drone))
        return seats[-1]

    return watch


def _achieved(odometer: Odometer, trial: Trial, tried: Attempt) -> Float[ndarray, "7"]:
    end = trial.contact_time
    assert end is not None, "a hit has a contact"
    return hitting_point(odometer.path(end - float(tried.hitting_point[6]), end))


def _met(spec: Spec, settings: PaperSettings, drone: SimulatedDrone) -> Serve | None:
    path, eyes = free_path(drone.now), spec.make_eyes(drone)
    while (observation := drone.observe()) is not None:
        drone.command(HOVER)
        seen = eyes.see(observation)
        if seen is None or not settings.triggers(seen):
            continue
        blade = drone.truth().blade_path[round(seen.time / TICK)]
        passed = np.flatnonzero(path[:, 0] - blade[0] < BALL_RADIUS)
        if not len(passed):
            return None
        return Serve(ball_of(seen), -(path[passed[0]] - blade)[1:])
    return None
