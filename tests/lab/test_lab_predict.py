"""`predict` on made flights: which windows it takes, what it looks at, and what it says."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.flight_files import Flight, read_flight
from rotorpong.lab.flight_frames import along_x, bounce_heights, heights_by_others
from rotorpong.lab.predict import Question, predict_flights, predicted, windows_of
from rotorpong.physics.ball import Air, Ball
from rotorpong.physics.flight_arcs import find_arcs
from rotorpong.physics.flight_bounces import UP
from rotorpong.physics.flight_fit import Table, follow
from rotorpong.vision.flight_points import MATCH, TRACKED, PointNoise

RATE, HEIGHT = 100.0, -0.02
FAR = Question(ahead=0.38)  # few windows
EXAMPLE = Path(__file__).parents[2] / "examples" / "flight.csv"


def quiet(done, total):
    pass


def recorded(seed, *, noise=0.001, duration=0.6):
    """A flight along -x over the table with a bounce, spun as in matches, as a tracker has it."""
    rng = np.random.default_rng(seed)
    velocity = np.array([rng.uniform(-5.5, -4.5), rng.normal(0.0, 0.2), 0.3])
    spin = np.array(MATCH.spin) + MATCH.spin_sd * rng.standard_normal(3)
    ball = Ball(np.array([1.2, 0.0, 0.25]), velocity, spin * [-1.0, -1.0, 1.0])
    times = np.arange(0.0, duration, 1.0 / RATE)
    points = follow(ball, times, Air(), Table(height=HEIGHT), most=1).position
    return Flight(f"{seed}.csv", times, points + rng.normal(0.0, noise, points.shape))


def struck(seed):
    """A flight that a racket sends back after 0.3 s."""
    one = recorded(seed, duration=0.3)
    back = Ball(one.positions[-1], np.array([6.0, 0.3, 2.0]), np.zeros(3))
    times = np.arange(1, 31) / RATE
    after = follow(back, np.append(0.0, times), Air(), Table(height=HEIGHT)).position[1:]
    return Flight(
        "struck", np.append(one.times, 0.29 + times), np.concatenate([one.positions, after])
    )


def windows(flight, question):
    return list(windows_of(flight, find_arcs(flight.times, flight.positions), question))


def write(path, flight):
    rows = np.column_stack([flight.times, flight.positions]).tolist()
    path.write_text("\n".join(";".join(f"{value:.6f}" for value in row) for row in rows) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    top = tmp_path_factory.mktemp("flights")
    for seed in range(6):
        write(top / f"{seed}.csv", recorded(seed))
    write(top / "short.csv", recorded(7, duration=0.2))
    (top / "notes.txt").write_text("hello")
    return top


@pytest.fixture(scope="module")
def found(folder):
    return predict_flights(folder, FAR, quiet)


def test_a_window_spans_its_time_and_its_target_lies_ahead_among_the_points():
    flight, question = recorded(0), Question(window=0.1, ahead=0.155)
    taken = windows(flight, question)
    assert [one.first for one in taken] == list(range(len(taken)))
    for one in taken:
        span = flight.times[one.last - 1] - flight.times[one.first]
        assert span == pytest.approx(question.window)
        assert one.time == pytest.approx(flight.times[one.last - 1] + question.ahead)
        for axis in range(3):
            wanted = np.interp(one.time, flight.times, flight.positions[:, axis])
            assert one.target[axis] == pytest.approx(wanted)
    assert taken[-1].time > flight.times[-2]


def test_what_was_measured_after_the_window_changes_no_prediction():
    flight = recorded(1)
    for window in windows(flight, Question())[::5]:
        other = flight.positions.copy()
        other[window.last :] += 1.0
        changed = replace(flight, positions=other)
        places = [predicted(one, window, MATCH, TRACKED, HEIGHT) for one in (flight, changed)]
        assert np.array_equal(*places)


def test_windows_are_told_apart_by_where_the_bounce_is():
    flight, kinds = recorded(2, noise=0.0), {}
    arcs = find_arcs(flight.times, flight.positions)
    assert [arc.follows_bounce for arc in arcs] == [False, True]
    bounce = flight.times[arcs[1].first]
    for one in windows(flight, Question(window=0.1, ahead=0.1)):
        start, end = flight.times[one.first], flight.times[one.last - 1]
        wanted = "free" if one.time < bounce or start >= bounce else "over_bounce"
        wanted = "after_bounce" if start < bounce <= end else wanted
        kinds.setdefault(wanted, []).append(one.kind)
    assert set(kinds) == {"free", "over_bounce", "after_bounce"}
    assert all(set(got) == {wanted} for wanted, got in kinds.items())


def test_no_window_and_no_target_lies_across_a_stroke():
    flight = struck(3)
    taken = windows(flight, Question(window=0.08, ahead=0.05))
    assert taken
    for one in taken:
        before = one.time <= 0.291
        after = flight.times[one.first] >= 0.289
        assert before or after


def test_no_target_lies_where_nothing_was_measured():
    flight = recorded(4)
    kept = np.ones(len(flight.times), dtype=bool)
    kept[40:44] = False
    gappy = Flight("gappy", flight.times[kept], flight.positions[kept])
    low, high = flight.times[39], flight.times[44]
    assert not any(low + 1e-9 < one.time < high - 1e-9 for one in windows(gappy, Question()))


def test_coarse_stamps_of_which_most_are_equal_are_taken():
    flight = recorded(4)
    coarse = replace(flight, times=np.floor(flight.times * RATE / 3.0 + 1e-6) * 3.0 / RATE)
    taken = windows(coarse, Question())
    assert taken
    place = predicted(coarse, taken[0], MATCH, PointNoise(0.0015, 0.01), HEIGHT)
    assert np.linalg.norm(place - taken[0].target) < 0.3


def test_flights_without_noise_are_predicted_to_a_millimetre():
    flight, noise = recorded(5, noise=0.0), PointNoise(1e-6, 0.0)
    errors = {
        one.kind: np.linalg.norm(predicted(flight, one, MATCH, noise, HEIGHT) - one.target)
        for one in windows(flight, Question(window=0.15, ahead=0.1))
    }
    assert errors["free"] < 1e-3
    assert max(errors.values()) < 6e-3  # a target's line between two points cuts the bounce off


def test_pooled_counts_are_sums_and_more_of_the_model_errs_less(found):
    kinds = [found[kind]["n"] for kind in ("free", "after_bounce", "over_bounce")]
    assert found["n"] == sum(kinds) == sum(one["n"] for one in found["flights"])
    assert len(found["flights"]) == 6
    assert (found["files_passed_over"], found["flights_passed_over"]) == (1, 1)
    assert found["drag_only"]["n"] == found["gravity_only"]["n"] == found["n"]
    assert found["median_m"] < found["drag_only"]["median_m"] < found["gravity_only"]["median_m"]
    assert found["median_m"] < found["p90_m"]
    assert found["median_m"] < 0.08


def test_the_same_question_has_the_same_answer(folder, found):
    again = predict_flights(folder, FAR, quiet)
    assert json.dumps(again) == json.dumps(found)


def test_a_table_along_y_is_the_same_table(found, folder, tmp_path):
    for file in folder.glob("?.csv"):
        flight = read_flight(file)
        turned = np.stack(
            [-flight.positions[:, 1], flight.positions[:, 0], flight.positions[:, 2]], axis=1
        )
        write(tmp_path / file.name, replace(flight, positions=turned))
    got = predict_flights(tmp_path, FAR, quiet)
    for key in ("median_m", "p90_m", "n"):
        assert got[key] == pytest.approx(found[key], rel=1e-3)


def test_the_table_is_found_by_the_bounces_of_other_flights(found):
    assert all(
        one["table_height_m"] == pytest.approx(HEIGHT, abs=0.003) for one in found["flights"]
    )
    flight = recorded(6, noise=0.0)
    (height,) = bounce_heights(flight, find_arcs(flight.times, flight.positions))
    assert height == pytest.approx(HEIGHT, abs=0.001)
    assert heights_by_others([[0.5]] + [[0.01]] * 5) == pytest.approx([0.01] * 6)
    assert heights_by_others([[0.5], [0.1]]) == [0.0, 0.0]


def test_each_folder_is_a_frame_of_its_own(folder, found, tmp_path):
    for name, lift in (("low", 0.0), ("high", 0.02)):
        (tmp_path / name).mkdir()
        for file in folder.glob("?.csv"):
            flight = read_flight(file)
            write(
                tmp_path / name / file.name,
                replace(flight, positions=flight.positions + lift * UP),
            )
    got = predict_flights(tmp_path, FAR, quiet)
    heights = {Path(one["flight"]).parent.name: one["table_height_m"] for one in got["flights"]}
    assert heights["high"] - heights["low"] == pytest.approx(0.02, abs=0.001)
    assert got["n"] == 2 * found["n"]
    assert got["median_m"] == pytest.approx(found["median_m"], rel=1e-3)


def test_flights_are_turned_together_or_not_at_all():
    flight = recorded(0)
    assert along_x((flight,)) == (flight,)
    (turned,) = along_x((replace(flight, positions=flight.positions[:, [1, 0, 2]]),))
    assert np.ptp(turned.positions[:, 0]) > np.ptp(turned.positions[:, 1])


def test_a_height_that_is_told_is_taken():
    got = predict_flights(EXAMPLE, Question(ahead=0.1, table_height=-0.1), quiet)
    assert [one["table_height_m"] for one in got["flights"]] == [-0.1]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"window": 0.0}, "window-s 0: expected a number from 0.02 to 3"),
        ({"window": math.nan}, "window-s nan"),
        ({"ahead": -0.1}, "ahead-s -0.1: expected a number from 0.001 to 3"),
        ({"noise": PointNoise(0.0)}, "point-sd-mm 0: expected"),
        ({"noise": PointNoise(0.001, -1.0)}, "stamp-sd-ms -1000: expected"),
        ({"table_height": 760.0}, "table-height-m 760: expected a number from -2 to 2"),
        (
            {"ahead": 0.5},
            "no window of 0.15 s with a point 0.5 s after it and 5 points in it; the longest",
        ),
    ],
)
def test_a_question_without_an_answer_is_told_why(wrong, said):
    with pytest.raises(InputError, match=said):
        predict_flights(EXAMPLE, Question(**wrong), quiet)


def test_a_target_right_after_the_window_counts():
    """The place just after the last point lies between it and the next."""
    flight = recorded(0)
    step = float(np.median(np.diff(flight.times)))
    near, next_but_one = (
        len(windows(flight, Question(ahead=share * step))) for share in (0.4, 1.4)
    )
    assert near >= next_but_one > 0
