"""The documentation's site is whole: every example, every public name, every command as it runs."""

import ast
import importlib.util
import pkgutil
import re
import sys
from pathlib import Path

import gymnasium
import pytest

import rotorpong

HOUSE = Path(__file__).resolve().parents[1]
DOCS = HOUSE / "docs"
EXAMPLES = sorted((HOUSE / "examples").glob("*.py"))
REFERENCE = "\n".join(page.read_text() for page in sorted((DOCS / "reference").glob("*.md")))
WHOLE = ("primitives", "learning", "control", "physics", "vision", "experience")  # packages
IN_PARTS = ("conventions", "drone", "geometry", "lab.spec", "lab.evaluate", "lab.train")
EACH = pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)


def module_at(path):
    """Return a file as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def modules_of(package):
    """Yield the public modules of a package, by their full names."""
    found = importlib.import_module(f"rotorpong.{package}")
    for module in pkgutil.iter_modules(found.__path__):
        if not module.name.startswith("_"):
            yield f"{found.__name__}.{module.name}"


def section_of(module):
    """Return what the reference says to Sphinx about a module."""
    found = re.search(rf"^\.\. automodule:: {re.escape(module)}\n(.*?)^```", REFERENCE, re.M | re.S)
    return found and found[1]


def left_out(module):
    """Return the names that the reference leaves out of a module."""
    found = re.search(r":exclude-members: (.+)", section_of(module) or "")
    return set(found[1].split(", ")) if found else set()


def listed_pages():
    """Return the names of all pages that a table of contents lists."""
    blocks = {}
    for page in (DOCS / "index.md", DOCS / "reference" / "index.md"):
        for block in re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text(), re.M | re.S):
            for name in re.findall(r"^\w[\w/]*$", block, re.M):
                blocks[(page.parent / name).relative_to(DOCS).as_posix()] = page
    return set(blocks)


def test_the_gallery_has_all_examples_and_no_others():
    order = module_at(DOCS / "gallery_order.py").ORDER
    assert sorted(order) == [example.name for example in EXAMPLES]


@EACH
def test_an_example_begins_with_a_title_and_says_what_it_shows(example):
    said = ast.get_docstring(ast.parse(example.read_text())).splitlines()
    assert said[1] == "=" * len(said[0])
    assert said[2] == ""
    assert said[3].strip()


@EACH
def test_an_example_draws_without_a_display(example):
    code = example.read_text()
    assert 'plt.switch_backend("agg")' in code
    assert "plt.show" not in code


def test_the_own_player_is_thirty_lines():
    code, _, _ = (HOUSE / "examples" / "own_player.py").read_text().partition("\n# %%")
    player = code.split('"""\n', 2)[2].strip().splitlines()
    assert 10 < len(player) <= 30
    assert "class Chaser:" in player


@pytest.mark.parametrize("package", WHOLE)
def test_the_reference_has_every_public_module_and_every_name_that_a_package_offers(package):
    missing = [name for name in modules_of(package) if section_of(name) is None]
    assert missing == []
    full = f"rotorpong.{package}"
    assert section_of(full) is not None
    for name in getattr(importlib.import_module(full), "__all__", []):
        by_itself = f".. autofunction:: {full}.{name}\n" in REFERENCE
        assert (name in left_out(full)) == by_itself


@pytest.mark.parametrize("package", WHOLE)
def test_a_module_leaves_out_only_what_its_package_has(package):
    offered = set(getattr(importlib.import_module(f"rotorpong.{package}"), "__all__", []))
    for name in modules_of(package):
        module = importlib.import_module(name)
        assert left_out(name) <= offered
        assert all(getattr(module, left).__module__ == name for left in left_out(name))


@pytest.mark.parametrize("module", IN_PARTS)
def test_the_reference_has_the_modules_that_players_import(module):
    assert section_of(f"rotorpong.{module}") is not None


def test_the_reference_has_every_environment():
    ours = [spec for name, spec in gymnasium.registry.items() if name.startswith("rotorpong/")]
    assert len(ours) >= 3
    for spec in ours:
        for made_by in filter(None, (spec.entry_point, spec.vector_entry_point)):
            assert section_of(made_by.partition(":")[0]) is not None


def test_every_page_is_in_the_contents_and_every_entry_is_a_page():
    pages = {
        path.relative_to(DOCS).with_suffix("").as_posix()
        for path in DOCS.rglob("*.md")
        if "gallery" not in path.parts
    }
    assert listed_pages() == pages - {"index"} | {"gallery/index"}


def test_the_five_minute_start_shows_what_its_commands_print():
    page = (DOCS / "start.md").read_text()
    assert page.count("\n$ rotorpong ") >= 5
    assert module_at(DOCS / "console.py").refreshed(page) == page


def test_a_page_that_shows_something_else_is_not_what_its_commands_print():
    page = "```console\n$ ls\nfile\n$ rotorpong evaluate --player hover --balls 1\nsplendid\n```\n"
    console = module_at(DOCS / "console.py")
    again = console.refreshed(page)
    assert again.startswith("```console\n$ ls\nfile\n$ rotorpong evaluate --player hover")
    assert "splendid" not in again
    assert "│ balls" in again
    with pytest.raises(SystemExit, match="nobody"):
        console.refreshed("```console\n$ rotorpong evaluate --player nobody\n```\n")


def test_links_that_lead_nowhere_and_things_from_elsewhere_are_found(tmp_path):
    checks = module_at(HOUSE / ".ci" / "docs.py")
    (tmp_path / "a.html").write_text(
        '<h1 id="top"></h1><a href="b.html#part">1</a><a href="#top">2</a><a href="#no">3</a>'
        '<a href="c.html">4</a><a href="https://example.com/x">5</a>'
        '<script src="//example.com/x.js"></script><img src="no.png">'
    )
    (tmp_path / "b.html").write_text('<p id="part"></p>')
    (tmp_path / "a.css").write_text("@import 'https://example.com/font.css'; a {}")
    pages = {path: checks.Page(path) for path in sorted(tmp_path.glob("*.html"))}
    assert list(checks.leading_nowhere(pages)) == [
        "a.html leads to #no",
        "a.html leads to c.html",
    ]
    assert list(checks.loaded_from_elsewhere(tmp_path, pages)) == [
        "a.html loads //example.com/x.js",
        "a.html loads no.png",
        "a.css loads https://example.com/font.css",
    ]


DOCSTRING = """Say `f(x)`, `name` and *this* of x_ and |x|.

    s = a * b

    t = c

Args:
    x: of shape (*batch, 3).

Raises:
    InputError: never."""


def test_docstrings_keep_equations_and_signs_as_they_are_written():
    docstrings = module_at(DOCS / "docstrings.py")
    said = docstrings.readable(DOCSTRING)
    assert said.startswith("Say ``f(x)``, `name` and \\*this\\* of x\\_ and \\|x\\|.")
    assert "\n\n::\n\n    s = a * b\n\n    t = c\n\n" in said
    assert "    x: of shape (\\*batch, 3)." in said


def test_the_comments_behind_fields_and_constants_are_told():
    docstrings = module_at(DOCS / "docstrings.py")
    fields = docstrings.fields_of(rotorpong.drone.VelocityCommand)
    assert "    yaw_rate (float): rad/s, counter-clockwise seen from above" in fields
    constants = "\n".join(docstrings.constants_of(rotorpong.conventions))
    assert ".. py:data:: GRAVITY\n   :value: 9.81\n\n   m/s^2" in constants
    assert "CAMERA_FROM_BODY_AXES" not in constants  # it has a docstring of its own


def test_a_constant_with_a_docstring_keeps_what_stands_before_a_colon():
    docstrings = module_at(DOCS / "docstrings.py")
    lines = ["The one axis map: right = -left.", ""]
    docstrings.prepare(None, "data", "name", 0, None, lines)
    assert lines[:2] == ["The one axis map:", "right = -left."]
