"""Section V on the robot: what is pooled, what is said of it, and one job played for real."""

import json
from dataclasses import replace

import pytest

from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import wilson_interval
from rotorpong.lab.train import knowledge_of, train
from rotorpong.paper import real
from rotorpong.paper.findings import Scale
from rotorpong.paper.reproduce import as_json

WHOLE, QUICK = Scale(), Scale(0, quick=True)


def one(hits, balls=20):
    return {
        **{"balls": balls, "hits": hits, "near_hits": 1, "near_hulls": 2, "hulls": 5},
        "moved_m2": 4e-4 * balls,
    }


def made(scale, after):
    """Return answers in which `after(vehicle, test, k)` balls are hit after learning."""
    found = {}
    for job in real.jobs(scale):
        vehicle, test, k = job.key.split(", ")
        found[job.key] = {
            **{"hover": one(1), "before": one(2), "after": one(after(vehicle, test, int(k)))},
            **{"own_hits": int(k) % 2, "training_balls": 30},
        }
    return found


def test_balls_are_pooled_and_repetitions_spread():
    answers = made(WHOLE, lambda vehicle, test, k: 8 if k < 4 else 4)
    values = {line.label: line.values for line in real.findings(WHOLE, answers).ours}
    after = values["as ported, 1 primitive, after"]
    assert after["balls"] == 16 * 20
    assert after["hit_percent"] == 25.0
    low, high = wilson_interval(80, 320)
    assert after["hit_percent_interval"] == pytest.approx([100.0 * low, 100.0 * high])
    assert after["hit_percent_by_repetition"] == [40.0, 20.0, 20.0, 20.0]
    assert after["hit_percent_sd"] == pytest.approx(10.0)
    assert after["moved_cm"] == pytest.approx(2.0)
    assert after["own_hits"] == 0.5
    assert after["trainings_without_hit"] == 8
    before = values["as ported, 1 primitive, before"]
    assert before["own_hits"] == 0.0
    assert before["hit_percent"] == 10.0
    assert values["with a velocity loop, 10 primitives, after"]["hit_percent_sd"] is None


def test_words_follow_numbers():
    said = real.findings(WHOLE, made(WHOLE, lambda vehicle, test, k: 8)).remarks
    assert "As ported, 1 primitive: 10.0 % before and 40.0 % after 0.5 own hits" in said
    assert "+30.0 points where the paper has +12.5. 8 of 16 trainings hit nothing" in said
    said = real.findings(WHOLE, made(WHOLE, lambda vehicle, test, k: 2)).remarks
    assert "+0.0 points where the paper has +12.5, within what chance does." in said


def test_same_answers_give_the_same_plain_json():
    answers = made(QUICK, lambda vehicle, test, k: 3)
    texts = {
        json.dumps(as_json("real", real.findings(QUICK, answers), QUICK), allow_nan=False)
        for _ in range(2)
    }
    assert len(texts) == 1


def test_both_vehicles_meet_the_same_throws_with_parameters_of_the_simulator():
    jobs = {job.key: job.trainings[0] for job in real.jobs(WHOLE)}
    assert len(jobs) == len(real.jobs(WHOLE)) == 2 * (16 + 1)
    for key, training in jobs.items():
        other = jobs[key.replace("as ported", "with a velocity loop")]
        assert replace(training.spec, vehicle=other.spec.vehicle) == other.spec
        changed = replace(training.spec.player_settings, primitive=None)
        assert changed == PlayerSettings()
        assert training.spec.control is None


def test_four_primitives_take_turns_and_each_meets_throws_of_its_own():
    alone = [
        job.trainings[0].spec for job in real.jobs(WHOLE) if job.key.startswith("as ported, 1 ")
    ]
    assert [spec.player_settings.primitive for spec in alone] == [0, 1, 2, 3] * 4
    assert len({spec.seed for spec in alone}) == 16
    assert {(spec.player, spec.serves) for spec in alone} == {("single", "constant")}


def test_the_same_balls_are_played_hovering_before_and_after(tmp_path):
    spec = Spec(
        "single", eyes="truth", serves="constant", player_settings=PlayerSettings(primitive=1)
    )
    path = tmp_path / "run"
    train(spec, 1, path)
    known = knowledge_of(path)[1]
    found = real.compared(spec, 4, path)
    assert found["own_hits"] == sum(trial.outcome == "hit" for trial in known.trials)
    assert found["training_balls"] == len(known.trials)
    who = {
        "hover": (replace(spec, player="hover", player_settings=PlayerSettings()), None),
        "after": (spec, known),
    }
    for stage, (played, taught) in who.items():
        outcomes = [result.outcome for result in evaluate(played, 4, knowledge=taught)]
        assert found[stage]["hits"] == outcomes.count("hit")
        assert found[stage]["hulls"] == outcomes.count("hull")
