"""The page of the documentation is that of a whole reproduction, and nothing in it is by hand."""

import json
from pathlib import Path

from rotorpong.paper.page import markdown_page
from rotorpong.paper.reproduce import ITEMS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "paper"


def test_the_page_says_what_the_results_hold():
    results = json.loads((PAGE / "results.json").read_text())
    assert (PAGE / "page.md").read_text() == markdown_page(results)


def test_the_results_are_of_every_item_and_not_rough():
    results = json.loads((PAGE / "results.json").read_text())
    assert set(ITEMS) <= set(results)
    assert not any(one["setting"]["quick"] for one in results.values())
    assert {one["setting"]["seed"] for one in results.values()} == {0}


def test_every_figure_of_the_page_is_there_and_no_other():
    results = json.loads((PAGE / "results.json").read_text())
    named = {figure for one in results.values() for figure in one["figures"]}
    assert named == {path.name for path in PAGE.glob("*.png")}
