"""Verdicts against slow and obvious ways to the same answers."""

import itertools

import numpy as np
import pytest

from rotorpong.geometry import quaternion_from_euler
from rotorpong.physics.camera import GAZEBO
from rotorpong.physics.vehicle import TICK, TUM_GAZEBO
from rotorpong.world import _contact_kernels as contacts
from rotorpong.world import _judging_kernels as rules
from rotorpong.world._judging_kernels import hull_in_court
from rotorpong.world._nearness_kernels import box_of
from rotorpong.world.contact import drone_touches_court, miss_distances, time_error
from rotorpong.world.judging import judge
from rotorpong.world.racket import HOME_BLADE, HOME_BODY, HULL, Racket
from rotorpong.world.serves import HUMAN, draw
from rotorpong.world.simulated_drone import Setting, SimulatedDrone
from rotorpong.world.solids import SOLIDS

SETTING = Setting(TUM_GAZEBO, GAZEBO)
RACKET = Racket()


def passing(seed):
    """A ball straight past a drone that moves, turns and tilts at random."""
    generator = np.random.default_rng(seed)
    n = 400
    times = 0.001 * np.arange(n)[:, None]
    target = np.array(HOME_BLADE) + generator.uniform(-0.4, 0.4, 3)
    velocity = generator.uniform([-8, -1, -3], [-5, 1, 1])
    balls = np.zeros((n, 9))
    balls[:, :3] = target + velocity * (times - generator.uniform(0.1, 0.3))
    balls[:, 3:6] = velocity
    where = np.array(HOME_BODY) + generator.uniform([-0.5, -2, -0.5], [0.5, 2, 0.5]) * (times - 0.2)
    angles = generator.uniform(-1.0, 1.0, 3) * times + generator.uniform(-0.3, 0.3, 3)
    return balls, np.concatenate([where, quaternion_from_euler(angles)], axis=1)


def test_nearness_is_that_of_looking_at_every_instant_and_every_lag():
    lates = set()
    for seed in range(150):
        balls, track = passing(seed)
        verdict, miss, late = judge("miss", None, balls, track, RACKET)
        assert miss == max(miss_distances(balls[:, :3], track, RACKET).min(), 0.0)
        assert late == time_error(balls[:, :3], track, RACKET)
        near = miss < 0.05 or (late is not None and abs(late) <= 0.1)
        assert verdict.outcome == ("near_hit" if near else "miss")
        lates.add(None if late is None else int(np.sign(late)))
    assert lates == {None, -1, 0, 1}


def test_who_touched_hull_or_court_never_nearly_hit():
    balls, track = passing(3)
    for outcome in ("hull", "fault"):
        assert judge(outcome, None, balls, track, RACKET)[0].outcome == outcome


def test_the_gap_of_a_ball_before_the_blades_middle_is_its_distance_less_the_radius():
    level = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (3, 1))
    balls = np.zeros((3, 9))
    balls[:, :3] = [[0.9, 0.0, 0.16], [0.73, 0.0, 0.16], [0.8, 0.0, 0.16]]
    _, miss, late = judge("miss", None, balls, level, RACKET)
    assert miss == pytest.approx(0.5 - 0.02)
    assert late is None


def test_a_hull_is_in_the_court_where_the_whole_path_says_so():
    generator = np.random.default_rng(0)
    places = generator.uniform([-2, -1.5, -0.8], [2, 1.5, 0.4], size=(3000, 3))
    touched = 0
    for place in places:
        track = np.concatenate([place, [1.0, 0.0, 0.0, 0.0]])[None]
        assert hull_in_court(*place, (HULL.radius, HULL.half_height)) == drone_touches_court(
            track, HULL
        )
        touched += drone_touches_court(track, HULL)
    assert 300 < touched < 2700


def touch(solid, tick, facing=1.0):
    row = np.zeros(contacts.CONTACT_COLUMNS)
    row[contacts.TIME], row[contacts.SOLID], row[contacts.FACING] = tick * TICK, solid, facing
    return row


def ending_in_legs(touches, track, cuts):
    """Return how a serve ends that is judged leg by leg."""
    edges = [0, *cuts, len(track) - 1]
    for low, high in itertools.pairwise(edges):
        within = [t for t in touches if low * TICK < t[contacts.TIME] <= high * TICK]
        rows = np.array(within).reshape(-1, contacts.CONTACT_COLUMNS)
        leg = track[low : high + 1]
        hull = HULL.radius, HULL.half_height
        has_passed = False
        code, _ = rules.ending(rows, has_passed, leg, box_of(leg), high, TICK, hull)
        if code != rules.PLAYING:
            return code
    return rules.PLAYING


@pytest.mark.parametrize("cuts", [[], [10, 20, 30, 40], [24], [25], [26], [5, 33]])
def test_what_came_first_decides_wherever_the_leg_is_cut(cuts):
    """The drone is in the table from tick 25.5 on; ball and blade meet before or after."""
    track = np.tile([0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (50, 1))
    track[:, 2] = HULL.half_height + 0.001 * (25.5 - np.arange(50))
    blade, hull, floor = (SOLIDS.index(name) for name in ("blade", "hull", "floor"))
    for touches, wanted in (
        ([touch(blade, 24.2)], rules.HIT),
        ([touch(blade, 27.2)], rules.FAULT),
        ([touch(hull, 12.1), touch(blade, 13.0)], rules.HULL_TOUCHED),
        ([touch(floor, 12.1), touch(blade, 13.0)], rules.MISSED),
        ([touch(blade, 12.0, facing=0.2), touch(blade, 13.0)], rules.HIT),
        ([touch(floor, 30.0)], rules.FAULT),
        ([], rules.FAULT),
    ):
        assert ending_in_legs(touches, track, cuts) == wanted


def test_verdicts_of_whole_serves_agree_with_their_paths():
    for seed in range(12):
        generators = {
            "vehicle_rng": np.random.default_rng(seed),
            "sensor_rng": np.random.default_rng(seed + 99),
        }
        serve = draw(HUMAN, np.random.default_rng(seed))
        truth = SimulatedDrone(serve, SETTING, **generators).truth()
        if truth.verdict.outcome == "hit":
            assert truth.miss_distance == truth.time_error == 0.0
            continue
        gaps = np.linalg.norm(truth.ball_path - truth.blade_path, axis=1)
        assert gaps.min() - 0.02 - 0.0785 - 1e-9 <= truth.miss_distance <= gaps.min()
