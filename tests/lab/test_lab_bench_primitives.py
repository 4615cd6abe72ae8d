"""Rows of `bench primitives`, and peers that belong to one suite."""

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.bench import peers, primitives_rows
from rotorpong.lab.bench.suites import SUITES, Order
from rotorpong.primitives import fit_dmp


def test_what_needs_no_clock_is_met():
    rows = {row.name: row for row in primitives_rows.rows(quick=True)}
    assert len(rows) > 12
    exact = [row for row in rows.values() if row.unit in {"m", "m/s", "mm"}]
    assert [row.name for row in exact if row.met is False] == []
    assert all(np.isfinite(row.value) and row.value >= 0.0 for row in rows.values())


def test_the_error_of_a_reproduction_is_that_of_the_motion():
    t = primitives_rows.TIMES
    shifted = fit_dmp(t, primitives_rows.stroke(t) + np.array([0.003, 0.0, 0.0]))
    error = primitives_rows.reproduction_error(shifted)
    assert error == pytest.approx(0.003 / np.sqrt(3), rel=0.02)


def test_trials_are_the_same_for_everybody_and_last_whole_milliseconds():
    one, other = (primitives_rows.trials(5) for _ in range(2))
    assert [trial[2] for trial in one] == [trial[2] for trial in other]
    assert all(round(trial[2] * 1000) / 1000 == trial[2] for trial in one)


def test_peers_are_asked_for_by_the_suite_that_they_belong_to(tmp_path):
    text = "from rotorpong.lab.bench.rows import Row\n{}\ndef require(): {}\n"
    text += "def rows(*, quick): return (Row('{}', 1.0, '1'),)\n"
    (tmp_path / "a.py").write_text(text.format("", "pass", "plain"))
    (tmp_path / "b.py").write_text(text.format("SUITE = 'primitives'", "import nowhere", "dmp"))
    peers.require(tmp_path)
    assert [row.name for row in peers.rows(folder=tmp_path)] == ["plain"]
    assert [row.name for row in peers.rows(folder=tmp_path, suite="primitives")] == ["dmp"]
    with pytest.raises(InputError, match=r"nowhere.*\[bench\]"):
        peers.require(tmp_path, suite="primitives")


def test_the_suite_measures_peers_when_asked_and_nothing_of_other_suites(tmp_path):
    sections = SUITES["primitives"]
    assert [s.title for s in sections if s.asked(Order("primitives"))] == ["primitives"]
    assert [s.title for s in sections if s.asked(Order("primitives", peers=True))] == [
        "primitives",
        "peers",
    ]
    with pytest.raises(InputError, match="--flights with bench primitives: belongs to bench world"):
        Order("primitives", flights=tmp_path).check()
    with pytest.raises(InputError, match="--peers with bench eyes: belongs to bench world or prim"):
        Order("eyes", peers=True).check()


def test_the_adapters_of_this_checkout_compare_with_their_peers():
    peers.require(suite="primitives")
    rows = peers.rows(quick=True, suite="primitives")
    compared = [row for row in rows if row.peer is not None]
    assert {row.peer.partition(",")[0] for row in compared} == {"movement_primitives", "pydmps"}
    assert all(row.ratio > 1.0 for row in compared)
