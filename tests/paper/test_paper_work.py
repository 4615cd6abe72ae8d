"""Work in pieces whose answers are kept."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import knowledge_of
from rotorpong.paper import reproduce
from rotorpong.paper.findings import Job, Scale, Training
from rotorpong.paper.reproduce import ITEMS, chosen_items, command_of, item_of
from rotorpong.paper.work import answers_of, state

TRAINING = Training(Spec(eyes="truth", seed=3), 1)


def counted(path, number):
    """A piece of work that leaves a mark each time it is done."""
    with open(path, "a") as marks:
        marks.write("x")
    return {"square": number**2, "third": number / 3}


def hits(path):
    return sum(trial.outcome == "hit" for trial in knowledge_of(path)[1].trials)


def test_what_was_worked_out_is_not_worked_out_again(tmp_path):
    marks = tmp_path / "marks"
    jobs = {"item": [Job(f"number {k}", counted, (str(marks), k)) for k in (2, 3)]}
    first = answers_of(jobs, tmp_path)
    assert first["item"]["number 3"] == {"square": 9, "third": 1.0}
    assert answers_of(jobs, tmp_path) == first
    assert marks.read_text() == "xx"
    jobs["item"].append(Job("number 4", counted, (str(marks), 4)))
    assert answers_of(jobs, tmp_path)["item"]["number 4"]["square"] == 16
    assert marks.read_text() == "xxx"


def test_other_arguments_are_other_work_although_the_key_is_the_same(tmp_path):
    marks = str(tmp_path / "marks")
    (one,) = answers_of({"item": [Job("it", counted, (marks, 2))]}, tmp_path)["item"].values()
    (two,) = answers_of({"item": [Job("it", counted, (marks, 5))]}, tmp_path)["item"].values()
    assert (one["square"], two["square"]) == (4, 25)


def test_a_training_run_is_played_once_for_all_jobs_that_ask_for_it(tmp_path):
    told = []
    jobs = {
        "one": [Job("a", hits, trainings=(TRAINING,))],
        "other": [Job("a", hits, trainings=(TRAINING,)), Job("b", hits, trainings=(TRAINING,))],
    }
    answers = answers_of(jobs, tmp_path, progress=lambda *what: told.append(what))
    assert answers == {"one": {"a": 1}, "other": {"a": 1, "b": 1}}
    assert ("training runs", 1, 1) in told
    assert len(list((tmp_path / f"work-{state()}" / "runs").glob("*.sqlite"))) == 1


def test_a_file_that_was_not_finished_counts_for_nothing(tmp_path):
    marks = tmp_path / "marks"
    jobs = {"item": [Job("it", counted, (str(marks), 2))]}
    answers_of(jobs, tmp_path)
    (kept,) = (tmp_path / f"work-{state()}" / "item").iterdir()
    kept.rename(kept.with_name(".rotorpong-1-abcd.part.json"))
    assert answers_of(jobs, tmp_path)["item"]["it"]["square"] == 4
    assert marks.read_text() == "xx"


def test_killed_and_begun_again_a_reproduction_ends_with_the_same_numbers(tmp_path):
    killed, whole = tmp_path / "killed", tmp_path / "whole"
    script = (
        "from pathlib import Path; from rotorpong.paper import reproduce\n"
        "from rotorpong.paper.findings import Scale\n"
        f"reproduce(['table2'], Path({str(killed)!r}), scale=Scale(quick=True))"
    )
    process = subprocess.Popen([sys.executable, "-c", script], start_new_session=True)
    until = time.monotonic() + 120.0
    while not list(killed.glob("work-*/table2/*.json")) and time.monotonic() < until:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert not (killed / "results.json").exists()
    again = reproduce(["table2"], killed, scale=Scale(quick=True))
    assert again == reproduce(["table2"], whole, scale=Scale(quick=True))
    assert (killed / "results.json").read_bytes() == (whole / "results.json").read_bytes()
    assert (killed / "page.md").read_bytes() == (whole / "page.md").read_bytes()


def test_every_item_tells_its_title_and_its_work_without_doing_it():
    for name in ITEMS:
        item = item_of(name)
        for scale in (Scale(), Scale(seed=7, quick=True)):
            keys = [job.key for job in item.jobs(scale)]
            assert len(keys) == len(set(keys))
        assert item.TITLE
        assert name in command_of(name, Scale())


def test_items_come_in_the_papers_order_whatever_order_is_asked_for():
    assert chosen_items(["all"]) == ITEMS
    assert chosen_items([ITEMS[-1], ITEMS[0], ITEMS[0]]) == (ITEMS[0], ITEMS[-1])


def test_an_unknown_item_or_none_is_bad_input():
    with pytest.raises(InputError, match="unknown item 'table9': expected one of"):
        chosen_items(["fig6", "table9"])
    with pytest.raises(InputError, match="nothing to reproduce: expected"):
        chosen_items([])


def test_a_folder_that_is_a_file_is_bad_input_before_any_work(tmp_path):
    (tmp_path / "out").write_text("text")
    with pytest.raises(InputError, match="is a file; expected a folder"):
        reproduce(["fig6"], tmp_path / "out", scale=Scale(quick=True))


def test_answers_must_be_plain_numbers(tmp_path):
    jobs = {"item": [Job("nan", float, ("nan",))]}
    with pytest.raises(ValueError, match="not JSON compliant"):
        answers_of(jobs, tmp_path)
    assert json.dumps(float("1e300")) == "1e+300"
