"""The player with one primitive is the paper's without its mixture."""

from dataclasses import replace

import numpy as np
import pytest
from test_play_paper import HIT, LESSONS, MISS, served

from rotorpong.conventions import InputError
from rotorpong.drone import Player
from rotorpong.play.paper import PaperPlayer, PaperSettings
from rotorpong.play.single import SinglePlayer

SAME_MOTION = tuple(replace(one, path=LESSONS[0].path) for one in LESSONS)


def test_it_is_a_player():
    assert isinstance(SinglePlayer(LESSONS), Player)


def test_it_moves_as_the_demonstration_that_was_rewarded_best():
    player = SinglePlayer(LESSONS)
    served(player)
    best = max(range(len(LESSONS)), key=lambda k: LESSONS[k].reward)
    np.testing.assert_array_equal(player.attempt(MISS).mixture_weights, np.eye(6)[best])


@pytest.mark.parametrize("asked", [0, 4, 5])
def test_it_moves_as_the_demonstration_that_is_asked_for(asked):
    player = SinglePlayer(LESSONS, PaperSettings(primitive=asked))
    served(player)
    np.testing.assert_array_equal(player.attempt(MISS).mixture_weights, np.eye(6)[asked])


@pytest.mark.parametrize("asked", [-1, 6])
def test_a_primitive_that_was_not_demonstrated_is_refused(asked):
    with pytest.raises(InputError, match=f"primitive {asked}: expected a whole number from 0 to 5"):
        SinglePlayer(LESSONS, PaperSettings(primitive=asked))


@pytest.mark.parametrize("explore", [False, True])
def test_it_is_the_papers_player_where_all_primitives_are_one(explore):
    """The library then blends one motion with itself, whatever the weights."""
    single, paper = (kind(SAME_MOTION, explore=explore) for kind in (SinglePlayer, PaperPlayer))
    for seed in range(3):
        sent = [
            [(c.forward, c.left, c.up) for _, c in served(player, seed=seed).commands]
            for player in (single, paper)
        ]
        np.testing.assert_allclose(*sent, atol=1e-12)
        single.learn(HIT), paper.learn(HIT)


def test_it_aims_where_the_papers_player_aims_with_other_motions_too():
    single, paper = SinglePlayer(LESSONS, explore=True), PaperPlayer(LESSONS, explore=True)
    for seed in range(3):
        served(single, seed=seed), served(paper, seed=seed)
        one, other = single.attempt(HIT), paper.attempt(HIT)
        np.testing.assert_array_equal(one.hitting_point, other.hitting_point)
        assert not np.allclose(one.mixture_weights, other.mixture_weights)
        single.learn(HIT), paper.learn(HIT)


def test_what_was_kept_teaches_as_much_as_what_was_just_played():
    played, told = SinglePlayer(LESSONS, explore=True), SinglePlayer(LESSONS, explore=True)
    for seed, verdict in enumerate((HIT, MISS, HIT)):
        served(played, seed=seed)
        told.recall(verdict.outcome, played.attempt(verdict), 0.8)
        played.learn(verdict)
    served(played, seed=9), served(told, seed=9)
    assert played.attempt(MISS) == told.attempt(MISS)


def test_its_labels_may_be_what_was_achieved():
    player = SinglePlayer(LESSONS, PaperSettings(labels="achieved"))
    served(player)
    assert player.attempt(HIT) != player.attempt(MISS)


def test_it_needs_two_demonstrations():
    with pytest.raises(InputError, match="0 demonstrations: expected at least 2"):
        SinglePlayer(())
