"""How exactly is a motion flown: Table II, open loop, with feed-forward and in closed loop.

The error is that of the paper: the mean of |where the drone was - where the motion was| over the
motion, axis by axis (X right, Y down, Z depth), here against the simulator's truth and from where
the drone was when the motion began. A drone hovers for half a second, and then flies

- ten times one motion whose displacement in X is small, as in the paper (its footnote 6): the even
  mixture of the shipped demonstrations, to `GOAL`;
- motions to goals aside and up or down, in 0.5 to 1.0 s: far ones, most of which ask for more than
  the drone's commands allow (how many is a row), and near ones.

Commands go out 30 times a second. Every run has its own noise of vehicle and navdata, the same for
all controls.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control import Control, Course, Departure, Follower, follower
from rotorpong.control.feed_forward import feed_forward
from rotorpong.control.identification import Identification, Record
from rotorpong.control.plant import Plant, plant_of
from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import HOVER, Navdata, VelocityCommand
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.spec import Spec
from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW
from rotorpong.physics.vehicle import TICK, TUM_GAZEBO, Vehicle
from rotorpong.play.paper import PaperPlayer
from rotorpong.primitives import Dmp, State
from rotorpong.world.sensors import draw_sensors, read

GOAL = np.array([0.03, -0.12, 0.25])  # m: right, down, forward
SPEED = np.array([0.0, -0.2, 0.5])  # m/s, there
DURATION, RUNS = 0.8, 10  # s
FAR, NEAR = (0.4, 0.2), (0.15, 0.05)  # m aside and up or down
DURATIONS = (0.5, 0.75, 1.0)  # s
HOVERING = 15  # intervals before
RATE = 30  # commands/s
DRAWN, STROKES, ASIDE = 20, 10, 0.4  # drones whose constants are learnt, strokes of each, m/s
CONTROLS: tuple[Control, ...] = ("open", "feed_forward", "closed_loop")
VEHICLES: tuple[Vehicle, ...] = (TUM_GAZEBO, ARDRONE2, ARDRONE2_RAW)
TARGETS = {"feed_forward": (0.8, 1.0, 1.5), "closed_loop": (0.8, 0.8, 1.0)}  # cm


@dataclass(frozen=True, slots=True)
class Task:
    """A motion to be flown."""

    dmp: Dmp
    goal: State
    duration: float  # s

    def course(self, departure: Departure, *, smooth: bool) -> Course:
        """Return it from where a drone departs.

        Args:
            departure: where, when, how fast.
            smooth: begin without acceleration, not as the primitive would.
        """
        rest = np.zeros(3) if smooth else None
        start = State(departure.position, departure.velocity, rest)

        def sample(elapsed: Float[ndarray, "n"]) -> tuple[ndarray, ndarray, ndarray]:
            motion = self.dmp.roll_out(start, self.goal, self.duration, elapsed)
            assert motion.acceleration is not None, "a rolled out motion has one"
            return motion.position, motion.velocity, motion.acceleration

        return Course(departure.time, self.duration, sample)


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Return the errors of all controls on all vehicles, and how well constants are learnt.

    Args:
        quick: fewer runs.
    """
    dmp = _mixture()
    found: list[Row] = []
    for vehicle in VEHICLES:
        found += table_rows(vehicle, dmp, runs=3 if quick else RUNS)
        for aside in (FAR, NEAR):
            found += spread_rows(vehicle, dmp, aside, DURATIONS[-1:] if quick else DURATIONS)
    return (*found, *learning_rows(drones=3 if quick else DRAWN))


def table_rows(vehicle: Vehicle, dmp: Dmp, *, runs: int) -> Iterator[Row]:
    """Yield Table II of a vehicle: mean absolute error of each axis, cm."""
    task = Task(dmp, State(GOAL, SPEED), DURATION)
    for control in CONTROLS:
        errors = [flown_error(vehicle, control, task, seed=seed) for seed in range(runs)]
        targets = TARGETS.get(control, (None,) * 3) if not _is_raw(vehicle) else (None,) * 3
        for axis, error, target in zip("XYZ", _mean_cm(errors), targets, strict=True):
            name = f"Table II, {vehicle.name}, {_words(control)}, {axis}"
            yield Row(name, error, "cm", target=target, better="less")


def spread_rows(
    vehicle: Vehicle, dmp: Dmp, aside: tuple[float, float], durations: tuple[float, ...]
) -> Iterator[Row]:
    """Yield the same over goals aside (m), and what share of them the commands' limits forbid."""
    tasks = [
        Task(dmp, State(np.array([side, height, 0.0]), np.zeros(3)), duration)
        for side, height, duration in product(*((-way, way) for way in aside), durations)
    ]
    name = f"goals {aside[0]} m aside, {vehicle.name}"
    cut = np.mean([_is_cut(task, plant_of(vehicle)) for task in tasks])
    yield Row(f"{name}, beyond the limits", 100.0 * float(cut), "%")
    for control in CONTROLS:
        errors = [flown_error(vehicle, control, task, seed=k) for k, task in enumerate(tasks)]
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
        flight, record = _Flight(vehicle, seed=STROKES * seed + stroke), Record(known.plant)
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


def flown_error(
    vehicle: Vehicle, control: Control, task: Task, *, seed: int
) -> Float[ndarray, "n 3"]:
    """Return where a drone was minus where it was meant to be, at each tick of a motion, m."""
    flight, flown = _Flight(vehicle, seed=seed), follower(control, plant_of(vehicle))
    for _ in range(HOVERING):
        _fly(flight, flown, HOVER)
    departure = flown.depart(flight.time)
    course = task.course(departure, smooth=control != "open")
    while flight.time < course.end:
        now, interval = flight.time, flight.interval
        _fly(flight, flown, flown.command(course, now, interval))
    ticks = round(course.begin / TICK) + np.arange(round(task.duration / TICK) + 1)
    wanted = course.at(ticks * TICK)[0] - departure.position
    path = np.concatenate(flight.path) @ CAMERA_FROM_BODY_AXES.T
    return path[ticks] - path[ticks[0]] - wanted


def _fly(flight: "_Flight", flown: Follower, command: VelocityCommand) -> None:
    now = flight.time
    flown.sent(now, flight.command(command))
    flown.sense(flight.advance())


class _Flight:
    """A drone in the air, with nothing else in it."""

    def __init__(self, vehicle: Vehicle, *, seed: int) -> None:
        vehicle_rng, sensor_rng = np.random.default_rng(seed).spawn(2)
        self._vehicle = vehicle
        self._state = vehicle.start(np.zeros(3), vehicle_rng)
        self._sensors = draw_sensors(vehicle.sensor_noise, sensor_rng)
        self._command, self._ticks, self._frames = np.zeros(4), 0, 0
        self._under_way: list[Navdata] = []
        self.path = [np.zeros((1, 3))]  # m, body axes of the start, one row per tick

    @property
    def time(self) -> float:
        """Now, s."""
        return self._ticks * TICK

    @property
    def interval(self) -> float:
        """How long the next command is held, s."""
        return (round((self._frames + 1) * 1000 / RATE) - self._ticks) * TICK

    def command(self, velocity: VelocityCommand) -> VelocityCommand:
        """Fly at a velocity from now on; return what was sent."""
        given = np.array([velocity.forward, velocity.left, velocity.up, velocity.yaw_rate])
        self._command = np.clip(given, -self._vehicle.limits, self._vehicle.limits)
        return VelocityCommand(*self._command.tolist())

    def advance(self) -> Navdata:
        """Fly until the next frame; return the navdata that arrived."""
        first, ticks = self._ticks, round(self.interval / TICK)
        self._state, track = self._vehicle.advance(
            self._state, self._command, ticks=ticks, new_command=True
        )
        self.path.append(track.position[1:])
        self._ticks, self._frames = first + ticks, self._frames + 1
        return self._arrived(read(self._sensors, track, first, departure=first == 0))

    def _arrived(self, navdata: Navdata) -> Navdata:
        """Return what has arrived by now, and keep the rest."""
        names = [field.name for field in fields(Navdata)]
        parts = [*self._under_way, navdata]
        whole = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        late = self.time + 0.5 * TICK - self._sensors.noise.delay
        count = int(np.searchsorted(whole["times"], late))
        self._under_way = [Navdata(*(whole[name][count:] for name in names))]
        return Navdata(*(whole[name][:count] for name in names))


def _mixture() -> Dmp:
    """Return the even mixture of the shipped demonstrations."""
    library = PaperPlayer(lessons_of(shipped_demonstrations(), Spec(eyes="truth"))).library
    count = len(library.primitives)
    return library.mix(np.full(count, 1.0 / count))


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
