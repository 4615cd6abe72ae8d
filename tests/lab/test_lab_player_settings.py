"""What can be set about players, and what a run keeps of it."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.drone import BallEstimate
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.evaluate import Knowledge, evaluate, make_player
from rotorpong.lab.player_settings import DECIDING_ONCE, PlayerSettings
from rotorpong.lab.spec import LEARNERS, PLAYERS, Spec
from rotorpong.lab.train import run_of
from rotorpong.learning import Selection
from rotorpong.learning.mixture import RULES
from rotorpong.play.paper import PaperPlayer, PaperSettings


@pytest.mark.parametrize(
    ("player", "labels", "said"),
    [
        ("hover", "achieved", "--labels achieved with player 'hover': has no effect; expected"),
        ("bandit", "commanded", "has no effect; expected player single or paper"),
        ("paper", "guessed", "unknown labels 'guessed': expected one of commanded, achieved"),
        ("single", "", "unknown labels ''"),
    ],
)
def test_settings_that_are_unknown_or_without_effect_are_refused(player, labels, said):
    with pytest.raises(InputError) as refusal:
        Spec(player, player_settings=PlayerSettings(labels)).check()
    assert said in str(refusal.value)


@pytest.mark.parametrize("given", [0.0, -1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("what", ["length_scale", "regularization"])
def test_numbers_of_crkr_are_positive(what, given):
    with pytest.raises(InputError) as refusal:
        Spec("bandit", player_settings=PlayerSettings(**{what: given})).check()
    assert f"--{what.replace('_', '-')} {given}: expected a positive number" in str(refusal.value)


def test_tuning_is_refused_where_nothing_can_be_tuned():
    with pytest.raises(InputError, match="--tune with player 'nearest': has no effect"):
        Spec("nearest", player_settings=PlayerSettings(tune=True)).check()
    assert PlayerSettings(tune=True).of_paper().tune


def test_which_primitive_is_asked_of_the_player_with_one():
    with pytest.raises(InputError, match="--primitive 3 with player 'paper': has no effect"):
        Spec("paper", player_settings=PlayerSettings(primitive=3)).check()
    settings = PlayerSettings(primitive=3)
    assert Spec("single", player_settings=settings).check().player_settings.of_paper() == (
        PaperSettings(primitive=3)
    )
    assert settings.unusual("single") == {"primitive": 3}
    assert run_of(Spec("single")).spec.keys().isdisjoint({"player_settings"})


def test_what_is_not_asked_for_is_as_usual():
    assert PlayerSettings().of_paper() == PaperSettings()
    assert PlayerSettings("achieved").of_paper() == PaperSettings(labels="achieved")
    assert PlayerSettings(None, 6.0, 0.01).of_paper() == PaperSettings(
        length_scale=6.0, regularization=0.01
    )
    usual = PlayerSettings().as_json("bandit")
    assert PlayerSettings(length_scale=6.0).as_json("bandit") == usual | {"length_scale": 6.0}
    assert PlayerSettings(length_scale=6.0).unusual("bandit")["length_scale"] == 6.0


def test_what_is_asked_for_reaches_the_player():
    """Written out, so that no field can be lost on the way."""
    asked = PlayerSettings(
        *("achieved", 6.0, 0.01, True, "distance", 2.0, 0.05, "temperature", 0.1),
        learn_from_misses=True,
    )
    asked.check("paper")
    assert asked.of_paper() == PaperSettings(
        labels="achieved",
        length_scale=6.0,
        regularization=0.01,
        tune=True,
        trigger="distance",
        plane_distance=2.0,
        exploration_sd=0.05,
        selection=Selection("temperature", 0.1),
        learn_from_misses=True,
    )
    assert PlayerSettings(selection="ucb", deviations=2.0).of_paper().selection == Selection(
        "ucb", deviations=2.0
    )


def test_json_names_units_and_leaves_out_what_no_rule_reads():
    told = PlayerSettings(plane_distance=2.0, selection="ucb").as_json("paper")
    assert (told["plane_distance_m"], told["selection"], told["deviations"]) == (2.0, "ucb", 1.0)
    assert set(told) == {
        *("labels", "length_scale", "regularization", "tune", "trigger", "plane_distance_m"),
        *("exploration_sd_m", "selection", "deviations", "learn_from_misses"),
    }
    assert set(PlayerSettings().as_json("nearest")) == {"trigger", "plane_distance_m"}
    assert PlayerSettings().as_json("hover") == {}
    assert not {"temperature", "deviations"} & set(PlayerSettings().as_json("paper"))


@pytest.mark.parametrize(
    ("player", "asked", "said"),
    [
        ("hover", {"trigger": "plane"}, "expected player nearest or single or paper or bandit"),
        ("oracle", {"plane_distance": 2.0}, "--plane-distance-m 2.0 with player 'oracle': has no"),
        ("bandit", {"exploration_sd": 0.1}, "--exploration-sd-m 0.1 with player 'bandit': has no"),
        ("nearest", {"exploration_sd": 0.1}, "has no effect; expected player single or paper"),
        ("single", {"selection": "ucb"}, "--selection ucb with player 'single': has no effect"),
        ("single", {"learn_from_misses": True}, "--learn-from-misses with player 'single': has"),
        ("paper", {"selection": "best"}, "unknown selection 'best': expected one of paper, temp"),
        ("paper", {"trigger": "time"}, "unknown trigger 'time': expected one of plane, distance"),
        ("paper", {"temperature": 0.1}, "--temperature 0.1: has no effect without --selection t"),
        ("paper", {"deviations": 2.0}, "--deviations 2.0: has no effect without --selection ucb"),
        (
            "bandit",
            {"selection": "ucb", "temperature": 0.1},
            "--temperature 0.1: has no effect without --selection temperature",
        ),
        (
            "paper",
            {"selection": "temperature", "temperature": 0.0},
            "--temperature 0.0: expected a number from 0.001 to 1000",
        ),
        ("paper", {"selection": "ucb", "deviations": -1.0}, "expected a number from 0 to 100"),
        ("paper", {"exploration_sd": math.nan}, "--exploration-sd-m nan: expected a number from"),
        ("paper", {"exploration_sd": 2.0}, "expected a number from 0 to 1 m"),
        ("nearest", {"plane_distance": 0.0}, "expected a number from 0.8 to 4 m"),
        ("nearest", {"plane_distance": -2.5}, "--plane-distance-m -2.5: expected a number from"),
        ("paper", {"plane_distance": math.inf}, "expected a number from 0.8 to 4 m"),
    ],
)
def test_what_has_no_effect_or_no_meaning_is_refused(player, asked, said):
    with pytest.raises(InputError) as refusal:
        Spec(player, eyes="truth", player_settings=PlayerSettings(**asked)).check()
    assert said in str(refusal.value)


@pytest.mark.parametrize("player", DECIDING_ONCE)
@pytest.mark.parametrize("what", [one.name for one in fields(PlayerSettings)])
def test_a_setting_is_accepted_by_exactly_those_whose_json_tells_it(player, what):
    given = {"labels": "achieved", "trigger": "distance", "selection": "greedy"}
    given |= {"tune": True, "learn_from_misses": True, "primitive": 0}
    rule = {"temperature": {"selection": "temperature"}, "deviations": {"selection": "ucb"}}
    asked = PlayerSettings(**{what: given.get(what, 0.9), **rule.get(what, {})})
    told = {key.removesuffix("_m") for key in asked.as_json(player)}
    if what in told:
        asked.check(player)
    else:
        with pytest.raises(InputError, match="has no effect"):
            asked.check(player)


def test_a_run_tells_its_settings_only_where_they_are_unusual():
    """So runs of older versions can be resumed."""
    first = PlayerSettings("commanded", 3.0, 0.1, None, "plane", 2.5, 0.1, "paper")
    usual = run_of(Spec("paper", player_settings=first))
    assert "player_settings" not in usual.spec
    assert run_of(Spec("paper", player_settings=replace(first, labels=None))) == usual
    for what, value, key in (
        ("labels", "achieved", "labels"),
        ("trigger", "distance", "trigger"),
        ("plane_distance", 2.0, "plane_distance_m"),
        ("exploration_sd", 0.0, "exploration_sd_m"),
        ("selection", "greedy", "selection"),
        ("learn_from_misses", True, "learn_from_misses"),
    ):
        other = run_of(Spec("paper", player_settings=replace(first, **{what: value})))
        assert other.spec["player_settings"] == {key: value}
        assert other.identity() != usual.identity()
    rule = run_of(Spec("paper", player_settings=replace(first, selection="temperature")))
    assert rule.spec["player_settings"] == {"selection": "temperature", "temperature": 1.0}


def test_training_without_exploration_tries_what_an_evaluation_would():
    still = Spec("paper", "truth", player_settings=PlayerSettings(exploration_sd=0.0))
    shown = Knowledge(shipped_demonstrations()[:3])
    estimate = BallEstimate(1.0, np.array([0.1, 0.0, 2.4]), np.array([0.0, 0.5, -4.5]), np.eye(6))
    rng = np.random.default_rng(0)

    def aim(spec, *, explore=True):
        player = make_player(spec, shown, explore=explore)
        assert isinstance(player, PaperPlayer)
        return player.aim(estimate, rng)

    meant = aim(still, explore=False)
    np.testing.assert_array_equal(aim(still), meant)
    wide = replace(still, player_settings=PlayerSettings(exploration_sd=0.2))
    tried = np.array([aim(wide) - meant for _ in range(3)])
    assert 0.05 < np.std(tried[:, :3]) < 0.4  # nine draws of sd 0.2 m
    np.testing.assert_array_equal(tried[:, 3:], 0.0)


@pytest.mark.parametrize("rule", RULES)
def test_every_rule_is_played(rule):
    chosen = Spec("paper", "truth", player_settings=PlayerSettings(selection=rule))
    results = evaluate(chosen.check(), 2, knowledge=Knowledge(shipped_demonstrations()[:3]))
    assert all(result.outcome != "fault" for result in results)


def test_who_learns_and_who_decides_at_the_plane_are_players():
    assert set(LEARNERS) < set(DECIDING_ONCE) < set(PLAYERS)


@pytest.mark.parametrize("name", LEARNERS)
def test_every_learner_starts_from_the_same_demonstrations(name):
    shown = shipped_demonstrations()[:3]
    player = make_player(Spec(name, eyes="truth"), Knowledge(shown))
    assert type(player).__name__.lower() == f"{name}player"
