"""Navdata: what the simulated drone measures of itself, every fifth tick (200 Hz).

    gyro            w + bias + white                                   body axes
    accelerometer   R' (dv/dt + (0, 0, g)) + white                     body axes
    attitude        roll, pitch + bias + slow + white; yaw + white     yaw: magnetic heading
    optical flow    Rz(yaw)' v + bias + white                          forward, left, up
    sonar           height above the table top when over it, else above the floor; + white
    battery         falls evenly, as the profile says

A profile's optical flow may come late: then v is that which its track calls seen, while attitude is
of the instant. All of them are stamped when they are measured; the player gets them `delay` later.
Slow is a process of Ornstein and Uhlenbeck. A bias is normal, uniform, or both.

Sample k belongs to tick 5 k of the world, and its noise is a function of (key, k) alone, so it does
not matter in what portions a path is read. Where the profile's attitude comes at a lower rate than
navdata, its white part is held in between. It is drawn apart from the noise that the vehicle's own
controller sees.
"""

import math
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float, UInt64
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import Navdata
from rotorpong.physics.noise import draw_keys
from rotorpong.physics.vehicle import TICK, SensorNoise, Track
from rotorpong.world._navdata_kernels import NAVDATA_TICKS, measure

LONGEST_DELAY = 1.0  # s
SLOW_STREAM = np.uint64(0x5DEECE66D)  # makes another key of the attitude's


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensors of one drone in one serve: all their errors, past and future."""

    noise: SensorNoise
    keys: UInt64[ndarray, "3"]  # of what is white at 200 Hz, of the attitude, of the slow attitude
    gyro_bias: Float[ndarray, "3"]  # rad/s
    attitude_bias: Float[ndarray, "2"]  # rad, roll and pitch
    velocity_bias: Float[ndarray, "3"]  # m/s
    errors: Float[ndarray, "26"]  # all of the above but the keys, as the kernel takes them


def draw_sensors(noise: SensorNoise, rng: np.random.Generator) -> Sensors:
    """Draw every error that the sensors will show in one serve.

    Raises:
        InputError: a standard deviation is negative or not finite, the attitude has no rate, the
            slow process no time, or the battery is no battery.
    """
    levels = [getattr(noise, f.name) for f in fields(noise)]
    if not all(math.isfinite(value) and value >= 0.0 for value in levels):
        raise InputError(f"{noise}: expected standard deviations that are finite and >= 0")
    if not 0.0 < noise.attitude_rate <= 1.0 / TICK:
        raise InputError(f"attitude_rate {noise.attitude_rate} Hz: expected 0 < rate <= {1 / TICK}")
    if not (noise.attitude_slow_time > 0.0 and noise.battery_life > 0.0):
        raise InputError(f"{noise}: expected attitude_slow_time and battery_life > 0 s")
    if noise.delay > LONGEST_DELAY:
        raise InputError(f"delay of navdata {noise.delay} s: expected 0 to {LONGEST_DELAY:g}")
    if noise.battery_charge > 1.0:
        raise InputError(f"battery_charge {noise.battery_charge}: expected 0 to 1")
    key, attitude_key = draw_keys(rng), draw_keys(rng)
    gyro = _bias(noise.gyro_bias, noise.gyro_bias_limit, rng.standard_normal(3))
    attitude = _bias(noise.attitude_bias, noise.attitude_bias_limit, rng.standard_normal(2))
    velocity = noise.velocity_bias * rng.standard_normal(3)
    return Sensors(
        noise,
        keys=np.array([key, attitude_key, attitude_key ^ SLOW_STREAM]),
        gyro_bias=gyro,
        attitude_bias=attitude,
        velocity_bias=velocity,
        errors=np.array([*_sizes(noise), *gyro, *attitude, *velocity, *_rest(noise)]),
    )


def _sizes(noise: SensorNoise) -> list[float]:
    """Return the white noise of each channel."""
    sizes = [noise.gyro_white] * 3 + [noise.acceleration_white] * 3 + [noise.velocity_white] * 3
    return [*sizes, noise.heading_white, noise.height_white]


def _rest(noise: SensorNoise) -> tuple[float, ...]:
    """Return what the kernel knows by its place in `errors`, from ATTITUDE_WHITE on."""
    attitude = (noise.attitude_white, noise.attitude_rate)
    slow = (noise.attitude_slow, noise.attitude_slow_time)
    return (*attitude, *slow, noise.gravity, noise.battery_charge, noise.battery_life)


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
    earliest = first_tick if departure else first_tick + 1
    first = -(-earliest // NAVDATA_TICKS) * NAVDATA_TICKS
    n = max(0, -(-(first_tick + len(track.position) - first) // NAVDATA_TICKS))
    seen = track.velocity if track.seen_velocity is None else track.seen_velocity
    flown = (track.position, seen, track.quaternion, track.body_rates, track.acceleration)
    times, height, battery = np.empty((3, n))
    gyro, force, attitude, flow = np.empty((4, n, 3))
    out = (times, gyro, force, attitude, flow, height, battery)
    measure(flown, first_tick, first, sensors.errors, sensors.keys, out)
    return Navdata(times, gyro, force, attitude, flow, height, battery)
