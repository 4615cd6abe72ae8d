"""What can be reached: sound against players that try, and tight for the oracle."""

from dataclasses import replace

import numpy as np
import pytest

from rotorpong.drone import HOVER
from rotorpong.lab.bench.reach_rows import WIDE, Count, count_serves, stage_of
from rotorpong.lab.evaluate import evaluate, summary
from rotorpong.lab.reachable import (
    FRAMES_TO_DECIDE,
    blade_corners,
    decide,
    free_path,
    hovering_bound,
    is_reachable,
    shows_ball,
)
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone
from rotorpong.physics.ball import Ball, fly
from rotorpong.world.contact import TICK
from rotorpong.world.racket import HOME_BLADE, Racket
from rotorpong.world.serves import Serve
from rotorpong.world.simulated_drone import SimulatedDrone

BESIDE = np.array([0.0, 0.6, 0.0])
STAGE = stage_of("tum_gazebo", "human", 0)


def drone_for(serve):
    rngs = (np.random.default_rng(k) for k in (1, 2))
    vehicle_rng, sensor_rng = rngs
    return SimulatedDrone(serve, STAGE.setting, vehicle_rng=vehicle_rng, sensor_rng=sensor_rng)


def straight(left, up, flat=8.0):
    """A serve through the air that passes home's blade plane so far left and up of its centre."""
    release = np.array(HOME_BLADE) + np.array([4.0, 0.0, 0.0])
    duration = 4.0 / flat
    velocity = np.array([-flat, left / duration, up / duration + 0.5 * 9.81 * duration])
    return Serve(Ball(release, velocity, np.zeros(3)))


def test_the_decision_is_the_arrival_of_the_third_frame_that_shows_the_ball():
    decision = decide(new_drone(STAGE, 0))
    drone, seen = new_drone(STAGE, 0), 0
    while seen < FRAMES_TO_DECIDE:
        observation = drone.observe()
        seen += shows_ball(drone, observation)
        if seen < FRAMES_TO_DECIDE:
            drone.command(HOVER)
    assert decision.instant.tick == round(observation.arrival_time / TICK)
    np.testing.assert_array_equal(decision.instant.vehicle.motion, drone.now.vehicle.motion)
    np.testing.assert_array_equal(decision.path[decision.instant.tick], drone.now.ball[:3])


def test_the_free_path_of_a_ball_in_the_air_is_that_of_physics():
    serve = straight(0.0, 0.3)
    path = free_path(drone_for(serve).now)
    np.testing.assert_allclose(path[300], fly(serve.ball, serve.air, 0.3).position, atol=1e-9)


def test_the_free_path_goes_on_to_the_floor():
    assert free_path(drone_for(straight(0.0, 0.0)).now)[:, 2].min() < -0.7


def test_a_ball_at_the_blade_is_reachable_and_one_two_metres_aside_is_not():
    assert is_reachable(drone_for(straight(0.0, 0.1)))
    assert not is_reachable(drone_for(straight(2.0, 0.1)))
    assert not is_reachable(drone_for(straight(0.0, 2.0, flat=14.0)))


def test_a_ball_that_is_never_seen_can_only_be_met_by_hovering():
    """From behind a wall of nothing: a ball that drops from above is in no picture."""
    above = np.array(HOME_BLADE) + np.array([0.04, 0.0, 1.5])
    falling = Serve(Ball(above, np.array([-0.001, 0.0, 0.0]), np.zeros(3)))
    drone = drone_for(falling)
    assert decide(drone).instant is None
    assert is_reachable(drone_for(falling))
    aside = replace(falling, ball=replace(falling.ball, position=above + BESIDE))
    assert not is_reachable(drone_for(aside))


def test_the_blade_lies_within_its_corners():
    racket, corners = Racket(), blade_corners(Racket())
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    rim_y, rim_z = racket.half_width * np.cos(angle), racket.half_height * np.sin(angle)
    assert np.all(corners[:, 0] == racket.x)
    assert corners[:, 1].max() >= racket.y + rim_y.max()
    assert corners[:, 2].min() <= racket.z + rim_z.min()


def test_a_hovering_blade_stays_within_the_bound_of_hovering():
    for index in range(3):
        truth = new_drone(STAGE, index).truth()
        bound = hovering_bound(Racket(), len(truth.blade_path))
        reach = np.array([0.0, Racket().half_width, Racket().half_height])
        assert np.all(truth.blade_path + reach <= bound.high)
        assert np.all(truth.blade_path - reach >= bound.low)


def test_nobody_hits_what_is_called_unreachable():
    count = count_serves(stage_of("tum_gazebo", WIDE, 3), 60, with_oracle=False)
    assert count.balls - count.reachable >= 3
    assert count.false_alarms == 0


def test_the_oracle_hits_what_is_called_reachable():
    count = count_serves(STAGE, 10)
    assert count == Count(balls=10, reachable=10, oracle_hits=10, false_alarms=0)


@pytest.mark.parametrize("player", ["hover", "oracle"])
def test_evaluate_says_what_was_reachable_whoever_plays(player):
    spec = Spec(player, "truth", seed=5)
    results = evaluate(spec, 3)
    found = summary(spec, results)
    assert found["reachable"] == sum(r.reachable for r in results) == 3
    assert found["hits_of_reachable"] == sum(r.outcome == "hit" for r in results)
    assert found["hit_rate_of_reachable"] == found["hits_of_reachable"] / 3
    assert [trial["reachable"] for trial in found["trials"]] == [True] * 3
