"""The page of a reproduction."""

import io

import cv2
import numpy as np
import pytest
from rich.console import Console

from rotorpong.paper.page import html_page, markdown_page
from rotorpong.paper.tables import ResultsTables

PNG = cv2.imencode(".png", np.zeros((2, 3, 3), np.uint8))[1].tobytes()
FOUND = {
    "title": "Table 0",
    "paper": {"": {"x_cm": 0.77, "rate": None}},
    "ours": {
        "one": {"x_cm": 1.234, "x_cm_sd": 0.5, "rate": 18.0, "rate_interval": [15.0, 21.26]},
        "exact": {"x_cm": 3e-9, "rate": 0.0},
    },
    "setting": {"balls": 100, "cameras": ["a", "b"], "eyes": {"whole_px": True}, "quick": False},
    "command": "rotorpong reproduce it --out DIR",
    "columns": [
        {"key": "x_cm", "head": "X, cm", "digits": 2},
        {"key": "rate", "head": "hits, %", "digits": 1},
    ],
    "figures": ["it.png"],
    "remarks": "Because.",
}


def test_each_number_stands_with_its_deviation_or_interval_in_the_digits_of_its_column():
    page = markdown_page({"it": FOUND})
    assert "| **paper** | 0.77 | - |" in page
    assert "| **ours**: one | 1.23 ± 0.50 | 18.0 (15.0 to 21.3) |" in page


def test_a_number_that_would_seem_to_be_zero_is_a_power_and_zero_is_zero():
    assert "| **ours**: exact | 3e-09 | 0.0 |" in markdown_page({"it": FOUND})


def test_setting_and_command_stand_below_the_table():
    page = markdown_page({"it": FOUND})
    assert "Setting: balls 100; cameras a, b; eyes whole_px True; quick False." in page
    assert "Command: `rotorpong reproduce it --out DIR`" in page
    assert "](it.png)" in page


def test_rough_numbers_are_called_so():
    assert "rough numbers" in markdown_page({"it": FOUND | {"setting": {"quick": True}}})
    assert "rough numbers" not in markdown_page({"it": FOUND})


def test_the_html_page_is_whole_in_itself():
    page = html_page(markdown_page({"it": FOUND}), {"it": PNG})
    assert page.count("data:image/png;base64,") == 1
    assert "<table>" in page
    assert 'src="it.png' not in page
    assert "http" not in page.replace("http-equiv", "")


@pytest.mark.parametrize("width", [30, 60, 200])
def test_on_a_terminal_of_any_width_every_number_can_be_read(width):
    console = Console(width=width, file=io.StringIO())
    console.print(ResultsTables({"it": FOUND}))
    shown = " ".join(console.file.getvalue().split())
    for number in ("0.77", "1.23 ± 0.50", "3e-09"):
        assert number in shown
    assert "…" not in shown
