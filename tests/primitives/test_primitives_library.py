"""Blends of primitives, and the file they are kept in."""

import json

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.primitives import Dmp, Library, Motion, State, integrate_dmp, mix

rng = np.random.default_rng(0)
ENDS = Motion(np.array([0.0, 0.7]), rng.normal(size=(2, 3)), rng.normal(size=(2, 3)))
DMPS = (
    Dmp(rng.normal(size=(20, 3)) * 100, ends=ENDS),
    Dmp(rng.normal(size=(20, 3)) * 100, forcing_gain=0.7),
    Dmp(rng.normal(size=(20, 3)) * 100),
)
GAMMA = np.array([1.0, 2.5, 0.2])
START = State(np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.0, -0.4]))
GOAL = State(np.array([0.4, 0.3, -0.1]), np.array([-0.3, 1.0, 0.6]))
TIMES = np.linspace(0.0, 0.8, 30)


def test_the_blend_moves_as_the_weighted_mean_of_the_motions():
    blend = mix(DMPS, GAMMA).roll_out(START, GOAL, 0.8, TIMES)
    motions = [dmp.roll_out(START, GOAL, 0.8, TIMES) for dmp in DMPS]
    for field in ("position", "velocity"):
        mean = np.average([getattr(motion, field) for motion in motions], axis=0, weights=GAMMA)
        np.testing.assert_allclose(getattr(blend, field), mean, rtol=0, atol=1e-14)


def test_the_blend_agrees_with_blended_solutions_of_the_differential_equation():
    blend = mix(DMPS, GAMMA).roll_out(START, GOAL, 0.8, TIMES)
    solutions = [integrate_dmp(dmp, START, GOAL, 0.8, TIMES).position for dmp in DMPS]
    mean = np.average(solutions, axis=0, weights=GAMMA)
    np.testing.assert_allclose(blend.position, mean, rtol=0, atol=1e-7)


def test_one_primitive_with_all_the_weight_is_that_primitive():
    alone = mix(DMPS, np.array([0.0, 3.0, 0.0]))
    np.testing.assert_allclose(alone.weights, 0.7 * DMPS[1].weights, rtol=1e-15)


def test_the_scale_of_the_weights_does_not_matter():
    np.testing.assert_allclose(mix(DMPS, GAMMA).weights, mix(DMPS, 1e3 * GAMMA).weights)


def test_a_library_mixes_as_its_primitives_do():
    np.testing.assert_array_equal(Library(DMPS).mix(GAMMA).weights, mix(DMPS, GAMMA).weights)
    assert len(Library(DMPS)) == 3


def test_a_blend_that_has_no_meaning_is_refused():
    cases = [
        ((), np.empty(0), "no primitives"),
        (DMPS, GAMMA[:2], "one per primitive"),
        (DMPS, np.zeros(3), "not all zero"),
        (DMPS, np.array([1.0, -1.0, 2.0]), "none negative"),
        (DMPS, np.array([1.0, np.nan, 2.0]), "finite"),
        (DMPS, np.array([1.0, np.inf, 2.0]), "finite"),
        ((*DMPS, Dmp(np.zeros((10, 3)))), np.ones(4), "same bases"),
    ]
    for dmps, weights, message in cases:
        with pytest.raises(InputError, match=message):
            mix(dmps, weights)
    for primitives in ((), (*DMPS, Dmp(np.zeros((20, 2))))):
        with pytest.raises(InputError, match="expected"):
            Library(primitives)


def test_what_is_read_is_what_was_saved_bit_for_bit(tmp_path):
    path = tmp_path / "library.json"
    Library(DMPS).save(path)
    read = Library.load(path)
    for ours, theirs in zip(DMPS, read.primitives, strict=True):
        np.testing.assert_array_equal(ours.weights, theirs.weights)
        assert ours.forcing_gain == theirs.forcing_gain
    assert read.primitives[1].ends is None
    for field in ("times", "position", "velocity"):
        np.testing.assert_array_equal(getattr(read.primitives[0].ends, field), getattr(ENDS, field))
    read.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


def test_saving_replaces_the_old_file_and_leaves_no_other(tmp_path):
    path = tmp_path / "library.json"
    Library(DMPS[:1]).save(path)
    Library(DMPS).save(path)
    assert len(Library.load(path)) == 3
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_cannot_be_written_is_one_clear_error(tmp_path):
    for path in (tmp_path / "nowhere" / "library.json", tmp_path):
        with pytest.raises(InputError, match="cannot be written"):
            Library(DMPS).save(path)
    assert list(tmp_path.iterdir()) == []


def damage(change):
    entry = {"weights": [[1.0, 2.0]], "forcing_gain": 1.0, "ends": None}
    document = {"format": "rotorpong-library", "version": 1, "primitives": [entry]}
    change(document, entry)
    return json.dumps(document)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "not json",
        '{"format": "rotorpong-library", "ver',
        "[" * 100_000,
        "[]",
        "3",
        "{}",
        damage(lambda document, _: document.update(format="other")),
        damage(lambda document, _: document.update(version=2)),
        damage(lambda document, _: document.pop("primitives")),
        damage(lambda document, _: document.update(primitives=[])),
        damage(lambda document, _: document.update(primitives=7)),
        damage(lambda document, _: document.update(primitives=[None])),
        damage(lambda _, entry: entry.pop("ends")),
        damage(lambda _, entry: entry.update(weights=[[1.0, 2.0], [3.0]])),
        damage(lambda _, entry: entry.update(weights=[1.0])),
        damage(lambda _, entry: entry.update(weights=[])),
        damage(lambda _, entry: entry.update(weights=[["a"]])),
        damage(lambda _, entry: entry.update(weights=[[float("nan")]])),
        damage(lambda _, entry: entry.update(weights=[[10**400]])),
        damage(lambda _, entry: entry.update(forcing_gain=None)),
        damage(lambda _, entry: entry.update(forcing_gain=[1.0])),
        damage(lambda _, entry: entry.update(ends={"times_s": [0.0, 1.0]})),
        damage(
            lambda _, entry: entry.update(
                ends={"times_s": [0.0], "position_m": [[0.0]], "velocity_m_s": [[0.0]]}
            )
        ),
    ],
)
def test_a_damaged_or_foreign_file_is_one_clear_line(tmp_path, text):
    path = tmp_path / "library.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"library\.json") as caught:
        Library.load(path)
    assert "\n" not in str(caught.value)


def test_a_missing_or_binary_file_is_one_clear_line(tmp_path):
    (tmp_path / "binary").write_bytes(bytes(range(256)))
    for path in (tmp_path / "missing", tmp_path, tmp_path / "binary"):
        with pytest.raises(InputError, match=r"expected|cannot be read"):
            Library.load(path)
