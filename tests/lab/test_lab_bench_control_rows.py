"""Rows of `bench control`: Table II."""

import numpy as np
import pytest

from rotorpong.control import Departure
from rotorpong.lab.bench.control_rows import table_rows
from rotorpong.lab.bench.suites import SUITES, Order
from rotorpong.lab.free_flight import GOAL, SPEED, Task, fly
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.physics.vehicle import TUM_GAZEBO
from rotorpong.primitives import Dmp, State

PLAIN = Dmp(np.zeros((20, 3)))
TASK = Task(PLAIN, State(GOAL, SPEED), 0.8)


@pytest.mark.parametrize("vehicle", [TUM_GAZEBO, ARDRONE2])
def test_knowing_the_drone_is_worth_most_of_the_error(vehicle):
    rows = {row.name: row.value for row in table_rows(vehicle, PLAIN, runs=4)}
    assert len(rows) == 9
    opened = rows[f"Table II, {vehicle.name}, open, Z"]
    for control in ("feed forward", "closed loop"):
        assert rows[f"Table II, {vehicle.name}, {control}, Z"] < 0.35 * opened


def test_an_error_is_measured_from_where_the_motion_began_and_the_same_twice():
    one, other = (fly(TUM_GAZEBO, "closed_loop", TASK, seed=3).position for _ in range(2))
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(one[0], np.zeros(3))
    assert one.shape == (801, 3)
    assert not np.array_equal(one, fly(TUM_GAZEBO, "closed_loop", TASK, seed=4).position)


def test_a_drone_that_stands_still_is_off_by_the_whole_way():
    still = Task(PLAIN, State(np.zeros(3), np.zeros(3)), 0.8)
    drift = fly(TUM_GAZEBO, "open", still, seed=0).position
    assert 0.0 < np.abs(drift).max() < 0.06
    course = TASK.course(Departure.of_hover(1.0), smooth=True)
    np.testing.assert_allclose(course.at(np.array([1.8]))[0, 0], GOAL, atol=1e-9)


def test_the_suite_has_its_own_name_and_takes_nothing_of_others():
    assert [section.title for section in SUITES["control"]] == ["control"]
    assert Order("control", quick=True).check().suite == "control"
