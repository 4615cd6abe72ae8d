"""The odometer against motions whose integrals are known in closed form."""

from itertools import pairwise

import numpy as np
import pytest

from rotorpong.drone import Navdata
from rotorpong.play.odometer import SMOOTHING, Odometer

TIMES = np.arange(0.0, 1.0001, 0.005)


def navdata(times, velocity, yaw=0.0):
    """What a drone reports that flies at `velocity` (forward, left, up) and looks to `yaw`."""
    n = len(times)
    attitude = np.zeros((n, 3))
    attitude[:, 2] = yaw
    nothing = np.zeros((n, 3))
    velocity = np.broadcast_to(velocity, (n, 3)).astype(float)
    return Navdata(times, nothing, nothing, attitude, velocity, np.ones(n), np.ones(n))


def odometer(*parts):
    filled = Odometer()
    for part in parts:
        filled.add(part)
    return filled


def assert_same_path(one, two):
    np.testing.assert_array_equal(one.times, two.times)
    np.testing.assert_array_equal(one.positions, two.positions)
    np.testing.assert_array_equal(one.velocities, two.velocities)


def test_a_constant_velocity_gives_a_straight_line():
    path = odometer(navdata(TIMES, [2.0, -1.0, 0.5])).path(0.1, 0.9)
    right_down_forward = np.array([1.0, -0.5, 2.0])
    since = (path.times - 0.1)[:, None]
    np.testing.assert_allclose(path.positions, since * right_down_forward, atol=1e-12)
    np.testing.assert_allclose(
        path.velocities, np.tile(right_down_forward, (len(path.times), 1)), atol=1e-10
    )


def test_a_constant_acceleration_gives_a_parabola():
    velocity = TIMES[:, None] * np.array([3.0, 0.0, -1.0])
    path = odometer(navdata(TIMES, velocity)).path(0.0, 0.7)
    fallen = 0.5 * path.times[:, None] ** 2 * np.array([0.0, 1.0, 3.0])
    np.testing.assert_allclose(path.positions, fallen, atol=1e-12)


def test_inside_the_path_the_velocity_of_an_acceleration_is_exact():
    velocity = TIMES[:, None] * np.array([3.0, 0.0, 0.0])
    path = odometer(navdata(TIMES, velocity)).path(0.0, 0.7)
    inside = (path.times > SMOOTHING) & (path.times < 0.7 - SMOOTHING)
    np.testing.assert_allclose(path.velocities[inside, 2], 3.0 * path.times[inside], atol=1e-10)


def test_a_turning_drone_flies_a_circle():
    speed, rate = 1.5, 2.0
    path = odometer(navdata(TIMES, [speed, 0.0, 0.0], yaw=rate * TIMES)).path(0.2, 0.9)
    angle = rate * (path.times - 0.2)
    radius = speed / rate
    expected = np.column_stack(
        [-radius * (1.0 - np.cos(angle)), 0.0 * angle, radius * np.sin(angle)]
    )
    np.testing.assert_allclose(path.positions, expected, atol=2e-5)  # trapezoids of 5 ms


@pytest.mark.parametrize("heading", [1.0, np.pi - 0.3, -2.5])
def test_a_path_does_not_depend_on_where_north_is(heading):
    velocity = np.random.default_rng(0).normal(size=(len(TIMES), 3))
    yaw = 1.2 * TIMES
    wrapped = (yaw + heading + np.pi) % (2 * np.pi) - np.pi
    one = odometer(navdata(TIMES, velocity, yaw)).path(0.1, 0.8)
    two = odometer(navdata(TIMES, velocity, wrapped)).path(0.1, 0.8)
    np.testing.assert_allclose(one.positions, two.positions, atol=1e-12)


def test_it_does_not_matter_in_what_portions_navdata_come():
    velocity = np.random.default_rng(1).normal(size=(len(TIMES), 3))
    whole = navdata(TIMES, velocity, yaw=TIMES)
    cuts = [0, 1, 1, 40, 41, 150, len(TIMES)]
    parts = [navdata(TIMES[a:b], velocity[a:b], yaw=TIMES[a:b]) for a, b in pairwise(cuts)]
    assert_same_path(odometer(*parts).path(0.1, 0.8), odometer(whole).path(0.1, 0.8))


def test_a_gap_is_bridged_by_a_straight_velocity():
    kept = (TIMES < 0.3) | (TIMES > 0.5)
    velocity = TIMES[:, None] * np.array([1.0, 2.0, 3.0])
    gapped = odometer(navdata(TIMES[kept], velocity[kept])).path(0.0, 0.8)
    whole = odometer(navdata(TIMES, velocity)).path(0.0, 0.8)
    np.testing.assert_allclose(gapped.positions[-1], whole.positions[-1], atol=1e-12)


def test_outside_the_navdata_the_velocity_is_held():
    path = odometer(navdata(TIMES, [1.0, 0.0, 0.0])).path(-0.5, 2.0)
    assert (path.times[0], path.times[-1]) == (-0.5, 2.0)
    np.testing.assert_allclose(path.positions[-1], [0.0, 0.0, 2.5], atol=1e-12)


def test_the_first_position_is_zero_and_the_ends_are_as_asked():
    path = odometer(navdata(TIMES, [1.0, 1.0, 1.0])).path(0.1234, 0.1236)
    np.testing.assert_array_equal(path.times, [0.1234, 0.1236])
    np.testing.assert_array_equal(path.positions[0], np.zeros(3))
    np.testing.assert_allclose(path.velocities, [[-1.0, -1.0, 1.0]] * 2, atol=1e-9)


@pytest.mark.parametrize("parts", [(), (navdata(np.empty(0), [0.0, 0.0, 0.0]),)])
def test_without_navdata_the_body_stands_still(parts):
    still = odometer(*parts)
    path = still.path(1.0, 2.0)
    np.testing.assert_array_equal(still.velocity(1.5), np.zeros(3))
    np.testing.assert_array_equal(path.times, [1.0, 2.0])
    np.testing.assert_array_equal(path.positions, np.zeros((2, 3)))
    np.testing.assert_array_equal(path.velocities, np.zeros((2, 3)))


def test_the_velocity_about_a_time_is_the_mean_of_what_was_measured_there():
    velocity = TIMES[:, None] * np.array([1.0, -2.0, 4.0])
    found = odometer(navdata(TIMES, velocity)).velocity(0.5025)
    np.testing.assert_allclose(found, 0.5025 * np.array([2.0, -4.0, 1.0]), atol=1e-12)


def test_the_velocity_far_from_all_navdata_is_not_known():
    np.testing.assert_array_equal(
        odometer(navdata(TIMES, [1.0, 1.0, 1.0])).velocity(1.0 + 2 * SMOOTHING), np.zeros(3)
    )
