"""Rows of `bench learning`: what they are made of, and that exactness is met."""

import numpy as np
import pytest

from rotorpong.conventions import GRAVITY, InputError
from rotorpong.lab.bench import learning_rows, peers, selection_rows
from rotorpong.lab.bench.suites import SUITES, Order
from rotorpong.learning import CrKR, Selection


def test_peers_are_asked_for_and_belong_to_their_suite(tmp_path):
    titles = [section.title for section in SUITES["learning"] if section.asked(Order("learning"))]
    assert titles == ["learning", "selecting"]
    with pytest.raises(InputError, match="--peers with bench eyes: belongs to bench world or "):
        Order("eyes", peers=True).check()
    (tmp_path / "one.py").write_text("def require(): raise ImportError('gone')")
    peers.require(tmp_path, suite="learning")
    with pytest.raises(InputError, match="gone"):
        peers.require(tmp_path)
    with pytest.raises(InputError, match="belongs to bench world"):
        Order("learning", out=tmp_path).check()


def test_a_throw_passes_the_plane_where_a_parabola_does():
    standard, passed = learning_rows.throws(50, seed=0)
    balls = learning_rows.BALL_MEAN + learning_rows.BALL_SD * standard
    elapsed = passed[:, 2]
    np.testing.assert_allclose(balls[:, 2] + balls[:, 5] * elapsed, learning_rows.TO)
    np.testing.assert_allclose(balls[:, 0] + balls[:, 3] * elapsed, passed[:, 0])
    fall = balls[:, 1] + balls[:, 4] * elapsed + GRAVITY / 2.0 * elapsed**2
    np.testing.assert_allclose(fall, passed[:, 1])


def test_more_throws_leave_less_error():
    errors = [learning_rows.rmse_cm(CrKR(3.0, 0.1), n) for n in (10, 50, 170)]
    assert errors[0] > errors[1] > errors[2]


def test_what_needs_no_clock_is_met():
    rows = [row for row in learning_rows.rows(quick=True) if row.unit == "1"]
    assert len([row for row in rows if row.target is not None]) >= 4
    assert [row.name for row in rows if row.met is False] == []


def test_the_toy_rewards_who_selects():
    even = selection_rows.Way("even", Selection("temperature", 1e9))
    greatest = selection_rows.Way("ucb", Selection("ucb"))
    random, ucb = (selection_rows.hits_of(way, 0)[200:].mean() for way in (even, greatest))
    best, chance = selection_rows._known_rates(0)
    assert random == pytest.approx(chance, abs=4 * 0.5 / np.sqrt(100))
    assert random + 0.1 < ucb < best + 4 * 0.5 / np.sqrt(100)


def test_the_adapter_of_scikit_learn_compares_with_it():
    peers.require(suite="learning")
    rows = {row.name: row for row in peers.rows(quick=True, suite="learning")}
    assert [name for name, row in rows.items() if row.target is not None and not row.met] == []
    compared = [row for row in rows.values() if row.peer is not None]
    assert len(compared) >= 3
    assert all(row.ratio > 0.0 for row in compared)
