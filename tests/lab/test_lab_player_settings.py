"""What can be set about players, and what a run keeps of it."""

import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.evaluate import Knowledge, make_player
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import DECIDING_ONCE, LEARNERS, PLAYERS, Spec
from rotorpong.lab.train import run_of
from rotorpong.play.paper import PaperSettings


@pytest.mark.parametrize(
    ("player", "labels", "said"),
    [
        ("hover", "achieved", "--labels achieved with player 'hover': has no effect; expected"),
        ("bandit", "commanded", "has no effect; expected player paper or single"),
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
    told = {"length_scale": 6.0, "regularization": 0.1, "tune": False}
    assert PlayerSettings(length_scale=6.0).as_json("bandit") == told
    assert PlayerSettings(length_scale=6.0).unusual("bandit") == {"length_scale": 6.0}


def test_a_run_tells_its_settings_only_where_they_are_unusual():
    """So runs of older versions can be resumed."""
    usual = run_of(Spec("paper"))
    assert run_of(Spec("paper", player_settings=PlayerSettings("commanded"))) == usual
    assert "player_settings" not in usual.spec
    other = run_of(Spec("paper", player_settings=PlayerSettings("achieved")))
    assert other.spec["player_settings"] == {"labels": "achieved"}
    assert other.identity() != usual.identity()


def test_who_learns_and_who_decides_at_the_plane_are_players():
    assert set(LEARNERS) < set(DECIDING_ONCE) < set(PLAYERS)


@pytest.mark.parametrize("name", LEARNERS)
def test_every_learner_starts_from_the_same_demonstrations(name):
    from rotorpong.experience import shipped_demonstrations

    shown = shipped_demonstrations()[:3]
    player = make_player(Spec(name, eyes="truth"), Knowledge(shown))
    assert type(player).__name__.lower() == f"{name}player"
