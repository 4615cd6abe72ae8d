from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from noise_samples import normal_samples, slow_samples
from scipy import stats
from scipy.spatial.transform import Rotation

from rotorpong.conventions import InputError
from rotorpong.drone import Navdata
from rotorpong.geometry import euler_from_quaternion, rotation_from_quaternion
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.physics.vehicle import (
    NOISE_FREE_CASCADE,
    SCALED_NOISE,
    TUM_GAZEBO,
    SensorNoise,
    Track,
    TumGazebo,
)
from rotorpong.world.sensors import draw_sensors, read

PERFECT = replace(TUM_GAZEBO.sensor_noise, **dict.fromkeys(SCALED_NOISE, 0.0))
NOISY = SensorNoise(0.01, 0.02, 0.3, 0.03, 0.005, 100.0, 0.04, 0.1, 0.03, 0.02, 9.8)


def rng(seed=0):
    return np.random.default_rng(seed)


def flown(ticks=1000):
    """Return a path with turns, climbs and tilts."""
    drone = TumGazebo(NOISE_FREE_CASCADE)
    state = drone.start(np.array([-1.9, 0.1, 0.2]), rng())
    order = np.array([1.5, -1.0, 0.3, 1.0])
    return drone.advance(state, order, ticks=ticks, new_command=True)[1]


def resting(position, instants):
    """Return the path of a drone that hovers at `position`."""
    zeros = np.zeros((instants, 3))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (instants, 1))
    return Track(np.tile(position, (instants, 1)), zeros, level, zeros, zeros)


def cut(track, first, last):
    """Return the instants first to last of a path."""
    columns = (getattr(track, f.name) for f in fields(Track))
    return Track(*(None if part is None else part[first : last + 1] for part in columns))


def joined(parts, name):
    return np.concatenate([getattr(part, name) for part in parts])


def test_perfect_sensors_tell_what_scipy_derives_from_the_path():
    track = flown()
    navdata = read(draw_sensors(PERFECT, rng()), track, 0, departure=True)
    at = np.arange(0, 1001, 5)
    assert navdata.times == pytest.approx(at / 1000)
    turn = Rotation.from_quat(track.quaternion[at], scalar_first=True)
    yaw_pitch_roll = turn.as_euler("ZYX")
    assert navdata.attitude == pytest.approx(yaw_pitch_roll[:, ::-1], abs=1e-12)
    assert np.array_equal(navdata.body_rates, track.body_rates[at])
    force = turn.apply(track.acceleration[at] + [0.0, 0.0, 9.8], inverse=True)
    assert navdata.acceleration == pytest.approx(force, abs=1e-12)
    level = Rotation.from_euler("Z", yaw_pitch_roll[:, :1]).apply(track.velocity[at], inverse=True)
    assert navdata.velocity == pytest.approx(level, abs=1e-12)


def read_slowly(sensors, track, first_tick):
    """Return what `read` returns, in whole arrays: the equations of the module, by numpy."""
    ticks = np.arange(first_tick, first_tick + len(track.position))
    at = np.flatnonzero((ticks % 5 == 0) & (ticks > first_tick))
    noise, times, first = sensors.noise, 0.001 * ticks[at], int(ticks[at[0]]) // 5
    white = normal_samples(sensors.keys[0, ...], first, (len(at), 11))
    messages = np.floor(times * noise.attitude_rate + 1e-6).astype(int)
    drawn = normal_samples(sensors.keys[1, ...], 0, (int(messages[-1]) + 1, 2))[messages]
    slow = slow_samples(sensors.keys[2, ...], times, noise.attitude_slow_time, 2)
    attitude = euler_from_quaternion(track.quaternion[at])
    yaw, seen = (
        attitude[:, 2],
        track.velocity if track.seen_velocity is None else track.seen_velocity,
    )
    x, y, up = seen[at].T
    level = np.stack(
        [np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x, up], axis=1
    )
    felt = (track.acceleration[at] + [0.0, 0.0, noise.gravity])[:, None]
    force = (felt @ rotation_from_quaternion(track.quaternion[at]))[:, 0]
    error = noise.attitude_white * drawn + sensors.attitude_bias + noise.attitude_slow * slow
    attitude = attitude + np.column_stack([error, noise.heading_white * white[:, 9]])
    x, y, z = track.position[at].T
    over_table = (np.abs(x) <= 1.37) & (np.abs(y) <= 0.7625) & (z >= 0.0)
    return Navdata(
        times=times,
        body_rates=track.body_rates[at] + sensors.gyro_bias + noise.gyro_white * white[:, :3],
        acceleration=force + noise.acceleration_white * white[:, 3:6],
        attitude=attitude,
        velocity=level + sensors.velocity_bias + noise.velocity_white * white[:, 6:9],
        height=np.where(over_table, z, z + 0.76) + noise.height_white * white[:, 10],
        battery=np.maximum(0.0, noise.battery_charge - times / noise.battery_life),
    )


@pytest.mark.parametrize("first_tick", [0, 3, 1234])
@pytest.mark.parametrize(
    "noise", [NOISY, replace(NOISY, attitude_slow=0.02, attitude_rate=70.0), ARDRONE2.sensor_noise]
)
@pytest.mark.parametrize("vehicle", [TUM_GAZEBO, ARDRONE2])
def test_the_kernel_reads_what_numpy_reads(vehicle, noise, first_tick):
    state = vehicle.start(np.array([-1.9, 0.1, 0.2]), rng(1))
    order = np.array([1.5, -1.0, 0.3, 1.0])
    track = vehicle.advance(state, order, ticks=700, new_command=True)[1]
    sensors = draw_sensors(noise, rng(first_tick))
    fast, slow = read(sensors, track, first_tick), read_slowly(sensors, track, first_tick)
    for f in fields(fast):
        np.testing.assert_allclose(getattr(fast, f.name), getattr(slow, f.name), atol=1e-13, rtol=0)


def test_a_quadrotor_without_drag_feels_thrust_along_its_own_axis_only():
    navdata = read(draw_sensors(PERFECT, rng()), flown(), 0)
    assert np.abs(navdata.acceleration[:, :2]).max() < 0.02  # half a tick of rotation
    assert navdata.acceleration[:, 2].max() > 9.8


def test_a_resting_drone_feels_gravity_alone():
    navdata = read(draw_sensors(PERFECT, rng()), resting([0.0, 0.0, 0.3], 21), 0)
    assert np.array_equal(navdata.acceleration, np.tile([0.0, 0.0, 9.8], (4, 1)))


def test_the_gyro_of_tum_gazebo_is_clean_and_its_attitude_is_not():
    navdata = read(draw_sensors(TUM_GAZEBO.sensor_noise, rng()), flown(), 0)
    assert np.array_equal(navdata.body_rates, flown().body_rates[5::5])
    assert np.degrees(navdata.attitude[:, :2] - clean_attitude()[:, :2]).std() == pytest.approx(
        2.05,
        rel=4 / np.sqrt(2 * 200),  # 4 sigma
    )


def clean_attitude():
    return read(draw_sensors(PERFECT, rng()), flown(), 0).attitude


@pytest.mark.parametrize("cuts", [[], [33, 66, 100], [4, 5, 6, 7, 12, 500], [0, 33, 33, 67]])
def test_the_portions_in_which_a_path_is_read_do_not_matter(cuts):
    track, sensors = flown(), draw_sensors(NOISY, rng(3))
    whole = read(sensors, track, 0, departure=True)
    edges = [0, *cuts, 1000]
    parts = [
        read(sensors, cut(track, a, b), a, departure=i == 0)
        for i, (a, b) in enumerate(pairwise(edges))
    ]
    for f in fields(whole):
        assert np.array_equal(joined(parts, f.name), getattr(whole, f.name))


def test_errors_have_the_size_that_the_record_says():
    n = 20_000
    track = resting([3.0, 0.0, 0.3], 5 * n + 1)
    sensors = draw_sensors(NOISY, rng(5))
    navdata = read(sensors, track, 0)
    four_sigma = 4 / np.sqrt(2 * n)
    for values, size in (
        (navdata.body_rates, 0.01),
        (navdata.acceleration, 0.3),
        (navdata.velocity, 0.1),
        (navdata.attitude[:, 2], 0.04),
        (navdata.height, 0.02),
    ):
        assert values.std(axis=0) == pytest.approx(size, rel=four_sigma)
    assert navdata.attitude[:, :2].std(axis=0) == pytest.approx(0.03, rel=four_sigma * 2**0.5)
    for values, bias, white in (
        (navdata.body_rates, sensors.gyro_bias, 0.01),
        (navdata.velocity, sensors.velocity_bias, 0.1),
    ):
        assert values.mean(axis=0) == pytest.approx(bias, abs=4 * white / np.sqrt(n))


def test_biases_differ_between_serves_with_the_size_that_the_record_says():
    drawn = [draw_sensors(NOISY, rng(seed)) for seed in range(500)]
    within = 4 / np.sqrt(2 * 1000)  # 4 sigma of the least numerous
    for name, size in (("gyro_bias", 0.02), ("attitude_bias", 0.005), ("velocity_bias", 0.03)):
        assert np.std([getattr(s, name) for s in drawn]) == pytest.approx(size, rel=within)


def test_attitude_errors_stay_for_the_two_samples_of_one_message():
    navdata = read(draw_sensors(NOISY, rng()), resting([0.0, 0.0, 0.3], 1000), 0, departure=True)
    roll = navdata.attitude[:, 0]
    assert np.array_equal(roll[0::2], roll[1::2])
    assert np.all(roll[1:-1:2] != roll[2::2])


@pytest.mark.parametrize(
    ("position", "height"),
    [
        ([-1.36, 0.76, 0.3], 0.3),
        ([-1.38, 0.0, 0.3], 1.06),
        ([0.0, -0.77, 0.3], 1.06),
        ([0.0, 0.0, -0.3], 0.46),
    ],
)
def test_the_sonar_sees_the_table_top_only_from_above_it(position, height):
    navdata = read(draw_sensors(PERFECT, rng()), resting(position, 6), 0)
    assert navdata.height == pytest.approx(height)


def test_the_battery_lasts_twenty_minutes():
    sensors = draw_sensors(PERFECT, rng())
    halfway = read(sensors, resting([0.0, 0.0, 0.3], 6), 600_000 - 5)
    late = read(sensors, resting([0.0, 0.0, 0.3], 6), 2_000_000)
    assert halfway.battery == pytest.approx(0.5)
    assert late.battery[-1] == 0.0


REAL = replace(PERFECT, attitude_slow=0.02, gyro_bias_limit=0.03, attitude_bias_limit=0.005)


def test_attitude_wanders_slowly_about_a_constant():
    track = resting([0.0, 0.0, 0.3], 3001)
    errors = np.array([
        read(draw_sensors(replace(REAL, attitude_bias_limit=0.0), rng(seed)), track, 0).attitude
        for seed in range(300)
    ])  # fmt: skip
    assert not errors[:, :, 2].any()
    roll_pitch = errors[:, :, :2]
    assert roll_pitch.std(axis=(0, 2)) == pytest.approx(0.02, rel=4 / np.sqrt(2 * 600) + 0.01)
    steps = np.diff(roll_pitch, axis=1)
    assert np.abs(steps).max() < 0.1 * 0.02  # nothing jumps within 5 ms
    after = (roll_pitch[:, 0] * roll_pitch[:, -1]).mean() / 0.02**2
    assert after == pytest.approx(np.exp(-3 / 5), abs=4 / np.sqrt(600))  # 4 sigma


def test_bounded_biases_are_uniform_and_keep_to_their_bounds():
    drawn = [draw_sensors(REAL, rng(seed)) for seed in range(500)]
    for name, bound in (("gyro_bias", 0.03), ("attitude_bias", 0.005)):
        values = np.array([getattr(s, name) for s in drawn]).ravel() / bound
        assert stats.kstest(values, "uniform", (-1, 2)).pvalue > 1e-3
        assert np.abs(values).max() <= 1.0


def test_kinds_of_bias_take_as_much_from_their_generator():
    generators = [rng(4), rng(4)]
    for noise, generator in zip((NOISY, REAL), generators, strict=True):
        draw_sensors(noise, generator)
    assert generators[0].random() == generators[1].random()


def test_a_late_optical_flow_shows_the_velocity_that_was():
    drone = replace(ARDRONE2, noise=replace(PERFECT, gravity=9.81))
    order = np.array([3.0, 1.0, 1.0, 0.0])
    start = drone.start(np.zeros(3), rng())
    _, track = drone.advance(start, order, ticks=800, new_command=True)
    navdata = read(draw_sensors(drone.sensor_noise, rng()), track, 0, departure=True)
    assert navdata.velocity[8:] == pytest.approx(track.velocity[:-40:5], abs=1e-12)
    turn = Rotation.from_quat(track.quaternion[::5], scalar_first=True)
    assert navdata.attitude == pytest.approx(turn.as_euler("ZYX")[:, ::-1], abs=1e-12)
    assert np.abs(navdata.velocity[8:] - track.velocity[40::5]).max() > 0.1


@pytest.mark.parametrize("cuts", [[33, 66, 100], [4, 5, 6, 7, 12, 500], [0, 33, 33, 67]])
def test_what_wanders_and_what_is_late_do_not_depend_on_portions(cuts):
    sensors, orders = draw_sensors(ARDRONE2.sensor_noise, rng(3)), rng(1).uniform(-2, 2, 4)
    state = ARDRONE2.start(np.zeros(3), rng(2))
    _, track = ARDRONE2.advance(state, orders, ticks=1000, new_command=True)
    whole = read(sensors, track, 0, departure=True)
    parts = []
    for i, (a, b) in enumerate(pairwise([0, *cuts, 1000])):
        state, leg = ARDRONE2.advance(state, orders, ticks=b - a, new_command=i == 0)
        parts.append(read(sensors, leg, a, departure=i == 0))
    for f in fields(whole):
        assert np.array_equal(joined(parts, f.name), getattr(whole, f.name))


def test_the_battery_is_that_of_the_profile():
    flat = replace(ARDRONE2, constants=ARDRONE2.constants._replace(battery_charge=0.4))
    sensors = draw_sensors(flat.sensor_noise, rng())
    later = read(sensors, resting([0.0, 0.0, 0.3], 6), 66_000 - 5)
    assert later.battery == pytest.approx(0.4 - 66.0 / 660.0)


def test_the_same_seed_gives_the_same_navdata_and_another_does_not():
    first, again, other = (read(draw_sensors(NOISY, rng(s)), flown(50), 0) for s in (1, 1, 2))
    assert np.array_equal(first.velocity, again.velocity)
    assert not np.any(first.velocity == other.velocity)


def test_a_path_between_two_samples_gives_none():
    navdata = read(draw_sensors(NOISY, rng()), resting([0.0, 0.0, 0.3], 4), 5)
    assert [len(getattr(navdata, f.name)) for f in fields(navdata)] == [0] * 7


@pytest.mark.parametrize(
    "change",
    [
        {"gyro_white": -1.0},
        {"height_white": np.nan},
        {"attitude_rate": 0.0},
        {"attitude_rate": 2e3},
        {"attitude_slow_time": 0.0},
        {"battery_life": 0.0},
        {"battery_charge": 1.5},
        {"gyro_bias_limit": -0.1},
    ],
)
def test_impossible_noise_is_refused(change):
    with pytest.raises(InputError, match="expected"):
        draw_sensors(replace(NOISY, **change), rng())
