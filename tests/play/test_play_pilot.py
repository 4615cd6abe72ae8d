"""The scripted pilot is as slow and as clumsy as it says it is."""

from itertools import pairwise

import numpy as np
import pytest
from play_bench import BallEyes, BenchDrone, mirrored, play, straight

from rotorpong.drone import HOVER, Player, Verdict
from rotorpong.play.pilot import FASTEST, REACTION, STICK_PERIOD, STICK_STEP, ScriptedPilot

SIDE = straight(right=1.0, depth=6.0, speed=4.0)


def first_move(drone):
    return next((time for time, command in drone.commands if command != HOVER), None)


def test_it_is_a_player_that_never_learns():
    pilot = ScriptedPilot()
    assert isinstance(pilot, Player)
    pilot.learn(Verdict("hit", 0.0, 1.0))


def test_a_pilot_who_sees_nothing_hovers():
    drone = BenchDrone()
    assert play(ScriptedPilot(), drone, BallEyes(SIDE, first=99.0)) == [HOVER] * 60


def test_three_sights_are_not_enough_to_judge_by():
    drone = BenchDrone()
    play(ScriptedPilot(), drone, BallEyes(SIDE, first=0.1 - 1e-9, last=0.1 + 2.5 / 30))
    assert first_move(drone) is None


@pytest.mark.parametrize("first", [0.0, 0.1, 0.31])
def test_it_does_not_move_before_its_reaction_time_after_the_first_sight(first):
    drone = BenchDrone()
    play(ScriptedPilot(), drone, BallEyes(SIDE, first=first))
    assert first_move(drone) is not None
    assert first_move(drone) >= first + REACTION


def test_what_happens_now_changes_nothing_before_the_reaction_time_is_over():
    def turning(time):
        return SIDE(time) - (np.array([3.0, 0.0, 0.0]) * (time - 0.5) if time > 0.5 else 0.0)

    one, two = BenchDrone(), BenchDrone()
    play(ScriptedPilot(), one, BallEyes(SIDE))
    play(ScriptedPilot(), two, BallEyes(turning))
    differing = [a[0] for a, b in zip(one.commands, two.commands, strict=True) if a != b]
    assert min(differing) > 0.5 + REACTION


def test_late_pictures_are_judged_later_still():
    drone = BenchDrone(delay=0.1)
    play(ScriptedPilot(), drone, BallEyes(SIDE))
    assert first_move(drone) >= REACTION  # sight 0 was exposed at -0.1, but frame 0 is at -0.1
    assert first_move(drone) >= 3 / 30 - 0.1 + REACTION


@pytest.mark.parametrize("seed", range(5))
def test_sticks_move_at_most_every_tenth_of_a_second_and_in_steps(seed):
    drone = BenchDrone()
    play(ScriptedPilot(), drone, BallEyes(SIDE), seed=seed)
    moves = [t for (_, a), (t, b) in pairwise(drone.commands) if a != b]
    assert len(moves) >= 3
    assert np.diff(moves).min() >= STICK_PERIOD - 1e-9
    sticks = np.array([[command.left, command.up] for _, command in drone.commands])
    np.testing.assert_allclose(sticks / STICK_STEP, np.round(sticks / STICK_STEP), atol=1e-9)
    assert np.all(np.abs(sticks) <= FASTEST)
    assert all(c.forward == 0.0 and c.yaw_rate == 0.0 for _, c in drone.commands)


def test_it_flies_towards_the_ball():
    commands = play(ScriptedPilot(), BenchDrone(), BallEyes(straight(right=0.8, down=-0.6)))
    moved = [command for command in commands if command != HOVER]
    assert moved
    assert all(command.left < 0.0 for command in moved)


@pytest.mark.parametrize("seed", range(3))
def test_a_mirrored_ball_is_answered_by_mirrored_commands(seed):
    def mirror(time):
        return SIDE(time) * [-1.0, 1.0, 1.0]

    one = play(ScriptedPilot(), BenchDrone(), BallEyes(SIDE), seed=seed)
    two = play(ScriptedPilot(), BenchDrone(), BallEyes(mirror), seed=seed)
    assert [mirrored(command) for command in one] == two


def test_a_ball_that_goes_away_or_is_gone_is_let_go():
    away = play(ScriptedPilot(), BenchDrone(), BallEyes(straight(right=1.0, depth=1.0, speed=-4.0)))
    assert away == [HOVER] * 60
    past = play(ScriptedPilot(), BenchDrone(frames=90), BallEyes(SIDE))
    assert past[-1] == HOVER


def test_it_keeps_what_was_sent_and_when():
    pilot, drone = ScriptedPilot(), BenchDrone()
    play(pilot, drone, BallEyes(SIDE))
    assert pilot.commands == drone.commands
    play(pilot, BenchDrone(frames=3), BallEyes(SIDE))
    assert len(pilot.commands) == 3


def test_the_same_hands_give_the_same_game_and_other_hands_another():
    games = [play(ScriptedPilot(), BenchDrone(), BallEyes(SIDE), seed=s) for s in (1, 1, 2)]
    assert games[0] == games[1]
    assert games[0] != games[2]
