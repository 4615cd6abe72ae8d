"""Demonstrations: recorded from a pilot, and replayed into lessons.

A demonstration keeps the seed, what was flown and the pilot's commands. Replaying it through the
simulator with whatever eyes and camera are asked for gives the ball's state at the trigger and the
navdata of the motion: a lesson. The label is what navdata say, never the truth.
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import astuple, replace

import numpy as np

from rotorpong.conventions import InputError, RotorpongError
from rotorpong.drone import BallEstimate, Eyes, VelocityCommand
from rotorpong.experience import Demonstration
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.physics.camera import GAZEBO
from rotorpong.play.lessons import Lesson, reward_of
from rotorpong.play.odometer import Odometer
from rotorpong.play.paper import PaperSettings
from rotorpong.play.pilot import ScriptedPilot
from rotorpong.vision import PaperEyes
from rotorpong.world.simulated_drone import SimulatedDrone, Tape

FLOWN = {"vehicle": "tum_gazebo", "serves": "human"}
PILOT = "scripted"
MOST_SERVES_PER_HIT = 50

Progress = Callable[[int, int], None]
"""(done, of how many), called as work goes on."""


def record_demonstrations(
    seed: int, count: int = 10, progress: Progress | None = None
) -> tuple[Demonstration, ...]:
    """Let the scripted pilot play until it has hit `count` balls; keep those.

    Raises:
        RotorpongError: it hit too few in 50 serves each.
    """
    kept: list[Demonstration] = []
    for trial in range(MOST_SERVES_PER_HIT * count):
        if len(kept) == count:
            break
        demonstration = _demonstration(seed, trial)
        if demonstration is not None:
            kept.append(demonstration)
            if progress is not None:
                progress(len(kept), count)
    if len(kept) < count:
        raise RotorpongError(f"the scripted pilot hit {len(kept)} balls, expected {count}")
    return tuple(kept)


def replay(demonstration: Demonstration, spec: Spec) -> Lesson | None:
    """Fly a demonstration again before the eyes, camera and trigger of a spec.

    Returns:
        The lesson; `None` if these eyes never saw the ball pass the trigger in time.

    Raises:
        InputError: it was flown on what is not known here, or no longer ends in a hit.
    """
    if dict(demonstration.spec) != FLOWN:
        raise InputError(f"demonstration flown on {dict(demonstration.spec)}: expected {FLOWN}")
    pupil = _pupil(spec, demonstration.seed)
    contents = tuple(pupil.contents().items())
    commands = tuple(map(tuple, demonstration.commands.tolist()))
    return _replayed(pupil, contents, demonstration.trial, commands)


def lessons_of(
    demonstrations: Sequence[Demonstration], spec: Spec, progress: Progress | None = None
) -> tuple[Lesson, ...]:
    """Replay demonstrations; those whose ball the eyes did not see teach nothing."""
    lessons = []
    for done, demonstration in enumerate(demonstrations, start=1):
        lessons.append(replay(demonstration, spec))
        if progress is not None:
            progress(done, len(demonstrations))
    return tuple(lesson for lesson in lessons if lesson is not None)


def _pupil(spec: Spec, seed: int) -> Spec:
    """Return what a spec says of who watches a demonstration of this seed, and nothing else."""
    asked = spec.player_settings
    return Spec(
        eyes=spec.eyes,
        camera=spec.camera_profile(),
        seed=seed,
        racket=spec.racket,
        ball=spec.ball,
        eye_settings=spec.eye_settings,
        player_settings=PlayerSettings(trigger=asked.trigger, plane_distance=asked.plane_distance),
    )


@functools.lru_cache(maxsize=256)  # every training and evaluation begins with the same ten
def _replayed(
    pupil: Spec,
    contents: tuple[tuple[str, str], ...],
    trial: int,
    commands: tuple[tuple[float, ...], ...],
) -> Lesson | None:
    """Return what a pupil learns from these commands; `contents` are of its files."""
    drone = _drone(pupil, trial, [(row[0], VelocityCommand(*row[1:])) for row in commands])
    odometer, trigger = _watch(drone, pupil.make_eyes(drone), pupil.player_settings.of_paper())
    verdict = drone.verdict()
    if verdict.contact_time is None:
        raise InputError(
            f"demonstration {trial} of seed {pupil.seed} no longer hits: "
            "it was recorded with another version of the simulator"
        )
    if trigger is None or trigger.time >= verdict.contact_time:
        return None
    ball = np.concatenate([trigger.position, trigger.velocity])
    return Lesson(ball, odometer.path(trigger.time, verdict.contact_time), reward_of(verdict))


def _demonstration(seed: int, trial: int) -> Demonstration | None:
    pilot, spec = ScriptedPilot(), Spec(seed=seed)
    drone = _drone(spec, trial, ())
    eyes = PaperEyes(GAZEBO, whole_pixels=False)
    pilot.play(drone, eyes, trial_generators(seed, "demonstrate", trial).player)
    if drone.verdict().outcome != "hit":
        return None
    rows = [(time, *astuple(command)) for time, command in pilot.commands]
    return Demonstration(seed, trial, FLOWN, PILOT, np.array(rows))


def _drone(spec: Spec, trial: int, tape: Tape) -> SimulatedDrone:
    plain = replace(spec, blackout=False, randomize=False)
    return new_drone(stage_of(plain, "demonstrate"), trial, tape)


def _watch(
    drone: SimulatedDrone, eyes: Eyes, settings: PaperSettings
) -> tuple[Odometer, BallEstimate | None]:
    odometer, trigger = Odometer(), None
    while (observation := drone.observe()) is not None:
        odometer.add(observation.navdata)
        if trigger is None:
            estimate = eyes.see(observation)
            if estimate is not None and settings.triggers(estimate):
                trigger = estimate
    if drone.last_navdata is not None:
        odometer.add(drone.last_navdata)
    return odometer, trigger
