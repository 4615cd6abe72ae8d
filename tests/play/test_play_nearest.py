"""The player that repeats the nearest demonstration, unchanged."""

import numpy as np
import pytest
from play_bench import PERIOD, BenchDrone, play
from test_play_paper import BALL, LESSONS, flown, served, trigger_time, velocity_of

from rotorpong.conventions import InputError
from rotorpong.drone import BallEstimate, Player, Verdict
from rotorpong.play.nearest import NearestPlayer
from rotorpong.play.paper import PaperSettings
from rotorpong.primitives import State, fit_dmp


class Glimpse:
    """Implements Eyes: one ball, seen at once."""

    def __init__(self, ball):
        self._ball = ball

    def see(self, observation):
        return BallEstimate(
            observation.frame_time, self._ball[:3], self._ball[3:], np.zeros((6, 6))
        )


@pytest.fixture
def player():
    return NearestPlayer(LESSONS, PaperSettings(plane_distance=99.0))


def test_it_is_a_player(player):
    assert isinstance(player, Player)


@pytest.mark.parametrize("k", range(len(LESSONS)))
def test_a_ball_seen_before_is_answered_by_the_motion_of_that_demonstration(player, k):
    lesson, drone = LESSONS[k], BenchDrone()
    play(player, drone, Glimpse(lesson.ball))
    goal = lesson.hitting_point
    np.testing.assert_allclose(flown(drone, 0.0, goal[6]), goal[:3], atol=1e-9)
    path = lesson.path
    own = fit_dmp(path.times, path.positions, velocities=path.velocities)
    still = State(np.zeros(3), np.zeros(3))
    times = np.arange(int(goal[6] / PERIOD) + 1) * PERIOD
    ahead = own.roll_out(still, State(goal[:3], goal[3:6]), float(goal[6]), times).position
    sent = [velocity_of(command) for _, command in drone.commands[: len(times) - 1]]
    np.testing.assert_allclose(sent, np.diff(ahead, axis=0) / PERIOD, atol=1e-7)


def test_nearest_is_in_standard_deviations_of_the_demonstrated_balls(player):
    balls = np.array([lesson.ball for lesson in LESSONS])
    rng = np.random.default_rng(5)
    for ball in balls.mean(axis=0) + balls.std(axis=0) * rng.normal(size=(50, 6)):
        expected = np.argmin(np.sum(((balls - ball) / balls.std(axis=0)) ** 2, axis=1))
        assert player.nearest(ball) == expected


def test_it_hovers_until_the_plane():
    drone = served(NearestPlayer(LESSONS))
    assert BALL(trigger_time(drone))[2] < 2.5


def test_it_learns_nothing(player):
    before = served(player).commands
    player.learn(Verdict("hit", 0.1, 0.75))
    assert served(player).commands == before


def test_it_needs_two_demonstrations():
    with pytest.raises(InputError, match="1 demonstrations: expected at least 2"):
        NearestPlayer(LESSONS[:1])
