"""Lessons: their pages, and what their scripts print by the product's own constants."""

import importlib.util
import re
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "lessons"
LESSONS = sorted(FOLDER.glob("*.md"))
NUMBER = r"(-?[0-9.]+)"
sys.path.append(str(FOLDER))  # where scripts find what they share, as when they are run


def page(lesson):
    """Return the text of a lesson, by its name."""
    return (FOLDER / f"{lesson}.md").read_text()


def printed(lesson):
    """Return all that a lesson's script prints; the figures it draws are thrown away."""
    spec = importlib.util.spec_from_file_location(lesson, FOLDER / f"{lesson}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    said = []
    module.print = said.append
    with tempfile.TemporaryDirectory() as figures:
        module.IMAGES = Path(figures)
        module.main()
    return "\n".join(said)


def says(lesson, words):
    """Tell whether a page has these words, wherever its lines break if the words do not."""
    text = page(lesson)
    return words in text or words in " ".join(text.split())


def in_words(said, line, words):
    """Return these words with the numbers of the line that a script said."""
    return words.format(*map(float, re.search(line, said).groups()))
