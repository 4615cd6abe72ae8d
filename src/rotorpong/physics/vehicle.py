"""How a drone flies that is told a velocity: the profile `tum_gazebo`.

The simulator that the paper most likely used (tum_simulator, after hector_quadrotor) flies a rigid
body by a cascade of loops of one form, evaluated once per tick of 1 ms:

    u = clip(in, +-limit),   out = P (u - x) + D (du/dt - dx/dt),   du/dt = (u_k - u_k-1) / tick

    forward, left   in: commanded velocity, x: velocity in the yaw-aligned frame
                    out / g = wanted pitch, out / g = -wanted roll
    roll, pitch     in: wanted angle, x: measured angle, dx/dt: body rate;
                    out = angular acceleration
    yaw             in: commanded rate, x: rate about the vertical, dx/dt = 0
    up              in: commanded velocity, x: vertical velocity;
                    thrust = m (out + g / (cos roll cos pitch)), within 0..30 N

What the loops see is a sample taken every 10 ms and held; its acceleration is the difference of the
last two sampled velocities, its roll and pitch carry white noise. A step of a held command is a
kick of one tick that the tilt limit cuts off, so for horizontal steps v = v_c / (0.4 s + 1), while
a command that is smooth at 1 kHz acts with its derivative: the command rate changes the dynamics.

    p' = v,   m v' = R(q) (0, 0, thrust) - m (0, 0, g),   q' = q (0, w) / 2,
    I w' = I out - w x I w                            no drag, no motor lag; Runge-Kutta, 1 kHz

Frames: world and body of `conventions`; commands are forward, left, up in the level body frame.
Batch: a state may have one leading axis of vehicles that fly in lockstep; each row gives the same
bits as it would alone. The g of Gazebo, 9.8, stays inside this profile.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int64
from numpy import ndarray

from rotorpong.conventions import InputError, Quaternion, Vector3
from rotorpong.physics._vehicle_kernels import MEMORY_SIZE, fly
from rotorpong.physics._vehicle_kernels import TICK as TICK
from rotorpong.physics.cascade import NOISE_FREE_CASCADE as NOISE_FREE_CASCADE
from rotorpong.physics.cascade import TUM_CASCADE as TUM_CASCADE
from rotorpong.physics.cascade import Cascade as Cascade
from rotorpong.physics.constants import Range, drawn, require_constants
from rotorpong.physics.noise import Keys, draw_keys

VelocityArray = Float[ndarray, "*batch 4"]  # forward, left, up in m/s, yaw rate in rad/s

Rows = Int64[ndarray, "rows"]
Poses = Float[ndarray, "n instants 7"]  # position, quaternion

NO_REST = np.empty((0, 1, 9))
HOVER_MOTION = np.array([0.0] * 6 + [1.0] + [0.0] * 9)


TUM_RANGES: Mapping[str, Range] = {
    "horizontal_p": (4.5, 5.5),  # 10 %: what a tuned copy of the plugin would have
    "vertical_p": (4.5, 5.5),
    "tilt_p": (9.0, 11.0),
    "tilt_d": (4.5, 5.5),
    "yaw_p": (1.8, 2.2),
    "attitude_noise": (0.0025, 0.35 / 9.8),  # rad, see `Cascade`: both readings of the plugin
    "command_white": (0.0, 0.05),
    "command_offset": (0.0, 0.03),
}
TUM_LIMITS: Mapping[str, Range] = {
    **dict.fromkeys(("mass", "inertia_x", "inertia_y", "inertia_z", "gravity"), (1e-9, 1e9)),
    **dict.fromkeys(("horizontal_limit", "vertical_limit", "yaw_limit"), (0.0, 1e3)),
    "tilt_limit": (0.0, 1.5),
    "sample_ticks": (1.0, 1e6),
    "command_offset_period": (TICK, 1e9),
}


@dataclass(frozen=True, slots=True)
class SensorNoise:
    """How far navdata are off (standard deviations); `world.sensors` adds it."""

    gyro_white: float  # rad/s
    gyro_bias: float  # rad/s, constant per serve
    acceleration_white: float  # m/s^2
    attitude_white: float  # rad, roll and pitch
    attitude_bias: float  # rad, constant per serve
    attitude_rate: float  # Hz, at which the white part is drawn anew
    heading_white: float  # rad
    velocity_white: float  # m/s
    velocity_bias: float  # m/s, constant per serve
    height_white: float  # m
    gravity: float  # m/s^2, of the profile: what its accelerometer shows at rest
    gyro_bias_limit: float = 0.0  # rad/s, uniform +-, constant per serve; adds to `gyro_bias`
    attitude_bias_limit: float = 0.0  # rad, uniform +-, constant per serve
    attitude_slow: float = 0.0  # rad, roll and pitch, a process of Ornstein and Uhlenbeck
    attitude_slow_time: float = 5.0  # s, its correlation time
    battery_charge: float = 1.0  # at the start of a serve
    battery_life: float = 1200.0  # s, from full to empty; 1200 is tum_simulator's


SCALED_NOISE = (  # what `drawn_noise` scales: the levels
    *("gyro_white", "gyro_bias", "gyro_bias_limit", "acceleration_white", "attitude_white"),
    *("attitude_bias", "attitude_bias_limit", "attitude_slow", "heading_white"),
    *("velocity_white", "velocity_bias", "height_white"),
)
NOISE_FACTOR: Range = (0.5, 1.5)


def drawn_noise(noise: SensorNoise, rng: np.random.Generator) -> SensorNoise:
    """Return sensors whose every level is 0.5 to 1.5 times as large."""
    return replace(
        noise, **{name: getattr(noise, name) * rng.uniform(*NOISE_FACTOR) for name in SCALED_NOISE}
    )


TUM_GAZEBO_NOISE = SensorNoise(
    gyro_white=0.0,  # rateGaussianNoise 0
    gyro_bias=0.0,
    acceleration_white=0.35,  # accelGaussianNoise
    attitude_white=0.35 / 9.8,
    attitude_bias=0.0,
    attitude_rate=100.0,
    heading_white=0.0,  # headingGaussianNoise 0
    velocity_white=0.1,  # the real drone's optical flow; the simulator reports truth
    velocity_bias=0.03,
    height_white=0.0,  # sonar gaussianNoise 0
    gravity=9.8,
)


@dataclass(frozen=True, slots=True)
class VehicleState:
    """Everything that decides how vehicles fly on, noise included."""

    motion: Float[ndarray, "*batch 16"]
    memory: Float[ndarray, "*batch m"]  # of the flight controller, the held command last
    counters: Int64[ndarray, "*batch 2"]  # ticks flown, messages received
    keys: Keys

    @property
    def position(self) -> Vector3:
        """Centre of mass in the world, m."""
        return self.motion[..., 0:3]

    @property
    def velocity(self) -> Vector3:
        """Velocity in the world, m/s."""
        return self.motion[..., 3:6]

    @property
    def quaternion(self) -> Quaternion:
        """Attitude, body to world."""
        return self.motion[..., 6:10]

    @property
    def body_rates(self) -> Vector3:
        """Angular velocity in body axes, rad/s."""
        return self.motion[..., 10:13]

    @property
    def held_command(self) -> VelocityArray:
        """What the last message asked for, its noise included."""
        return self.memory[..., -4:]

    @property
    def ticks(self) -> Int64[ndarray, "*batch"]:
        """Ticks flown since the start."""
        return self.counters[..., 0]


@dataclass(frozen=True, slots=True)
class Track:
    """Flown path at n instants one tick apart, the instant of departure included."""

    position: Float[ndarray, "*batch n 3"]  # m, world
    velocity: Float[ndarray, "*batch n 3"]  # m/s, world
    quaternion: Float[ndarray, "*batch n 4"]  # body to world
    body_rates: Float[ndarray, "*batch n 3"]  # rad/s
    acceleration: Float[ndarray, "*batch n 3"]  # m/s^2, world, mean over the tick that ends here
    seen_velocity: Float[ndarray, "*batch n 3"] | None = None
    """m/s, world: what navdata show at the instant, before noise; None: `velocity`, undelayed."""


@runtime_checkable
class Vehicle(Protocol):
    """Anything that flies by velocity commands; users pass their own.

    A vehicle is immutable: whatever decides the rest of a flight is in the state that it hands out,
    of which `motion` and the held command are read by others and the rest is its own affair. State,
    position and command may have one leading axis of vehicles in lockstep. For `--randomize` it has
    `randomized(rng)` as well, which returns another of its kind.
    """

    @property
    def name(self) -> str:
        """How the vehicle is called in reports."""
        ...

    @property
    def limits(self) -> Float[ndarray, "4"]:
        """Largest magnitudes of a command: forward, left, up in m/s, yaw rate in rad/s."""
        ...

    @property
    def sensor_noise(self) -> SensorNoise:
        """How noisy its navdata are."""
        ...

    def start(self, position: Vector3, rng: np.random.Generator) -> VehicleState:
        """Hover level with yaw 0, centre of mass at `position`; draw all noise of the serve."""
        ...

    def advance(
        self, state: VehicleState, command: VelocityArray, *, ticks: int, new_command: bool
    ) -> tuple[VehicleState, Track]:
        """Fly on for `ticks` under one command; `new_command` says that a message brought it."""
        ...


class Legs(NamedTuple):
    """What each vehicle of a batch flies next: its own command over its own number of ticks."""

    commands: Float[ndarray, "n 4"]
    are_new: Bool[ndarray, "n"]  # whether a message brought the command
    starts: Int64[ndarray, "n"]  # instant of the log at which it is now
    ticks: Int64[ndarray, "n"]  # of the leg


@runtime_checkable
class BatchVehicle(Vehicle, Protocol):
    """A vehicle of which a batch flies at once, each row as far as it likes; not needed, but fast.

    Rows that it flies so have the bits that `advance` gives them.
    """

    def advance_rows(self, state: VehicleState, rows: Rows, legs: Legs, poses: Poses) -> None:
        """Fly some rows of a batch on, in place.

        Args:
            state: of all rows; those that fly are overwritten.
            rows: which fly, the longest leg first.
            legs: of all rows; commands are finite.
            poses: log of position and quaternion, filled from each row's start to its arrival.
        """
        ...


@dataclass(frozen=True, slots=True)
class TumGazebo:
    """The drone of tum_simulator. `replace` constants to make another of its kind."""

    constants: Cascade = TUM_CASCADE
    sensor_noise: SensorNoise = TUM_GAZEBO_NOISE
    name: str = "tum_gazebo"

    def __post_init__(self) -> None:
        """Refuse impossible constants.

        Raises:
            InputError: one is not finite, or negative, or zero where it may not be.
        """
        require_constants(self.name, self.constants, TUM_LIMITS)
        ticks = self.constants.sample_ticks
        if ticks != int(ticks):
            raise InputError(
                f"{self.name}: sample_ticks {ticks}: expected a finite number of whole ms"
            )

    @property
    def limits(self) -> Float[ndarray, "4"]:
        """Largest magnitudes of a command: forward, left, up in m/s, yaw rate in rad/s."""
        c = self.constants
        return np.array([c.horizontal_limit, c.horizontal_limit, c.vertical_limit, c.yaw_limit])

    def start(self, position: Vector3, rng: np.random.Generator) -> VehicleState:
        """Hover level with yaw 0, centre of mass at `position`; draw all noise of the serve."""
        batch = position.shape[:-1]
        motion = np.broadcast_to(HOVER_MOTION, (*batch, HOVER_MOTION.size)).copy()
        motion[..., 0:3] = position
        memory = np.zeros((*batch, MEMORY_SIZE))
        return VehicleState(
            motion, memory, np.zeros((*batch, 2), np.int64), draw_keys(rng, tuple(batch))
        )

    def advance(
        self, state: VehicleState, command: VelocityArray, *, ticks: int, new_command: bool
    ) -> tuple[VehicleState, Track]:
        """Fly on for `ticks` under one command.

        Args:
            state: one vehicle, or a batch of them with one leading axis.
            command: forward, left, up in m/s and yaw rate in rad/s, one for each vehicle.
            ticks: how far, in ms.
            new_command: whether a message brought the command at this instant. If not, what the
                last message brought stays in force and `command` is not read.

        Raises:
            InputError: a command is not finite, or not four numbers for each vehicle.
        """
        check_command(command, (*state.motion.shape[:-1], 4))
        return flown(fly, tuple(self.constants), state, command, span=(ticks, new_command))

    def advance_rows(self, state: VehicleState, rows: Rows, legs: Legs, poses: Poses) -> None:
        """Fly some rows of a batch on; see `BatchVehicle`."""
        fly(tuple(self.constants), rows, *parts_of(state), *legs, poses, NO_REST)

    def randomized(self, rng: np.random.Generator) -> "TumGazebo":
        """Return another drone of its kind: constants and sensor noise drawn.

        Controller and navdata read one and the same imu, so that their attitude is as noisy.
        """
        noise = drawn_noise(self.sensor_noise, rng)
        constants = drawn(self.constants, TUM_RANGES, rng)
        noise = replace(noise, attitude_white=constants.attitude_noise)
        return replace(self, constants=constants, sensor_noise=noise)


TUM_GAZEBO = TumGazebo()


def check_command(command: VelocityArray, shape: tuple[int, ...]) -> None:
    """Refuse a command that must not enter an integrator.

    Raises:
        InputError: it is not finite, or has another shape.
    """
    if command.shape != shape or not np.isfinite(command).all():
        raise InputError(
            f"velocity command {np.array2string(command, threshold=8)} of shape {command.shape}: "
            f"expected finite forward, left, up (m/s) and yaw rate (rad/s), shape {shape}"
        )


def rows_flown_by(vehicle: Vehicle) -> Callable[[VehicleState, Rows, Legs, Poses], None]:
    """Return what any vehicle does as `BatchVehicle.advance_rows`: equal legs fly together."""
    if isinstance(vehicle, BatchVehicle):
        return vehicle.advance_rows

    def advance_rows(state: VehicleState, rows: Rows, legs: Legs, poses: Poses) -> None:
        kinds = 2 * legs.ticks[rows] + legs.are_new[rows]
        for kind in np.unique(kinds).tolist():
            those, ticks, is_new = rows[kinds == kind], kind // 2, bool(kind % 2)
            some = VehicleState(*(part[those] for part in parts_of(state)))
            after, track = vehicle.advance(
                some, legs.commands[those], ticks=ticks, new_command=is_new
            )
            for part, new in zip(parts_of(state), parts_of(after), strict=True):
                part[those] = new
            instants = legs.starts[those, None] + np.arange(ticks + 1)
            flown = np.concatenate([track.position, track.quaternion], axis=-1)
            poses[those[:, None], instants] = flown

    return advance_rows


def parts_of(state: VehicleState) -> tuple[ndarray, ndarray, ndarray, Keys]:
    """Return the arrays of a state, as kernels take them."""
    return state.motion, state.memory, state.counters, state.keys


def flown(
    kernel: Callable[..., None],
    profile: Any,
    state: VehicleState,
    command: VelocityArray,
    *,
    span: tuple[int, bool],
    sees_late: bool = False,
) -> tuple[VehicleState, Track]:
    """Fly by a kernel: lay out one row per vehicle, make room, and shape what comes back.

    Args:
        kernel: called with profile, rows, parts of the state, legs, poses, the rest of the tracks.
        profile: the vehicle's constants.
        state: where they are.
        command: one for each vehicle.
        span: ticks, and whether the command is new.
        sees_late: whether the kernel fills `Track.seen_velocity` as well.
    """
    is_batch = state.motion.ndim > 1
    after = VehicleState(
        state.motion.copy(), state.memory.copy(), state.counters.copy(), state.keys
    )
    parts = parts_of(after) if is_batch else [part[None] for part in parts_of(after)]
    n, instants = len(parts[0]), span[0] + 1
    commands = np.ascontiguousarray(command, dtype=np.float64).reshape(n, 4)
    legs = Legs(commands, np.full(n, span[1], bool), np.zeros(n, np.int64), np.full(n, span[0]))
    poses, rest = np.empty((n, instants, 7)), np.empty((n, instants, 9 + 3 * sees_late))
    kernel(profile, np.arange(n), *map(np.ascontiguousarray, parts), *legs, poses, rest)
    if not is_batch:
        poses, rest = poses[0], rest[0]
    velocity, rates, acceleration = rest[..., :3], rest[..., 3:6], rest[..., 6:9]
    seen = rest[..., 9:] if sees_late else None
    track = Track(poses[..., :3], velocity, poses[..., 3:], rates, acceleration, seen)
    return after, track
