"""Hover never looks and never moves."""

from play_bench import BallEyes, BenchDrone, play, straight

from rotorpong.drone import HOVER, Drone, Eyes, Player, Verdict
from rotorpong.play.hover import Hover


def test_the_bench_keeps_the_protocols():
    assert isinstance(BenchDrone(), Drone)
    assert isinstance(BallEyes(straight()), Eyes)
    assert isinstance(Hover(), Player)


def test_hover_hovers_at_every_frame_and_asks_no_eyes():
    drone, eyes = BenchDrone(frames=40), BallEyes(straight())
    assert play(Hover(), drone, eyes) == [HOVER] * 40
    assert eyes.asked == []


def test_hover_learns_nothing():
    player = Hover()
    player.learn(Verdict("hit", 0.1, 0.5))
    assert play(player, BenchDrone(frames=5), BallEyes(straight())) == [HOVER] * 5
