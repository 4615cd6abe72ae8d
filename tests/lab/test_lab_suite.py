"""The frozen benchmark: the same balls, floor and ceiling for ever, and skill on that scale."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest
from lab_bench import LOOKING, STILL, write_player

from rotorpong.conventions import InputError, RotorpongError
from rotorpong.drone import OUTCOMES
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.evaluate import Knowledge, evaluate
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import skill, wilson_interval
from rotorpong.lab.suite.cells import QUICK_BALLS, SUITES, V1
from rotorpong.lab.suite.frozen import (
    LETTERS,
    balls_digest,
    frozen,
    hits_in,
    letters,
    require_frozen,
    suite_digest,
)
from rotorpong.lab.suite.kept import Kept
from rotorpong.lab.suite.playing import Entrant, play_suite
from rotorpong.lab.suite.scores import Score, mean_score, skill_score
from rotorpong.lab.train import knowledge_of, run_of, train
from rotorpong.lab.trial import play_trial, stage_of
from rotorpong.play.hover import Hover

FROZEN = frozen(V1)
SHORT = replace(V1, cells=(V1.cells[0], V1.cells[5], V1.cells[6]))
HOVER = Entrant(Spec("hover", "truth"))
EACH_CELL = pytest.mark.parametrize("cell", V1.cells, ids=lambda cell: cell.name)


@pytest.fixture(scope="module")
def hovered():
    """The first balls of each cell, played by nobody."""
    return play_suite(SHORT, HOVER, quick=True)


def test_the_cells_of_v1_are_what_they_were_when_it_was_frozen():
    """Any other vehicle, camera, serve, seed or count is another suite: make v2, leave v1."""
    told = [
        (c.name, c.vehicle, c.camera, c.camera_pitch_deg, c.serves, c.randomize) for c in V1.cells
    ]
    assert told == [
        ("human", "tum_gazebo", "gazebo", 0.0, "human", False),
        ("human_720p", "tum_gazebo", "ardrone2_720p", 0.0, "human", False),
        ("hard", "tum_gazebo", "gazebo", 0.0, "hard", False),
        ("randomized", "ardrone2", "ardrone2_720p", 0.0, "human", True),
        ("lob", "tum_gazebo", "gazebo", 0.0, "lob", False),
        ("lob_pitched", "tum_gazebo", "gazebo", 15.0, "lob", False),
        ("constant", "tum_gazebo", "gazebo", 0.0, "constant", False),
    ]
    assert {(cell.seed, cell.balls) for cell in V1.cells} == {(2015, 300)}
    assert SUITES == {"v1": V1}


def test_what_is_committed_of_v1_is_what_it_was_when_it_was_frozen():
    assert suite_digest(V1) == "19109167590f92cfa2d27d3f493a16519b3d34d72070657139b94a3e71361cad"
    assert list(FROZEN) == [cell.name for cell in V1.cells]


@EACH_CELL
def test_the_balls_of_v1_are_those_that_were_frozen(cell):
    known = FROZEN[cell.name]
    assert balls_digest(cell, cell.balls) == known.digest
    assert balls_digest(cell, QUICK_BALLS) == known.quick_digest
    require_frozen(cell, known, cell.balls)


@EACH_CELL
@pytest.mark.parametrize("player", ["hover", "oracle"])
def test_floor_and_ceiling_come_out_as_they_did_when_v1_was_frozen(cell, player):
    """So a world that changed is noticed even where the balls are released as before."""
    known = getattr(FROZEN[cell.name], player)
    results = evaluate(cell.spec(Spec(player, "truth")), 6)
    assert letters([result.outcome for result in results]) == known[:6]
    assert len(known) == cell.balls


def test_a_digest_is_of_the_balls_that_a_player_meets():
    """Written out by hand from serves that were played."""
    cell = V1.cells[3]
    stage = stage_of(cell.spec(Spec("hover")))
    lines = []
    for index in range(2):
        serve = play_trial(stage, index, Hover()).serve
        thrown = [*serve.ball.position, *serve.ball.velocity, *serve.ball.spin]
        line = " ".join(f"{number:.3f}" for number in thrown)
        line += "".join(f" {number:.6f}" for number in serve.air + serve.table)
        lines.append(line.replace("-0.000 ", "0.000 ") + "\n")
    assert balls_digest(cell, 2) == hashlib.sha256("".join(lines).encode()).hexdigest()


def test_other_balls_are_another_digest_and_are_refused():
    cell = V1.cells[0]
    digests = {
        balls_digest(one, 3)
        for one in (cell, replace(cell, seed=2016), replace(cell, serves="hard"))
    }
    assert len({*digests, balls_digest(cell, 2)}) == 4
    assert balls_digest(replace(cell, camera="ardrone2_720p"), 3) in digests
    other = replace(cell, seed=2016)
    with pytest.raises(RotorpongError, match=r"cell 'human': the balls thrown here .* frozen"):
        require_frozen(other, FROZEN["human"], QUICK_BALLS)
    with pytest.raises(RotorpongError, match="nothing to compare with"):
        play_suite(replace(V1, cells=(other,)), HOVER, quick=True)


def test_every_outcome_has_a_letter_of_its_own():
    assert set(LETTERS) == set(OUTCOMES)
    assert len(set(LETTERS.values())) == len(OUTCOMES)
    assert letters(["hit", "near_hit", "hit"]) == "hnh"
    assert hits_in("hnmudfh").tolist() == [True, *[False] * 5, True]


def test_hover_is_0_and_the_oracle_1_for_certain():
    hover, oracle = (hits_in(text) for text in (FROZEN["hard"].hover, FROZEN["hard"].oracle))
    assert skill_score(hover, hover, oracle) == Score(0.0, 0.0)
    assert skill_score(oracle, hover, oracle) == Score(1.0, 0.0)
    assert skill_score(oracle, hover, hover) is None
    nothing = skill_score(np.zeros_like(hover), hover, oracle)
    assert nothing.value < 0.0
    assert nothing.interval[0] < nothing.value < nothing.interval[1]


def test_the_interval_of_a_skill_is_that_of_a_bootstrap_over_balls():
    """4000 resamples tell a standard deviation to 1.1 % (1 sigma); 5 % is 4.5 of them."""
    rng = np.random.default_rng(0)
    hover = rng.random(300) < 0.2
    oracle = hover | (rng.random(300) < 0.9)
    player = (hover & (rng.random(300) < 0.8)) | (rng.random(300) < 0.3)
    drawn = rng.integers(300, size=(4000, 300))
    rates = (hits[drawn].mean(axis=1) for hits in (player, hover, oracle))
    values = [skill(*map(float, one)) for one in zip(*rates, strict=True)]
    found = skill_score(player, hover, oracle)
    assert found.value == skill(*(float(hits.mean()) for hits in (player, hover, oracle)))
    assert found.variance**0.5 == pytest.approx(np.std(values), rel=0.05)
    low, high = found.interval
    inside = np.mean((low < np.array(values)) & (np.array(values) < high))
    assert inside == pytest.approx(0.95, abs=0.015)


def test_a_certain_scale_gives_the_interval_of_a_rate():
    """Where hover hits nothing and the oracle all, skill is the rate and its variance p q / n."""
    player = np.arange(400) % 4 == 0
    found = skill_score(player, np.zeros(400, bool), np.ones(400, bool))
    assert found.value == 0.25
    assert found.variance == pytest.approx(0.25 * 0.75 / 399)


def test_the_score_is_the_mean_of_the_cells_skills():
    found = mean_score([Score(0.2, 0.01), Score(0.6, 0.03)])
    assert found.value == pytest.approx(0.4)
    assert found.variance == pytest.approx(0.01)
    assert found.interval == (pytest.approx(0.4 - 0.196, abs=1e-3), pytest.approx(0.596, abs=1e-3))
    assert mean_score([Score(0.2, 0.01), None]) is None
    assert mean_score([]) is None


def test_a_quick_run_is_marked_and_plays_the_first_balls_of_each_cell(hovered):
    assert (hovered["quick"], hovered["comparable"]) == (True, False)
    assert [cell["outcomes"] for cell in hovered["cells"]] == [
        FROZEN[cell.name].hover[:QUICK_BALLS] for cell in SHORT.cells
    ]
    assert hovered["balls"] == QUICK_BALLS * len(SHORT.cells)
    assert (hovered["score"], hovered["score_interval"]) == (0.0, (0.0, 0.0))


def test_a_cell_says_what_evaluate_says_of_the_same_balls(hovered):
    cell, told = V1.cells[5], hovered["cells"][1]
    results = evaluate(cell.spec(Spec("hover", "truth")), QUICK_BALLS)
    hits = sum(result.outcome == "hit" for result in results)
    assert (told["hits"], told["balls"]) == (hits, QUICK_BALLS)
    assert told["hit_rate_interval"] == wilson_interval(hits, QUICK_BALLS)
    assert told["reachable"] == sum(result.reachable for result in results)
    assert told["camera_pitch_deg"] == 15.0
    assert told["hover_hits"] == hits


def test_two_workers_find_what_one_finds_to_the_bit(hovered):
    again = play_suite(SHORT, HOVER, quick=True, workers=2)
    assert json.dumps(again) == json.dumps(hovered)


def test_a_suite_that_was_interrupted_goes_on_and_ends_as_if_it_was_not(hovered, tmp_path):
    kept = Kept(tmp_path / "result.json", resume=True).check()
    told = []

    def stop_in_the_second(cell, done, balls):
        told.append(cell)
        if len(set(told)) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        play_suite(SHORT, HOVER, quick=True, kept=kept, progress=stop_in_the_second)
    assert kept.part.exists()
    assert not kept.out.exists()
    told.clear()
    found = play_suite(
        SHORT, HOVER, quick=True, kept=kept, progress=lambda *one: told.append(one[0])
    )
    assert json.dumps(found) == json.dumps(hovered)
    assert list(dict.fromkeys(told)) == [cell.name for cell in SHORT.cells[1:]]
    kept.finish(found)
    assert not kept.part.exists()
    assert json.loads(kept.out.read_text()) == json.loads(json.dumps(hovered))


def test_what_another_run_left_is_not_gone_on_with(tmp_path):
    kept = Kept(tmp_path / "result.json", resume=True)
    kept.keep({"player": "paper"}, {})
    with pytest.raises(InputError, match=r"result\.json\.part: is of another run; expected"):
        kept.begin({"player": "hover"})
    assert Kept(kept.out).begin({"player": "hover"}) == {}
    for damaged in ("", "{", "[]", '{"head": {}}', '{"head": {}, "cells": 3}', "[" * 100_000):
        kept.part.write_text(damaged)
        with pytest.raises(InputError, match=r"result\.json\.part: cannot be read; expected"):
            kept.begin({})
    with pytest.raises(InputError, match="does not exist"):
        Kept(tmp_path / "gone" / "result.json").check()


def test_a_users_own_player_plays_and_its_file_is_told(tmp_path):
    one, same, other = (
        Entrant(Spec(write_player(tmp_path, text, name), "truth")).check(V1)
        for name, text in (("one.py", STILL), ("same.py", STILL), ("other.py", LOOKING))
    )
    digests = [entrant.as_json()["contents"]["player"] for entrant in (one, same, other)]
    assert digests[0] == digests[1] != digests[2]
    assert digests[0] == digest_by_hand(tmp_path / "one.py")
    found = play_suite(replace(V1, cells=V1.cells[:1]), one, quick=True)
    assert found["cells"][0]["outcomes"] == FROZEN["human"].hover[:QUICK_BALLS]


def digest_by_hand(path):
    """The digest by the rule of `files.digest_of`: name of none, length, bytes."""
    data = path.read_bytes()
    return hashlib.sha256(f"\0{len(data)}\0".encode() + data).hexdigest()


def test_the_result_tells_what_a_learner_learnt_from(tmp_path):
    spec = Spec(eyes="truth", seed=1, player_settings=PlayerSettings(length_scale=12.0))
    train(spec, 1, tmp_path / "run.sqlite")
    run, knowledge = knowledge_of(tmp_path / "run.sqlite")
    found = Entrant(replace(spec, seed=0), knowledge, run).check(V1).as_json()
    learnt = found["experience"]
    assert (learnt["hits"], learnt["balls"]) == (1, len(knowledge.trials))
    assert (learnt["demonstrations"], learnt["seed"], learnt["player"]) == (10, 1, "paper")
    assert learnt["spec"]["player_settings"] == {"length_scale": 12.0}
    assert found["player_settings"]["length_scale"] == 12.0
    untaught = Entrant(spec, Knowledge(knowledge.demonstrations), run).as_json()["experience"]
    assert untaught["digest"] != learnt["digest"]
    assert Entrant(spec).as_json()["experience"] is None


def test_experience_for_a_player_that_uses_none_is_refused():
    known = Knowledge(shipped_demonstrations())
    for player in ("hover", "oracle"):
        with pytest.raises(InputError, match=f"--experience with player '{player}': has no effect"):
            Entrant(Spec(player, "truth"), known).check(V1)
    assert Entrant(Spec("nearest", "truth"), known).check(V1)
    run = run_of(Spec(eyes="truth", seed=2015))
    with pytest.raises(InputError, match="--experience of seed 2015: is a seed of suite v1"):
        Entrant(Spec(eyes="truth"), known, run).check(V1)
    with pytest.raises(InputError, match="player oracle with eyes 'paper'"):
        Entrant(Spec("oracle")).check(V1)
