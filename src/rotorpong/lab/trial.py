"""One serve played: world, eyes and player brought together, and what came of it."""

import sys
from dataclasses import dataclass, replace

import numpy as np

from rotorpong.drone import BallEstimate, Eyes, Observation, Outcome, Player, Verdict
from rotorpong.lab.seeds import Purpose, trial_generators
from rotorpong.lab.serving import ServeSource
from rotorpong.lab.spec import Spec
from rotorpong.world.serves import Serve
from rotorpong.world.simulated_drone import Setting, SimulatedDrone, Truth


@dataclass(frozen=True, slots=True)
class Stage:
    """A spec made ready to play: what all its trials share."""

    spec: Spec
    setting: Setting
    serves: ServeSource
    purpose: Purpose


@dataclass(frozen=True, slots=True)
class Played:
    """One serve, after it was played."""

    index: int
    serve: Serve
    truth: Truth

    @property
    def verdict(self) -> Verdict:
        """What the referee says."""
        return self.truth.verdict

    @property
    def outcome(self) -> Outcome:
        """In one word."""
        return self.truth.verdict.outcome


class _Witness:
    """Eyes that remember whether they were asked and whether they answered."""

    def __init__(self, eyes: Eyes) -> None:
        self._eyes = eyes
        self.asked = self.answered = False

    def see(self, observation: Observation) -> BallEstimate | None:
        self.asked = True
        estimate = self._eyes.see(observation)
        self.answered = self.answered or estimate is not None
        return estimate


def play_trial(stage: Stage, index: int, player: Player) -> Played:
    """Play serve `index` of a stage.

    A player that raises an error before the serve is over has played a `fault`: the serve ends
    there, whatever the ball does after. What it raised goes to stderr.
    """
    generators = trial_generators(stage.spec.seed, stage.purpose, index)
    serve = stage.serves(index, generators.serve)
    drone = SimulatedDrone(
        serve,
        stage.setting,
        vehicle_rng=generators.vehicle,
        sensor_rng=generators.sensors,
    )
    witness = _Witness(stage.spec.make_eyes(drone))
    failed = _fails(player, drone, witness, generators.player, index)
    return Played(index, serve, _amended(drone.truth(), failed=failed, witness=witness))


def _fails(
    player: Player, drone: SimulatedDrone, eyes: Eyes, rng: np.random.Generator, index: int
) -> bool:
    try:
        player.play(drone, eyes, rng)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - a user's player may raise anything
        print(f"rotorpong: trial {index}: {type(error).__name__}: {error}", file=sys.stderr)  # noqa: T201
        return not drone.is_over
    return False


def _amended(truth: Truth, *, failed: bool, witness: _Witness) -> Truth:
    """Return the truth with the outcomes that only the player's side can tell."""
    if failed:
        return replace(truth, verdict=Verdict("fault"), landing_x=None)
    if truth.verdict.outcome == "miss" and witness.asked and not witness.answered:
        return replace(truth, verdict=Verdict("unseen"))
    return truth
