"""Rewards, costs and labels as the paper defines them."""

import numpy as np
import pytest

from rotorpong.drone import OUTCOMES, Verdict
from rotorpong.play.lessons import Lesson, cost_of, hitting_point, reward_of
from rotorpong.play.odometer import Path

PATH = Path(
    np.array([2.0, 2.3, 2.5]),
    np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.3, 0.1, -0.2]]),
    np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.5, -1.0]]),
)


def test_a_hitting_point_is_the_end_of_the_path():
    np.testing.assert_allclose(hitting_point(PATH), [0.3, 0.1, -0.2, 2.0, 0.5, -1.0, 0.5])
    lesson = Lesson(np.zeros(6), PATH, 1.0)
    np.testing.assert_array_equal(lesson.hitting_point, hitting_point(PATH))


def test_the_middle_of_the_blade_is_worth_twice_its_rim():
    assert reward_of(Verdict("hit", 0.0)) == 1.0
    assert reward_of(Verdict("hit", 1.0)) == 0.5
    assert reward_of(Verdict("hit", 1.0 + 1e-12)) == 0.5  # an edge, to rounding


def test_a_hit_nobody_measured_is_worth_as_much_as_the_best():
    assert reward_of(Verdict("hit")) == 1.0


@pytest.mark.parametrize("outcome", [o for o in OUTCOMES if o != "hit"])
def test_what_is_no_hit_is_worth_nothing(outcome):
    assert reward_of(Verdict(outcome)) == 0.0


def test_cost_is_the_inverse_of_the_reward_and_stays_finite():
    assert cost_of(0.5) == 2.0
    assert cost_of(0.0) == cost_of(0.01) == 20.0
    rewards = np.linspace(0.0, 1.0, 50)
    assert np.all(np.diff([cost_of(reward) for reward in rewards]) <= 0.0)
