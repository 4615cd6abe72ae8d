"""One serve played: world, eyes and player brought together, and what came of it."""

import contextlib
import copy
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rotorpong.conventions import UnsolvableServeError, one_line
from rotorpong.drone import (
    BallEstimate,
    Drone,
    Eyes,
    Observation,
    Outcome,
    Player,
    VelocityCommand,
    Verdict,
)
from rotorpong.lab.randomize import draw_trial
from rotorpong.lab.seeds import Generators, Purpose, trial_generators
from rotorpong.lab.serving import ServeSource, serve_source
from rotorpong.lab.spec import Spec
from rotorpong.world.serves import Medium, Serve
from rotorpong.world.simulated_drone import Setting, SimulatedDrone, Tape, Truth

MOST_BALLS = 20  # that are drawn for one serve
MOST_CALLS_TOO_LATE = 1000  # of a player that goes on when its serve is over


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
    is_broken_off: bool = False  # by an error of the player, with the ball still on its way

    @property
    def verdict(self) -> Verdict:
        """What the referee says."""
        return self.truth.verdict

    @property
    def outcome(self) -> Outcome:
        """In one word."""
        return self.truth.verdict.outcome

    @property
    def miss_distance(self) -> float | None:
        """How near the blade came to the ball, m; 0 for a hit, None for a serve broken off."""
        return None if self.is_broken_off else self.truth.miss_distance

    @property
    def time_error(self) -> float | None:
        """How late the blade was, s; None where that cannot be told."""
        return None if self.is_broken_off else self.truth.time_error


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


class Controls:
    """All that a player gets of a drone: to observe and to command."""

    __slots__ = ("_command", "_late", "_observe")

    def __init__(self, drone: SimulatedDrone) -> None:
        self._observe, self._command = drone.observe, drone.command
        self._late = 0

    def observe(self) -> Observation | None:
        """Wait for the next frame; `None` when the serve is over.

        Raises:
            RuntimeError: the serve has long been over.
        """
        observation = self._observe()
        if observation is None or self._late:
            self._late += 1
            if self._late > MOST_CALLS_TOO_LATE:
                raise RuntimeError(
                    f"observe() was called {MOST_CALLS_TOO_LATE} times after it returned None: "
                    "a serve is over then, and play must return"
                )
        return observation

    def command(self, velocity: VelocityCommand) -> VelocityCommand:
        """Fly at `velocity` from now on; return what was sent."""
        return self._command(velocity)


def stage_of(spec: Spec, purpose: Purpose = "evaluate") -> Stage:
    """Return where the serves of a spec are played."""
    return Stage(spec, spec.setting(), serve_source(spec.serves, spec.seed), purpose)


def play_trial(
    stage: Stage,
    index: int,
    player: Player,
    *,
    watch: Callable[[SimulatedDrone], Drone] = Controls,
) -> Played:
    """Play serve `index` of a stage.

    The player gets what `watch` makes of the drone: by default observe and command, nothing else.

    A player that raises an error before the serve is over has played a `fault`: the serve ends
    there, whatever the ball does after. What it raised goes to stderr.
    """
    generators = trial_generators(stage.spec.seed, stage.purpose, index)
    serve, drone = meet(stage, index, generators)
    witness = _Witness(stage.spec.make_eyes(drone, stage.setting.camera))
    error = _error_of(player, watch(drone), witness, generators.player)
    if error is not None:
        said = f"{type(error).__name__}: {one_line(error)}"
        print(f"rotorpong: trial {index}: {said}", file=sys.stderr)  # noqa: T201
    failed = error is not None and not drone.is_over
    return Played(index, serve, _amended(drone.truth(), failed=failed, witness=witness), failed)


def meet(
    stage: Stage, index: int, generators: Generators, tape: Tape = ()
) -> tuple[Serve, SimulatedDrone]:
    """Return serve `index` and the drone that hovers there at the instant of its release."""
    setting, serve = encounter(stage, index, generators)
    drone = SimulatedDrone(
        serve,
        setting,
        vehicle_rng=generators.vehicle,
        sensor_rng=generators.sensors,
        tape=tape,
    )
    return serve, drone


def encounter(stage: Stage, index: int, generators: Generators) -> tuple[Setting, Serve]:
    """Return what serve `index` really meets, which may be a world of its own, and the serve."""
    if not stage.spec.randomize:
        return stage.setting, stage.serves(index, generators.serve)
    setting, draw_ball = draw_trial(stage.setting, generators.world, ball=stage.spec.ball_colour)
    return setting, _thrown(stage.serves, index, generators.serve, draw_ball)


def new_drone(stage: Stage, index: int, tape: Tape = ()) -> SimulatedDrone:
    """Return the drone of serve `index` at the instant of the release, as every player meets it.

    Args:
        stage: where the serve is played.
        index: of the serve.
        tape: commands that are given at their times, as in a replay.
    """
    generators = trial_generators(stage.spec.seed, stage.purpose, index)
    return meet(stage, index, generators, tape)[1]


def _thrown(
    serves: ServeSource, index: int, rng: np.random.Generator, draw_ball: Callable[[], Medium]
) -> Serve:
    """Return the serve with the first ball that can be thrown so; the target stays as drawn."""
    for _ in range(MOST_BALLS - 1):
        with contextlib.suppress(UnsolvableServeError):
            return serves(index, copy.deepcopy(rng), draw_ball())
    return serves(index, rng, draw_ball())


def _error_of(
    player: Player, drone: Drone, eyes: Eyes, rng: np.random.Generator
) -> BaseException | None:
    try:
        player.play(drone, eyes, rng)
    except (Exception, SystemExit, GeneratorExit) as error:  # noqa: BLE001 - of a user's player
        return error
    return None


def _amended(truth: Truth, *, failed: bool, witness: _Witness) -> Truth:
    """Return the truth with the outcomes that only the player's side can tell."""
    if failed:
        return replace(truth, verdict=Verdict("fault"), landing_x=None)
    if truth.verdict.outcome == "miss" and witness.asked and not witness.answered:
        return replace(truth, verdict=Verdict("unseen"))
    return truth
