"""`rotorpong bench`, met by a hostile user and by one who reads its JSON."""

import json
import math
import subprocess
import sys

import pytest
from test_cli import ask, complaint, is_one_line_of_json

from rotorpong.lab.bench.timing import LIBRARIES

BAD = {
    "bench": "Missing from rotorpong bench: {world,eyes,primitives,learning,control,players}",
    "bench moon": "invalid choice 'moon' for argument 'what'. "
    "Expected one of ('world', 'eyes', 'primitives', 'learning', 'control', 'players')",
    "bench world --seed -1": "seed -1: expected a whole number",
    "bench world --flights gone": "--flights gone: expected a folder of measured flights",
    "bench world --flights text": "--flights text: expected a folder of measured flights",
    "bench world --events gone": "--events gone: no such file or folder of measured events",
    "bench world --out text": "text: is a file; expected a folder",
    "bench world --out text/figures": "expected a folder that can be written",
    "bench world --flights empty --out new": "empty: 0 files, none of them a flight",
    "bench world --flights few": "few: no free flight of 12 points and 0.12 s in 1 recordings",
    "bench world --events empty --out new": "empty: 0 files, none of them with the header",
    "bench world --events text": "text: begins with 'hello'; expected the header",
    "bench world --images few": "--images with bench world: belongs to bench eyes",
    "bench eyes --images gone": "gone: expected a folder of pictures with labels",
    "bench eyes --images empty": "empty: no picture in it or in its folders",
    "bench eyes --ball-class 0": "--ball-class: expected --images beside it",
    "bench players --player hover": "plays anyway or is none; expected FILE.py:CLASS",
    "bench world --quick 3": "Unrecognized options: 3",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_status_2_and_one_line(tmp_path, monkeypatch, capfd, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("hello")
    (tmp_path / "empty").mkdir()
    (tmp_path / "few").mkdir()
    rows = [f"{0.01 * i},{2 - 0.05 * i},0,0.3\n" for i in range(9)]
    (tmp_path / "few" / "flight.csv").write_text("time_s,x_m,y_m,z_m\n" + "".join(rows))
    assert BAD[line] in complaint(capfd, line, tmp_path)


def test_rows_are_one_line_of_json_as_the_contract_says(capfd):
    status, out, _ = ask(capfd, "bench", "world", "--quick", "--json")
    assert status == 0
    assert is_one_line_of_json(out)
    rows = json.loads(out)["rows"]
    names = [row["name"] for row in rows]
    assert len(set(names)) == len(names) > 5
    for row in rows:
        assert math.isfinite(row["value"])
        assert row["unit"]
        assert ("target" in row) == ("met" in row)
        assert row.get("met", True) in {True, False}
        assert "peer" not in row


def test_primitives_are_measured_without_what_they_do_not_need(capfd):
    status, out, _ = ask(capfd, "bench", "primitives", "--quick", "--json")
    assert status == 0
    assert is_one_line_of_json(out)
    rows = {row["name"]: row for row in json.loads(out)["rows"]}
    assert rows["motion: position against DOP853"]["met"] is True
    assert "batch, 240 samples each: peak speed only" in rows
    assert not any("peer" in row for row in rows.values())


def test_what_needs_no_clock_is_met(capfd):
    _, out, _ = ask(capfd, "bench", "world", "--quick", "--json")
    rows = {row["name"]: row for row in json.loads(out)["rows"]}
    for name in (
        "ball position error after 0.7 s",
        "energy drift of a flight with lift only, relative",
        "largest energy gain of a flight with drag",
        "contact time error, any phase",
        "restitution error, any phase",
    ):
        assert rows[name]["met"] is True


def test_the_command_starts_again_with_one_thread_for_every_library():
    code = """
import os, sys
from rotorpong.cli import entry
def become(program, arguments, environment):
    print(arguments[1:], *(environment[name] for name in sys.argv[-1].split(",")))
    raise SystemExit(0)
os.execve = become
sys.argv[1:-1] = ["bench", "world"]
entry.main()
"""
    names = ",".join(f"{library}_NUM_THREADS" for library in LIBRARIES)
    command = [sys.executable, "-c", code, "x", names]
    done = subprocess.run(
        command, capture_output=True, text=True, env={"PYTHONPATH": ":".join(sys.path)}
    )
    assert done.stdout == f"['-m', 'rotorpong', 'bench', 'world', '{names}'] 1 1 1 1 1 1\n", (
        done.stderr
    )
