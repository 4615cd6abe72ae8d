"""`rotorpong reproduce`: the paper's numbers from the command line."""

import json

import pytest
from test_cli import ask, complaint, is_one_line_of_json


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_json_is_keyed_by_item_and_is_what_the_folder_holds(here, capfd):
    line = ["reproduce", "fig5", "--out", "out", "--quick", "--workers", "1"]
    status, out, _ = ask(capfd, *line, "--json")
    assert status == 0
    assert is_one_line_of_json(out)
    found = json.loads(out)
    assert list(found) == ["fig5"]
    assert {"paper", "ours", "setting", "command"} <= set(found["fig5"])
    assert found == json.loads((here / "out" / "results.json").read_text())
    for name in ("page.md", "page.html", *found["fig5"]["figures"]):
        assert (here / "out" / name).stat().st_size > 0
    status, out, err = ask(capfd, *line)
    assert status == 0
    assert "Fig. 5" in out
    assert "0.068" in out
    assert "page.html" in err


def test_what_cannot_be_reproduced_is_bad_input(here, capfd):
    (here / "file").write_text("text")
    for line, said in (
        (["table9", "--out", "out"], "unknown item 'table9': expected one of fig"),
        (["--out", "out"], "nothing to reproduce: expected"),
        (["fig5", "--out", "file"], "file: is a file; expected a folder"),
        (["fig5", "--out", "out", "--workers", "-1"], "workers -1: expected a whole number"),
        (["fig5", "--out", "out", "--seed", "-1"], "seed"),
        (["fig5"], "--out"),
    ):
        assert said in complaint(capfd, " ".join(["reproduce", *line]), here)
    assert not (here / "out").exists()
