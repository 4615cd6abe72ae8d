"""What all environments share: who plays whom, which serve comes next, what is told at the end.

`reset(seed=S)` begins with trial 0 of seed S, and every later `reset()` takes that seed's next
trial. By default they are serves to train on; with `purpose="evaluate"` they are the trials of
`rotorpong evaluate --seed S`: the same serves and the same noise. `reset(options={"trial": i})`
begins with trial i.
"""

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypedDict, cast

import numpy as np

from rotorpong.conventions import InputError, require_seed
from rotorpong.drone import Outcome
from rotorpong.lab.choices import require_choice
from rotorpong.lab.reachable import is_reachable
from rotorpong.lab.seeds import PURPOSES, Purpose, trial_generators
from rotorpong.lab.serving import ServeSource, serve_source
from rotorpong.lab.spec import Spec, require_count
from rotorpong.lab.trial import Stage, encounter
from rotorpong.physics.camera import Camera
from rotorpong.physics.vehicle import Vehicle
from rotorpong.world.batch import Cast
from rotorpong.world.serves import Serve, ServeKind
from rotorpong.world.simulated_drone import Setting, SimulatedDrone

RENDER_MODES = ("rgb_array",)


class Game(TypedDict, total=False):
    """The keywords that all environments take; their defaults are those of `arena`."""

    vehicle: str | Vehicle
    camera: str | Camera
    serves: str
    racket: str
    purpose: str
    randomize: bool
    tell_reachable: bool


@dataclass(frozen=True, slots=True)
class Arena:
    """A setting of the game and where its trials come from."""

    spec: Spec
    setting: Setting
    purpose: Purpose
    reach: Callable[[SimulatedDrone], bool] | None = None  # of a fresh drone; takes milliseconds

    def meet(self, place: "Place") -> tuple[Setting, Cast]:
        """Return what a trial's serve meets, which `randomize` draws, and the serve with noise."""
        seed, trial = place.seed, place.trial
        generators = trial_generators(seed, self.purpose, trial)
        if self.spec.randomize:
            stage = Stage(self.spec, self.setting, _source(self.spec.serves, seed), self.purpose)
            setting, serve = encounter(stage, trial, generators)
        else:
            setting, serve = self.setting, _serve(self.spec.serves, self.purpose, seed, trial)
        return setting, Cast(serve, generators.vehicle, generators.sensors)

    def drone(self, place: "Place") -> SimulatedDrone:
        """Return the drone and the serve of a trial, fresh."""
        setting, cast = self.meet(place)
        return SimulatedDrone(
            cast.serve, setting, vehicle_rng=cast.vehicle_rng, sensor_rng=cast.sensor_rng
        )

    def reachable(self, place: "Place") -> bool | None:
        """Tell whether any player could have hit the ball of a trial; None: not worked out."""
        return None if self.reach is None else self.reach(self.drone(place))


def arena(  # noqa: PLR0913 - the keywords of `Game`, with their defaults
    *,
    vehicle: str | Vehicle = "tum_gazebo",
    camera: str | Camera = "gazebo",
    serves: str = "human",
    racket: str = "cardboard",
    purpose: str = "train",
    randomize: bool = False,
    tell_reachable: bool = True,
    eyes: str = "truth",
) -> Arena:
    """Return the arena that an environment's arguments describe; see docs/environments.md.

    Raises:
        InputError: one of them is unknown.
    """
    require_choice("purpose", purpose, tuple(PURPOSES))
    spec = Spec(
        player="hover",
        eyes=eyes,
        vehicle=vehicle,
        camera=camera,
        serves=serves,
        racket=racket,
        randomize=randomize,
    ).check()
    reach = is_reachable if tell_reachable else None
    return Arena(spec, spec.setting(), cast("Purpose", purpose), reach)


@dataclass(frozen=True, slots=True)
class Place:
    """The trial that is played: number `trial` of `seed`."""

    seed: int
    trial: int

    def next(self) -> "Place":
        """Return the trial after it."""
        return replace(self, trial=self.trial + 1)


def place_of(
    seed: int | None, options: dict[str, Any] | None, before: Place | None, rng: np.random.Generator
) -> Place:
    """Return the trial that a reset begins.

    Args:
        seed: as given to `reset`; None: go on.
        options: as given to `reset`; `trial` chooses one.
        before: the trial played before.
        rng: draws a seed where none was ever given.

    Raises:
        InputError: seed or trial is not a whole number in its range.
    """
    if seed is not None:
        require_seed(seed)
        place = Place(seed, 0)
    elif before is not None:
        place = before.next()
    else:
        place = Place(int(rng.integers(2**63)), 0)
    trial = (options or {}).get("trial")
    if trial is None:
        return place
    if isinstance(trial, bool) or not isinstance(trial, int | np.integer):
        raise InputError(f"trial {trial!r}: expected a whole number")
    require_count("trial", int(trial), least=0)
    return replace(place, trial=int(trial))


def told(
    place: Place,
    outcome: Outcome | None = None,
    miss_distance: float | None = None,
    time_error: float | None = None,
    *,
    reachable: bool | None = None,
) -> dict[str, Any]:
    """Return the info of a step; what is not known, or not yet, is None."""
    return {
        "hit": outcome == "hit",
        "reachable": reachable,
        "miss_distance_m": miss_distance,
        "time_error_s": time_error,
        "outcome": outcome,
        "seed": place.seed,
        "trial": place.trial,
    }


def require_render_mode(mode: str | None) -> None:
    """Raise InputError unless pictures can be had in this way."""
    if mode is not None and mode not in RENDER_MODES:
        known = ", ".join(map(repr, RENDER_MODES))
        raise InputError(f"render_mode {mode!r}: expected one of {known}, or None")


@functools.lru_cache(maxsize=4096)  # populations and vectors meet the same serves again
def _serve(serves: str | ServeKind, purpose: Purpose, seed: int, trial: int) -> Serve:
    return _source(serves, seed)(trial, trial_generators(seed, purpose, trial).serve)


@functools.lru_cache(maxsize=64)
def _source(serves: str | ServeKind, seed: int) -> ServeSource:
    return serve_source(serves, seed)
