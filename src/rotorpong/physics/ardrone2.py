"""How the real AR.Drone 2.0 flies: the profile `ardrone2`.

The drone hears an inclination, not a velocity: fractions of its tilt limit, climb limit and turn
limit (PCMD). With roll f, pitch t, yaw y, the target of each heard `dead_time` after it was sent,
and R the rotation of the body:

    f' = (f_c - f) / tilt_lag          t' = (t_c - t) / tilt_lag        tum_ardrone: 1 / c3
    v_xy' = b pull (R z)_xy - drag v_xy                                 c1 c2 and c1; b: battery
    v_z'  = climb_rate (b climb_gain c - v_z)                           c7, c8
    r' = turn_rate (r_c - r),   y' = r                                  c5
    b = 1 - battery_sag (1 - charge),   charge falls by 1 / battery_life per second

so with tilt limit a, K = pull sin(a) / drag, T = 1 / drag, L = tilt_lag and s = t - dead_time, from
hover

    d(t) = K [s - (T^2 (1 - exp(-s/T)) - L^2 (1 - exp(-s/L))) / (T - L)].

`pull` is thrust over mass: at hover it must be near g, which is why it and `drag` are the constants
and top speed is not: however drag is drawn, the drone starts as briskly as physics has it. Height
is held by the firmware whatever the tilt. The attitude is kinematic: what torque it takes to follow
that lag is the firmware's affair, and body rates are those of roll, pitch and yaw.

A velocity command is flown by a loop of our own, off board, on each navdata message (200 Hz). It
knows the nominal drone (`VelocityLoop`) and predicts with it, after Smith: its model m flies by
what it sends, without dead time; what the drone measures (v, `velocity_delay` late, noisy) is
compared with what the model did that long and one dead time ago; the difference, smoothed over
`offset_time`, is an offset o;

    v* = m + o                          velocity when a tilt sent now begins to act
    sin(tilt) = (drag m + gain (v_c - v*)) / pull                       m' = gain (v_c - v*)
    climb     = m_z + gain (v_c - v*_z) / climb_rate

each cut at its limit: the loop may use the whole tilt limit in each axis (its authority is then
8.7 m/s), and does where command and velocity differ by more than 2 m/s. The part of the tilt that
holds the speed against drag follows the model, not v*: so m comes to rest only where v* = v_c, and
a drone with other constants also reaches its command. With gain 2.5 /s and lag 0.14 s the loop is
damped with (1 + lag drag) / (2 sqrt(gain lag)) = 0.91 and lags a command by
0.1 + (1 + lag drag) / gain = 0.53 s. `raw` leaves the loop out: the command is sent as fractions,
with the limits of the factory (`ARDRONE2_RAW`); this is what a port without changes meets.

Frames: world and body of `conventions`; commands are forward, left, up in the level body frame.
Batch: as in `vehicle`, each row gives the bits that it would give alone.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import Vector3
from rotorpong.physics._ardrone2_kernels import MEMORY_SIZE, fly
from rotorpong.physics.constants import Range, drawn, require_constants
from rotorpong.physics.noise import draw_keys
from rotorpong.physics.vehicle import (
    HOVER_MOTION,
    Legs,
    Poses,
    Rows,
    SensorNoise,
    Track,
    VehicleState,
    VelocityArray,
    check_command,
    drawn_noise,
    flown,
    parts_of,
)


class Airframe(NamedTuple):
    """Constants of the drone itself, all floats; `ARDRONE2_RANGES` says how far they vary.

    `cfg` = StateestimationParams.cfg of tum_ardrone.
    """

    tilt_lag: float = 0.14  # s, 1 / c3, cfg
    dead_time: float = 0.1  # s, from command to tilt: delayControl of tum_ardrone, in whole ms
    pull: float = 10.15  # m/s^2, thrust over mass: c1 c2 = 0.58 * 17.5, cfg
    drag: float = 0.58  # 1/s, c1, cfg
    climb_rate: float = 0.8  # 1/s, c7, cfg
    climb_gain: float = 1.0  # of the vertical speed that was asked for, once reached
    turn_rate: float = 25.0  # 1/s, c5, cfg
    battery_charge: float = 1.0  # at the start of a serve; 1 is full
    battery_life: float = 660.0  # s, 10 to 12 minutes by reviews
    battery_sag: float = 0.1  # share of thrust that an empty battery lacks; assumed
    velocity_delay: float = 0.04  # s, delayXYZ of tum_ardrone, in whole periods of 5 ms


NOMINAL_AIRFRAME = Airframe()

ARDRONE2_RANGES: Mapping[str, Range] = {
    "tilt_lag": (0.10, 0.18),  # c3: 10 in tum_ardrone's code, 7 in its cfg; and as far beyond
    "dead_time": (0.08, 0.12),  # 50 ms and a ping of 25 to 50, with margin
    "pull": (9.135, 11.165),  # 10 %: payload 0.01-0.03 kg of 0.43, thrust
    "drag": (0.3, 0.8),  # time constants 3.6 s (UFES) to 1.2 s
    "climb_rate": (0.6, 1.4),  # c7: 1.4 in tum_ardrone's code, 0.8 in its cfg
    "climb_gain": (0.9, 1.1),
    "turn_rate": (10.0, 25.0),  # c5: code, cfg
    "battery_charge": (0.3, 1.0),  # nobody flies on below
    "battery_life": (600.0, 720.0),
    "battery_sag": (0.0, 0.15),
    "velocity_delay": (0.02, 0.06),
}


class Settings(NamedTuple):
    """What the drone's configuration lets a command ask for, all floats."""

    tilt_limit: float = 0.52  # rad, euler_angle_max, the most it allows
    climb_limit: float = 2.0  # m/s, control_vz_max, the most it allows
    turn_limit: float = 1.75  # rad/s, control_yaw of ardrone_autonomy


TUNED_SETTINGS = Settings()
FACTORY_SETTINGS = Settings(math.radians(12.0), 0.7, math.radians(100.0))  # SDK, indoor


class VelocityLoop(NamedTuple):
    """Our loop off board, and the nominal drone that it has in mind, all floats."""

    gain: float = 2.5  # 1/s
    offset_time: float = 0.3  # s, over which measured velocity corrects the model
    tilt_lag: float = NOMINAL_AIRFRAME.tilt_lag
    dead_time: float = NOMINAL_AIRFRAME.dead_time
    pull: float = NOMINAL_AIRFRAME.pull
    drag: float = NOMINAL_AIRFRAME.drag
    climb_rate: float = NOMINAL_AIRFRAME.climb_rate
    velocity_delay: float = NOMINAL_AIRFRAME.velocity_delay


VELOCITY_LOOP = VelocityLoop()
SPEED_LIMIT = 5.0  # m/s, what the AR.Drone is said to reach indoors

POSSIBLE: Mapping[str, Range] = {
    **dict.fromkeys(("tilt_lag", "offset_time"), (0.01, 100.0)),  # s
    **dict.fromkeys(("drag", "climb_rate", "turn_rate"), (0.01, 100.0)),  # 1/s
    **dict.fromkeys(("pull", "gain", "climb_gain"), (1e-3, 1e3)),
    "dead_time": (0.0, 0.2),  # s, with the next within what the drone remembers
    "velocity_delay": (0.0, 0.09),  # s
    "tilt_limit": (1e-3, 1.5),  # rad
    "battery_charge": (0.0, 1.0),
    "battery_life": (1.0, 1e9),  # s
    "battery_sag": (0.0, 0.9),
}

NO_REST = np.empty((0, 1, 12))
ARDRONE2_NOISE = SensorNoise(
    gyro_white=math.radians(0.1),
    gyro_bias=0.0,
    gyro_bias_limit=math.radians(0.2),
    acceleration_white=0.35,  # as in tum_gazebo: no figure of the drone's own
    attitude_white=math.radians(0.05),
    attitude_bias=0.0,
    attitude_bias_limit=math.radians(0.3),
    attitude_slow=math.radians(0.1),
    attitude_slow_time=5.0,
    attitude_rate=200.0,
    heading_white=math.radians(0.05),  # as roll and pitch
    velocity_white=0.1,
    velocity_bias=0.03,
    height_white=0.01,  # assumed; a sonar of this class resolves 1 cm
    gravity=9.81,
)


@dataclass(frozen=True, slots=True)
class ArDrone2:
    """An AR.Drone 2.0. `replace` constants to make another of its kind."""

    constants: Airframe = NOMINAL_AIRFRAME
    settings: Settings = TUNED_SETTINGS
    loop: VelocityLoop = VELOCITY_LOOP
    noise: SensorNoise = ARDRONE2_NOISE
    raw: bool = False  # the command is fractions of the limits, and no loop flies
    name: str = "ardrone2"

    def __post_init__(self) -> None:
        """Refuse constants that no drone has.

        Raises:
            InputError: one is not finite or not within `POSSIBLE`.
        """
        for part in (self.constants, self.settings, self.loop):
            require_constants(self.name, part, POSSIBLE)

    @property
    def limits(self) -> Float[ndarray, "4"]:
        """Largest magnitudes of a command: m/s and rad/s, or fractions if `raw`."""
        if self.raw:
            return np.ones(4)
        setting = self.settings
        return np.array([SPEED_LIMIT, SPEED_LIMIT, setting.climb_limit, setting.turn_limit])

    @property
    def sensor_noise(self) -> SensorNoise:
        """How noisy its navdata are; their battery is that which the drone flies on."""
        c = self.constants
        return replace(self.noise, battery_charge=c.battery_charge, battery_life=c.battery_life)

    def randomized(self, rng: np.random.Generator) -> "ArDrone2":
        """Return another drone of its kind: constants and noise drawn, the loop as it was."""
        constants = drawn(self.constants, ARDRONE2_RANGES, rng)
        return replace(self, constants=constants, noise=drawn_noise(self.noise, rng))

    def start(self, position: Vector3, rng: np.random.Generator) -> VehicleState:
        """Hover level with yaw 0, centre of mass at `position`; draw all noise of the serve."""
        batch = tuple(position.shape[:-1])
        motion = np.broadcast_to(HOVER_MOTION, (*batch, HOVER_MOTION.size)).copy()
        motion[..., 0:3] = position
        memory, counters = np.zeros((*batch, MEMORY_SIZE)), np.zeros((*batch, 2), np.int64)
        return VehicleState(motion, memory, counters, draw_keys(rng, batch))

    def advance(
        self, state: VehicleState, command: VelocityArray, *, ticks: int, new_command: bool
    ) -> tuple[VehicleState, Track]:
        """Fly on for `ticks` under one command; see `vehicle.TumGazebo.advance`.

        Raises:
            InputError: a command is not finite, or not four numbers for each vehicle.
        """
        check_command(command, (*state.motion.shape[:-1], 4))
        return flown(fly, self._profile, state, command, span=(ticks, new_command), sees_late=True)

    def advance_rows(self, state: VehicleState, rows: Rows, legs: Legs, poses: Poses) -> None:
        """Fly some rows of a batch on; see `vehicle.BatchVehicle`."""
        fly(self._profile, rows, *parts_of(state), *legs, poses, NO_REST)

    @property
    def _profile(self) -> tuple[Airframe, Settings, VelocityLoop, tuple[float, float], bool]:
        """Return all constants as the kernel takes them."""
        noise = (self.noise.velocity_white, self.noise.velocity_bias)
        return self.constants, self.settings, self.loop, noise, self.raw


ARDRONE2 = ArDrone2()
ARDRONE2_RAW = ArDrone2(settings=FACTORY_SETTINGS, raw=True, name="ardrone2_raw")
