"""Is `reachable` sound and tight: players that try to hit what is called unreachable.

Every player stands behind the oracle's gate, so its first command other than hover's follows the
third frame that shows the ball. Sound: none of them ever hits a serve called unreachable. Tight:
the oracle hits nearly all of the others. The kinds that players meet are nearly always within
reach, so soundness is also tried on `wide` serves, which mostly are not.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.drone import Drone, Eyes, Player, VelocityCommand, Verdict
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.oracle import Gate, Oracle
from rotorpong.lab.reachable import is_reachable
from rotorpong.lab.serving import SERVE_KINDS, serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Stage, new_drone, play_trial
from rotorpong.physics.ball import Ball
from rotorpong.world.racket import HOME_BLADE
from rotorpong.world.serves import PLAIN_MEDIUM, Medium, Serve

BALLS = 1000  # of each kind on each vehicle
WIDE_SHARE = 5  # times as many wide serves
TIGHT = 0.98
WIDE = "wide"
CAMERA_OF = {
    "tum_gazebo": "gazebo",
    "ardrone2": "ardrone2_720p",
    "ardrone2_raw": "ardrone2_720p",
}
VEHICLES = ("tum_gazebo", "ardrone2")


@dataclass(frozen=True, slots=True)
class Count:
    """What became of the serves of one kind on one vehicle."""

    balls: int
    reachable: int
    oracle_hits: int  # of reachable
    false_alarms: int  # serves called unreachable that somebody hit


def rows(
    balls: int = BALLS, *, seed: int = 0, vehicles: Sequence[str] = VEHICLES
) -> tuple[Row, ...]:
    """Return soundness and tightness on every vehicle and kind of serve."""
    found: list[Row] = []
    for vehicle in vehicles:
        for kind in SERVE_KINDS:
            count = count_serves(stage_of(vehicle, kind, seed), balls)
            found += _rows(f"reach, {vehicle}, {kind}", count)
        wide = count_serves(stage_of(vehicle, WIDE, seed), WIDE_SHARE * balls)
        found.append(_sound(f"reach, {vehicle}, {WIDE}", wide))
    return tuple(found)


def count_serves(stage: Stage, balls: int, *, with_oracle: bool = True) -> Count:
    """Play the oracle on what is called reachable, every adversary on what is not."""
    reachable = oracle_hits = false_alarms = 0
    for index in range(balls):
        if is_reachable(new_drone(stage, index)):
            reachable += 1
            oracle_hits += with_oracle and _hits(stage, index, Oracle())
        else:
            false_alarms += any(_hits(stage, index, make(index)) for make in ADVERSARIES)
    return Count(balls, reachable, oracle_hits, false_alarms)


def stage_of(vehicle: str, kind: str, seed: int) -> Stage:
    """Return where a kind of serves is played, truth eyes on."""
    spec = Spec("oracle", "truth", vehicle, CAMERA_OF[vehicle], seed=seed)
    source = wide_serves if kind == WIDE else serve_source(kind, seed)
    return Stage(spec, spec.setting(), source, "evaluate")


def wide_serves(index: int, rng: np.random.Generator, medium: Medium = PLAIN_MEDIUM, /) -> Serve:
    """Throw far to the side, high or low, with or without a bounce: no rules are obeyed."""
    release = np.array(HOME_BLADE) + rng.uniform([3.5, -0.4, -0.2], [4.5, 0.4, 0.3])
    goal = np.array(HOME_BLADE) + rng.uniform([0.0, -1.5, -0.6], [0.0, 1.5, 1.2])
    flat = rng.uniform(7.0, 12.0)
    duration = (release[0] - goal[0] - BALL_RADIUS) / flat
    velocity = (goal - release) / duration
    velocity[2] += 0.5 * 9.81 * duration
    ball = Ball(release, velocity, rng.normal(0.0, 20.0, size=3))
    return Serve(ball, medium.air, medium.table)


Rule = Callable[[int, np.random.Generator], Sequence[float] | np.ndarray]
"""Frame since the gate opened, generator -> command."""


class Commands:
    """A player that flies by a rule."""

    def __init__(self, rule: Rule) -> None:
        """Fly by `rule`."""
        self._rule = rule

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve."""
        frame = 0
        while drone.observe() is not None:
            if isinstance(drone, Gate) and not drone.is_open:
                continue  # say nothing: hover without a message, unlike the bound's drone
            drone.command(VelocityCommand(*(float(value) for value in self._rule(frame, rng))))
            frame += 1

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing."""


def _bang(index: int) -> Player:
    """Jump between the limits at random."""
    return Commands(lambda frame, rng: BIG * rng.choice([-1.0, 0.0, 1.0], size=4))


def _corner(index: int) -> Player:
    """Fly at the limits towards one corner after the other, serve by serve."""
    signs = np.array([index // 3**axis % 3 - 1 for axis in range(4)], dtype=float)
    return Commands(lambda frame, rng: BIG * signs)


def _yaw_swing(index: int) -> Player:
    """Turn one way while flying sideways."""
    side = 1.0 if index % 2 else -1.0
    turn = 1.0 if index // 2 % 2 else -1.0
    return Commands(lambda frame, rng: BIG * np.array([0.0, side, 0.0, turn]))


def _kicks(index: int) -> Player:
    """Kick the pitch at each frame, climbing or sinking by steps."""
    side, up = (1.0 if index // n % 2 else -1.0 for n in (1, 2))

    def rule(frame: int, rng: np.random.Generator) -> Sequence[float]:
        kick = 1.0 if frame % 2 else -1.0
        return [9.0 * kick, 9.0 * side, up * (0.8 + 0.2 * (frame % 5) / 4), 0.0]

    return Commands(rule)


def _lift(index: int) -> Player:
    """Fly to the side and up, then backwards or forwards: that tilts the blade."""
    side, up, pull = (1.0 if index // n % 2 else -1.0 for n in (1, 2, 4))
    turn = 8 + index % 12
    return Commands(lambda frame, rng: [0.0 if frame < turn else 9.0 * pull, 9.0 * side, up, 0.0])


BIG = np.array([9.0, 9.0, 9.0, 9.0])  # beyond anybody's limits
ADVERSARIES: tuple[Callable[[int], Player], ...] = (
    lambda index: Oracle(),
    _bang,
    _corner,
    _yaw_swing,
    _kicks,
    _lift,
)


def _hits(stage: Stage, index: int, player: Player) -> bool:
    return play_trial(stage, index, player, watch=Gate).outcome == "hit"


def _rows(name: str, count: Count) -> list[Row]:
    found = [Row(f"{name}: reachable", count.reachable / count.balls, "share"), _sound(name, count)]
    if count.reachable:
        tight = count.oracle_hits / count.reachable
        found.append(Row(f"{name}: oracle's hits of reachable", tight, "share", target=TIGHT))
    return found


def _sound(name: str, count: Count) -> Row:
    unreachable = count.balls - count.reachable
    return Row(
        f"{name}: hits of {unreachable} called unreachable",
        float(count.false_alarms),
        "hits",
        target=0.0,
        better="less",
    )
