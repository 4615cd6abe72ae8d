"""Serves: how balls are thrown at the drone.

A serve of the kind `human` is a table-tennis throw: it clears the net, bounces exactly once, on
the drone's half, and passes a target on the blade plane. `hard` has wider targets and more spin;
`lob` comes directly, touching nothing. The target is drawn first and kept; release, speed and spin
are drawn again until some launch direction meets the target, with drag, Magnus force and bounce
solved exactly. Where two arcs do, the lower one is thrown. World frame.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError, UnsolvableServeError
from rotorpong.physics.ball import (
    TABLE_SURFACE,
    Air,
    Ball,
    Surface,
    require_air,
    require_surface,
)
from rotorpong.world import _serve_kernels
from rotorpong.world.contact import BallState, approach, solid_at, state_of
from rotorpong.world.racket import HOME_BLADE
from rotorpong.world.solids import Solids, parameters

PLANE_X = HOME_BLADE[0] + BALL_RADIUS  # where the ball's centre is when it touches the blade
MOST_TRIES = 1000
LAUNCH_STEPS = (0.04, 0.01)  # s, of the flights that look for a launch and of those that aim it


class Medium(NamedTuple):
    """What a serve flies through and bounces on."""

    air: Air = Air()
    table: Surface = TABLE_SURFACE


PLAIN_MEDIUM = Medium()


@dataclass(frozen=True, slots=True)
class Serve:
    """One ball on its way, from the instant of release."""

    ball: Ball
    air: Air = field(default_factory=Air)
    table: Surface = TABLE_SURFACE
    target: tuple[float, float] | None = None  # m, left and up of the home blade centre

    def __post_init__(self) -> None:
        """Raise InputError unless the ball can fly and bounce."""
        require_air(self.air)
        require_surface(self.table, "table")
        if not np.isfinite(state_of(self.ball)).all():
            raise InputError(f"serve of {self.ball}: expected finite position, velocity and spin")
        blocked = solid_at(self.ball.position)
        if blocked is not None:
            raise InputError(
                f"serve from {self.ball.position} m: released inside the {blocked}; expected a "
                "place where the ball touches nothing"
            )


@dataclass(frozen=True, slots=True)
class ServeKind:
    """From what a serve is drawn; ranges are uniform, (low, high)."""

    name: str
    target_left: tuple[float, float] = (-0.4, 0.4)  # m, on the blade plane
    target_up: tuple[float, float] = (-0.2, 0.2)
    release_ahead: tuple[float, float] = (3.5, 4.5)  # m before the blade plane
    release_left: tuple[float, float] = (-0.4, 0.4)
    release_up: tuple[float, float] = (-0.4, 0.2)  # from blade height
    approach_speed: tuple[float, float] = (6.0, 8.0)  # m/s along -x
    spin_sd: float = 20.0  # rad/s, each axis
    bounces: Literal[0, 1] = 1  # on the drone's half
    medium: Medium = PLAIN_MEDIUM  # in which the launch is solved


HUMAN = ServeKind("human")
HARD = ServeKind("hard", target_left=(-0.5, 0.5), spin_sd=60.0)
LOB = ServeKind("lob", bounces=0)
KINDS = {kind.name: kind for kind in (HUMAN, HARD, LOB)}

CONSTANT_SPEED_SD = 0.2  # m/s
CONSTANT_ANGLE_SD = math.radians(2.0)


def draw(kind: ServeKind, rng: np.random.Generator) -> Serve:
    """Draw a serve.

    Raises:
        UnsolvableServeError: no launch within the rules met the target in 1000 draws.
    """
    target = (rng.uniform(*kind.target_left), rng.uniform(*kind.target_up))
    return draw_at(kind, target, rng)


def draw_at(kind: ServeKind, target: tuple[float, float], rng: np.random.Generator) -> Serve:
    """Draw a serve that passes `target`, metres left and up of the home blade's centre."""
    for _ in range(MOST_TRIES):
        ahead = rng.uniform(*kind.release_ahead)
        left = rng.uniform(*kind.release_left)
        up = rng.uniform(*kind.release_up)
        position = np.array(HOME_BLADE) + np.array([ahead, left, up])
        speed = rng.uniform(*kind.approach_speed)
        spin = rng.normal(0.0, kind.spin_sd, size=3)
        velocity = launch(position, speed, spin, target, kind)
        if velocity is not None:
            return Serve(Ball(position, velocity, spin), *kind.medium, target=target)
    raise UnsolvableServeError(
        f"serve {kind.name!r} at target {target[0]:.3f} m left, {target[1]:.3f} m up: "
        f"no launch within the rules in {MOST_TRIES} draws"
    )


def launch(
    position: Float[ndarray, "3"],
    speed: float,
    spin: Float[ndarray, "3"],
    target: tuple[float, float],
    kind: ServeKind = HUMAN,
) -> Float[ndarray, "3"] | None:
    """Return the launch velocity of the lower arc that obeys the rules; None if there is none."""
    state = np.concatenate([position, [-speed, 0.0, 0.0], spin])
    goal = np.array([HOME_BLADE[1] + target[0], HOME_BLADE[2] + target[1]])
    solved, vy, vz = _serve_kernels.solve(
        state, PLANE_X, goal, kind.bounces, _launch_solids(kind.medium)
    )
    return np.array([-speed, vy, vz]) if solved else None


@lru_cache(maxsize=4)
def _launch_solids(medium: Medium) -> Float[ndarray, "2 k"]:
    solids = [Solids(air=medium.air, table=medium.table, tick=tick) for tick in LAUNCH_STEPS]
    return np.array([*map(parameters, solids)])


def obeys_rules(serve: Serve, *, bounces: int = 1) -> bool:
    """Tell whether a serve bounces as often, on the drone's half, and touches nothing else."""
    solids = Solids(air=serve.air, table=serve.table)
    time, _, contacts = approach(state_of(serve.ball), PLANE_X, solids)
    there = all(c.solid == "table" and c.position[0] < 0.0 for c in contacts)
    return time is not None and there and len(contacts) == bounces


def crossing(serve: Serve) -> tuple[float | None, BallState]:
    """Return when the ball passes the home blade plane, and its state there."""
    solids = Solids(air=serve.air, table=serve.table)
    time, state, _ = approach(state_of(serve.ball), PLANE_X, solids)
    return time, state


def vary(serve: Serve, rng: np.random.Generator) -> Serve:
    """Throw once more with a thrower's scatter: the kind `constant`.

    Speed varies by 0.2 m/s, azimuth and elevation by 2 degrees; drawn again if it breaks the rules.

    Raises:
        UnsolvableServeError: 1000 throws in a row broke the rules.
    """
    vx, vy, vz = serve.ball.velocity
    speed = float(np.linalg.norm(serve.ball.velocity))
    azimuth, elevation = math.atan2(vy, vx), math.asin(vz / speed)
    for _ in range(MOST_TRIES):
        s = speed + rng.normal(0.0, CONSTANT_SPEED_SD)
        a = azimuth + rng.normal(0.0, CONSTANT_ANGLE_SD)
        e = elevation + rng.normal(0.0, CONSTANT_ANGLE_SD)
        flat = s * math.cos(e)
        velocity = np.array([flat * math.cos(a), flat * math.sin(a), s * math.sin(e)])
        thrown = replace(serve, ball=replace(serve.ball, velocity=velocity), target=None)
        if obeys_rules(thrown):
            return thrown
    raise UnsolvableServeError(
        f"serve 'constant' about {serve.ball.velocity} m/s: every throw broke the rules"
    )
