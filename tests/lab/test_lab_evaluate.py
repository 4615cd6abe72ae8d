"""Evaluation: the same numbers for whoever asks, however often, in however many processes."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from lab_bench import LOOKING, RAISING, STILL, write_player

from rotorpong import __version__
from rotorpong.conventions import InputError
from rotorpong.drone import OUTCOMES
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.evaluate import Knowledge, evaluate, header, make_player, summary
from rotorpong.lab.spec import Spec
from rotorpong.physics.camera import GAZEBO

PAPER = Spec(eyes="truth")
KEYS = {
    *("player", "eyes", "vehicle", "camera", "serves", "balls", "seed", "hits", "hit_rate"),
    *("hit_rate_interval", "reachable", "hits_of_reachable", "hit_rate_of_reachable"),
    *("near_hits", "returned", "miss_distance_median_m", "trials"),
    *("racket", "blackout", "randomize", "experience", "contents", "version"),
    *("hit_rate_of_reachable_interval", "ball", "eye_settings", "player_settings", "control"),
}
TRIAL_KEYS = {"index", "outcome", "reachable", "miss_distance_m", "time_error_s", "landing_x_m"}


@pytest.fixture(scope="module")
def paper():
    """Twelve serves of the paper's player with truth eyes, in this process."""
    return evaluate(PAPER, 12)


def test_two_workers_find_what_one_finds_to_the_bit(paper):
    told = []
    shared = evaluate(PAPER, 12, workers=2, progress=lambda *done: told.append(done))
    assert shared == paper
    assert told == [(10, 12), (12, 12)]


def test_the_same_again_is_the_same_and_fewer_balls_are_the_first_of_more(paper):
    again = evaluate(PAPER, 4)
    assert again == paper[:4]
    shown = [json.dumps(summary(PAPER, results)) for results in (again, paper[:4])]
    assert shown[0] == shown[1]


def test_another_seed_is_another_game():
    one, other = (evaluate(Spec("hover", seed=seed), 2) for seed in (0, 1))
    assert [r.miss_distance for r in one] != [r.miss_distance for r in other]


def test_the_summary_has_the_keys_and_types_of_the_contract(paper):
    found = summary(PAPER, paper)
    assert set(found) == KEYS
    assert all(set(trial) == TRIAL_KEYS for trial in found["trials"])
    assert len(found["trials"]) == 12
    assert [trial["index"] for trial in found["trials"]] == list(range(12))
    for key in ("balls", "seed", "hits", "near_hits", "returned", "reachable", "hits_of_reachable"):
        assert type(found[key]) is int
    assert 0.0 <= found["hit_rate_of_reachable"] <= 1.0
    for trial in found["trials"]:
        assert trial["outcome"] in OUTCOMES
        assert type(trial["reachable"]) is bool
        assert type(trial["miss_distance_m"]) is float
        assert (trial["outcome"] == "hit") <= (trial["miss_distance_m"] == 0.0)


def test_the_summary_adds_up(paper):
    found = summary(PAPER, paper)
    hits = sum(trial["outcome"] == "hit" for trial in found["trials"])
    assert (found["hits"], found["hit_rate"]) == (hits, hits / 12)
    low, high = found["hit_rate_interval"]
    assert low <= found["hit_rate"] <= high
    low, high = found["hit_rate_of_reachable_interval"]
    assert low <= found["hit_rate_of_reachable"] <= high
    missed = [t["miss_distance_m"] for t in found["trials"] if t["outcome"] != "hit"]
    assert found["miss_distance_median_m"] == pytest.approx(np.median(missed))


def test_the_summary_names_everything_that_was_asked_for():
    spec = Spec("nearest", "paper", "ardrone2", "gazebo", "hard", 3, racket="rubber")
    spec = replace(spec, randomize=True, blackout=True, control="closed-loop")
    found = summary(spec, (), header(spec, 0, Path("own.sqlite")))
    settings = spec.eye_settings.as_json(spec.eyes, spec.ball)
    of_player = spec.player_settings.as_json(spec.player)
    asked = {**asdict(spec), "eye_settings": settings, "player_settings": of_player}
    assert {key: found[key] for key in asked} == asked
    assert (found["experience"], found["version"]) == ("own.sqlite", __version__)
    assert (summary(spec, ())["experience"], found["contents"]) == (None, {})
    own = replace(spec, camera=replace(GAZEBO, focal_length_px=(370.0, 370.0)))
    assert set(summary(own, ())["contents"]) == {"camera"}


def test_of_nothing_there_are_no_rates():
    found = summary(PAPER, ())
    assert (
        found["hit_rate"] is found["hit_rate_interval"] is found["miss_distance_median_m"] is None
    )


def test_hover_needs_no_eyes():
    seen, dark, truth = (
        evaluate(Spec("hover", eyes, blackout=blackout), 4)
        for eyes, blackout in (("paper", False), ("paper", True), ("truth", False))
    )
    assert seen == dark == truth
    assert not any(result.outcome == "unseen" for result in seen)


def test_in_the_dark_the_papers_player_is_hover():
    dark = evaluate(Spec(blackout=True), 3)
    hover = evaluate(Spec("hover"), 3)
    for one, two in zip(dark, hover, strict=True):
        assert one.outcome == ("unseen" if two.outcome == "miss" else two.outcome)
        assert one.miss_distance == two.miss_distance


def test_paper_eyes_see_and_the_player_answers():
    seen, hover = evaluate(Spec(), 3), evaluate(Spec("hover"), 3)
    assert [r.miss_distance for r in seen] != [r.miss_distance for r in hover]
    assert not any(result.outcome == "unseen" for result in seen)


def test_a_rubber_racket_returns_balls_and_says_where():
    results = evaluate(Spec("hover", racket="rubber"), 18)
    found = summary(Spec("hover", racket="rubber"), results)
    landed = [result.landing_x for result in results if result.landing_x is not None]
    assert found["returned"] == len(landed)
    assert all(0.0 < x <= 1.37 for x in landed)
    assert all(r.landing_x is None for r in results if r.outcome != "hit")


def test_hits_kept_from_training_change_the_player():
    demonstrations = shipped_demonstrations()
    player = make_player(PAPER, Knowledge(demonstrations))
    ball = np.array([0.0, 0.1, 2.4, 0.0, 0.0, -6.0])
    assert np.isfinite(player.hitting_point(ball)).all()
    fewer = make_player(PAPER, Knowledge(demonstrations[:4]))
    assert not np.allclose(player.hitting_point(ball), fewer.hitting_point(ball))


@pytest.mark.parametrize("workers", [1, 2])
def test_too_little_to_learn_from_is_bad_input_for_any_number_of_workers(workers):
    with pytest.raises(InputError, match="1 demonstrations: expected at least 2"):
        evaluate(PAPER, 20, knowledge=Knowledge(shipped_demonstrations()[:1]), workers=workers)


def test_a_users_own_player_plays_and_is_never_taught(tmp_path):
    own = Spec(write_player(tmp_path, STILL))
    results = evaluate(own, 3)
    assert [r.miss_distance for r in results] == [
        r.miss_distance for r in evaluate(Spec("hover"), 3)
    ]
    assert summary(own, results)["player"] == own.player


def test_a_users_own_player_gets_the_eyes_that_were_asked_for(tmp_path):
    name = write_player(tmp_path, LOOKING)
    dark = evaluate(Spec(name, blackout=True), 3)
    assert "unseen" in [result.outcome for result in dark]
    assert "unseen" not in [result.outcome for result in evaluate(Spec(name, "truth"), 3)]


def test_a_users_own_player_is_fresh_for_every_ball(tmp_path):
    text = STILL.replace(
        "class Own:",
        "class Own:\n    def __init__(self):\n        self.balls = 0\n",
    ).replace("while", "self.balls += 1\n        assert self.balls == 1\n        while")
    assert "fault" not in [r.outcome for r in evaluate(Spec(write_player(tmp_path, text)), 2)]


def test_a_player_that_raises_plays_faults_and_the_rest_goes_on(tmp_path, capsys):
    name = write_player(tmp_path, RAISING.format("raise ValueError('no way')"))
    results = evaluate(Spec(name), 2)
    assert [result.outcome for result in results] == ["fault"] * 2
    assert capsys.readouterr().err.count("ValueError: no way") == 2
    found = summary(Spec(name), results)
    json.dumps(found, allow_nan=False)
    assert found["miss_distance_median_m"] is None
    for trial in found["trials"]:
        assert trial["miss_distance_m"] is trial["time_error_s"] is None
