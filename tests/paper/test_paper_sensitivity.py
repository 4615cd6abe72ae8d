"""One setting is changed at a time, and compared with the default on the same balls."""

from dataclasses import fields, replace

import pytest

from rotorpong.lab.spec import Spec
from rotorpong.paper import sensitivity
from rotorpong.paper.findings import Scale
from rotorpong.paper.reproduce import as_json
from rotorpong.paper.same_balls import outcomes
from rotorpong.world.serves import HUMAN

QUICK = Scale(quick=True)


def _played(kind, hits, balls=10):
    trained = 12 if kind != "hover" else None
    return {
        "outcomes": ["hit"] * hits + ["miss"] * (balls - hits),
        "reachable": [True] * balls,
        "training_balls": trained,
        "training_hits": None if trained is None else 2,
    }


def _answers(scale, hits=None):
    """Return answers to all jobs: so many hits by what a key begins with, else 4; 1 if hovering."""
    return {
        job.key: _played(job.arguments[0].player, _hits(job, hits or {}))
        for job in sensitivity.jobs(scale)
    }


def _hits(job, hits):
    usual = 1 if job.arguments[0].player == "hover" else 4
    return next((n for name, n in hits.items() if job.key.startswith(name)), usual)


def _lines(hits=None, scale=QUICK):
    found = sensitivity.findings(scale, _answers(scale, hits))
    return {line.label: line.values for line in found.ours}


def test_one_setting_is_changed_at_a_time():
    usual = Spec()
    for change in sensitivity.changes()[1:]:
        spec = change.spec.check()
        names = {f.name for f in fields(Spec) if getattr(spec, f.name) != getattr(usual, f.name)}
        assert len(names) == 1, change.label
        given = [v for v in (getattr(spec.player_settings, f.name)
                             for f in fields(spec.player_settings)) if v is not None]  # fmt: skip
        assert len(given) == (names == {"player_settings"}), change.label


def test_keys_of_jobs_are_unique_and_seeds_differ():
    jobs = sensitivity.jobs(Scale(seed=7))
    assert len({job.key for job in jobs}) == len(jobs)
    assert {job.arguments[0].seed for job in jobs} == {7, 8}


def test_a_window_holds_all_targets_and_of_one_is_the_usual_window():
    assert replace(sensitivity.window(1.0), name=HUMAN.name) == HUMAN
    half = sensitivity.window(0.5)
    assert half.target_left == (-0.2, 0.2)
    assert half.target_up == (-0.1, 0.1)


def test_a_narrow_window_is_easier_for_who_hovers():
    hits = [
        outcomes(Spec("hover", serves=sensitivity.window(factor)), 12)["outcomes"].count("hit")
        for factor in (0.1, 1.0)
    ]
    assert hits[0] == 12  # within 4 cm of the blade's middle
    assert hits[1] < 6


def test_a_setting_is_compared_with_the_default_of_the_same_eyes():
    lines = _lines({"plane at 2.0 m, truth": 10, "labels achieved": 1})
    near = lines["truth: plane at 2.0 m"]
    assert (near["won"], near["lost"]) == (6, 0)
    assert near["p_value"] == pytest.approx(2 * 0.5**6)
    assert lines["vision: labels achieved"]["points"] == pytest.approx(-30.0)
    assert "p_value" not in lines["vision: default"]


def test_other_balls_have_a_difference_but_no_test():
    lines = _lines({"serve window x 0.5, vision": 9, "serve window x 0.5, hover": 5})
    narrow = lines["vision: serve window x 0.5"]
    assert narrow["points"] == pytest.approx(50.0)
    assert "p_value" not in narrow
    assert narrow["skill"] == pytest.approx((0.9 - 0.5) / (1.0 - 0.5))


def test_remarks_name_what_is_told_apart_from_the_default():
    hits = {"60 frames/s, truth": 10}
    remarks = sensitivity.findings(QUICK, _answers(QUICK, hits)).remarks
    apart, alike = (
        next(part for part in remarks.split("\n\n") if part.startswith(begin))
        for begin in ("Told apart", "Not told apart")
    )
    assert "60 frames/s with truth (+60.0 points" in apart
    assert "60 frames/s with vision" in alike


def test_seeds_are_pooled():
    whole = Scale()
    line = _lines(scale=whole)["vision: default"]
    assert (line["balls"], line["hits"], line["training_balls"]) == (20, 8, 24)


def test_the_same_answers_give_the_same_json():
    made = [
        as_json("sensitivity", sensitivity.findings(QUICK, _answers(QUICK)), QUICK)
        for _ in range(2)
    ]
    assert made[0] == made[1]
