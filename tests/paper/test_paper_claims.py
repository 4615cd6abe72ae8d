"""The paper's numbers stand beside those of the items, and what is said follows from them."""

import copy
import sys

import pytest

from rotorpong.paper import claims, fig6, ladder, real, reproduce, sensitivity, table1, table2
from rotorpong.paper.claims import findings
from rotorpong.paper.discussion import WINDOWS
from rotorpong.paper.findings import Scale
from rotorpong.paper.page import html_page, markdown_page
from rotorpong.paper.readings import LOOP, PORTED, ROBOT, TABLE1, TABLE1_FAST, TABLE2, Told
from rotorpong.paper.reproduce import as_json
from rotorpong.paper.trajectory import WHOLE

KEYS = ("x_cm", "y_cm", "z_cm", "vx_cm_per_s", "vy_cm_per_s", "vz_cm_per_s")
STEPS = ("commanded labels", "wide CrKR", "float diameter", "tracker eyes", "feed-forward")


def _item(lines, **setting):
    return {"ours": lines, "setting": setting}


def _curve(label, *percents):
    return {
        f"{label}, {mark}": {
            "own_hits": mark,
            "hit_percent": percent,
            "near_hit_percent": 1.0,
            "near_percent": 9.0,
            "hull_percent": 44.0,
        }
        for mark, percent in zip((0, 40, 170), percents, strict=True)
    }


def _results():
    """Return results of items by hand."""
    steps = {
        name: {"points": points, "p_value": 0.5 / (1 + points**2), "hit_percent": 20.0}
        for points, name in enumerate((*STEPS, "closed loop"))
    }
    ends = {
        name: {"hit_percent": percent}
        for name, percent in {"hover": 7.0, "paper as written": 10.0, "oracle": 100.0}.items()
    }
    kinds = {line: dict.fromkeys(KEYS, 5.0) for line in TABLE1.values()}
    kinds[TABLE1["centred"]]["x_over_z"] = 0.031
    return {
        "table1": _item(kinds, trajectories=20),
        "fig7b": _item(_curve("vision", 8.0, 24.0, 25.0) | _curve("truth", 9.0, 20.0, 45.0)),
        "ladder": _item(steps | ends),
        "real": _item({
            f"{vehicle}, {n}, {stage}": {"hit_percent": 12.5, "hit_percent_interval": [8.0, 18.0]}
            for vehicle in ("as ported", "with a velocity loop")
            for n in ("1 primitive", "10 primitives")
            for stage in ("before", "after")
        }),
    }  # fmt: skip


def _ours(results):
    return {line.label: line.values for line in findings(results).ours}


def test_every_number_has_the_papers_and_ours_under_one_name():
    found = findings(_results())
    labels = [line.label for line in found.paper]
    assert labels == [line.label for line in found.ours]
    assert len(set(labels)) == len(labels) > 30


def test_the_papers_own_numbers_agree_with_its_text():
    paper = {line.label: line.values["value"] for line in findings({}).paper}
    told = {
        "Table I: error of Z, cm": 24.15,
        "Table II: execution error of vZ, cm/s": 26.88,
        "VI: hits after learning, simulated, %": 30.0,
        "V, robot: hits, one primitive, after the first hits, %": 32.5,
        "V, robot: hits, ten primitives, after 80 hits, %": 20.0,
        "V: successful hits learnt from": 170.0,
        "IV-B: plane where a motion begins, m": 2.5,
    }
    assert {label: paper[label] for label in told} == told


def test_the_lines_that_are_read_are_lines_that_items_make():
    whole = Scale()
    assert TABLE2 in [job.key for job in table2.jobs(whole)]
    watched = [f"{job.key}, {WHOLE}" for job in table1.jobs(whole)]
    assert {*TABLE1.values(), TABLE1_FAST} <= set(watched)
    assert "paper's eyes" in fig6.EYES
    played = [job.key for job in real.jobs(whole)]
    for begin in (f"{vehicle}, {test}" for vehicle in (PORTED, LOOP) for test in ROBOT):
        assert any(key.startswith(begin) for key in played), begin
    assert set(STEPS) < {rung.label for rung in ladder.rungs(0)}
    assert {"exploration 5 cm", "exploration 20 cm", *WINDOWS} < {
        change.label for change in sensitivity.changes()
    }


def test_ours_are_read_from_the_items():
    ours = _ours(_results())
    assert ours["VI: hits after learning, simulated, %"]["value"] == 25.0
    assert ours["Table I: error of X over that of Z"]["value"] == 0.031
    robot = ours["V, robot: hits, ten primitives, after 80 hits, %"]
    assert (robot["value"], robot["interval"]) == (12.5, [8.0, 18.0])
    almost = ours['V: "several missed balls were almost-hits": share of misses, %']
    assert almost["value"] == pytest.approx(100 * 9 / 75)


def test_constants_of_the_code_are_the_papers_equipment():
    found = findings({})
    paper = {line.label: line.values["value"] for line in found.paper}
    ours = {line.label: line.values for line in found.ours}
    code = [label for label, values in ours.items() if values["source"] == claims.CODE]
    assert len(code) == 6
    for label in code:
        assert ours[label]["value"] == pytest.approx(paper[label]), label


@pytest.mark.parametrize("missing", ["table1", "fig7b", "ladder", "real"])
def test_a_missing_item_leaves_its_numbers_open_and_the_others_as_they_are(missing):
    whole, less = _results(), _results()
    del less[missing]
    before, after = _ours(whole), _ours(less)
    for label, values in after.items():
        gone = before[label]["source"].startswith(missing)
        assert values["value"] == (None if gone else before[label]["value"]), label


def test_without_any_item_nothing_is_said_of_ours():
    remarks = findings({}).remarks
    assert "Where we differ" not in remarks
    assert "What the paper does not tell" in remarks


def test_words_follow_the_numbers():
    results = _results()
    remarks = findings(results).remarks
    assert "less than the paper" in remarks
    assert "sooner, as in the paper" in remarks
    assert "hardly a ball is out of reach" in remarks
    other = copy.deepcopy(results)
    other["fig7b"] = _item(_curve("vision", 8.0, 20.0, 45.0) | _curve("truth", 9.0, 44.0, 45.0))
    other["ladder"]["ours"]["oracle"]["hit_percent"] = 80.0
    remarks = findings(other).remarks
    assert "no less than the paper" in remarks
    assert "no sooner, unlike the paper's" in remarks
    assert "some balls are out of reach" in remarks


def test_steps_of_the_ladder_are_ranked():
    remarks = findings(_results()).remarks
    assert "closed loop +5.0, feed-forward +4.0, tracker eyes +3.0" in remarks
    assert (
        "+12.0 points together; told from chance one by one: feed-forward, closed loop" in remarks
    )


def test_a_sentence_is_empty_where_a_number_is_missing():
    told = Told({"a": _item({"one": {"x": 1.25}})})
    assert told.say("{} and {:+}", ("a", "one", "x"), ("a", "one", "x")) == "1.2 and +1.2"
    assert told.say("{} and {}", ("a", "one", "x"), ("a", "two", "x")) == ""


def test_the_page_holds_the_numbers_as_a_table():
    found = as_json("claims", findings(_results()), Scale())
    page = markdown_page({"claims": found})
    assert "| VI | hits after learning, simulated, % | 30.0 | 25.0 | fig7b: vision, 170 |" in page
    assert html_page(page, {}).count("<tr>") == 1 + len(findings(_results()).ours)


def test_all_items_together_close_with_the_comparison(tmp_path, monkeypatch):
    monkeypatch.setattr(sys.modules[reproduce.__module__], "ITEMS", ("fig1",))
    found = reproduce(["all"], tmp_path, scale=Scale(quick=True))
    assert list(found) == ["fig1", "claims"]
    assert found["claims"]["command"] == "rotorpong reproduce all --out DIR --quick"
    assert claims.TITLE in (tmp_path / "page.md").read_text()
