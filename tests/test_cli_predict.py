"""`rotorpong predict`, met by a hostile user and by one who reads its JSON."""

import json
from pathlib import Path

import pytest
from test_cli import ask, complaint, is_one_line_of_json

EXAMPLE = Path(__file__).parents[1] / "examples" / "flight.csv"
ROWS = [f"{0.01 * i:.2f},{1.2 - 0.05 * i:.3f},0,0.3" for i in range(40)]
FILES = {
    "nan.csv": [*ROWS[:6], "0.06,nan,0,0.3", *ROWS[7:]],
    "back.csv": [*ROWS[:6], "0.02,0.9,0,0.3", *ROWS[7:]],
    "mm.csv": [f"{0.01 * i:.2f},{1200 - 50 * i},0,300" for i in range(40)],
    "ms.csv": [f"{10 * i},{1.2 - 0.05 * i:.3f},0,0.3" for i in range(40)],
    "brief.csv": ROWS[:3],
    "still.csv": [f"0,{1.2 - 0.05 * i:.3f},0,0.3" for i in range(40)],
}
BAD = {
    "predict": "Missing from rotorpong predict: PATH CSV of time and position",
    "predict gone.csv": "gone.csv: no such file",
    "predict text": "text: begins with 'hello'; expected a flight",
    "predict empty": "empty: 0 files, none of them a flight",
    "predict nan.csv": "nan.csv: line 8: 'nan'; expected a finite number",
    "predict back.csv": "back.csv: line 8: time 0.02 s after 0.05 s; expected increasing times",
    "predict mm.csv": "mm.csv: line 2: 1200 m; expected metres",
    "predict ms.csv": "ms.csv: no window of 0.15 s",
    "predict brief.csv": "brief.csv: 3 points; expected at least 5",
    "predict still.csv": "still.csv: every time is 0 s",
    "predict good.csv --ahead-s 0": "ahead-s 0: expected a number from 0.001 to 3",
    "predict good.csv --ahead-s nan": "ahead-s nan: expected a number",
    "predict good.csv --ahead-s soon": "--ahead-s: could not convert string to float",
    "predict good.csv --window-s 0": "window-s 0: expected a number from 0.02 to 3",
    "predict good.csv --window-s 2": "no window of 2 s with a point 0.2 s after it",
    "predict good.csv --window-s inf": "window-s inf: expected a number",
    "predict good.csv --point-sd-mm 0": "point-sd-mm 0: expected a number from 0.001 to 100",
    "predict good.csv --stamp-sd-ms -1": "stamp-sd-ms -1: expected a number from 0 to 50",
    "predict good.csv --table-height-m 760": "table-height-m 760: expected a number",
    "predict good.csv --seed -1": "seed -1: expected a whole number",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_status_2_and_one_line_and_leaves_no_file(tmp_path, monkeypatch, capfd, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("hello")
    (tmp_path / "empty").mkdir()
    for name, rows in {**FILES, "good.csv": ROWS}.items():
        (tmp_path / name).write_text("\n".join(["time_s,x_m,y_m,z_m", *rows]) + "\n")
    assert BAD[line] in complaint(capfd, line, tmp_path)


def test_json_tells_the_error_of_each_model_and_of_each_flight(capfd):
    status, said, err = ask(capfd, "predict", EXAMPLE, "--ahead-s", "0.1", "--json")
    assert (status, err) == (0, "")
    assert is_one_line_of_json(said)
    told = json.loads(said)
    summary = {"median_m", "p90_m", "n"}
    assert summary <= set(told)
    for part in ("drag_only", "gravity_only", "free", "after_bounce", "over_bounce"):
        assert set(told[part]) == summary
    assert told["n"] > 5
    assert 0.0 < told["median_m"] < told["gravity_only"]["median_m"]
    (flight,) = told["flights"]
    assert (flight["flight"], flight["median_m"]) == (str(EXAMPLE), told["median_m"])


def test_without_json_a_table_is_shown(capfd):
    status, said, _ = ask(capfd, "predict", EXAMPLE, "--ahead-s", "0.1")
    assert status == 0
    assert "and spin: the flight filter" in said
