"""The ladder changes one thing a step; what a step buys is counted on the same balls."""

from dataclasses import fields

import pytest

from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import LEARNERS, Spec
from rotorpong.lab.train import train
from rotorpong.paper import ladder
from rotorpong.paper.findings import Scale
from rotorpong.paper.reproduce import as_json
from rotorpong.paper.same_balls import chance, gained, outcomes, pooled, shares


def _played(hits, balls=20, near=0, training=None):
    """Return answers of a player that hits the first balls."""
    rest = balls - hits - near
    return {
        "outcomes": ["hit"] * hits + ["near_hit"] * near + ["miss"] * rest,
        "reachable": [True] * balls,
        "training_balls": training,
        "training_hits": None if training is None else 3,
    }


def _answers():
    made = {rung.label: _played(5, near=2, training=40) for rung in ladder.rungs(0)}
    made[ladder.HOVER] = _played(2)
    made[ladder.WIDE] = _played(11, training=30)
    made[ladder.ORACLE] = _played(20)
    return made


def _changed(one, other):
    """Return which settings differ, those of the player one by one."""
    names = {f.name for f in fields(Spec) if getattr(one, f.name) != getattr(other, f.name)}
    ours, theirs = one.player_settings, other.player_settings
    inside = {f.name for f in fields(ours) if getattr(ours, f.name) != getattr(theirs, f.name)}
    return names, inside


def test_every_rung_can_be_played_and_meets_the_same_balls():
    for rung in ladder.rungs(3):
        spec = rung.spec.check()
        assert (spec.serves, spec.vehicle, spec.camera, spec.seed) == (
            "human", "tum_gazebo", "gazebo", 3
        )  # fmt: skip


def test_a_step_of_the_climb_changes_one_thing():
    steps = {rung.label: rung for rung in ladder.rungs(0)}
    for label, expected in {
        ladder.COMMANDED: ({"player_settings"}, {"labels"}),
        ladder.TUNED: ({"player_settings"}, {"tune"}),
        ladder.WIDE: ({"player_settings"}, {"length_scale", "regularization"}),
        ladder.FLOAT: ({"eye_settings"}, set()),
        ladder.TRACKER: ({"eyes", "eye_settings"}, set()),  # these eyes have no such setting
        ladder.AHEAD: ({"control"}, set()),
        ladder.CLOSED: ({"control"}, set()),
        ladder.TRUE: ({"eyes"}, set()),
    }.items():
        former = steps[steps[label].former]
        assert _changed(steps[label].spec, former.spec) == expected, label


def test_who_learns_trains_and_nobody_else():
    for job, rung in zip(ladder.jobs(Scale()), ladder.rungs(0), strict=True):
        trained = [(one.spec, one.hits) for one in job.trainings]
        learns = rung.spec.player in LEARNERS
        assert trained == ([(rung.spec, ladder.HITS)] if learns else [])


def test_a_step_buys_the_balls_won_less_those_lost():
    lines = {line.label: line.values for line in ladder.findings(Scale(), _answers()).ours}
    wide = lines[ladder.WIDE]
    assert (wide["won"], wide["lost"], wide["former"]) == (6, 0, ladder.COMMANDED)
    assert wide["points"] == pytest.approx(30.0)
    assert wide["p_value"] == pytest.approx(2 * 0.5**6)
    assert lines[ladder.FLOAT]["points"] == pytest.approx(-30.0)
    assert lines[ladder.HOVER].get("points") is None


def test_skill_is_nought_for_hovering_and_one_for_the_oracle():
    lines = {line.label: line.values for line in ladder.findings(Scale(), _answers()).ours}
    assert (lines[ladder.HOVER]["skill"], lines[ladder.ORACLE]["skill"]) == (0.0, 1.0)
    assert lines[ladder.WIDE]["skill"] == pytest.approx((11 - 2) / (20 - 2))


def test_remarks_say_what_chance_would_do_as_well():
    remarks = ladder.findings(Scale(), _answers()).remarks
    assert "wide CrKR +30.0 points, p = 0.031;" in remarks
    assert "feed-forward +0.0 points, p = 1, which chance would do as well" in remarks


def test_the_same_answers_give_the_same_json():
    made = [as_json("ladder", ladder.findings(Scale(), _answers()), Scale()) for _ in range(2)]
    assert made[0] == made[1]
    assert made[0]["figures"] == ["ladder.png"]


def test_outcomes_are_those_of_an_evaluation():
    spec = Spec("hover", seed=2)
    found = outcomes(spec, 6)
    assert found["outcomes"] == [result.outcome for result in evaluate(spec, 6)]
    assert shares(found)["hits"] == found["outcomes"].count("hit")
    assert found["training_balls"] is None


def test_a_trained_player_tells_what_its_training_took(tmp_path):
    spec = Spec(eyes="truth")
    trained = train(spec, 1, tmp_path / "run.sqlite")
    found = outcomes(spec, 3, tmp_path / "run.sqlite")
    assert (found["training_balls"], found["training_hits"]) == (trained.balls, trained.hits)
    assert len(found["outcomes"]) == len(found["reachable"]) == 3


def test_pooled_runs_are_one_run_of_all_their_balls():
    runs = [_played(3, training=10), _played(9, balls=40, training=20)]
    both = shares(pooled(runs))
    assert (both["balls"], both["hits"], both["training_balls"]) == (60, 12, 30)
    assert shares(pooled([_played(1)]))["training_balls"] is None


def test_players_of_other_balls_are_not_compared():
    with pytest.raises(ValueError, match="zip"):
        gained(_played(3, balls=10), _played(3, balls=11))


def test_chance_is_written_as_people_read_it():
    assert [chance(p) for p in (1.0, 0.0312, 2e-9)] == ["p = 1", "p = 0.031", "p < 0.001"]
