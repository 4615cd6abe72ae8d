"""What holds for every vehicle, whatever its physics."""

from dataclasses import fields, replace

import numpy as np
import pytest
from vehicle_flights import FORWARD, HOME, command, flight, joined, rng

from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW
from rotorpong.physics.vehicle import TUM_GAZEBO, Track

DRONES = {
    "tum_gazebo": TUM_GAZEBO,
    "another tum_gazebo": TUM_GAZEBO.randomized(rng(9)),
    "ardrone2": ARDRONE2,
    "ardrone2_raw": ARDRONE2_RAW,
    "another ardrone2": ARDRONE2.randomized(rng(9)),
}
each_drone = pytest.mark.parametrize("drone", DRONES.values(), ids=DRONES)
STATE = ("motion", "memory", "counters")


def told(track):
    """Names of what a track of this vehicle tells."""
    return [f.name for f in fields(Track) if getattr(track, f.name) is not None]


@each_drone
def test_the_portions_of_a_flight_do_not_change_a_bit_of_it(drone):
    orders = rng(5).uniform(-1, 1, (12, 4))
    whole, path = flight(drone, drone.start(HOME, rng(4)), [[33]] * 12, orders)
    split, pieces = flight(drone, drone.start(HOME, rng(4)), [[10, 0, 1, 3, 19]] * 12, orders)
    for name in told(path[0]):
        assert np.array_equal(joined(path, name), joined(pieces, name))
    for name in STATE:
        assert np.array_equal(getattr(whole, name), getattr(split, name))


@each_drone
def test_a_batch_flies_as_its_vehicles_alone_bit_for_bit(drone):
    orders = rng(6).uniform(-2, 2, (9, 4, 4))
    together = drone.start(rng(2).normal(size=(4, 3)), rng(3))
    batch, paths = flight(drone, together, [[33]] * 9, orders)
    for i in range(4):
        own = {f.name: np.asarray(getattr(together, f.name)[i]) for f in fields(together)}
        single, path = flight(drone, replace(together, **own), [[33]] * 9, orders[:, i])
        for name in STATE:
            assert np.array_equal(getattr(batch, name)[i], getattr(single, name))
        for name in told(path[0]):
            assert np.array_equal(joined(paths, name)[:, i], joined(path, name))


@each_drone
def test_advance_leaves_its_state_as_it_was(drone):
    state = drone.start(HOME, rng())
    before = [getattr(state, name).copy() for name in STATE]
    drone.advance(state, command(FORWARD, 1.0), ticks=150, new_command=True)
    for was, name in zip(before, STATE, strict=True):
        assert np.array_equal(was, getattr(state, name))
