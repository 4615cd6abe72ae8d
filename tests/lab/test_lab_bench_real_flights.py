import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.bench.real_flights import (
    both_ways,
    drop_rows,
    fit_arcs,
    lift,
    restitution_of_drop,
    rows,
)
from rotorpong.lab.flight_files import Flight
from rotorpong.physics.ball import Air, Ball, Surface
from rotorpong.physics.flight_fit import Table, follow

AIR, LAW = Air()._replace(drag=0.14, magnus=0.006), Surface(0.9, 0.2)
RATE = 160.0  # Hz
SPUN = 12  # flights


def quiet(done, total):
    pass


def throws(count, seed=0):
    """Balls thrown both ways over the table, and their spin."""
    rng = np.random.default_rng(seed)
    found = []
    for i in range(count):
        way = 1.0 if i % 2 else -1.0
        velocity = np.array([way * rng.uniform(5.0, 8.0), rng.normal(0.0, 0.3), 0.3])
        position = np.array([-way, 0.0, 0.3])
        found.append(Ball(position, velocity, rng.normal(0.0, 120.0, 3)))
    return found


def recorded(ball, seed, noise=0.0015):
    times = np.arange(0.0, 0.6, 1 / RATE)
    points = follow(ball, times, AIR, Table(LAW), most=1).position
    points = points + np.random.default_rng(seed).normal(0.0, noise, points.shape)
    low = np.flatnonzero(points[:, 2] < -0.02)
    last = int(low[0]) if len(low) else len(times)
    return Flight("made", times[:last], points[:last])


def write(path, flight):
    rows_ = np.column_stack([flight.times, flight.positions]).tolist()
    path.write_text("\n".join(";".join(f"{value:.5f}" for value in row) for row in rows_) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A tree of made flights with an index of their spins, and files of other kinds."""
    top = tmp_path_factory.mktemp("flights")
    inside = top / "machine"
    inside.mkdir()
    balls = throws(SPUN)
    index = ["traj_file,x_spin,y_spin,z_spin"]
    for i, ball in enumerate(balls):
        write(inside / f"{i:03d}.csv", recorded(ball, i))
        index.append(f"{i}," + ",".join(map(str, ball.spin)))
    (inside / "index.csv").write_text("\n".join(index))
    (top / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff")
    return top


@pytest.fixture(scope="module")
def found(folder):
    return rows(folder, quiet)


def values(found):
    return {row.name.partition(" (n")[0]: row.value for row in found}


def within(got, name, truth, count):
    """Whether a median of `count` values lies within 4 standard errors, 1.25 s / sqrt(n)."""
    spread = (got[f"{name}, 90 %"] - got[f"{name}, 10 %"]) / 2.56
    return abs(got[f"{name}, median"] - truth) < 4.0 * 1.25 * spread / np.sqrt(count)


def test_the_constants_of_made_flights_are_found(found):
    got = values(found)
    assert within(got, "flights: drag", AIR.drag, 8)
    assert within(got, "flights: Magnus coefficient, our saturation", AIR.magnus, 8)
    assert within(got, "flights: restitution", LAW.restitution, 8)
    assert got["flights: restitution, median"] == pytest.approx(LAW.restitution, abs=0.015)
    both = got["flights: restitution in machine, mean of both ways"]
    assert both == pytest.approx(LAW.restitution, abs=0.015)


def test_more_of_the_model_leaves_less_of_the_flight(found):
    got = values(found)
    names = ("gravity only", "default drag", "drag and spin")
    left = [got[f"flights: residual, {name}, median rms"] for name in names]
    assert left == sorted(left, reverse=True)
    assert left[-1] == pytest.approx(1.5 * np.sqrt(3.0), rel=0.15)  # mm: the noise alone
    (target,) = [row for row in found if row.target is not None]
    assert target.met


def test_files_of_other_kinds_are_passed_over_and_counted(found):
    got = values(found)
    assert got["flights: recordings"] == SPUN
    assert got["flights: files passed over"] == 2


def test_every_row_has_a_finite_value_and_a_name_of_its_own(found):
    assert all(row.as_json() for row in found)
    assert len({row.name for row in found}) == len(found)


def test_spin_of_the_wrong_sign_shows_in_the_lift():
    (ball,) = throws(1)
    before = fit_arcs(recorded(ball, 0))[0]
    magnus, cosine, ratio = lift(before.open_fit, ball.spin)
    assert lift(before.open_fit, -ball.spin) == pytest.approx((-magnus, -cosine, ratio))
    assert cosine > 0.7


def test_a_tilted_frame_shifts_the_two_ways_apart_and_not_their_mean():
    """A tilt of 0.5 degrees, put into exact vertical speeds by hand."""
    way = np.repeat([1.0, -1.0], 10)
    flat = np.stack([7.0 * way, 0.3 * np.ones(20)], axis=1)
    lifted = np.radians(0.5) * flat[:, 0]
    measured = (0.9 * 2.3 + lifted) / (2.3 - lifted)
    one, other, mean = both_ways("here", flat, measured)
    assert abs(one.value - other.value) > 0.06
    assert mean.value == pytest.approx(0.9, abs=2e-3)


def test_of_one_way_alone_no_mean_is_told():
    flat = np.tile([[5.0, 0.0]], (10, 1))
    assert len(both_ways("here", flat, np.full(10, 0.9))) == 1


def test_without_air_the_drop_gives_the_square_root_of_the_heights():
    vacuum = Air(drag=0.0, magnus=0.0)
    for height in (0.230, 0.245, 0.260):
        assert restitution_of_drop(height, vacuum) == pytest.approx(
            np.sqrt(height / 0.305), abs=1e-6
        )


def test_in_air_the_drop_follows_the_closed_form_of_quadratic_drag():
    """Down v^2 = g/k (1 - exp(-2kh)), up h = ln(1 + k v^2/g) / 2k."""
    k, g = 0.15, 9.81
    for row, height in zip(drop_rows(Air(drag=k)), (0.230, 0.245, 0.260), strict=True):
        down = g / k * (1.0 - np.exp(-2.0 * k * 0.305))
        up = g / k * (np.exp(2.0 * k * height) - 1.0)
        assert row.value == pytest.approx(np.sqrt(up / down), abs=1e-6)


def test_short_arcs_are_left_out():
    flight = recorded(throws(1)[0], 0)
    assert fit_arcs(Flight("short", flight.times[:10], flight.positions[:10])) == []


ROWS = "".join(f"{i / 100};{1 - i * 0.05};0;{0.3 - 0.001 * i}\n" for i in range(20))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROWS + "0.5;nan;0;0\n", "line 21: 'nan'"),
        (ROWS.replace("0.3;", "0.3;", 1) + "0.5;400;0;0\n", "400 m; expected metres"),
        (ROWS[:90], "expected"),
        ("", "is empty"),
    ],
)
def test_a_damaged_flight_is_one_line_that_names_the_file(tmp_path, text, message):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        rows(path, quiet)
    assert message in str(error.value)
    assert "bad.csv" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_folder_without_flights_is_an_error(tmp_path):
    with pytest.raises(InputError, match="0 files, none of them a flight"):
        rows(tmp_path, quiet)


def test_a_damaged_index_is_an_error(folder, tmp_path):
    (tmp_path / "000.csv").write_bytes((folder / "machine" / "000.csv").read_bytes())
    (tmp_path / "index.csv").write_text("traj_file,x_spin,y_spin,z_spin\n0,1,nan,3\n")
    with pytest.raises(InputError, match=r"index.csv: line 2: 'nan'"):
        rows(tmp_path, quiet)


def test_recordings_too_short_to_tell_anything_are_an_error(tmp_path):
    (tmp_path / "short.csv").write_text(
        ROWS.splitlines()[0] + "\n" + "\n".join(ROWS.split("\n")[1:8])
    )
    with pytest.raises(InputError, match="no free flight of 12 points"):
        rows(tmp_path, quiet)
