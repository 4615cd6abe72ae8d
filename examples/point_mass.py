"""
A drone of your own: from nothing
=================================

A point that takes on a commanded velocity with one lag. It never tilts or turns, so it is a drone
that only its lag keeps from perfection: what a player misses with it is the player's own fault.

The methods are those of ``rotorpong.physics.vehicle.Vehicle``; all state that decides the rest of
the flight is in what ``start`` and ``advance`` return, and nothing in the object changes.

Give it a name to keep the figure: ``python examples/point_mass.py step.png``.
"""

import sys
from dataclasses import dataclass, replace

import matplotlib.pyplot as plt
import numpy as np

from rotorpong.lab.evaluate import evaluate, summary
from rotorpong.lab.spec import Spec
from rotorpong.physics.noise import draw_keys
from rotorpong.physics.vehicle import (
    HOVER_MOTION,
    TICK,
    TUM_GAZEBO,
    TUM_GAZEBO_NOISE,
    SensorNoise,
    Track,
    Vehicle,
    VehicleState,
    check_command,
)

BALLS = 40


@dataclass(frozen=True)
class PointMass:
    """v' = (command - v) / lag; the yaw rate is not obeyed."""

    lag: float = 0.2  # s
    name: str = "point_mass"
    sensor_noise: SensorNoise = TUM_GAZEBO_NOISE

    @property
    def limits(self) -> np.ndarray:
        """Largest magnitudes of a command: forward, left, up in m/s, yaw rate in rad/s."""
        return np.array([3.0, 3.0, 3.0, 0.0])

    def start(self, position: np.ndarray, rng: np.random.Generator) -> VehicleState:
        """Hover at `position`, of one drone or of many: shape (3,) or (n, 3)."""
        batch = position.shape[:-1]
        motion = np.broadcast_to(HOVER_MOTION, (*batch, 16)).copy()
        motion[..., 0:3] = position
        counters = np.zeros((*batch, 2), np.int64)
        return VehicleState(motion, np.zeros((*batch, 4)), counters, draw_keys(rng, batch))

    def advance(
        self, state: VehicleState, command: np.ndarray, *, ticks: int, new_command: bool
    ) -> tuple[VehicleState, Track]:
        """Fly on for `ticks` of 1 ms; between messages the last command stays in force."""
        check_command(command, (*state.motion.shape[:-1], 4))
        held = command if new_command else state.held_command
        goal, keep = held[..., 0:3], np.exp(-TICK / self.lag)
        motions = [state.motion]
        for _ in range(ticks):
            motion, before = motions[-1].copy(), motions[-1][..., 3:6]
            motion[..., 3:6] = goal + (before - goal) * keep
            motion[..., 13:16] = (motion[..., 3:6] - before) / TICK
            motion[..., 0:3] += goal * TICK - motion[..., 13:16] * self.lag * TICK
            motions.append(motion)
        path = np.stack(motions, axis=-2)
        parts = np.split(path, [3, 6, 10, 13], axis=-1)  # as Track has them
        return replace(state, motion=motions[-1], memory=held.astype(float)), Track(*parts)

    def randomized(self, rng: np.random.Generator) -> "PointMass":
        """Return another of its kind, for `Spec(randomize=True)`."""
        return replace(self, lag=rng.uniform(0.1, 0.3))


# %%
# It plays like any other: the paper's player on it, as it is and with a lag of its own every ball.


def play() -> None:
    """Play the paper's player on it, as it is and randomised."""
    for randomize in (False, True):
        spec = Spec("paper", "truth", vehicle=PointMass(), randomize=randomize)
        result = summary(spec, evaluate(spec, BALLS))
        kind = "every one different" if randomize else "all alike"
        print(f"{result['vehicle']}, {kind}: {result['hits']} hits of {result['balls']} balls")


if __name__ == "__main__":
    play()

# %%
# Its answer to a step is 1 - exp(-t / lag), dashed; the simulator's own drone must tilt first.


def velocity_after_step(vehicle: Vehicle, ticks: int) -> np.ndarray:
    """Return the velocity to the left at every tick after 1 m/s is commanded, from hover."""
    state = vehicle.start(np.array([0.0, 0.0, 1.0]), np.random.default_rng(0))
    left = np.array([0.0, 1.0, 0.0, 0.0])
    return vehicle.advance(state, left, ticks=ticks, new_command=True)[1].velocity[:, 1]


def draw() -> None:
    """Draw the steps of ten of its kind, of itself with its closed form, and of the simulator's."""
    plt.switch_backend("agg")  # a figure needs no display
    figure, axes = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
    point, rng, ticks = PointMass(), np.random.default_rng(0), 1200
    times = np.arange(ticks + 1) * TICK
    for _ in range(10):
        one = velocity_after_step(point.randomized(rng), ticks)
        axes.plot(times, one, color="C0", alpha=0.25, linewidth=1)
    axes.plot(times, velocity_after_step(point, ticks), color="C0", label="point_mass")
    axes.plot(times, 1.0 - np.exp(-times / point.lag), "k--", linewidth=1, label="closed form")
    axes.plot(times, velocity_after_step(TUM_GAZEBO, ticks), color="C1", label="tum_gazebo")
    axes.set(xlabel="time since the command, s", ylabel="velocity to the left, m/s")
    axes.grid(alpha=0.3)
    axes.legend()
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    draw()
