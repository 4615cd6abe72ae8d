"""Navdata: what the simulated drone measures of itself, every fifth tick (200 Hz).

    gyro            w + bias + white                                   body axes
    accelerometer   R' (dv/dt + (0, 0, g)) + white                     body axes
    attitude        roll, pitch + bias + slow + white; yaw + white     yaw: magnetic heading
    optical flow    Rz(yaw)' v + bias + white                          forward, left, up
    sonar           height above the table top when over it, else above the floor; + white
    battery         falls evenly, as the profile says

A profile's optical flow may come late: then v is that which its track calls seen, while attitude is
of the instant. Slow is a process of Ornstein and Uhlenbeck. A bias is normal, uniform, or both.

Sample k belongs to tick 5 k of the world, and its noise is a function of (key, k) alone, so it does
not matter in what portions a path is read. Where the profile's attitude comes at a lower rate than
navdata, its white part is held in between. It is drawn apart from the noise that the vehicle's own
controller sees.
"""

import math
from dataclasses import astuple, dataclass

import numpy as np
from jaxtyping import Bool, Float, Int64, UInt64
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import Navdata
from rotorpong.geometry import euler_from_quaternion, rotation_from_quaternion
from rotorpong.physics.noise import draw_keys, normal_samples, slow_samples
from rotorpong.physics.vehicle import TICK, SensorNoise, Track
from rotorpong.world.court import FLOOR_HEIGHT, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH

NAVDATA_TICKS = 5  # 200 Hz, as both tum_simulator and the AR.Drone in full mode publish
CHANNELS = 11  # gyro 0:3, accelerometer 3:6, flow 6:9, heading 9, sonar 10
SLOW_STREAM = np.uint64(0x5DEECE66D)  # makes another key of the attitude's


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensors of one drone in one serve: all their errors, past and future."""

    noise: SensorNoise
    key: UInt64[ndarray, ""]  # of what is white at 200 Hz
    attitude_key: UInt64[ndarray, ""]
    gyro_bias: Float[ndarray, "3"]  # rad/s
    attitude_bias: Float[ndarray, "2"]  # rad, roll and pitch
    velocity_bias: Float[ndarray, "3"]  # m/s


def draw_sensors(noise: SensorNoise, rng: np.random.Generator) -> Sensors:
    """Draw every error that the sensors will show in one serve.

    Raises:
        InputError: a standard deviation is negative or not finite, the attitude has no rate, the
            slow process no time, or the battery is no battery.
    """
    if not all(np.isfinite(value) and value >= 0.0 for value in astuple(noise)):
        raise InputError(f"{noise}: expected standard deviations that are finite and >= 0")
    if not 0.0 < noise.attitude_rate <= 1.0 / TICK:
        raise InputError(f"attitude_rate {noise.attitude_rate} Hz: expected 0 < rate <= {1 / TICK}")
    if not (noise.attitude_slow_time > 0.0 and noise.battery_life > 0.0):
        raise InputError(f"{noise}: expected attitude_slow_time and battery_life > 0 s")
    if noise.battery_charge > 1.0:
        raise InputError(f"battery_charge {noise.battery_charge}: expected 0 to 1")
    return Sensors(
        noise,
        key=draw_keys(rng),
        attitude_key=draw_keys(rng),
        gyro_bias=_bias(noise.gyro_bias, noise.gyro_bias_limit, rng.standard_normal(3)),
        attitude_bias=_bias(noise.attitude_bias, noise.attitude_bias_limit, rng.standard_normal(2)),
        velocity_bias=noise.velocity_bias * rng.standard_normal(3),
    )


def _bias(size: float, limit: float, draw: Float[ndarray, "n"]) -> Float[ndarray, "n"]:
    """Return a normal bias plus a uniform one, both made of the same standard normal draw.

    So a profile of either kind takes as much from its generator.
    """
    uniform = np.array([math.erf(value / math.sqrt(2.0)) for value in draw])
    return size * draw + limit * uniform


def read(sensors: Sensors, track: Track, first_tick: int, *, departure: bool = False) -> Navdata:
    """Return what the sensors measured along a path.

    Args:
        sensors: of this serve.
        track: of one vehicle, instants one tick apart.
        first_tick: the world's tick at the path's departure; tick 0 is time 0.
        departure: whether the departure itself is read. Where paths join, the arrival of the one
            is the departure of the next, and is read once.
    """
    ticks = _sample_ticks(first_tick, len(track.position), departure=departure)
    at = ticks - first_tick
    white = _white(sensors, ticks)
    rotation = rotation_from_quaternion(track.quaternion[at])
    attitude = euler_from_quaternion(track.quaternion[at])
    times = ticks * TICK
    noise = sensors.noise
    seen = track.velocity if track.seen_velocity is None else track.seen_velocity
    return Navdata(
        times=times,
        body_rates=track.body_rates[at] + sensors.gyro_bias + white[:, 0:3],
        acceleration=_specific_force(sensors, rotation, track.acceleration[at]) + white[:, 3:6],
        attitude=attitude + _attitude_error(sensors, ticks, white[:, 9]),
        velocity=_level(seen[at], attitude[:, 2]) + sensors.velocity_bias + white[:, 6:9],
        height=_height(track.position[at]) + white[:, 10],
        battery=np.maximum(0.0, noise.battery_charge - times / noise.battery_life),
    )


def _sample_ticks(first_tick: int, instants: int, *, departure: bool) -> Int64[ndarray, "n"]:
    earliest = first_tick if departure else first_tick + 1
    first = -(-earliest // NAVDATA_TICKS) * NAVDATA_TICKS
    return np.arange(first, first_tick + instants, NAVDATA_TICKS, dtype=np.int64)


def _white(sensors: Sensors, ticks: Int64[ndarray, "n"]) -> Float[ndarray, "n 11"]:
    noise = sensors.noise
    sizes = [noise.gyro_white] * 3 + [noise.acceleration_white] * 3 + [noise.velocity_white] * 3
    sizes += [noise.heading_white, noise.height_white]
    first = int(ticks[0]) // NAVDATA_TICKS if len(ticks) else 0
    return np.array(sizes) * normal_samples(sensors.key, first, (len(ticks), CHANNELS))


def _attitude_error(
    sensors: Sensors, ticks: Int64[ndarray, "n"], heading: Float[ndarray, "n"]
) -> Float[ndarray, "n 3"]:
    messages = np.floor(ticks * TICK * sensors.noise.attitude_rate + 1e-6).astype(np.int64)
    error = np.column_stack([np.zeros((len(ticks), 2)), heading])
    if len(ticks):
        first, last = int(messages[0]), int(messages[-1])
        drawn = normal_samples(sensors.attitude_key, first, (last - first + 1, 2))
        error[:, 0:2] = sensors.noise.attitude_white * drawn[messages - first]
    error[:, 0:2] += sensors.attitude_bias
    slow = sensors.noise.attitude_slow
    if slow > 0.0:
        key = np.asarray(sensors.attitude_key ^ SLOW_STREAM)
        correlation_time = sensors.noise.attitude_slow_time
        error[:, 0:2] += slow * slow_samples(key, ticks * TICK, correlation_time, 2)
    return error


def _specific_force(
    sensors: Sensors, rotation: Float[ndarray, "n 3 3"], acceleration: Float[ndarray, "n 3"]
) -> Float[ndarray, "n 3"]:
    felt = acceleration + np.array([0.0, 0.0, sensors.noise.gravity])
    return np.einsum("nij,ni->nj", rotation, felt)


def _level(velocity: Float[ndarray, "n 3"], yaw: Float[ndarray, "n"]) -> Float[ndarray, "n 3"]:
    cosine, sine = np.cos(yaw), np.sin(yaw)
    x, y, up = velocity.T
    return np.column_stack([cosine * x + sine * y, cosine * y - sine * x, up])


def _height(position: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
    x, y, z = position.T
    return np.where(_over_table(x, y) & (z >= 0.0), z, z - FLOOR_HEIGHT)


def _over_table(x: Float[ndarray, "n"], y: Float[ndarray, "n"]) -> Bool[ndarray, "n"]:
    return (np.abs(x) <= TABLE_HALF_LENGTH) & (np.abs(y) <= TABLE_HALF_WIDTH)
