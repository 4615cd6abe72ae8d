"""What a controller knows of drones is what their equations do."""

from dataclasses import replace

import numpy as np
import pytest
from lagging_drone import rates_of
from scipy.signal import cont2discrete

from rotorpong.control.identification import step_answer
from rotorpong.control.plant import UNKNOWN_LAG, Axis, plant_of
from rotorpong.conventions import InputError
from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW
from rotorpong.physics.vehicle import NOISE_FREE_CASCADE, TUM_GAZEBO

AXES = (Axis(0.4), Axis(0.43, 0.056), Axis(1.86, 0.24, 3.6), Axis(0.4, 0.04))
QUIET_ARDRONE2, QUIET_RAW = (
    replace(drone, noise=replace(drone.noise, velocity_white=0.0, velocity_bias=0.0))
    for drone in (ARDRONE2, ARDRONE2_RAW)
)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("elapsed", [0.001, 0.033, 0.5])
def test_held_commands_carry_the_state_on_as_scipy_says(axis, elapsed):
    rates, push = rates_of(axis)
    n = axis.order
    phi, gamma, *_ = cont2discrete((rates, push, np.eye(n), np.zeros((n, 1))), elapsed)
    ours = axis.transition(elapsed)
    np.testing.assert_allclose(ours[0], phi, atol=1e-10)
    np.testing.assert_allclose(ours[1], gamma[:, 0], atol=1e-10)


@pytest.mark.parametrize("axis", AXES)
def test_two_stretches_are_one_of_their_length(axis):
    (p1, g1), (p2, g2), (p3, g3) = (axis.transition(t) for t in (0.01, 0.023, 0.033))
    np.testing.assert_allclose(p2 @ p1, p3, atol=1e-12)
    np.testing.assert_allclose(p2 @ g1 + g2, g3, atol=1e-12)


@pytest.mark.parametrize(
    ("vehicle", "axis", "size", "share"),
    [
        (replace(TUM_GAZEBO, constants=NOISE_FREE_CASCADE), 2, 0.3, 0.035),
        (replace(TUM_GAZEBO, constants=NOISE_FREE_CASCADE), 1, 0.4, 0.22),  # see `plant`
        (QUIET_ARDRONE2, 2, 0.5, 0.03),
        (QUIET_ARDRONE2, 1, 0.5, 0.03),
        (QUIET_RAW, 2, 0.5, 0.03),
        (QUIET_RAW, 1, 0.5, 0.03),
    ],
)
def test_a_step_is_answered_by_the_vehicle_as_by_its_plant(vehicle, axis, size, share):
    column, sign = {2: (0, 1.0), 1: (2, -1.0)}[axis]
    state = vehicle.start(np.zeros(3), np.random.default_rng(0))
    order = np.eye(4)[column] * size * sign
    _, track = vehicle.advance(state, order, ticks=1200, new_command=True)
    known = plant_of(vehicle).axes[axis]
    since = np.maximum(np.arange(1201) * 1e-3 - known.dead_time, 0.0)
    answer = known.gain * step_answer(known.answer_at(known.lag), since[:, None])[0][:, 0]
    flown = sign * track.velocity[:, column] / size
    assert np.abs(flown - answer).max() < share * known.gain


def test_the_lag_is_what_a_ramp_is_late():
    for axis in (plant_of(vehicle).axes[2] for vehicle in (TUM_GAZEBO, ARDRONE2, ARDRONE2_RAW)):
        t = np.linspace(0.0, 40.0, 400_001)
        answer, _ = step_answer(axis.answer_at(axis.lag), t[:, None])
        late = np.sum(1.0 - answer[:, 0]) * 1e-4
        assert late == pytest.approx(axis.lag, abs=1e-3)


def test_an_unknown_vehicle_is_taken_for_a_plain_lag_within_its_own_limits():
    class Own:
        name = "own"
        limits = np.array([3.0, 2.0, 1.0, 0.5])
        sensor_noise = TUM_GAZEBO.sensor_noise
        start, advance = TUM_GAZEBO.start, TUM_GAZEBO.advance

    plant = plant_of(Own())
    assert [axis.lag for axis in plant.axes] == [UNKNOWN_LAG] * 3
    np.testing.assert_array_equal(plant.limits, [2.0, 1.0, 3.0])


@pytest.mark.parametrize(
    "numbers", [(0.0,), (-0.4,), (np.nan,), (0.4, -1.0), (0.4, 0.0, 0.0), (0.4, 0.0, 1.0, np.inf)]
)
def test_axes_that_cannot_be_flown_are_refused(numbers):
    with pytest.raises(InputError, match="of an axis: expected a"):
        Axis(*numbers)
