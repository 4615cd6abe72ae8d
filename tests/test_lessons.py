"""Lessons say what the code says: their blocks of code run, and print what they print."""

import doctest
import re

import pytest
from lesson_pages import LESSONS

EACH = pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)


def test_there_are_lessons():
    assert LESSONS


@EACH
def test_the_code_of_a_lesson_prints_what_the_page_says(lesson):
    done = doctest.testfile(str(lesson), module_relative=False)
    assert done.attempted > 10
    assert done.failed == 0


@EACH
def test_every_figure_of_a_lesson_is_there_and_small(lesson):
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", lesson.read_text())
    assert 4 <= len(shown) <= 6
    for name in shown:
        figure = lesson.parent / name
        assert figure.read_bytes().startswith(b"\x89PNG")
        assert figure.stat().st_size < 100_000


@EACH
def test_a_lesson_has_code_that_draws_its_figures(lesson):
    code = lesson.with_suffix(".py").read_text()
    for name in re.findall(r"images/lessons/(\w+)\.png", lesson.read_text()):
        assert f"def {name}(" in code
