"""A colour's file: what is read back, and what is refused."""

import contextlib
import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotorpong.conventions import InputError
from rotorpong.vision.colour import COLOURS
from rotorpong.vision.colour_files import FIELDS, LARGEST_FILE, colour_text, read_colour

GREEN = {
    "name": "green",
    "core": [50, 120, 100],
    "lower": [45, 90, 60],
    "upper": [75, 255, 255],
    "typical": [60, 180, 160],
}


@pytest.mark.parametrize("colour", COLOURS.values(), ids=COLOURS)
def test_what_is_written_is_read_back(tmp_path, colour):
    (tmp_path / "c.json").write_text(colour_text(colour))
    assert read_colour(tmp_path / "c.json") == colour


def test_the_documented_example_is_a_colour(tmp_path):
    page = (Path(__file__).resolve().parents[2] / "docs" / "colours.md").read_text()
    (tmp_path / "c.json").write_text(re.search(r"```json\n(.*?)```", page, re.S)[1])
    colour = read_colour(tmp_path / "c.json")
    assert colour.name == "green"
    assert colour_text(colour) in page
    assert all(f"`{field}`" in page for field in FIELDS)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"nmae": "x"}, "unknown nmae; expected name, core, lower, upper, typical"),
        ({"name": None}, "name is None; expected text"),
        ({"name": ""}, "expected 1 to 40 printable"),
        ({"name": "a,b"}, "without commas"),
        ({"name": "a\nb"}, "printable"),
        ({"name": "x" * 41}, "expected 1 to 40"),
        ({"core": [50, 120]}, "core is [50, 120]; expected whole numbers"),
        ({"core": [50, 120, 100.5]}, "expected whole numbers"),
        ({"core": [50, 120, True]}, "expected whole numbers"),
        ({"core": "green"}, "core is green; expected whole numbers"),
        ({"upper": [181, 255, 255]}, "upper is [181, 255, 255]; expected"),
        ({"lower": [-1, 90, 60]}, "lower is [-1, 90, 60]; expected"),
        ({"lower": [170, 90, 60]}, "hue: lower 170, upper 75; expected lower < upper; hues do not"),
        ({"lower": [45, 255, 60]}, "saturation: lower 255, upper 255; expected lower < upper"),
        ({"core": [50, 80, 100]}, "saturation: core 80; expected 90 (lower) to 255 (upper)"),
        ({"typical": [90, 180, 160]}, "hue: typical 90; expected 45 (lower) to 75 (upper)"),
    ],
)
def test_a_colour_with_one_thing_wrong_is_refused_with_the_reason(tmp_path, change, says):
    path = tmp_path / "c.json"
    path.write_text(json.dumps({**GREEN, **change}))
    with pytest.raises(InputError, match=re.escape(says)) as raised:
        read_colour(path)
    assert str(raised.value).startswith(f"colour {path}: ")


@pytest.mark.parametrize("field", FIELDS)
def test_a_colour_that_lacks_a_field_is_refused(tmp_path, field):
    path = tmp_path / "c.json"
    path.write_text(json.dumps({key: value for key, value in GREEN.items() if key != field}))
    with pytest.raises(InputError, match=f"lacks {field}; expected"):
        read_colour(path)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "is no JSON"),
        (b"{", "is no JSON"),
        (b"[1, 2]", "is no JSON object"),
        (b"\xff\xfe\x00", "is no JSON"),
        (b"[" * 50_000, "is no JSON"),
        (b" " * (LARGEST_FILE + 1), "is larger than"),
    ],
)
def test_files_that_are_nothing_are_refused(tmp_path, data, says):
    (tmp_path / "c.json").write_bytes(data)
    with pytest.raises(InputError, match=says):
        read_colour(tmp_path / "c.json")


def test_missing_files_and_folders_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "gone.json"):
        with pytest.raises(InputError, match="cannot be read"):
            read_colour(path)


@given(data=st.binary(max_size=60), at=st.integers(0, 150))
def test_damaged_bytes_give_a_colour_or_one_clear_error(tmp_path_factory, data, at):
    text = json.dumps(GREEN).encode()
    path = tmp_path_factory.mktemp("colour") / "c.json"
    path.write_bytes(text[:at] + data + text[at + len(data) :])
    with contextlib.suppress(InputError):
        assert read_colour(path).name


def test_a_field_given_twice_is_refused(tmp_path):
    path = tmp_path / "c.json"
    path.write_text(json.dumps(GREEN)[:-1] + ', "name": "red"}')
    with pytest.raises(InputError, match="gives name twice; expected each field once"):
        read_colour(path)
