"""Rules that turn expected rewards into weights, and what no weights can change."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from rotorpong.conventions import InputError
from rotorpong.learning import Mixture, Selection
from rotorpong.primitives import State, fit_dmp, mix

rng = np.random.default_rng(0)
FEATURES = np.concatenate([np.ones((9, 1)), rng.normal(size=(9, 2))], axis=1)


def trained():
    mixture = Mixture.prior(4, 3)
    for features in rng.normal(size=(40, 3)):
        mixture = mixture.update(features, rng.uniform(), rng.dirichlet(np.ones(4)))
    return mixture


MIXTURE = trained()


def test_the_paper_s_rule_is_the_one_unless_stated():
    np.testing.assert_array_equal(MIXTURE.select(FEATURES), MIXTURE.weights(FEATURES))
    warm = MIXTURE.select(FEATURES, Selection("temperature", temperature=1.0))
    np.testing.assert_array_equal(warm, MIXTURE.weights(FEATURES))


def test_a_temperature_divides_the_values():
    found = MIXTURE.select(FEATURES, Selection("temperature", temperature=0.2))
    gamma = np.exp(MIXTURE.values(FEATURES) / 0.2)
    np.testing.assert_allclose(found, gamma / gamma.sum(axis=1, keepdims=True))


def test_one_of_ten_that_is_certain_gets_a_quarter_from_the_paper_and_all_from_a_tenth():
    mixture, one = Mixture.prior(10, 1, precision=1e-9), np.ones(1)
    mixture = mixture.update(one, 1.0, np.eye(10)[0])
    paper = mixture.select(one)[0]
    cold = mixture.select(one, Selection("temperature", temperature=0.1))[0]
    assert paper == pytest.approx(np.e / (np.e + 9.0), abs=1e-6)
    assert cold == pytest.approx(0.9996, abs=1e-4)


def test_cold_is_greedy_and_hot_is_even():
    values = MIXTURE.values(FEATURES)
    cold = MIXTURE.select(FEATURES, Selection("temperature", temperature=1e-9))
    np.testing.assert_array_equal(cold, MIXTURE.select(FEATURES, Selection("greedy")))
    np.testing.assert_array_equal(cold.argmax(axis=1), values.argmax(axis=1))
    hot = MIXTURE.select(FEATURES, Selection("temperature", temperature=1e9))
    np.testing.assert_allclose(hot, 0.25, atol=1e-8)


def test_doubt_is_worth_something_to_ucb():
    one = np.ones(1)
    mixture = Mixture.prior(2, 1)
    for _ in range(50):
        mixture = mixture.update(one, 0.6, np.array([1.0, 0.0]))
    np.testing.assert_array_equal(mixture.select(one, Selection("greedy")), [1.0, 0.0])
    np.testing.assert_array_equal(mixture.select(one, Selection("ucb")), [0.0, 1.0])
    never = Selection("ucb", deviations=0.0)
    np.testing.assert_array_equal(mixture.select(one, never), [1.0, 0.0])


def test_thompson_chooses_as_often_as_it_believes_to_be_best():
    one = np.ones(1)
    mixture = Mixture.prior(2, 1).update(one, 1.0, np.array([1.0, 0.0]))
    dice = np.random.default_rng(0)
    chosen = [mixture.select(one, Selection("thompson"), dice)[0] for _ in range(2000)]
    first, second = mixture.regressions
    gap = first.mean(one) - second.mean(one)
    expected = norm.cdf(gap / np.sqrt(first.variance(one) + second.variance(one)))
    assert np.mean(chosen) == pytest.approx(expected, abs=5.0 * 0.5 / np.sqrt(2000))


@pytest.mark.parametrize("rule", ["paper", "temperature", "greedy", "ucb", "thompson"])
def test_weights_sum_to_1_and_one_row_alone_is_the_same(rule):
    selection = Selection(rule)
    found = MIXTURE.select(FEATURES, selection, np.random.default_rng(1))
    np.testing.assert_allclose(found.sum(axis=1), 1.0)
    alone = MIXTURE.select(FEATURES[3], selection, np.random.default_rng(1))
    np.testing.assert_allclose(alone, found[3])


def test_credit_by_the_weights_never_sets_apart_what_starts_alike():
    mixture = Mixture.prior(4, 3)
    for features in rng.normal(size=(40, 3)):
        mixture = mixture.update(features, rng.uniform(), mixture.weights(features))
    np.testing.assert_array_equal(mixture.weights(FEATURES), 0.25)


def test_forgetting_forgets_in_every_primitive():
    found = MIXTURE.forget(0.5).values(FEATURES)
    expected = np.stack([one.forget(0.5).mean(FEATURES) for one in MIXTURE.regressions], axis=1)
    np.testing.assert_array_equal(found, expected)


def motion(seed):
    draw = np.random.default_rng(seed)
    times = np.linspace(0.0, 1.0, 60)
    waves = np.sin(np.outer(times, [1.0, 2.0, 3.0]) * np.pi)
    return fit_dmp(times, waves @ draw.normal(size=(3, 3)))


PRIMITIVES = [motion(seed) for seed in range(4)]
STILL = State(np.zeros(3), np.zeros(3))
NUMBERS = st.floats(-1.0, 1.0)


@settings(max_examples=50, deadline=None)
@given(
    weights=st.lists(st.floats(0.0, 10.0), min_size=4, max_size=4).filter(lambda w: sum(w) > 0.0),
    goal=st.lists(NUMBERS, min_size=6, max_size=6),
    duration=st.floats(0.2, 2.0),
)
def test_no_weights_move_the_hitting_point(weights, goal, duration):
    end = State(np.array(goal[:3]), np.array(goal[3:]))
    blend = mix(PRIMITIVES, np.array(weights))
    reached = blend.roll_out(STILL, end, duration, np.array([duration]))
    np.testing.assert_allclose(reached.position[0], end.position, rtol=0, atol=1e-9)
    np.testing.assert_allclose(reached.velocity[0], end.velocity, rtol=0, atol=1e-8)


def test_but_weights_do_change_how_it_gets_there():
    end, times = State(np.ones(3), np.ones(3)), np.linspace(0.0, 1.0, 50)
    one, other = (mix(PRIMITIVES, w).roll_out(STILL, end, 1.0, times) for w in np.eye(4)[:2])
    assert np.abs(one.position - other.position).max() > 0.1


def test_rules_without_meaning_are_refused():
    with pytest.raises(InputError, match="'best': expected one of paper, temperature, greedy"):
        Selection("best")
    for temperature in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="temperature"):
            Selection("temperature", temperature)
    with pytest.raises(InputError, match="deviations"):
        Selection("ucb", deviations=-1.0)
    with pytest.raises(InputError, match="without rng"):
        MIXTURE.select(FEATURES, Selection("thompson"))
    with pytest.raises(InputError, match="expected 3"):
        MIXTURE.select(FEATURES[:, :2], Selection("greedy"))
