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

from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int64
from numpy import ndarray

from rotorpong.conventions import InputError, Quaternion, Vector3
from rotorpong.physics._vehicle_kernels import TICK as TICK
from rotorpong.physics._vehicle_kernels import fly
from rotorpong.physics.noise import Keys, draw_keys

VelocityArray = Float[ndarray, "*batch 4"]  # forward, left, up in m/s, yaw rate in rad/s

HOVER_MOTION = np.array([0.0] * 6 + [1.0] + [0.0] * 9)
MEMORY_SIZE = 22


class Cascade(NamedTuple):
    """Constants of the rigid body and its loops, all floats.

    Sources: `simple` = quadrotor_simple_controller and its xacro, `imu` = gazebo_ros_imu and
    quadrotor_sensors.urdf.xacro, `base` = quadrotor_base.urdf.xacro of tum_simulator.
    """

    mass: float = 1.477  # kg, base
    inertia_x: float = 0.01152  # kg m^2, base
    inertia_y: float = 0.01152
    inertia_z: float = 0.0218
    gravity: float = 9.8  # m/s^2, Gazebo's
    thrust_limit: float = 30.0  # N, simple
    horizontal_p: float = 5.0  # 1/s, simple, as all loops below
    horizontal_d: float = 1.0
    horizontal_limit: float = 2.0  # m/s
    vertical_p: float = 5.0  # 1/s
    vertical_d: float = 1.0
    vertical_limit: float = 0.5  # m/s
    tilt_p: float = 10.0  # 1/s^2
    tilt_d: float = 5.0  # 1/s
    tilt_limit: float = 0.5  # rad
    yaw_p: float = 2.0  # 1/s
    yaw_d: float = 1.0
    yaw_limit: float = 1.5  # rad/s
    sample_ticks: float = 10.0  # state and imu at 100 Hz
    attitude_noise: float = 0.35 / 9.8  # rad, white in each sample: accelerometer noise over g, imu
    command_white: float = 0.05  # m/s and rad/s, uniform +-, anew for each message, simple
    command_offset: float = 0.03  # m/s and rad/s, uniform +-, anew every period, simple
    command_offset_period: float = 5.0  # s


TUM_CASCADE = Cascade()
NOISE_FREE_CASCADE = Cascade(attitude_noise=0.0, command_white=0.0, command_offset=0.0)


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
    memory: Float[ndarray, "*batch 22"]  # of the flight controller
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
        return self.memory[..., 18:22]

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


@runtime_checkable
class Vehicle(Protocol):
    """Anything that flies by velocity commands; users pass their own."""

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


@dataclass(frozen=True, slots=True)
class TumGazebo:
    """The drone of tum_simulator. `replace` constants to make another of its kind."""

    constants: Cascade = TUM_CASCADE
    sensor_noise: SensorNoise = TUM_GAZEBO_NOISE
    name: str = "tum_gazebo"

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
        _check(command, (*state.motion.shape[:-1], 4))
        rows = _rows(state)
        outputs = _room(rows, ticks)
        orders = np.ascontiguousarray(command, dtype=np.float64).reshape(-1, 4)
        fly(self.constants, rows, orders, (ticks, new_command), outputs)
        motion, memory, counters, *track = (_like(part, state) for part in outputs)
        return VehicleState(motion, memory, counters, state.keys), Track(*track)


TUM_GAZEBO = TumGazebo()


def _check(command: VelocityArray, shape: tuple[int, ...]) -> None:
    if command.shape != shape or not np.isfinite(command).all():
        raise InputError(
            f"velocity command {np.array2string(command, threshold=8)} of shape {command.shape}: "
            f"expected finite forward, left, up (m/s) and yaw rate (rad/s), shape {shape}"
        )


def _rows(state: VehicleState) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    return (
        np.ascontiguousarray(state.motion).reshape(-1, 16),
        np.ascontiguousarray(state.memory).reshape(-1, MEMORY_SIZE),
        np.ascontiguousarray(state.counters).reshape(-1, 2),
        np.ascontiguousarray(state.keys).reshape(-1),
    )


def _room(rows: tuple[ndarray, ...], ticks: int) -> tuple[ndarray, ...]:
    n = len(rows[0])
    tracks = [np.empty((n, ticks + 1, width)) for width in (3, 3, 4, 3, 3)]
    return (*(np.empty_like(part) for part in rows[:3]), *tracks)


def _like(part: ndarray, state: VehicleState) -> ndarray:
    return part.reshape(state.motion.shape[:-1] + part.shape[1:])
