"""How exactly is a motion flown: Table II, open loop, with feed-forward and in closed loop.

The error is that of the paper: the mean of |where the drone was - where the motion was| over the
motion, axis by axis (X right, Y down, Z depth), here against the simulator's truth and from where
the drone was when the motion began. A drone hovers for half a second, and then flies

- ten times one motion whose displacement in X is small, as in the paper (its footnote 6): the even
  mixture of the shipped demonstrations;
- motions to goals aside and up or down, in 0.5 to 1.0 s: far ones, most of which ask for more than
  the drone's commands allow (how many is a row), and near ones.

Commands go out 30 times a second. Every run has its own noise of vehicle and navdata, the same for
all controls.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control import Control, Departure
from rotorpong.control.feed_forward import feed_forward
from rotorpong.control.identification import Identification, Record
from rotorpong.control.plant import Plant, plant_of
from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import VelocityCommand
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.free_flight import (
    HOVERING,
    RATE,
    FreeFlight,
    Task,
    even_mixture,
    fly,
    small_aside,
    tasks_aside,
)
from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW
from rotorpong.physics.vehicle import TUM_GAZEBO, Vehicle
from rotorpong.primitives import Dmp

RUNS = 10
FAR, NEAR = (0.4, 0.2), (0.15, 0.05)  # m aside and up or down
DURATIONS = (0.5, 0.75, 1.0)  # s
DRAWN, STROKES, ASIDE = 20, 10, 0.4  # drones whose constants are learnt, strokes of each, m/s
CONTROLS: tuple[Control, ...] = ("open", "feed_forward", "closed_loop")
VEHICLES: tuple[Vehicle, ...] = (TUM_GAZEBO, ARDRONE2, ARDRONE2_RAW)
TARGETS = {"feed_forward": (0.8, 1.0, 1.5), "closed_loop": (0.8, 0.8, 1.0)}  # cm


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Return the errors of all controls on all vehicles, and how well constants are learnt.

    Args:
        quick: fewer runs.
    """
    dmp = even_mixture()
    found: list[Row] = []
    for vehicle in VEHICLES:
        found += table_rows(vehicle, dmp, runs=3 if quick else RUNS)
        for aside in (FAR, NEAR):
            found += spread_rows(vehicle, dmp, aside, DURATIONS[-1:] if quick else DURATIONS)
    return (*found, *learning_rows(drones=3 if quick else DRAWN))


def table_rows(vehicle: Vehicle, dmp: Dmp, *, runs: int) -> Iterator[Row]:
    """Yield Table II of a vehicle: mean absolute error of each axis, cm."""
    task = small_aside(dmp)
    for control in CONTROLS:
        errors = [fly(vehicle, control, task, seed=seed).position for seed in range(runs)]
        targets = TARGETS.get(control, (None,) * 3) if not _is_raw(vehicle) else (None,) * 3
        for axis, error, target in zip("XYZ", _mean_cm(errors), targets, strict=True):
            name = f"Table II, {vehicle.name}, {_words(control)}, {axis}"
            yield Row(name, error, "cm", target=target, better="less")


def spread_rows(
    vehicle: Vehicle, dmp: Dmp, aside: tuple[float, float], durations: tuple[float, ...]
) -> Iterator[Row]:
    """Yield the same over goals aside (m), and what share of them the commands' limits forbid."""
    tasks = tasks_aside(dmp, aside, durations)
    name = f"goals {aside[0]} m aside, {vehicle.name}"
    cut = np.mean([_is_cut(task, plant_of(vehicle)) for task in tasks])
    yield Row(f"{name}, beyond the limits", 100.0 * float(cut), "%")
    for control in CONTROLS:
        errors = [fly(vehicle, control, task, seed=k).position for k, task in enumerate(tasks)]
        for axis, error in zip("XY", _mean_cm(errors), strict=False):
            yield Row(f"{name}, {_words(control)}, {axis}", error, "cm")


def learning_rows(*, drones: int) -> Iterator[Row]:
    """Yield how far the lag to the right is off, before and after strokes with drawn drones."""
    before, after = [], []
    for seed in range(drones):
        vehicle = TUM_GAZEBO.randomized(np.random.default_rng([seed, 1]))
        lag = plant_of(vehicle).axes[0].lag
        known = learnt(vehicle, Identification.prior(plant_of(TUM_GAZEBO)), seed)
        before.append(plant_of(TUM_GAZEBO).axes[0].lag / lag - 1.0)
        after.append(known.axes[0].lag / lag - 1.0)
    for when, off in (("before", before), (f"after {STROKES} strokes", after)):
        rms = 100.0 * float(np.sqrt(np.mean(np.square(off))))
        yield Row(f"lag of a drawn tum_gazebo, {when}, rms", rms, "%")


def learnt(vehicle: Vehicle, known: Identification, seed: int) -> Identification:
    """Return what is known of a drone after strokes aside, each a serve of its own."""
    for stroke in range(STROKES):
        flight, record = FreeFlight(vehicle, seed=STROKES * seed + stroke), Record(known.plant)
        known = known.renewed()
        for k in range(HOVERING + RATE):
            side = (
                ASIDE * (-1.0) ** stroke * (k >= HOVERING) * (1 if k < HOVERING + RATE // 2 else -1)
            )
            velocity = np.array([side, 0.5 * side, 0.0])
            forward, left, up = CAMERA_FROM_BODY_AXES.T @ velocity
            sent = flight.command(VelocityCommand(float(forward), float(left), float(up)))
            record.add(flight.time, CAMERA_FROM_BODY_AXES @ [sent.forward, sent.left, sent.up])
            known = record.learnt(known, flight.advance())
    return known


def _is_cut(task: Task, plant: Plant) -> bool:
    course = task.course(Departure.of_hover(plant.dead_time), smooth=True)
    times = np.arange(0.0, task.duration, 1.0 / RATE).tolist()
    return any(
        feed_forward(course, plant.axes, now, 1.0 / RATE, plant.limits).is_cut for now in times
    )


def _mean_cm(errors: list[Float[ndarray, "_ 3"]]) -> list[float]:
    return (100.0 * np.mean([np.abs(error).mean(axis=0) for error in errors], axis=0)).tolist()


def _is_raw(vehicle: Vehicle) -> bool:
    return vehicle is ARDRONE2_RAW


def _words(control: Control) -> str:
    return control.replace("_", " ")
