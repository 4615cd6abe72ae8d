"""Hits played again are the hits that were kept, and what a witness tells of them is right."""

from dataclasses import replace

import numpy as np
import pytest

from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import knowledge_of, train
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.paper.hits import hits_again, serves_seen
from rotorpong.world.simulated_drone import SimulatedDrone

SPEC = Spec(eyes="truth", seed=5)
ACHIEVED = replace(SPEC, player_settings=PlayerSettings(labels="achieved"))


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """Return what runs kept, by their labels."""
    folder = tmp_path_factory.mktemp("runs")
    for name, spec in (("commanded", SPEC), ("achieved", ACHIEVED)):
        train(spec, 3, folder / name)
    return {name: knowledge_of(folder / name)[1] for name in ("commanded", "achieved")}


def own_hits(knowledge):
    return [trial for trial in knowledge.trials if trial.outcome == "hit"]


def test_all_hits_come_again_in_order(known):
    again = list(hits_again(SPEC, known["commanded"]))
    assert [hit.trial for hit in again] == own_hits(known["commanded"])
    assert len(again) == 3
    for hit in again:
        assert hit.attempt("commanded") == hit.trial.attempt


def test_achieved_labels_are_those_of_a_run_that_learns_them(known):
    """Up to and with its first hit, a run does not depend on its labels."""
    first = next(hits_again(SPEC, known["commanded"]))
    kept = own_hits(known["achieved"])[0]
    assert first.trial.index == kept.index
    label = first.attempt("achieved").hitting_point
    np.testing.assert_allclose(label, kept.attempt.hitting_point, atol=1e-9)
    assert not np.allclose(label, first.attempt("commanded").hitting_point, atol=1e-3)


def test_the_run_of_another_seed_is_not_taken_for_this_one(known):
    with pytest.raises(AssertionError, match="a trial depends on seed and hits alone"):
        list(hits_again(replace(SPEC, seed=6), known["commanded"]))


def test_needs_are_where_serves_were_aimed_and_balls_what_is_true():
    """Serves are aimed from where the blade hovers at home; the drone drifts by centimetres."""
    serves, stage = serves_seen(SPEC, 8), stage_of(SPEC)
    assert len(serves) == 8
    for index, serve in enumerate(serves):
        drone = new_drone(stage, index)
        assert isinstance(drone, SimulatedDrone)
        left, up = drone._serve.target
        np.testing.assert_allclose(serve.need, [-left, -up], atol=0.04)
        assert serve.ball[2] < 2.5
        assert serve.ball[5] < -3.0
