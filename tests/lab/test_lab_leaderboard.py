"""What a leaderboard takes, and that its page is made of what is committed."""

import importlib.util
import json
import re
from pathlib import Path

import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.suite.cells import V1
from rotorpong.lab.suite.entries import read_entry
from rotorpong.lab.suite.frozen import frozen

DOCS = Path(__file__).resolve().parents[2] / "docs"
ENTRIES = sorted((DOCS / "leaderboard").glob("*.json"))
HOVER = DOCS / "leaderboard" / "hover.json"


@pytest.fixture(scope="module")
def maker():
    """The script that makes the page."""
    spec = importlib.util.spec_from_file_location("make_leaderboard", DOCS / "make_leaderboard.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def refused(tmp_path, change):
    """What is said of hover's result after `change` was made to it."""
    found = json.loads(HOVER.read_text())
    change(found)
    (tmp_path / "entry.json").write_text(json.dumps(found))
    with pytest.raises(InputError, match="expected what `rotorpong suite` writes") as error:
        read_entry(tmp_path / "entry.json")
    said = str(error.value)
    assert "\n" not in said
    assert said.startswith("entry.json: ")
    return said


@pytest.mark.parametrize("path", ENTRIES, ids=lambda path: path.stem)
def test_every_result_of_the_leaderboard_is_one(path):
    """It carries command, version and digest, is not quick, and adds up."""
    found = read_entry(path)
    assert found["command"].startswith(f"rotorpong suite v1 --player {found['player']} ")
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*", found["version"])
    assert path.stat().st_size < 20_000


def test_the_page_is_what_the_results_make(maker):
    assert (DOCS / "leaderboard.md").read_text() == maker.page(
        maker.read_entries(DOCS / "leaderboard")
    )


def test_hover_and_oracle_on_the_leaderboard_are_the_committed_floor_and_ceiling():
    known = frozen(V1)
    for player, score in (("hover", 0.0), ("oracle", 1.0)):
        found = read_entry(DOCS / "leaderboard" / f"{player}.json")
        assert found["score"] == score
        for cell in found["cells"]:
            assert cell["outcomes"] == getattr(known[cell["name"]], player)


def test_our_own_results_are_of_the_commands_that_play_them(maker):
    """Flag by flag; their order in a result is that of the help."""
    for name, flags in maker.OURS.items():
        path = DOCS / "leaderboard" / f"{name}.json"
        if path.exists():
            words = read_entry(path)["command"].replace(".0 ", " ").split()[3:]
            assert sorted(words) == sorted(flags.split())


def test_the_best_come_first_and_those_who_are_told_the_truth_stand_apart(maker):
    entries = maker.read_entries(DOCS / "leaderboard")
    scores = [one["score"] for one in entries.values()]
    assert scores == sorted(scores, reverse=True)
    page = maker.page(entries)
    seen, told = page.split("## Told the truth")
    for name, one in entries.items():
        where = told if one["eyes"] == "truth" else seen
        assert f"[{name}](#{name})" in where
        assert f"    {one['command']}\n" in told


def test_what_does_not_add_up_is_refused(tmp_path):
    """A hit more, in the numbers or in the outcomes, is noticed; so is another score."""

    def hit_more(found):
        found["cells"][2]["hits"] += 1

    def outcome(found):
        text = found["cells"][2]["outcomes"]
        found["cells"][2]["outcomes"] = "h" + text[1:]

    def score(found):
        found["score"] = 0.5

    def reachable(found):
        found["cells"][0]["reachable"] = 301

    assert "does not add up in cell hard (hits)" in refused(tmp_path, hit_more)
    assert "does not add up in cell hard (hits, hit_rate, " in refused(tmp_path, outcome)
    assert "does not add up (score)" in refused(tmp_path, score)
    assert "does not add up in cell human (" in refused(tmp_path, reachable)


def test_quick_runs_and_other_balls_are_refused(tmp_path):
    said = refused(tmp_path, lambda found: found.update(quick=True))
    assert "is a quick run, which compares with nothing" in said
    said = refused(tmp_path, lambda found: found.update(digest="0" * 64))
    assert "is not of the balls, floor and ceiling of suite v1" in said
    said = refused(tmp_path, lambda found: found["cells"][1].update(digest="0"))
    assert "cell human_720p (digest)" in said
    said = refused(tmp_path, lambda found: found["cells"][1].update(seed=3))
    assert "cell human_720p (seed)" in said
    said = refused(tmp_path, lambda found: found["cells"].pop())
    assert "has the cells human, human_720p, hard, randomized, lob, lob_pitched;" in said


def test_what_carries_no_command_is_refused(tmp_path):
    said = refused(tmp_path, lambda found: found.update(command="", version=3))
    assert "does not say command, version" in said
    assert "does not say experience" in refused(tmp_path, lambda found: found.pop("experience"))


def test_what_is_no_result_is_one_line(tmp_path):
    said = "entry.json: is no result of a suite"
    assert said in refused(tmp_path, lambda found: found.update(suite="v9"))
    assert said in refused(tmp_path, lambda found: found.update(suite=[]))
    assert said in refused(tmp_path, lambda found: found.pop("command"))
    assert said in refused(tmp_path, lambda found: found.update(cells=3))
    assert said in refused(tmp_path, lambda found: found["cells"][0].update(outcomes="x" * 300))
    assert said in refused(tmp_path, lambda found: found["cells"][0].update(hit_rate="much"))
    assert said in refused(tmp_path, lambda found: found["cells"][0].pop("reachable"))


def test_a_file_that_is_no_json_is_one_line(tmp_path):
    for text in (b"", b"{", b"\xff", b"[" * 100_000):
        (tmp_path / "entry.json").write_bytes(text)
        with pytest.raises(InputError, match=r"entry\.json: is no JSON; expected"):
            read_entry(tmp_path / "entry.json")
    (tmp_path / "entry.json").write_text("[3]")
    with pytest.raises(InputError, match="is no result of a suite"):
        read_entry(tmp_path / "entry.json")
    with pytest.raises(InputError, match="cannot be read"):
        read_entry(tmp_path)
