"""One serve seen by several eyes at once, the truth beside: what Table I and Fig. 4 are made of.

All eyes look at the same frames of a hovering drone. Truth is taken at the time that an estimate is
for; its velocity is that of the ball less that of the camera, along the camera's axes, so what a
turning camera adds to finite differences counts as their error.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import HOVER
from rotorpong.lab.eye_settings import EyeSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Stage, new_drone
from rotorpong.physics.camera import GAZEBO
from rotorpong.world.contact import TICK
from rotorpong.world.simulated_drone import SimulatedDrone

WHOLE, FLOAT, TRACKER = "paper's eyes, whole pixels", "paper's eyes, float", "tracker"
EYES: Mapping[str, tuple[str, EyeSettings]] = {
    WHOLE: ("paper", EyeSettings(diameter="whole")),
    FLOAT: ("paper", EyeSettings(diameter="float")),
    TRACKER: ("tracker", EyeSettings()),
}
QUANTITIES = ("x", "y", "z", "vx", "vy", "vz")
UNITS = {q: "cm_per_s" if q.startswith("v") else "cm" for q in QUANTITIES}
KEYS = tuple(f"{quantity}_{unit}" for quantity, unit in UNITS.items())
HEADS = ("X, cm", "Y, cm", "Z, cm", "vX, cm/s", "vY, cm/s", "vZ, cm/s")
FAST = replace(GAZEBO, name="gazebo, 60 frames/s", frames_per_second=60.0)  # tum_simulator's rate
ON_A_TICK = 1e-6  # of a tick: nearer is rounding

Sights = Float[ndarray, "n 13"]  # time (s), estimate (m, m/s), truth (m, m/s)


class Told(NamedTuple):
    """What eyes told along a serve, beside the truth; camera frame."""

    time: Float[ndarray, "n"]  # s
    estimate: Float[ndarray, "n 6"]  # m, m/s
    truth: Float[ndarray, "n 6"]  # m, m/s

    @property
    def error(self) -> Float[ndarray, "n 6"]:
        """Estimate less truth, cm and cm/s."""
        return 100.0 * (self.estimate - self.truth)


def told(rows: Sequence[Sequence[float]] | Sights) -> Told:
    """Return rows of `watched` by their meaning."""
    table = np.asarray(rows, dtype=float).reshape(-1, 1 + 2 * len(QUANTITIES))
    return Told(table[:, 0], table[:, 1:7], table[:, 7:])


def watched(stage: Stage, index: int, eyes: Sequence[str] = tuple(EYES)) -> dict[str, Sights]:
    """Return what eyes tell along serve `index` of a stage, frame by frame, by their labels.

    Args:
        stage: where the serve is played.
        index: of the serve.
        eyes: labels, of `EYES`.
    """
    drone = new_drone(stage, index)
    looking = {label: _spec(stage.spec, label).make_eyes(drone) for label in eyes}
    rows: dict[str, list[ndarray]] = {label: [] for label in eyes}
    while (seen := drone.observe()) is not None:
        drone.command(HOVER)
        for label, one in looking.items():
            if (estimate := one.see(seen)) is not None:
                truth = true_state(drone, estimate.time)
                row = [[estimate.time], estimate.position, estimate.velocity, truth]
                rows[label].append(np.concatenate(row))
    return {label: np.array(found).reshape(-1, 13) for label, found in rows.items()}


def true_state(drone: SimulatedDrone, time: float) -> Float[ndarray, "6"]:
    """Return the ball's position (m) and velocity (m/s) in the camera frame.

    Between ticks the position is on the line from one to the other; the velocity is the nearer
    tick's, for a bounce has none in between.
    """
    tick = math.floor(time / TICK + ON_A_TICK)
    share = time / TICK - tick
    position, velocity = drone.ball_in_camera(tick * TICK)
    if share > ON_A_TICK:
        after, _ = drone.ball_in_camera((tick + 1) * TICK)
        position = position + share * (after - position)
        velocity = drone.ball_in_camera(time)[1]
    return np.concatenate([position, velocity])


def mean_errors(sights: Told) -> Float[ndarray, "6"]:
    """Return mean absolute errors along a trajectory, cm and cm/s; nan of nothing."""
    if not len(sights.time):
        return np.full(len(QUANTITIES), np.nan)
    return np.abs(sights.error).mean(axis=0)


def _spec(spec: Spec, label: str) -> Spec:
    eyes, settings = EYES[label]
    return replace(spec, eyes=eyes, eye_settings=settings)
