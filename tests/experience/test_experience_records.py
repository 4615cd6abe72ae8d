"""Records take what can be stored and compared, and refuse the rest at the door."""

import math

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from rotorpong.conventions import InputError
from rotorpong.drone import OUTCOMES
from rotorpong.experience import Attempt, Demonstration, Run, Trial
from rotorpong.experience.records import canonical_json, require_array

COMMANDS = np.array([[0.0, 0.1, 0.2, 0.3, 0.4], [0.1, 1.0, 2.0, 3.0, 4.0]])


def demonstration(*, seed=0, spec=None, commands=COMMANDS):
    return Demonstration(seed, 0, spec or {}, "scripted", commands)


def test_equal_values_make_equal_records_and_any_other_value_does_not():
    attempt = Attempt(np.arange(6.0), np.arange(7.0), np.ones(3))
    assert attempt == Attempt(np.arange(6.0), np.arange(7.0), np.ones(3))
    assert attempt != Attempt(np.arange(6.0), np.arange(7.0), np.ones(4))
    assert attempt != "attempt"
    assert demonstration() == demonstration(commands=COMMANDS.copy())
    assert demonstration() != demonstration(spec={"serves": "human"})


@pytest.mark.parametrize("outcome", OUTCOMES)
def test_every_outcome_of_a_drone_can_be_kept(outcome):
    assert Trial(0, outcome, 0.0, None, None, None).outcome == outcome


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(bad):
    with pytest.raises(InputError, match="reward"):
        Trial(0, "hit", bad, None, None, None)
    with pytest.raises(InputError, match="contact_offset"):
        Trial(0, "hit", 1.0, None, bad, None)
    with pytest.raises(InputError, match="contact_time"):
        Trial(0, "hit", 1.0, None, None, bad)
    with pytest.raises(InputError, match="hitting_point"):
        Attempt(np.zeros(6), np.full(7, bad), np.ones(2))
    with pytest.raises(InputError, match="commands"):
        demonstration(commands=np.array([[0.0, bad, 0.0, 0.0, 0.0]]))
    with pytest.raises(InputError, match="cannot be stored"):
        demonstration(spec={"noise": bad})


def test_wrong_shapes_are_refused_with_the_shape_expected():
    with pytest.raises(InputError, match=r"state has shape \(5,\); expected \(6,\)"):
        require_array("state", np.zeros(5), 6)
    with pytest.raises(InputError, match=r"commands has shape \(3, 4\); expected \(-1, 5\)"):
        require_array("commands", np.zeros((3, 4)), -1, 5)
    with pytest.raises(InputError, match="state has shape"):
        require_array("state", np.zeros((6, 1)), 6)
    with pytest.raises(InputError, match="mixture_weights has shape"):
        Attempt(np.zeros(6), np.zeros(7), np.ones(0))
    with pytest.raises(InputError, match="commands has shape"):
        demonstration(commands=np.zeros((0, 5)))


def test_a_demonstration_needs_rising_times_and_a_flat_spec():
    with pytest.raises(InputError, match="times"):
        demonstration(commands=COMMANDS[::-1])
    with pytest.raises((InputError, TypeCheckError), match="camera"):
        demonstration(spec={"camera": ["gazebo"]})


@pytest.mark.parametrize("seed", [-1, 2**63, True])
def test_integers_that_no_column_holds_are_refused(seed):
    with pytest.raises(InputError, match="seed"):
        demonstration(seed=seed)


def test_an_unknown_outcome_is_refused_naming_those_there_are():
    with pytest.raises((InputError, TypeCheckError), match="near_hit"):
        Trial(0, "homerun", 0.0, None, None, None)


def test_json_has_one_text_whatever_the_order_of_keys():
    assert canonical_json({"b": 1, "a": [1.5, None]}) == '{"a": [1.5, null], "b": 1}'
    assert canonical_json({"a": [1.5, None], "b": 1}) == canonical_json({"b": 1, "a": [1.5, None]})


def test_a_run_takes_only_json():
    words = ("paper", "truth", "tum_gazebo", "gazebo", "human", "0.1.0", "scripted")
    with pytest.raises(InputError, match="cannot be stored"):
        Run(0, 0, *words, {"folder": object()})
