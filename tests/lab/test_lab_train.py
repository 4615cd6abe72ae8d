"""A trial acknowledged is a trial kept, whatever is done to the process."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lab_bench import STILL, write_player

from rotorpong.conventions import InputError, StoreError
from rotorpong.experience import create, open_store, shipped_demonstrations
from rotorpong.experience.truth import truth_rows
from rotorpong.lab.evaluate import Knowledge, evaluate
from rotorpong.lab.eye_settings import EyeSettings
from rotorpong.lab.serve_files import write_serves
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import MOST_BALLS_PER_HIT, knowledge_of, run_of, train
from rotorpong.physics.camera import GAZEBO
from rotorpong.vision.colour import WHITE
from rotorpong.vision.colour_files import colour_text

SPEC = Spec(eyes="truth", seed=4)
HITS = 2
COMMAND = [*(sys.executable, "-m", "rotorpong", "train", "--eyes", "truth", "--seed", "4")]


def rows(path):
    """Every row of every table, as text."""
    with sqlite3.connect(path) as connection:
        return list(connection.iterdump())


def kept(path):
    try:
        with open_store(path, readonly=True) as store:
            return store.count()
    except StoreError:
        return 0


def start(path, *more, hits=HITS):
    return subprocess.Popen(
        [*COMMAND, "--hits", str(hits), "--out", str(path), "--json", *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def interrupt(process, path, trials, kind):
    """Send a signal once so many trials are kept, or when the process ends before."""
    while kept(path) < trials and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(kind)
    return process.communicate(timeout=60)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """A run that nobody disturbed, and how it stood at the end."""
    path = tmp_path_factory.mktemp("trained") / "run.sqlite"
    told = []
    done = train(SPEC, HITS, path, progress=lambda *state: told.append(state))
    assert told[-1] == (done.hits, HITS)
    assert len(told) == done.balls
    return path, done


def test_a_run_killed_again_and_again_ends_as_if_nothing_had_happened(trained, tmp_path):
    path, more = tmp_path / "run.sqlite", ()
    for trials in (1, 4):
        process = start(path, *more)
        interrupt(process, path, trials, signal.SIGKILL)
        more = ("--resume",)
    before = kept(path)
    assert 0 < before < trained[1].balls
    assert train(SPEC, HITS, path, resume=True) == trained[1]
    assert rows(path) == rows(trained[0])


def test_ctrl_c_is_status_130_and_leaves_a_run_to_go_on_with(trained, tmp_path):
    path = tmp_path / "run.sqlite"
    process = start(path, hits=50)
    out, err = interrupt(process, path, 2, signal.SIGINT)
    assert (process.returncode, out, err) == (130, "", "rotorpong: interrupted\n")
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.sqlite"]
    assert kept(path) >= 2
    assert train(SPEC, HITS, path, resume=True).hits >= HITS
    kept_rows = set(rows(path))
    assert set(rows(trained[0])) <= kept_rows or kept_rows <= set(rows(trained[0]))


def test_a_finished_run_resumed_stays_as_it_is(trained):
    before = rows(trained[0])
    assert train(SPEC, HITS, trained[0], resume=True) == trained[1]
    assert rows(trained[0]) == before


def test_a_short_run_is_the_beginning_of_a_long_one(trained, tmp_path):
    path = tmp_path / "run.sqlite"
    short = train(SPEC, 1, path)
    assert short.hits == 1
    assert train(SPEC, HITS, path, resume=True) == trained[1]
    assert rows(path) == rows(trained[0])


def test_it_stops_at_the_hit_that_was_asked_for(trained):
    path, done = trained
    with open_store(path, readonly=True) as store:
        trials = store.trials()
        truths = truth_rows(store)
        assert store.demonstrations() == shipped_demonstrations()
    assert done.hits == HITS == sum(trial.outcome == "hit" for trial in trials)
    assert trials[-1].outcome == "hit"
    assert done.balls == len(trials) <= MOST_BALLS_PER_HIT * HITS
    assert [t.index for t in trials] == [t.index for t in truths] == list(range(done.balls))
    assert done.as_json() == {
        "balls": done.balls,
        "hits": HITS,
        "hit_rate": HITS / done.balls,
    }


def test_rewards_and_attempts_are_those_of_the_outcomes(trained):
    with open_store(trained[0], readonly=True) as store:
        for trial, truth in zip(store.trials(), truth_rows(store), strict=True):
            is_hit = trial.outcome == "hit"
            assert is_hit == (truth.miss_distance == 0.0) == (trial.contact_time is not None)
            assert (0.5 - 1e-9 < trial.reward <= 1.0) if is_hit else trial.reward == 0.0
            if is_hit:
                assert trial.reward == pytest.approx(1.0 - 0.5 * trial.contact_offset)
            assert trial.attempt is None or trial.attempt.mixture_weights.sum() == pytest.approx(1)


def test_what_was_learnt_makes_another_player(trained):
    run, knowledge = knowledge_of(trained[0])
    assert (run.player, run.eyes, run.seed, run.pilot) == ("paper", "truth", 4, "scripted")
    taught = evaluate(SPEC, 2, knowledge=knowledge)
    untaught = evaluate(SPEC, 2, knowledge=Knowledge(knowledge.demonstrations))
    assert [r.miss_distance for r in taught] != [r.miss_distance for r in untaught]
    assert taught == evaluate(SPEC, 2, knowledge=knowledge)


def test_a_file_in_the_way_is_not_touched(trained):
    before = trained[0].read_bytes()
    with pytest.raises(StoreError, match="exists; use --resume to go on with it"):
        train(SPEC, HITS, trained[0])
    assert trained[0].read_bytes() == before


@pytest.mark.parametrize(
    ("other", "field"),
    [
        (Spec(eyes="truth", seed=5), "seed is 4, given 5"),
        (Spec("paper", "truth", seed=4, racket="rubber"), 'is "cardboard", given "rubber"'),
    ],
)
def test_another_run_cannot_be_resumed_and_is_told_why(trained, other, field):
    before = rows(trained[0])
    with pytest.raises(StoreError, match="is another run") as refusal:
        train(other, HITS, trained[0], resume=True)
    assert field in str(refusal.value)
    assert rows(trained[0]) == before


def write_camera(path, focal):
    lens = {"fx": focal, "fy": focal, "cx": 320.5, "cy": 180.5, "width": 640, "height": 360}
    path.write_text(json.dumps(lens))


def test_a_file_of_a_run_may_be_renamed_but_not_changed(tmp_path):
    """Resume compares what the files hold, not what they are called."""
    camera, serves, run = tmp_path / "c.json", tmp_path / "s.csv", tmp_path / "run.sqlite"
    write_camera(camera, 370)
    serve = serve_source("human", 0)(0, np.random.default_rng(0))
    write_serves(serves, [serve])
    spec = Spec(eyes="truth", camera=str(camera), serves=str(serves))
    short = train(spec, 1, run)
    (tmp_path / "moved").mkdir()
    moved = replace(
        spec,
        camera=str(camera.rename(tmp_path / "moved" / "other.json")),
        serves=str(serves.rename(tmp_path / "moved" / "other.csv")),
    )
    assert train(moved, 1, run, resume=True) == short
    before = rows(run)
    write_camera(Path(moved.camera), 380)
    with pytest.raises(
        StoreError, match=r"another run: camera is a file with sha256 .*, given a f"
    ):
        train(moved, 1, run, resume=True)
    write_camera(Path(moved.camera), 370)
    write_serves(Path(moved.serves), [serve, serve])
    with pytest.raises(StoreError, match="another run: serves is a file with sha256"):
        train(moved, 1, run, resume=True)
    with pytest.raises(StoreError, match='given "gazebo"'):
        train(replace(spec, camera="gazebo", serves=moved.serves), 1, run, resume=True)
    assert rows(run) == before


def test_a_camera_of_ones_own_is_not_the_profile_whose_name_it_has(tmp_path):
    run = tmp_path / "run.sqlite"
    done = train(SPEC, 1, run)
    assert train(replace(SPEC, camera=GAZEBO), 1, run, resume=True) == done
    own = replace(GAZEBO, focal_length_px=(370.0, 370.0))
    with pytest.raises(StoreError, match="another run: camera is"):
        train(replace(SPEC, camera=own), 1, run, resume=True)


def test_a_run_with_other_balls_or_eyes_cannot_be_resumed_and_one_that_says_the_same_can(tmp_path):
    run, colour = tmp_path / "run.sqlite", tmp_path / "colour.json"
    seen = Spec(eyes="paper", seed=4, ball="white", eye_settings=EyeSettings("pratt"))
    with create(run, run_of(seen)):
        pass
    said = EyeSettings("pratt", "whole", "white")
    with open_store(run) as store:
        store.check_run(run_of(replace(seen, eye_settings=said)))
        colour.write_text(colour_text(replace(WHITE, name="mine")))
        store.check_run(run_of(replace(seen, eye_settings=replace(said, colour=str(colour)))))
        colour.write_text(colour_text(replace(WHITE, typical=(91, 20, 235))))
        for other, field in (
            (replace(seen, ball="orange"), 'spec.ball is "white", given absent'),
            (replace(seen, eye_settings=EyeSettings("taubin")), '"pratt"}, given {"circle_fit"'),
            (replace(seen, eye_settings=EyeSettings("pratt", "float")), "spec.eye_settings is"),
            (
                replace(seen, eye_settings=replace(said, colour=str(colour))),
                "colour is absent, given a file with sha256",
            ),
        ):
            with pytest.raises(StoreError, match="is another run") as refusal:
                store.check_run(run_of(other))
            assert field in str(refusal.value)


def test_a_run_as_the_paper_has_it_says_nothing_of_balls_and_eyes():
    assert run_of(Spec()).spec == {"racket": "cardboard", "blackout": False}
    explicit = EyeSettings("kasa", "whole", "orange")
    assert run_of(Spec(eye_settings=explicit)).spec == run_of(Spec()).spec


def test_players_that_cannot_learn_are_refused(tmp_path):
    for player in ("hover", write_player(tmp_path, STILL)):
        with pytest.raises(InputError, match="cannot learn: expected one of single, paper, bandit"):
            train(Spec(player), 1, tmp_path / "run.sqlite")
    assert not (tmp_path / "run.sqlite").exists()


def test_bad_input_leaves_no_file_behind(tmp_path):
    path = tmp_path / "run.sqlite"
    with pytest.raises(InputError, match="1 demonstrations: expected at least 2"):
        train(SPEC, 1, path, demonstrations=shipped_demonstrations()[:1])
    with pytest.raises(InputError, match=r"serves 'gone\.csv'"):
        train(Spec(eyes="truth", serves="gone.csv"), 1, path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["", ".", "..", os.sep])
def test_a_folder_is_no_experience_file(tmp_path, monkeypatch, place):
    monkeypatch.chdir(tmp_path)
    for resume in (False, True):
        with pytest.raises(InputError, match="is a folder; expected a file"):
            train(SPEC, 1, Path(place), resume=resume)


def test_a_damaged_file_is_refused_and_stays(trained, tmp_path):
    whole = trained[0].read_bytes()
    path = tmp_path / "run.sqlite"
    for content in (b"", b"hello", whole[: len(whole) // 2], b"\0" * len(whole)):
        path.write_bytes(content)
        with pytest.raises(StoreError, match=r"run\.sqlite: "):
            knowledge_of(path)
        assert path.read_bytes() == content
    with pytest.raises(StoreError, match=r"run\.sqlite: "):
        train(SPEC, HITS, path, resume=True)
    assert path.read_bytes() == content
