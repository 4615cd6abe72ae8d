from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rotorpong.conventions import InputError
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
    ],
)
def test_impossible_noise_is_refused(change):
    with pytest.raises(InputError, match="expected"):
        draw_sensors(replace(NOISY, **change), rng())
