"""The page about control says what the code says."""

import doctest
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "control.md"


def test_the_code_of_the_page_prints_what_the_page_says():
    done = doctest.testfile(str(PAGE), module_relative=False)
    assert done.attempted > 15
    assert done.failed == 0
