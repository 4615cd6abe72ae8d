"""What became of so many balls."""

import statistics

import numpy as np
import pytest

from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.evaluate import Knowledge, evaluate, make_player
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import play_trial, stage_of
from rotorpong.paper.tally import is_near, moved, percent, spread, tally
from rotorpong.play.hover import Hover

SPEC = Spec(eyes="truth", seed=3)
BALLS = 8


def test_a_tally_is_that_of_an_evaluation():
    player = make_player(SPEC, Knowledge(shipped_demonstrations()))
    found = tally(stage_of(SPEC), player, BALLS)
    outcomes = [one.outcome for one in evaluate(SPEC, BALLS)]
    assert found["balls"] == BALLS
    for what, outcome in (("hits", "hit"), ("near_hits", "near_hit"), ("hulls", "hull")):
        assert found[what] == outcomes.count(outcome)
    assert 0 <= found["near_hulls"] <= found["hulls"]
    assert found["hulls"] > 0


def test_every_near_hit_is_near_and_no_clear_miss_is():
    stage, hover = stage_of(Spec("hover", serves="hard")), Hover()
    played = [play_trial(stage, index, hover) for index in range(50)]
    near = {one.outcome: [] for one in played}
    for one in played:
        near[one.outcome].append(is_near(one))
    assert all(near.get("near_hit", [True]))
    assert len(near["miss"]) > 10
    assert not any(near["miss"])
    assert any(near["hull"])


def test_a_blade_that_hovers_hardly_moves_and_one_that_strikes_does():
    player = make_player(SPEC, Knowledge(shipped_demonstrations()))
    ways = {
        name: [moved(play_trial(stage_of(SPEC), index, who)) for index in range(6)]
        for name, who in (("hover", Hover()), ("strike", player))
    }
    assert max(ways["hover"]) < 0.05
    assert np.mean(ways["strike"]) > np.mean(ways["hover"])


def test_percentages_are_of_all_balls():
    tallies = [{"balls": 10, "hits": 1, "hulls": 0}, {"balls": 30, "hits": 9, "hulls": 4}]
    assert percent(tallies) == 25.0
    assert percent(tallies, "hulls") == 10.0


def test_a_spread_is_of_a_sample():
    values = [1.0, 4.0, 4.0, 7.0]
    found = spread(values)
    assert found["mean"] == 4.0
    assert found["sd"] == pytest.approx(statistics.stdev(values))
    assert found["error"] == pytest.approx(statistics.stdev(values) / 2.0)
    assert spread([3.0]) == {"mean": 3.0, "sd": None, "error": None}
