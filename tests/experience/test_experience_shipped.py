"""Demonstrations survive their text file exactly; damaged files are one clear error."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rotorpong.conventions import StoreError
from rotorpong.experience import Demonstration
from rotorpong.experience.shipped import read_demonstrations, write_demonstrations

finite = st.floats(allow_nan=False, allow_infinity=False)
scalars = st.none() | st.booleans() | st.integers() | finite | st.text()


@st.composite
def demonstrations(draw):
    times = sorted(draw(st.sets(st.floats(0, 1e6), min_size=1, max_size=5)))
    rest = draw(arrays(float, (len(times), 4), elements=finite))
    whole = st.integers(0, 2**63 - 1)
    spec = draw(st.dictionaries(st.text(), scalars, max_size=3))
    return Demonstration(draw(whole), draw(whole), spec, draw(st.text()), np.c_[times, rest])


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("shipped") / "demonstrations.json"


@pytest.fixture
def text(path):
    commands = np.c_[np.arange(8) / 30.0, np.linspace(-1, 1, 32).reshape(8, 4)]
    spec = {"vehicle": "tum_gazebo", "serves": "human"}
    write_demonstrations(path, [Demonstration(0, i, spec, "scripted", commands) for i in range(2)])
    return path.read_text("utf-8")


@settings(deadline=None, max_examples=40)
@given(st.lists(demonstrations(), max_size=3))
def test_writing_and_reading_gives_the_same_bits(path, written):
    write_demonstrations(path, written)
    read = read_demonstrations(path)
    assert read == tuple(written)
    for one, two in zip(written, read, strict=True):
        assert one.commands.tobytes() == two.commands.tobytes()


def test_the_file_is_plain_json_with_one_command_a_row(text):
    content = json.loads(text)
    assert content["columns"][0] == "time_s"
    assert len(content["demonstrations"][1]["commands"]) == 8
    assert sum(line.startswith("  [") for line in text.splitlines()) == 16


def test_writing_replaces_the_file_and_leaves_nothing_beside_it(path, text):
    write_demonstrations(path, read_demonstrations(path)[:1])
    assert len(read_demonstrations(path)) == 1
    assert list(path.parent.iterdir()) == [path]


def test_any_truncation_and_any_damaged_byte_is_an_error_or_a_valid_file(path, text):
    rng = np.random.default_rng(0)
    data = text.encode()
    for _ in range(300):
        damaged = bytearray(data)
        damaged[rng.integers(len(data))] ^= 1 << rng.integers(8)
        path.write_bytes(damaged[: rng.choice([len(data), rng.integers(len(data))])])
        try:
            read = read_demonstrations(path)
        except StoreError:
            continue
        assert len(read) == 2  # a digit or a letter changed, as if edited by hand


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("rotorpong demonstrations", "shopping list", "format"),
        ('"version": 1', '"version": 2', "version is 2; expected 1"),
        ("forward_m_s", "forward_mm_s", "columns"),
        ('"pilot": "scripted"', '"pilot": 7', "pilot"),
        ('"seed": 0', '"seed": 0.5', "seed"),
        ('"seed": 0', '"sed": 0', "fields"),
        ("[0.0, -1.0", "[NaN, -1.0", "NaN"),
        ("[0.0, -1.0", "[1e999, -1.0", "infinity"),
        ("[0.0, -1.0", f"[1{'0' * 400}, -1.0", "int too large"),
        ("[0.0, -1.0", "[true, -1.0", "not a number"),
        ("[0.0, -1.0", "[-1.0", "rows of 5"),
        ("[0.0, -1.0", "[9.0, -1.0", "times"),
        ("{", "[" * 100_000, "damaged"),
        ("{", "\udcff{", "damaged"),
    ],
)
def test_what_is_wrong_with_a_file_is_named(path, text, old, new, named):
    path.write_text(text.replace(old, new, 1), "utf-8", "surrogateescape")
    with pytest.raises(StoreError, match=named) as caught:
        read_demonstrations(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_or_folder_is_one_line(tmp_path):
    with pytest.raises(StoreError, match="No such file"):
        read_demonstrations(tmp_path / "none.json")
    with pytest.raises(StoreError, match="does not exist"):
        write_demonstrations(tmp_path / "none" / "x.json", [])
    with pytest.raises(StoreError, match="directory"):
        read_demonstrations(tmp_path)
