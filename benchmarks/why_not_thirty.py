"""Why does the paper's player not hit more, and what would help?

    python benchmarks/why_not_thirty.py [TRAINING_SERVES] [SERVES] [OWN_HITS]

The player hovers until its eyes see the ball cross the plane, so what they see there is measured
once a serve and serves all experiments. By how far the ball misses the blade's centre when it
passes the blade's home plane, right and down, is split, exactly, into

    spin, chance    need - E[need | true state]: what no eyes at the plane can tell
    eyes            E[need | true state] - E[need | seen state]
    learning        E[need | seen state] - the mean motion that the player's choice leads to
    execution       that mean motion - the motion: noise of the flight

`need` is where the ball passes, from the blade at the trigger. E[] is a kernel regression on the
exact needs of all training serves, its scales chosen on a held-out quarter of them; the mean motion
is that of flights with other noise. A part's rate is what would hit were that part zero. Prints one
JSON object per line: lengths in cm, rates in per cent. Four minutes of CPU time with 1500, 300 and
170, which are the default.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS
from rotorpong.drone import HOVER, BallEstimate, Observation
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.reachable import free_path
from rotorpong.lab.seeds import Purpose, trial_generators
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import meet, new_drone, stage_of
from rotorpong.learning import CrKR
from rotorpong.play.lessons import reward_of
from rotorpong.play.paper import PaperPlayer, PaperSettings
from rotorpong.world.contact import TICK
from rotorpong.world.racket import RACKETS
from rotorpong.world.simulated_drone import SimulatedDrone

SPEC = Spec()
SEED = SPEC.seed
FLIGHTS = 6  # with other noise, for the mean motion
BLADE = np.array([RACKETS["cardboard"].half_width, RACKETS["cardboard"].half_height])
SETTINGS = {
    "as it is": PaperSettings(),
    "length scale 12": PaperSettings(length_scale=12.0),
    "length scale 12, lambda 0.01": PaperSettings(length_scale=12.0, regularization=0.01),
    "length scale 12, lambda 0.002": PaperSettings(length_scale=12.0, regularization=0.002),
}


@dataclass(frozen=True, slots=True)
class Scene:
    """One serve up to the trigger, and what it needs."""

    index: int
    purpose: Purpose
    seen: BallEstimate | None  # what the eyes tell at the trigger
    true: Float[ndarray, "6"]  # the same, true
    begin: int  # tick of the trigger's frame
    crossing: int  # tick at which the ball passes the blade's home plane; 0: never
    need: Float[ndarray, "2"]  # m right and down


class Remembered:
    """Eyes that tell at the trigger what the paper's eyes or the truth told there."""

    def __init__(self, scene: Scene, *, truth: bool) -> None:
        """Remember one scene."""
        seen = scene.seen
        self._seen = replace(seen, **_halves(scene.true)) if seen and truth else seen

    def see(self, observation: Observation) -> BallEstimate | None:
        """Tell what was seen at this instant."""
        if self._seen is None or abs(observation.frame_time - self._seen.time) > TICK / 2:
            return None
        return self._seen


def _halves(ball: Float[ndarray, "6"]) -> dict[str, Float[ndarray, "3"]]:
    return {"position": ball[:3], "velocity": ball[3:]}


def scene_of(purpose: Purpose, index: int) -> Scene:
    """Hover until the paper's eyes see the ball cross the plane."""
    drone = new_drone(stage_of(SPEC, purpose), index)
    path, eyes, settings = free_path(drone.now), SPEC.make_eyes(drone), PaperSettings()
    while (observation := drone.observe()) is not None:
        seen = eyes.see(observation)
        if seen is not None and settings.triggers(seen):
            true = np.concatenate(drone.ball_in_camera(seen.time))
            begin = round(seen.time / TICK)
            blade = drone.truth().blade_path[begin]
            passed = np.flatnonzero(path[:, 0] - blade[0] < BALL_RADIUS)
            crossing = int(passed[0]) if len(passed) else 0
            need = _right_down(path[crossing] - blade)
            return Scene(index, purpose, seen, true, begin, crossing, need)
        drone.command(HOVER)
    return Scene(index, purpose, None, np.zeros(6), 0, 0, np.zeros(2))


def _right_down(place: Float[ndarray, "3"]) -> Float[ndarray, "2"]:
    return -place[1:]


def flown(
    player: PaperPlayer, scene: Scene, noise: int | None = None, *, truth: bool = False
) -> SimulatedDrone:
    """Play one serve, in its own noise of the vehicle or in another; return the drone."""
    stage = stage_of(SPEC, scene.purpose)
    generators = trial_generators(SEED, scene.purpose, scene.index)
    if noise is not None:
        other = np.random.default_rng([SEED, scene.index, noise])
        generators = replace(generators, vehicle=other)
    drone = meet(stage, scene.index, generators)[1]
    player.play(drone, Remembered(scene, truth=truth), generators.player)
    return drone


def moved(drone: SimulatedDrone, scene: Scene) -> Float[ndarray, "2"]:
    """Return how far the blade had moved when the ball passed, m right and down."""
    blade = drone.truth().blade_path
    return _right_down(blade[min(scene.crossing, len(blade) - 1)] - blade[scene.begin])


@dataclass(frozen=True, slots=True)
class Trained:
    """A player that learnt from its own hits, and which serves these were."""

    player: PaperPlayer
    hits: list[Scene]
    balls: int


def trained(
    settings: PaperSettings, scenes: Sequence[Scene], hits: int, *, truth: bool = False
) -> Trained:
    """Return a player that learnt from so many own hits."""
    lessons = lessons_of(shipped_demonstrations(), Spec(eyes="truth" if truth else "paper"))
    learner, still = (PaperPlayer(lessons, settings, explore=explore) for explore in (True, False))
    won: list[Scene] = []
    balls = 0
    while balls < len(scenes) and len(won) < hits:
        scene = scenes[balls]
        verdict = flown(learner, scene, truth=truth).verdict()
        still.recall(verdict.outcome, learner.attempt(verdict), reward_of(verdict))
        learner.learn(verdict)
        won, balls = won + [scene] * (verdict.outcome == "hit"), balls + 1
    return Trained(still, won, balls)


def expected(
    states: Float[ndarray, "n 6"], needs: Float[ndarray, "n 2"], asked: Float[ndarray, "m 6"]
) -> Float[ndarray, "m 2"]:
    """Return E[need | state] at the states asked for, learnt from exact needs."""
    mean, sd = states.mean(axis=0), states.std(axis=0)
    standard, asked = (states - mean) / sd, (asked - mean) / sd
    middle, quarter = needs.mean(axis=0), len(states) // 4

    def fit(rows: slice, length: float, noise: float) -> CrKR:
        return CrKR(length, noise).fit(standard[rows], needs[rows] - middle)

    def error(choice: tuple[float, float]) -> float:
        found = fit(slice(quarter, None), *choice).predict(standard[:quarter]) + middle
        return float(np.mean((found - needs[:quarter]) ** 2))

    best = min(product((2.0, 4.0, 8.0, 16.0), (1e-1, 1e-2, 1e-3, 1e-4)), key=error)
    return fit(slice(None), *best).predict(asked) + middle


def within(errors: Float[ndarray, "n 2"]) -> float:
    """Return the share of misses of the centre that are on the blade, per cent."""
    return 100.0 * float(np.mean(np.sum((errors / BLADE) ** 2, axis=1) < 1.0))


def split(
    player: PaperPlayer, scenes: Sequence[Scene], beliefs: dict[str, Float[ndarray, "n 2"]]
) -> dict[str, Any]:
    """Return the parts of the misses, and what would hit without each."""
    drones = [flown(player, scene) for scene in scenes]
    motion = np.array([moved(*pair) for pair in zip(drones, scenes, strict=True)])
    means = np.array([
        np.mean([moved(flown(player, one, k), one) for k in range(FLIGHTS)], axis=0)
        for one in scenes
    ])  # fmt: skip
    need = np.array([scene.need for scene in scenes])
    parts = {
        "spin, chance": need - beliefs["true"],
        "eyes": beliefs["true"] - beliefs["seen"],
        "learning": beliefs["seen"] - means,
        "execution": means - motion,
    }
    whole = need - motion
    hits = sum(drone.verdict().outcome == "hit" for drone in drones)
    return {
        "hit_percent": 100.0 * hits / len(scenes),
        "on_the_blade_percent": within(whole),
        "parts": {
            name: {"rms_right_down_cm": _rms(part), "without_it_percent": within(whole - part)}
            for name, part in {"all": whole, **parts}.items()
        },
    }


def examples(
    taught: Trained, settings: PaperSettings, known: Sequence[Scene], asked: Sequence[Scene]
) -> dict[str, Any]:
    """Return what exact labels would do, of the serves that were hit and of as many of all."""
    sets = {"serves it hit": taught.hits, "serves as they come": known[: len(taught.hits)]}
    found: dict[str, Any] = {}
    for name, scenes in sets.items():
        states, needs, wanted = _states(scenes, "seen"), _needs(scenes), _states(asked, "seen")
        own = [np.stack([*map(taught.player.standardised, rows)]) for rows in (states, wanted)]
        crkr = CrKR(settings.length_scale, settings.regularization)
        middle = needs.mean(axis=0)
        its = crkr.fit(own[0], needs - middle).predict(own[1]) + middle
        best = expected(states, needs, wanted)
        found[name] = {
            "need_sd_right_down_cm": _rms(needs - middle),
            "its_regression_percent": within(_needs(asked) - its),
            "best_regression_percent": within(_needs(asked) - best),
        }
    return {"exact_labels_flown_exactly": found}


def _rms(errors: Float[ndarray, "n 2"]) -> list[float]:
    return [round(float(rms), 1) for rms in 100.0 * np.sqrt(np.mean(errors**2, axis=0))]


def tell(**found: Any) -> None:
    """Print one line."""
    print(json.dumps(found), flush=True)


def main() -> None:
    """Measure."""
    words = (*sys.argv[1:], *("1500", "300", "170")[len(sys.argv) - 1 :])
    training, serves, hits = (int(word) for word in words)
    lessons = [scene_of("train", index) for index in range(training)]
    tests = [scene_of("evaluate", index) for index in range(serves)]
    known, asked = ([one for one in scenes if one.crossing] for scenes in (lessons, tests))
    beliefs = {
        name: expected(_states(known, name), _needs(known), _states(asked, name))
        for name in ("seen", "true")
    }
    for name, belief in beliefs.items():
        missed = _needs(asked) - belief
        tell(limit=f"best regression on {name} states", serves=len(known), flown="exactly",
             rms_right_down_cm=_rms(missed), on_the_blade_percent=within(missed))  # fmt: skip
    for name, settings in SETTINGS.items():
        for eyes in ("paper", "truth"):
            taught = trained(settings, lessons, hits, truth=eyes == "truth")
            drones = [flown(taught.player, one, truth=eyes == "truth") for one in tests]
            rate = 100.0 * sum(one.verdict().outcome == "hit" for one in drones) / serves
            own = len(taught.hits)
            tell(settings=name, eyes=eyes, own_hits=own, balls=taught.balls, hit_percent=rate)
            if eyes == "paper":
                tell(settings=name, **split(taught.player, asked, beliefs))
                tell(settings=name, **examples(taught, settings, known, asked))


def _needs(scenes: Sequence[Scene]) -> Float[ndarray, "n 2"]:
    return np.array([scene.need for scene in scenes])


def _states(scenes: Sequence[Scene], name: str) -> Float[ndarray, "n 6"]:
    if name == "true":
        return np.array([scene.true for scene in scenes])
    seen = [scene.seen for scene in scenes if scene.seen is not None]
    return np.array([np.concatenate([one.position, one.velocity]) for one in seen])


if __name__ == "__main__":
    main()
