import warnings

import numpy as np
import pytest

from rotorpong.conventions import BALL_RADIUS, InputError
from rotorpong.lab.bench import real_events
from rotorpong.lab.bench.real_events import rows
from rotorpong.lab.bench.rows import quantile_rows
from rotorpong.lab.event_files import HEADER, read_events
from rotorpong.physics.ball import Air, Ball, Surface, bounce
from rotorpong.physics.flight_bounces import UP
from rotorpong.physics.flight_fit import fall
from rotorpong.physics.flight_legs import undelayed

AIR, LAW = Air(drag=0.14, magnus=0.006, saturation=3.0), Surface(0.9, 0.2)
DELAY = 0.010


def quiet(done, total):
    pass


def vector(values):
    return "[" + " ".join(f"{value:.8f}" for value in values) + "]"


def line(rally, number, kind, time, ball):
    state = ",".join(map(vector, (ball.position, ball.velocity, ball.spin)))
    return f"A,/game_0/rally_{rally}/event{number},{kind},{time:.6f},{state}"


def shots(count, rng):
    position = rng.uniform([-1.5, -0.5, 0.15], [-1.0, 0.5, 0.4], (count, 3))
    velocity = rng.uniform([4.0, -1.0, 0.0], [10.0, 1.0, 2.0], (count, 3))
    spin = rng.normal(0.0, 100.0, (count, 3))
    spin[::2, 1] += velocity[::2, 0] / BALL_RADIUS  # every other one nearly rolls: it will grip
    return Ball(position, velocity, spin)


def noisy(ball, rng, noise):
    sizes = (0.002, 0.03, 3.0)
    parts = (ball.position, ball.velocity, ball.spin)
    return Ball(
        *(p + noise * s * rng.normal(size=p.shape) for p, s in zip(parts, sizes, strict=True))
    )


def match_lines(count=150, *, seed=0, noise=1.0):
    """Rallies of one shot and one bounce, whose velocities are measured late."""
    rng = np.random.default_rng(seed)
    start = shots(count, rng)
    end, times = fall(start, AIR, BALL_RADIUS, 3.0)
    seen = [
        noisy(undelayed(ball, AIR, -DELAY), rng, noise) for ball in (start, bounce(end, UP, LAW))
    ]
    lines = [HEADER]
    for i in range(count):
        shot, after = (Ball(b.position[i], b.velocity[i], b.spin[i]) for b in seen)
        lines += [
            line(i, 1, "shot_p1", 10.0, shot),
            line(i, 2, "bounce_p2", 10.0 + times[i], after),
        ]
    return lines


def write(path, lines):
    path.write_text("\n".join(lines) + "\n")
    return path


def values(found):
    return {row.name.partition(" (n")[0]: row.value for row in found}


def test_the_constants_of_a_made_match_are_found(tmp_path):
    """150 noisy legs: within 4 standard errors, of the median of 20 values, 1.25 s / sqrt(20)."""
    got = values(rows(write(tmp_path / "match.csv", match_lines()), quiet))
    drag, magnus = "events: drag of all flights", "events: Magnus coefficient of all flights"
    assert abs(got[drag] - AIR.drag) < 4.0 * got[f"{drag}, standard error"]
    assert abs(got[magnus] - AIR.magnus) < 4.0 * got[f"{magnus}, standard error"]
    saturation = "events: lift saturation of all flights"
    assert abs(got[saturation] - AIR.saturation) < 4.0 * got[f"{saturation}, standard error"]
    assert got["events: delay of the velocities"] == pytest.approx(1e3 * DELAY, abs=1.0)
    for name, truth in (
        ("events: restitution, delay undone", LAW.restitution),
        ("events: friction of sliding balls", LAW.friction),
        ("events: slip that gripping balls lose", 0.4),
        ("events: spin change over a thin shell's", 1.0),
    ):
        spread = (got[f"{name}, 90 %"] - got[f"{name}, 10 %"]) / 2.56
        assert abs(got[f"{name}, median"] - truth) < 4.0 * 1.25 * spread / np.sqrt(20), name
        assert abs(got[f"{name}, median"] - truth) < 0.03, name


def test_an_exact_match_is_explained_to_the_last_digit(tmp_path):
    got = values(rows(write(tmp_path / "match.csv", match_lines(noise=0.0)), quiet))
    assert got["events: drag of all flights"] == pytest.approx(AIR.drag, abs=1e-4)
    assert got["events: restitution, delay undone, 10 %"] == pytest.approx(0.9, abs=2e-3)
    assert got["events: friction of sliding balls, 90 %"] == pytest.approx(0.2, abs=2e-3)
    assert got["events: spin change over a thin shell's, median"] == pytest.approx(1.0, abs=1e-2)


def test_a_row_that_was_not_measured_breaks_no_other(tmp_path):
    lines = match_lines()
    nothing = "[nan nan nan]"
    lines.append(f"A,/game_0/rally_900/event1,net,5.0,[0 0 0.15],{nothing},{nothing}")
    got = values(rows(write(tmp_path / "match.csv", lines), quiet))
    assert got["events: rows without velocity"] == 1
    assert got["events: flights to a bounce"] == 150


def test_events_that_lie_far_apart_are_no_flight(tmp_path):
    """A leg of 1e6 s would be flown for hours."""
    lines = match_lines()
    for rally, seconds in ((900, 10.0), (901, 1e6)):
        ball = Ball(np.array([0.0, 0.0, 0.1]), np.array([5.0, 0.0, 1.0]), np.zeros(3))
        lines += [line(rally, 1, "shot_p1", 10.0, ball)]
        lines += [line(rally, 2, "bounce_p2", 10.0 + seconds, ball)]
    got = values(rows(write(tmp_path / "match.csv", lines), quiet))
    assert got["events: flights to a bounce"] == 150


def test_a_value_that_is_not_finite_is_left_out_of_its_quantiles():
    finite = np.arange(20.0)
    spoilt = np.concatenate([finite, [np.nan, np.inf, -np.inf]])
    assert quantile_rows("x", spoilt, "1", fewest=20) == quantile_rows("x", finite, "1", fewest=20)
    assert quantile_rows("x", spoilt[1:], "1", fewest=20) == []


def test_a_ball_that_comes_in_level_breaks_no_row(tmp_path, monkeypatch, capfd):
    bounces = real_events.bounces_of

    def level(match, fit):
        found = bounces(match, fit)
        found.before.velocity[:3, 2] = 0.0
        return found

    monkeypatch.setattr(real_events, "bounces_of", level)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = rows(write(tmp_path / "match.csv", match_lines()), quiet)
    assert all(row.as_json() for row in found)
    assert "events: restitution, velocities as given, median (n = 147)" in {r.name for r in found}


def test_every_row_has_a_finite_value_and_a_name_of_its_own(tmp_path):
    found = rows(write(tmp_path / "match.csv", match_lines()), quiet)
    assert all(row.as_json() for row in found)
    assert len({row.name for row in found}) == len(found)


def test_in_a_folder_files_of_another_kind_are_passed_over_and_counted(tmp_path):
    (tmp_path / "inside").mkdir()
    write(tmp_path / "inside" / "match.csv", match_lines())
    write(tmp_path / "flight.csv", ["time_s,x_m,y_m,z_m", "0,0,0,1"])
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff")
    events, others = read_events(tmp_path)
    assert (len(events), others) == (300, 2)


def test_progress_ends_with_all_steps_done(tmp_path):
    told = []
    rows(write(tmp_path / "match.csv", match_lines()), lambda *step: told.append(step))
    assert told[-1][0] == told[-1][1]
    assert [done for done, _ in told] == sorted(done for done, _ in told)


GOOD = "A,/game_0/rally_0/event1,shot_p1,1.0,[0 0 0.3],[5 0 1],[0 10 0]"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "is empty"),
        (["a,b"], "begins with 'a,b'"),
        ([HEADER], "no row after its header"),
        ([HEADER, GOOD + ",7"], "line 2: 8 fields; expected 7"),
        ([HEADER, GOOD.replace("[0 0 0.3]", "[nan 0 0.3]")], "line 2: nan m"),
        ([HEADER, GOOD.replace("[5 0 1]", "[nan nan nan]")], "line 2: nan m/s"),
        ([HEADER, GOOD.replace("[0 0 0.3]", "[0 0 300]")], "line 2: 300 m; expected at most 10"),
        ([HEADER, GOOD.replace("[5 0 1]", "[5000 0 1000]")], "m/s; expected at most 60"),
        ([HEADER, GOOD.replace("[0 10 0]", "[0 1e5 0]")], "rad/s; expected at most 2000"),
        ([HEADER, GOOD.replace("[0 10 0]", "0 10 0")], "'0 10 0'; expected a vector"),
        ([HEADER, GOOD.replace("[0 10 0]", "[0 ten 0]")], "expected a vector"),
        ([HEADER, GOOD.replace(",1.0,", ",inf,")], "timestamp 'inf'"),
        ([HEADER, GOOD.replace("shot_p1", "serve")], "type 'serve'"),
        ([HEADER, GOOD.replace("event1", "end")], "expected one that ends in event<n>"),
        ([HEADER, GOOD, GOOD.replace("event1", "event2").replace(",1.0,", ",0.5,")], "increasing"),
        ([HEADER, GOOD], "0 flights to a bounce in 1 events"),
    ],
)
def test_what_are_no_events_is_one_line_that_names_the_file(tmp_path, lines, message):
    with pytest.raises(InputError) as error:
        rows(write(tmp_path / "bad.csv", lines), quiet)
    assert message in str(error.value)
    assert "bad.csv" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_folder_without_events_is_an_error(tmp_path):
    with pytest.raises(InputError, match="0 files, none of them with the header"):
        rows(tmp_path, quiet)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        rows(tmp_path / "nowhere.csv", quiet)
