"""Rows about whole serves: how many a core plays, without pictures and with them.

Time is CPU time of one thread, nothing is taken from a cache of pictures. Balls are human serves.
"""

import itertools
import time
from dataclasses import dataclass

import numpy as np

from rotorpong.drone import HOVER, Drone, Eyes, Player, Verdict
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.lab.evaluate import Knowledge, make_player
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Stage, play_trial
from rotorpong.play.hover import Hover
from rotorpong.world.simulated_drone import SimulatedDrone


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure and return the rows."""
    import cv2

    cv2.setNumThreads(1)
    return (
        Row("control steps from Python, no picture", _steps(quick=quick), "steps/s", 10_000.0),
        Row("serves at a hovering drone, one by one", _unseen(quick=quick), "trials/s"),
        Row("vision trials, every frame, 640x360", _seen("gazebo", quick=quick), "trials/s", 8.0),
        Row("trials of the paper's player, 640x360", _paper(quick=quick), "trials/s"),
    )


@dataclass(frozen=True, slots=True)
class Watcher:
    """Hovers, and looks at every frame."""

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve."""
        while (seen := drone.observe()) is not None:
            eyes.see(seen)
            drone.command(HOVER)

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing."""


def stage_of(spec: Spec) -> Stage:
    """Return where serves of a spec are played."""
    return Stage(spec, spec.setting(), serve_source(spec.serves, spec.seed), "evaluate")


def trial_seconds(spec: Spec, player: Player, trials: int, *, quick: bool) -> float:
    """Return the CPU time of one serve, s: the median over groups of different serves."""
    stage, index = stage_of(spec), itertools.count()

    def work() -> None:
        for _ in range(trials):
            play_trial(stage, next(index), player)

    return cpu_seconds(work, quick=quick) / trials


def _steps(*, quick: bool) -> float:
    """Return observations and commands per second, the serve's set-up apart."""
    spec = Spec("hover")
    _rate_of(_drone(spec, 0))  # what is loaded once is not counted
    steps: list[float] = []
    for index in range(5 if quick else 40):
        drone = _drone(spec, index)
        steps.append(_rate_of(drone))
    return float(np.median(steps))


def _rate_of(drone: SimulatedDrone) -> float:
    start, count = time.process_time(), 0
    while drone.observe() is not None:
        drone.command(HOVER)
        count += 1
    return count / (time.process_time() - start)


def _drone(spec: Spec, index: int) -> SimulatedDrone:
    generators = trial_generators(spec.seed, "evaluate", index)
    serve = serve_source(spec.serves, spec.seed)(index, generators.serve)
    return SimulatedDrone(
        serve, spec.setting(), vehicle_rng=generators.vehicle, sensor_rng=generators.sensors
    )


def _unseen(*, quick: bool) -> float:
    return 1.0 / trial_seconds(Spec("hover"), Hover(), 10, quick=quick)


def _seen(camera: str, *, quick: bool) -> float:
    return 1.0 / trial_seconds(Spec("hover", camera=camera), Watcher(), 1, quick=quick)


def _paper(*, quick: bool) -> float:
    """Frames that the player does not look at are not rendered: it looks until its trigger.

    The target for lazy looks, 50 a second, is held by the box of `render_rows`: these eyes search
    whole pictures.
    """
    spec = Spec("paper")
    player = make_player(spec, Knowledge(shipped_demonstrations()))
    return 1.0 / trial_seconds(spec, player, 2, quick=quick)
