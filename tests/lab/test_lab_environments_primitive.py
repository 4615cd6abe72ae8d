"""One decision per serve, flown as the paper's player flies it."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from rotorpong.conventions import InputError
from rotorpong.lab.environments.primitive import (
    ACTION,
    action_for,
    hitting_point_of,
    reward_of,
)
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import Spec
from rotorpong.play import lessons

PRIMITIVE = "rotorpong/Primitive-v0"
SEED, BALLS = 3, 12


@pytest.mark.parametrize("randomize", [False, True])
@pytest.mark.parametrize("eyes", ["truth", "paper"])
def test_the_papers_own_hitting_points_give_what_evaluate_gives(eyes, randomize):
    spec = Spec(player="paper", eyes=eyes, seed=SEED, randomize=randomize)
    balls = BALLS if eyes == "truth" else 3
    game = {"purpose": "evaluate", "randomize": randomize}
    env = gymnasium.make(PRIMITIVE, eyes=eyes, **game).unwrapped
    for index, result in enumerate(evaluate(spec, balls)):
        env.reset(seed=SEED if index == 0 else None)
        info = env.step(env.paper_action())[-1]
        assert info["outcome"] == result.outcome
        assert info["miss_distance_m"] == pytest.approx(result.miss_distance, abs=1e-9)


def test_an_episode_is_one_step_and_begins_at_the_plane():
    env = gymnasium.make(PRIMITIVE)
    for trial in range(6):
        ball, info = env.reset(seed=SEED if trial == 0 else None)
        assert info["triggered"]
        assert 1.5 < ball[2] < 2.5
        assert -10.0 < ball[5] < -3.0
        again, reward, terminated, truncated, info = env.step(np.zeros(7, np.float32))
        assert np.array_equal(again, ball)
        assert (terminated, truncated) == (True, False)
        assert (reward > 0.0) == info["hit"]
        assert 0.0 <= reward <= 1.0


def test_where_it_is_told_to_go_decides_what_it_hits():
    env, rewards = gymnasium.make(PRIMITIVE), {}
    for left in (-0.6, 0.0, 0.6):
        env.reset(seed=1)
        info = env.step(np.array([left, 0, 0, 0, 0, 0, -0.3], np.float32))[-1]
        rewards[left] = info["miss_distance_m"]
    assert len(set(rewards.values())) == 3


def test_actions_and_hitting_points_are_each_others_inverse():
    generator = np.random.default_rng(0)
    actions = generator.uniform(-1, 1, (20, 7))
    points = hitting_point_of(actions)
    assert action_for(points) == pytest.approx(actions, abs=1e-12)
    assert hitting_point_of(np.zeros(7))[:6] == pytest.approx(np.zeros(6))
    for i, quantity in enumerate(ACTION):
        assert quantity.low <= points[:, i].min()
        assert points[:, i].max() <= quantity.high


def test_gymnasiums_own_checks_pass_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(PRIMITIVE, render_mode="rgb_array").unwrapped)


def test_rubber_pays_for_depth_on_the_opponents_side_and_cardboard_for_the_middle():
    env = gymnasium.make(PRIMITIVE, racket="rubber", purpose="evaluate").unwrapped
    paid = []
    for trial in range(BALLS):
        env.reset(seed=SEED if trial == 0 else None)
        _, reward, _, _, info = env.step(env.paper_action())
        truth = env.truth()
        assert reward == (0.0 if truth.landing_x is None else truth.landing_x / 1.37)
        assert reward_of(truth, "cardboard") == lessons.reward_of(truth.verdict)
        paid.append((info["hit"], reward))
    assert any(hit for hit, _ in paid)


@pytest.mark.parametrize("bad", [np.full(7, np.nan), np.zeros(6), np.full(7, np.inf)])
def test_an_action_is_seven_finite_numbers(bad):
    env = gymnasium.make(PRIMITIVE).unwrapped
    env.reset(seed=0)
    with pytest.raises(InputError, match=r"finite numbers from -1 to 1, shape \(7,\)"):
        env.step(bad)
    env.step(np.zeros(7))
    with pytest.raises(InputError, match="call reset"):
        env.step(np.zeros(7))


def test_eyes_that_are_unknown_are_refused():
    with pytest.raises(InputError, match="unknown eyes 'eagle'"):
        gymnasium.make(PRIMITIVE, eyes="eagle")
