"""Motions flown in empty air: how far a drone is from where a motion is, at every instant.

A drone hovers for half a second and then flies a motion, with commands 30 times a second. Every
seed has its own noise of vehicle and navdata, the same for all controls. Axes X right, Y down,
Z depth, those of the level camera at the start.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control import Control, Course, Departure, Follower, follower
from rotorpong.control.plant import plant_of
from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import HOVER, Navdata, VelocityCommand
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.spec import Spec
from rotorpong.physics.vehicle import TICK, Vehicle
from rotorpong.play.paper import PaperPlayer
from rotorpong.primitives import Dmp, State
from rotorpong.world.sensors import draw_sensors, read

HOVERING = 15  # intervals before
RATE = 30  # commands/s
GOAL = np.array([0.03, -0.12, 0.25])  # m: right, down, forward
SPEED = np.array([0.0, -0.2, 0.5])  # m/s, there
DURATION = 0.8  # s


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


def small_aside(dmp: Dmp) -> Task:
    """Return a motion whose displacement in X is small, as in the paper (its footnote 6)."""
    return Task(dmp, State(GOAL, SPEED), DURATION)


def tasks_aside(
    dmp: Dmp, aside: tuple[float, float], durations: Sequence[float]
) -> tuple[Task, ...]:
    """Return motions to either side (m), up and down (m), in each duration (s), ending at rest."""
    return tuple(
        Task(dmp, State(np.array([side, height, 0.0]), np.zeros(3)), duration)
        for side, height, duration in product(*((-way, way) for way in aside), durations)
    )


@dataclass(frozen=True, slots=True)
class Flown:
    """A motion as it was flown, a row for each tick of it, from its beginning to its end."""

    times: Float[ndarray, "n"]  # s since the beginning
    wanted: Float[ndarray, "n 3"]  # m, from where it began
    position: Float[ndarray, "n 3"]  # m, where the drone was minus where it was meant to be
    velocity: Float[ndarray, "n 3"]  # m/s, the same of the velocity


def fly(vehicle: Vehicle, control: Control, task: Task, *, seed: int) -> Flown:
    """Fly a motion and return how far off the drone was."""
    flight, flown = FreeFlight(vehicle, seed=seed), follower(control, plant_of(vehicle))
    for _ in range(HOVERING):
        _step(flight, flown, HOVER)
    departure = flown.depart(flight.time)
    course = task.course(departure, smooth=control != "open")
    while flight.time < course.end:
        now, interval = flight.time, flight.interval
        _step(flight, flown, flown.command(course, now, interval))
    ticks = round(course.begin / TICK) + np.arange(round(task.duration / TICK) + 1)
    wanted, speed, *_ = course.at(ticks * TICK)
    wanted -= departure.position
    path = np.concatenate(flight.path) @ CAMERA_FROM_BODY_AXES.T
    velocity = np.gradient(path, TICK, axis=0)[ticks]
    return Flown(
        ticks * TICK - course.begin, wanted, path[ticks] - path[ticks[0]] - wanted, velocity - speed
    )


def even_mixture() -> Dmp:
    """Return the even mixture of the shipped demonstrations."""
    library = PaperPlayer(lessons_of(shipped_demonstrations(), Spec(eyes="truth"))).library
    count = len(library.primitives)
    return library.mix(np.full(count, 1.0 / count))


class FreeFlight:
    """A drone in the air, with nothing else in it."""

    def __init__(self, vehicle: Vehicle, *, seed: int) -> None:
        """Hover.

        Args:
            vehicle: the drone.
            seed: of its own noise and that of its sensors.
        """
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


def _step(flight: FreeFlight, flown: Follower, command: VelocityCommand) -> None:
    now = flight.time
    flown.sent(now, flight.command(command))
    flown.sense(flight.advance())
