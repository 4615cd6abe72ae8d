"""Fig. 7b: averages over seeds, where plateaus begin, and one run played for real."""

import json
from dataclasses import replace

import pytest

from rotorpong.lab.bench.player_rows import until
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import knowledge_of, train
from rotorpong.paper import fig7b
from rotorpong.paper.findings import Scale
from rotorpong.paper.reproduce import as_json

QUICK = Scale(0, quick=True)


def one(own_hits, hits, near=0, on_hull=0):
    return {
        **{"own_hits": own_hits, "balls": 20, "hits": hits, "near_hits": near},
        **{"near_hulls": on_hull, "hulls": on_hull + 2, "moved_m2": 0.1},
    }


ANSWERS = {
    "truth 0": [one(0, 2), one(3, 4), one(6, 6)],
    "truth 1": [one(0, 4), one(3, 8), one(6, 10)],
    "vision 0": [one(0, 2, 1, 3), one(3, 4), one(6, 4, 1, 2)],
    "vision 1": [one(0, 2, 3, 1), one(3, 4), one(6, 4, 2, 3)],
}


def test_lines_are_means_and_deviations_over_seeds():
    lines = {line.label: line.values for line in fig7b.findings(QUICK, ANSWERS).ours}
    assert len(lines) == 6
    end = lines["truth, 6"]
    assert end["hit_percent"] == 40.0
    assert end["hit_percent_sd"] == pytest.approx(20.0 / 2**0.5)
    assert end["hit_percent_by_seed"] == [30.0, 50.0]
    assert end["balls"] == 40
    begin = lines["vision, 0"]
    assert begin["near_hit_percent"] == 10.0
    assert begin["near_hull_percent"] == 10.0
    assert begin["near_percent"] == 20.0
    assert begin["near_percent_sd"] == 0.0
    assert begin["hull_percent"] == 20.0


def test_words_follow_numbers():
    said = fig7b.findings(QUICK, ANSWERS).remarks
    assert "Vision: from 10.0 % to 20.0 % after 6 own hits." in said
    assert "less than the paper's 30 %" in said
    assert "after 3 own hits with vision and 5 with true states" in said
    assert "sooner, as in the paper" in said
    assert "standard errors of up to 10.0 points" in said
    assert "are fewer than the hits" in said
    swapped = {
        key: ANSWERS[f"{'truth' if 'vision' in key else 'vision'}{key[-2:]}"] for key in ANSWERS
    }
    said = fig7b.findings(QUICK, swapped).remarks
    assert "no less than the paper's 30 %" in said
    assert "no sooner, unlike in the paper" in said


def test_same_answers_give_the_same_plain_json():
    texts = {
        json.dumps(as_json("fig7b", fig7b.findings(QUICK, ANSWERS), QUICK), allow_nan=False)
        for _ in range(2)
    }
    assert len(texts) == 1


@pytest.mark.parametrize(
    ("percents", "begins"),
    [
        ([10.0, 20.0, 30.0], 90.0),  # a straight line
        ([10.0, 30.0, 30.0], 45.0),
        ([10.0, 30.0, 20.0], 22.5),  # passes its end on the way
        ([10.0, 40.0, 10.0], None),  # no gain
    ],
)
def test_a_plateau_begins_at_nine_tenths_of_the_gain(percents, begins):
    assert fig7b.plateau([0.0, 50.0, 100.0], percents) == pytest.approx(begins)


def test_both_eyes_meet_the_same_balls_and_each_seed_others():
    whole = [fig7b.runs(Scale(7), label) for label in fig7b.EYES]
    for truth, vision in zip(*whole, strict=True):
        assert replace(truth.spec, eyes="paper") == vision.spec
        assert truth.hits == vision.hits == 170
    assert [run.spec.seed for run in whole[0]] == list(range(7, 17))
    keys = [job.key for job in fig7b.jobs(Scale(7))]
    assert len(set(keys)) == len(keys) == 20


def test_a_run_is_measured_after_each_mark_with_that_many_hits(tmp_path):
    spec, path = Spec(eyes="truth", seed=2), tmp_path / "run"
    train(spec, 2, path)
    known = knowledge_of(path)[1]
    found = fig7b.played(spec, (0, 1, 9), 5, path)
    assert [tally["own_hits"] for tally in found] == [0, 1, 2]
    taught = replace(known, trials=until(known.trials, 1))
    outcomes = [result.outcome for result in evaluate(spec, 5, knowledge=taught)]
    assert found[1]["hits"] == outcomes.count("hit")
    assert found[1]["hulls"] == outcomes.count("hull")
