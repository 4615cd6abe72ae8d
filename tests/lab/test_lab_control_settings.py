"""Controls chosen by name: what is refused, what is kept, what is flown."""

from dataclasses import replace

import numpy as np
import pytest

from rotorpong.conventions import InputError, StoreError
from rotorpong.experience import create, open_store, shipped_demonstrations
from rotorpong.lab.control_settings import CONTROLS, control_of
from rotorpong.lab.evaluate import Knowledge, evaluate, header, make_player
from rotorpong.lab.learners import settings_of
from rotorpong.lab.player_settings import DECIDING_ONCE, PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import run_of

SPEC = Spec(eyes="truth", seed=4)


@pytest.mark.parametrize(
    ("player", "control", "message"),
    [
        ("paper", "closed", "unknown control 'closed': expected one of open, feed-forward"),
        ("hover", "open", "--control open with player 'hover': has no effect; expected player"),
    ],
)
def test_a_control_that_is_unknown_or_without_effect_is_refused(player, control, message):
    with pytest.raises(InputError) as refusal:
        Spec(player, eyes="truth", control=control).check()
    assert message in str(refusal.value)


def test_a_run_keeps_its_control_and_is_not_resumed_with_another(tmp_path):
    assert run_of(replace(SPEC, control="open")).spec == run_of(SPEC).spec
    with create(tmp_path / "run.sqlite", run_of(replace(SPEC, control="closed-loop"))):
        pass
    with open_store(tmp_path / "run.sqlite") as store:
        store.check_run(run_of(replace(SPEC, control="closed-loop")))
        for other in (None, "feed-forward"):
            with pytest.raises(StoreError, match=r'spec\.control is "closed-loop", given'):
                store.check_run(run_of(replace(SPEC, control=other)))


def test_an_evaluation_says_how_motions_were_flown_if_any_were():
    assert header(SPEC, 1)["control"] == "open"
    assert header(replace(SPEC, control="feed-forward"), 1)["control"] == "feed-forward"
    assert "control" not in header(replace(SPEC, player="hover"), 1)


@pytest.mark.parametrize("player", DECIDING_ONCE)
def test_the_same_serves_are_flown_otherwise_and_open_is_as_ever(player):
    known = Knowledge(shipped_demonstrations())
    misses = {
        control: [
            r.miss_distance
            for r in evaluate(replace(SPEC, player=player, control=control), 3, knowledge=known)
        ]
        for control in (None, *CONTROLS)
    }
    assert misses[None] == misses["open"]
    assert len({tuple(misses[control]) for control in CONTROLS}) == 3
    assert np.isfinite([x for some in misses.values() for x in some]).all()


def test_control_knows_the_nominal_drone_also_where_trials_draw_their_own():
    player = make_player(
        replace(SPEC, vehicle="ardrone2", randomize=True, control="closed-loop"),
        Knowledge(shipped_demonstrations()),
    )
    settings = player._settings
    assert settings.control == control_of("closed-loop") == "closed_loop"
    assert [axis.dead_time for axis in settings.plant.axes] == [0.1] * 3


def test_control_and_settings_of_learning_are_chosen_side_by_side():
    learning = PlayerSettings("achieved", 12.0, 0.002)
    spec = replace(SPEC, control="feed-forward", player_settings=learning)
    settings = settings_of(spec.check())
    assert (settings.control, settings.labels) == ("feed_forward", "achieved")
    assert (settings.length_scale, settings.regularization) == (12.0, 0.002)
    kept = run_of(spec).spec
    assert (kept["control"], kept["player_settings"]["labels"]) == ("feed-forward", "achieved")
    head = header(spec, 1)
    assert (head["control"], head["player_settings"]["length_scale"]) == ("feed-forward", 12.0)
