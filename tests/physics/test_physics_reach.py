"""The outer bound of where a plate on a vehicle can be: nobody flies out of it."""

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.physics.reach import (
    DRIFT,
    MARGIN,
    Bound,
    corner_commands,
    fly_all,
    plate_bound,
    plate_crossings,
    repeated,
)
from rotorpong.physics.vehicle import NOISE_FREE_CASCADE, TUM_GAZEBO, Track, TumGazebo

HOME = np.array([-1.9, 0.0, 0.19])
PLATE = np.array([[0.23, y, z] for y in (-0.075, 0.075) for z in (0.0815, 0.2385)])
CALM = TumGazebo(constants=NOISE_FREE_CASCADE)
STILL = np.zeros(4)


def hovering(vehicle=TUM_GAZEBO, seed=0, messages=3):
    """A vehicle that was told to hover at each of some frames."""
    state = vehicle.start(HOME, np.random.default_rng(seed))
    for _ in range(messages):
        state, _ = vehicle.advance(state, STILL, ticks=33, new_command=True)
    return state


def flown(vehicle, state, commands, ticks_each):
    """Fly b sequences of commands; return the plate's points, (b, n, m, 3)."""
    batch, parts = repeated(state, commands.shape[1]), []
    for i, command in enumerate(commands):
        batch, track = vehicle.advance(batch, command, ticks=ticks_each, new_command=True)
        parts.append([part[:, min(i, 1) :] for part in (track.position, track.quaternion)])
    position, quaternion = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
    turned = np.einsum("bnij,mj->bnmi", rotation_from_quaternion(quaternion), PLATE)
    return position[:, :, None] + turned


@pytest.mark.parametrize("seed", range(3))
def test_no_sequence_of_commands_leaves_the_bound(seed):
    rng = np.random.default_rng(seed)
    state = hovering(seed=seed)
    signs = rng.choice([-1.0, 0.0, 1.0], size=(18, 40, 4))
    held = np.repeat(signs[::3], 3, axis=0)  # half of them change only at each third frame
    signs[:, :20] = held[:, :20]
    points = flown(TUM_GAZEBO, state, signs * TUM_GAZEBO.limits, 33)
    bound = plate_bound(TUM_GAZEBO, state, 18 * 33, PLATE)
    assert np.all(points >= bound.low[None, :, None])
    assert np.all(points <= bound.high[None, :, None])


def test_a_drone_that_was_told_nothing_so_far_stays_within_the_bound_of_one_told_to_hover():
    told = hovering(messages=4)
    silent = TUM_GAZEBO.start(HOME, np.random.default_rng(0))
    silent, _ = TUM_GAZEBO.advance(silent, STILL, ticks=4 * 33, new_command=True)
    corners = corner_commands(TUM_GAZEBO)[None]
    points = flown(TUM_GAZEBO, silent, corners, 600)
    bound = plate_bound(TUM_GAZEBO, told, 600, PLATE)
    assert np.all((points >= bound.low[:, None]) & (points <= bound.high[:, None]))


def test_at_the_decision_the_bound_is_the_plate_where_it_is_and_the_margin():
    state = CALM.start(HOME, np.random.default_rng(0))
    bound = plate_bound(CALM, state, 100, PLATE)
    assert np.all(bound.low[0] <= HOME + PLATE.min(axis=0) - MARGIN)
    assert np.all(bound.high[0] >= HOME + PLATE.max(axis=0) + MARGIN)


def test_sideways_it_reaches_what_the_step_response_says_and_no_faster_than_the_limit():
    """Half a second at the limit of 2 m/s moves the simulator's drone by 0.329 m."""
    state = CALM.start(HOME, np.random.default_rng(0))
    bound = plate_bound(CALM, state, 500, PLATE)
    margin, edge = MARGIN + 0.5 * DRIFT, 0.075
    assert bound.high[500, 1] > 0.329 + margin + edge - 0.01
    diagonal = 2.0 * np.sqrt(2.0) * 0.5
    assert bound.high[500, 1] < diagonal + 0.23 + 0.16 + margin + edge
    assert bound.high[500, 2] < HOME[2] + 0.2385 + 0.5 * 0.5 + 0.23 + margin


def test_the_bound_is_the_same_mirrored_for_a_drone_without_noise():
    state = CALM.start(HOME, np.random.default_rng(0))
    bound = plate_bound(CALM, state, 400, PLATE)
    np.testing.assert_allclose(bound.low[:, 1], -bound.high[:, 1], atol=1e-9)


def test_looking_further_ahead_changes_nothing_before():
    state = hovering()
    short, long = (plate_bound(TUM_GAZEBO, state, ticks, PLATE) for ticks in (199, 399))
    np.testing.assert_array_equal(short.low, long.low[:200])
    np.testing.assert_array_equal(short.high, long.high[:200])


def test_a_batch_flies_as_each_vehicle_would_alone():
    state, commands = hovering(), corner_commands(TUM_GAZEBO)[::9]
    _, together = fly_all(TUM_GAZEBO, state, commands, 50)
    for row, command in enumerate(commands):
        _, alone = TUM_GAZEBO.advance(state, command, ticks=50, new_command=True)
        np.testing.assert_array_equal(together.position[row], alone.position)
        np.testing.assert_array_equal(together.quaternion[row], alone.quaternion)


def test_a_ball_touches_a_box_up_to_its_radius_away():
    bound = Bound(np.zeros((3, 3)), np.ones((3, 3)))
    ball = np.array([[1.019, 0.5, 0.5], [1.021, 0.5, 0.5], [0.5, -0.019, 1.019]])
    assert bound.touched_by(ball).tolist() == [True, False, True]


def still_track(n, angles=(1.0, 0.0, 0.0, 0.0)):
    """Two drones that stand still at the origin, one of them moved left by 0.1 m."""
    position = np.zeros((2, n, 3))
    position[1, :, 1] = 0.1
    quaternion = np.broadcast_to(np.array(angles), (2, n, 4)).copy()
    return Track(position, position, quaternion, position, position)


def test_a_straight_ball_crosses_a_level_plate_where_geometry_says():
    ticks = np.arange(400)
    ball = np.column_stack([1.0 - 0.004 * ticks, 0.05 + 0.0 * ticks, 0.3 - 0.0005 * ticks])
    found = plate_crossings(ball, still_track(400), (0.23, 0.0, 0.16), (0.26, 0.05))
    when = (1.0 - 0.23 - 0.02) / 0.004
    np.testing.assert_allclose(found.tick, when)
    np.testing.assert_allclose(found.left, [0.05, -0.05])
    np.testing.assert_allclose(found.up, 0.3 - 0.0005 * when - 0.16)


def test_a_plate_that_is_turned_left_is_crossed_in_its_own_axes():
    half = np.pi / 6
    turned = still_track(400, (np.cos(half / 2), 0.0, 0.0, np.sin(half / 2)))
    ticks = np.arange(400)
    ball = np.column_stack([1.0 - 0.004 * ticks, 0.2 + 0.0 * ticks, 0.16 + 0.0 * ticks])
    found = plate_crossings(ball, turned, (0.23, 0.0, 0.16), (0.26, 0.05))
    x = (0.25 - 0.2 * np.sin(half)) / np.cos(half)
    np.testing.assert_allclose(found.tick[0], (1.0 - x) / 0.004)
    np.testing.assert_allclose(found.left[0], 0.2 * np.cos(half) - x * np.sin(half))


def test_a_ball_that_turns_back_never_crosses():
    ball = np.column_stack([np.full(50, 0.9), np.zeros(50), np.zeros(50)])
    found = plate_crossings(ball, still_track(50), (0.23, 0.0, 0.16), (0.26, 0.05))
    assert np.isnan(found.tick).all()
    assert np.isnan(found.left).all()


def test_the_gap_to_the_hull_is_the_least_before_the_crossing():
    ticks = np.arange(400)
    ball = np.column_stack([1.0 - 0.004 * ticks, 0.0 * ticks, 0.1 + 0.0 * ticks])
    found = plate_crossings(ball, still_track(400), (0.23, 0.0, 0.16), (0.26, 0.05))
    np.testing.assert_allclose(found.hull_gap[0], 0.1 - 0.05 - 0.02, atol=1e-9)


@pytest.mark.parametrize(("ticks", "plate"), [(0, PLATE), (-5, PLATE), (10, np.empty((0, 3)))])
def test_nothing_to_look_at_is_bad_input(ticks, plate):
    with pytest.raises(InputError, match="expected at least one"):
        plate_bound(TUM_GAZEBO, hovering(), ticks, plate)
