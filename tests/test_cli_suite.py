"""`rotorpong suite`, met by a hostile user and by one who reads its JSON."""

import json
import subprocess
import sys

import pytest
from test_cli import HEAVY, ask, complaint, is_one_line_of_json

from rotorpong.cli.suite import Suite
from rotorpong.experience import create
from rotorpong.lab.spec import Spec
from rotorpong.lab.suite.entries import read_entry
from rotorpong.lab.train import run_of

BAD = {
    "suite": "Missing from rotorpong suite: {v1}",
    "suite v2": "invalid choice 'v2' for argument 'what'. Expected one of ('v1',)",
    "suite v1 --seed 1": "--seed 1: the seeds of a suite are fixed; expected none",
    "suite v1 --seed -1": "seed -1: expected a whole number",
    "suite v1 --balls 10": "--balls",
    "suite v1 --serves lob": "--serves",
    "suite v1 --vehicle ardrone2": "--vehicle",
    "suite v1 --camera gazebo": "--camera",
    "suite v1 --ball white": "--ball",
    "suite v1 --randomize": "--randomize",
    "suite v1 --player nobody": "unknown player 'nobody': expected one of hover",
    "suite v1 --player gone.py:Own": "no file 'gone.py'; expected FILE.py:CLASS",
    "suite v1 --player oracle": "player oracle with eyes 'paper': expected eyes truth",
    "suite v1 --player hover --length-scale 3": "with player 'hover': has no effect; expected",
    "suite v1 --eyes radar": "unknown eyes 'radar'",
    "suite v1 --experience gone.sqlite": "gone.sqlite: does not exist",
    "suite v1 --experience text": "text: not an experience file",
    "suite v1 --player hover --experience own.sqlite": "--experience with player 'hover': has no",
    "suite v1 --workers 0": "workers 0: expected a whole number",
    "suite v1 --resume": "--resume: expected --out beside it",
    "suite v1 --out empty": "empty: is a folder; expected a file",
    "suite v1 --out gone/result.json": "the folder gone does not exist",
    "suite v1 --player hover --resume --out damaged.json": "damaged.json.part: cannot be read",
    "suite v1 --player hover --resume --out other.json": "other.json.part: is of another run",
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("hello")
    (tmp_path / "empty").mkdir()
    (tmp_path / "damaged.json.part").write_text("{")
    (tmp_path / "other.json.part").write_text('{"head": {"player": "paper"}, "cells": {}}')
    with create(tmp_path / "own.sqlite", run_of(Spec())):
        pass
    return tmp_path


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_status_2_and_one_line(here, capfd, line):
    assert BAD[line] in complaint(capfd, line, here)


def test_a_quick_run_prints_one_line_of_json_writes_it_and_is_no_entry(here, capfd):
    (here / "result.json").write_text("what was there before")
    line = "suite v1 --player hover --eyes truth --quick --out result.json"
    status, out, err = ask(capfd, *line.split(), "--json")
    assert (status, err) == (0, "")
    assert is_one_line_of_json(out)
    told = json.loads(out)
    assert json.loads((here / "result.json").read_text()) == told
    assert told["command"] == "rotorpong suite v1 --player hover --eyes truth --quick"
    assert (told["suite"], told["quick"], told["comparable"]) == ("v1", True, False)
    assert not (here / "result.json.part").exists()
    with pytest.raises(ValueError, match="is a quick run"):
        read_entry(here / "result.json")


def test_the_command_in_the_result_names_all_that_decides_it_and_nothing_else():
    plain = Suite(what="v1", json=True, workers=2)
    assert plain.command() == "rotorpong suite v1 --player paper --eyes paper"
    rich = Suite(
        what="v1",
        player="my players/own.py:Own",
        eyes="tracker",
        tune=True,
        length_scale=12.0,
        control="feed-forward",
    )
    assert rich.command() == (
        "rotorpong suite v1 --player 'my players/own.py:Own' --eyes tracker --length-scale 12.0 "
        "--tune --control feed-forward"
    )


def test_help_names_no_flag_that_a_suite_fixes_and_loads_nothing_heavy():
    code = (
        "import sys, rotorpong.cli.entry as entry\n"
        "try:\n    entry._run(['suite', '--help'])\nexcept SystemExit:\n    pass\n"
        f"print('LOADED', [name for name in {HEAVY!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    shown, _, loaded = done.stdout.partition("LOADED")
    assert "--player" in shown
    for fixed in ("--vehicle", "--camera", "--serves", "--ball ", "--randomize"):
        assert fixed not in shown
    assert loaded.strip() == "[]"
