"""The bandit: it tries about CrKR's answer, and believes rewards."""

import numpy as np
import pytest
from test_play_paper import BALL, HIT, LESSONS, MISS, served

from rotorpong.conventions import InputError
from rotorpong.drone import Player
from rotorpong.experience import Attempt
from rotorpong.play.bandit import OFFSETS, BanditPlayer, hoped
from rotorpong.play.paper import PaperPlayer, PaperSettings

AHEAD = np.array([0.2, 0.1, 2.4, 0.0, 0.0, -6.0])  # a ball as BALL crosses the plane
FAULTY = np.array([0.10, -0.05])  # m by which the demonstrations mislead, in the toy
RADIUS = 0.06  # m of the toy's blade


def attempt(goal, ball=AHEAD):
    return Attempt(ball, goal, np.full(len(LESSONS), 1.0 / len(LESSONS)))


def toy(player, pupils, serves, *, spread=0.1, seed=3):
    """Serve balls about AHEAD, of which FAULTY off the demonstrations hits; return the hits."""
    rng, honest, hits = np.random.default_rng(seed), PaperPlayer(LESSONS), 0
    for _ in range(serves):
        ball = AHEAD + spread * rng.normal(size=6)
        goal = player.hitting_point(ball)
        off = goal[:2] - honest.hitting_point(ball)[:2] - FAULTY
        is_hit = bool(np.linalg.norm(off) < RADIUS)
        hits += is_hit
        for one in pupils:
            one.recall("hit" if is_hit else "miss", attempt(goal, ball), float(is_hit))
    return hits


def test_it_is_a_player():
    assert isinstance(BanditPlayer(LESSONS), Player)


def test_of_balls_that_are_alike_it_soon_hits_nearly_all():
    curious, greedy = BanditPlayer(LESSONS, explore=True), BanditPlayer(LESSONS)
    assert toy(greedy, (), 40, spread=0.02) == 0
    toy(curious, (curious, greedy), 80, spread=0.02, seed=2)
    assert toy(greedy, (), 40, spread=0.02) > 36


def test_of_balls_that_differ_it_hits_more_than_before():
    curious, greedy = BanditPlayer(LESSONS, explore=True), BanditPlayer(LESSONS)
    before = toy(greedy, (), 100)
    toy(curious, (curious, greedy), 160, seed=2)
    assert toy(greedy, (), 100) > before + 10


def test_misses_drive_it_away_from_where_it_missed():
    player = BanditPlayer(LESSONS)
    before = player.hitting_point(AHEAD)
    for _ in range(6):
        player.recall("miss", attempt(before), 0.0)
    after = player.hitting_point(AHEAD)
    assert np.linalg.norm(after[:2] - before[:2]) >= 0.05 - 1e-9
    np.testing.assert_array_equal(after[2:], before[2:])


def test_hits_keep_it_where_it_hit():
    player = BanditPlayer(LESSONS)
    before = player.hitting_point(AHEAD)
    for _ in range(6):
        player.recall("hit", attempt(before), 1.0)
    np.testing.assert_allclose(player.hitting_point(AHEAD)[:2], before[:2], atol=0.025)


def test_curiosity_tries_arms_that_were_not_tried():
    greedy, curious = BanditPlayer(LESSONS), BanditPlayer(LESSONS, explore=True)
    tried = []
    for _ in range(8):
        goal = curious.hitting_point(AHEAD)
        tried.append(tuple(np.round(goal[:2], 6)))
        for player in (greedy, curious):
            player.recall("miss", attempt(goal), 0.0)
    assert len(set(tried)) >= 6


def test_an_arm_is_never_faster_than_what_was_demonstrated_or_what_crkr_asks_for():
    player, paper = BanditPlayer(LESSONS, explore=True), PaperPlayer(LESSONS)
    fastest = np.max([np.abs(one.path.velocities).max(axis=0) for one in LESSONS], axis=0)[:2]
    rng = np.random.default_rng(4)
    for ball in AHEAD + rng.normal(size=(30, 6)):
        goal, asked = player.hitting_point(ball), np.abs(paper.hitting_point(ball)[:2])
        assert np.all(np.abs(goal[:2]) <= np.maximum(fastest * goal[6], asked) + 1e-12)


def test_hope_is_greatest_in_the_middle_and_the_middle_is_an_arm():
    assert OFFSETS.shape == (49, 2)
    assert np.argmax(hoped(OFFSETS)) == np.flatnonzero((OFFSETS == 0.0).all(axis=1))[0]
    assert hoped(np.zeros(2)) == pytest.approx(0.3)
    assert hoped(np.array([0.15, 0.0])) == pytest.approx(0.3 * np.exp(-0.5))


def test_playing_and_being_told_teach_the_same():
    played, told = (BanditPlayer(LESSONS, explore=True) for _ in range(2))
    for seed, verdict in enumerate((MISS, HIT, MISS)):
        served(played, seed=seed)
        reward = 0.0 if verdict is MISS else 0.8
        told.recall(verdict.outcome, played.attempt(verdict), reward)
        played.learn(verdict)
    np.testing.assert_array_equal(played.hitting_point(AHEAD), told.hitting_point(AHEAD))


def test_what_it_tried_is_its_label_even_if_achieved_labels_are_asked_for():
    player = BanditPlayer(LESSONS, PaperSettings(labels="achieved"))
    served(player)
    np.testing.assert_array_equal(
        player.attempt(HIT).hitting_point[:6], player.attempt(MISS).hitting_point[:6]
    )


def test_who_sees_nothing_learns_nothing():
    player = BanditPlayer(LESSONS)
    before = player.hitting_point(AHEAD)
    served(player, ball=BALL, first=99.0)
    player.learn(MISS)
    np.testing.assert_array_equal(player.hitting_point(AHEAD), before)


def test_it_needs_two_demonstrations():
    with pytest.raises(InputError, match="1 demonstrations: expected at least 2"):
        BanditPlayer(LESSONS[:1])
