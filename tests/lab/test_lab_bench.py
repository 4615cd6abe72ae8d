"""Rows of a benchmark say what they say; sections are measured when they are asked for."""

import io
import math
from types import SimpleNamespace

import pytest
from rich.console import Console

from rotorpong.conventions import InputError
from rotorpong.lab.bench import ball_rows, peers, timing
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.suites import SUITES, Order
from rotorpong.lab.bench.tables import number, rows_table
from rotorpong.lab.bench.timing import LIBRARIES, cpu_seconds, single_thread, wall_seconds

ADAPTER = """
from rotorpong.lab.bench.rows import Row

def require():
    {}

def rows(*, quick):
    return (Row("quick" if quick else "slow", 2.0, "1", peer="other", ratio=4.0),)
"""


def shown(rows):
    console = Console(width=200, record=True, file=io.StringIO())
    console.print(rows_table(rows))
    return console.export_text()


@pytest.mark.parametrize(
    ("better", "met"), [("more", [False, True, True]), ("less", [True, True, False])]
)
def test_a_target_is_met_on_its_good_side_and_on_the_spot(better, met):
    assert [Row("x", value, "1", 2.0, better).met for value in (1.0, 2.0, 3.0)] == met


def test_json_of_a_row_leaves_out_what_is_not_known():
    assert Row("x", 1.0, "m").as_json() == {"name": "x", "value": 1.0, "unit": "m"}
    assert Row("x", 1.0, "m", 2.0, "less").as_json()["met"] is True
    compared = Row("x", 1.0, "m", peer="other", ratio=3.0).as_json()
    assert (compared["peer"], compared["ratio"]) == ("other", 3.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_not_finite_never_leaves(value):
    with pytest.raises(ValueError, match="'x'"):
        Row("x", value, "m").as_json()


def test_a_table_shows_target_and_verdict():
    rows = (
        Row("fast", 2e5, "1/s", 1e5),
        Row("exact", 1e-3, "m", 1e-6, "less"),
        Row("bare", 0.0, "m"),
    )
    lines = {line.split("│")[1].strip(): line for line in shown(rows).splitlines() if "│" in line}
    assert "200,000" in lines["fast"]
    assert "≥ 100,000" in lines["fast"]
    assert "yes" in lines["fast"]
    assert "≤ 1.0e-06" in lines["exact"]
    assert "no" in lines["exact"].split("│")[5]
    assert "yes" not in lines["bare"]


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1.25, "1.25"), (123456.7, "123,457"), (4e-10, "4.0e-10"), (-9.5, "-9.5")],
)
def test_numbers_are_readable(value, text):
    assert number(value) == text


@pytest.mark.parametrize(
    ("measure", "clock"), [(cpu_seconds, "process_time"), (wall_seconds, "perf_counter")]
)
def test_a_time_is_the_median_of_its_own_clock_after_warm_ups(monkeypatch, measure, clock):
    worked, ticks = [], iter([0.0, 5.0, 10.0, 11.0, 20.0, 23.0])  # three times: 5, 1, 3
    monkeypatch.setattr(timing, "time", SimpleNamespace(**{clock: lambda: next(ticks)}))
    other = {"process_time": "perf_counter", "perf_counter": "process_time"}[clock]
    setattr(timing.time, other, None)
    assert measure(lambda: worked.append(1), quick=True) == 3.0
    assert len(worked) == timing.WARM_UPS + timing.QUICK_REPETITIONS


def test_one_thread_is_asked_of_every_library():
    environment = {"HOME": "there"}
    single_thread(environment)
    assert environment.pop("HOME") == "there"
    assert environment == {f"{library}_NUM_THREADS": "1" for library in LIBRARIES}


def test_peers_and_private_data_are_measured_only_when_asked_for():
    titles = [section.title for section in SUITES["world"] if section.asked(Order())]
    assert "ball" in titles
    assert not {"peers", "flights", "events"} & set(titles)


def test_adapters_of_peers_are_found_in_their_folder(tmp_path):
    (tmp_path / "one.py").write_text(ADAPTER.format("pass"))
    (tmp_path / "_helper.py").write_text("raise AssertionError")
    peers.require(tmp_path)
    assert [row.name for row in peers.rows(quick=True, folder=tmp_path)] == ["quick"]


def test_a_missing_peer_is_bad_input_that_names_the_extra(tmp_path):
    (tmp_path / "one.py").write_text(ADAPTER.format("import not_there"))
    with pytest.raises(InputError, match=r"not_there.*\[bench\]"):
        peers.require(tmp_path)
    with pytest.raises(InputError, match="checkout"):
        peers.require(tmp_path / "gone")


def test_balls_fly_as_exactly_as_the_target_says():
    rows = {row.name: row for row in ball_rows.rows(quick=True)}
    exact = [row for row in rows.values() if row.target is not None and row.better == "less"]
    assert [row.name for row in exact if not row.met] == []


def test_the_adapters_of_this_checkout_compare_with_a_peer():
    peers.require()
    rows = peers.rows(quick=True)
    compared = [row.as_json() for row in rows if row.peer is not None]
    assert len(compared) >= 2
    assert all(row["ratio"] > 0.0 for row in compared)
    assert "mujoco" in compared[0]["peer"]
