import itertools

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.flight_files import Flight, read_flight, read_flights
from rotorpong.lab.from_flight import convert, convert_flight, serves_from_flight
from rotorpong.lab.placing import LEAST_AHEAD
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball
from rotorpong.physics.flight_fit import Table, follow
from rotorpong.world.contact import Solids, advance, approach, state_of
from rotorpong.world.racket import HOME_BLADE
from rotorpong.world.serves import HUMAN, PLANE_X, draw

RATE = 180.0  # Hz
LAYOUTS = {
    "time_s,x_m,y_m,z_m\n": ",",
    "Timestamp,X,Y,Z\n": ",",
    "": ";",
}


def path_of(serve, times):
    """The court's own simulator, not the one that fits."""
    track = np.repeat([[0.0, 0.0, 99.0, 1.0, 0.0, 0.0, 0.0]], round(times[-1] * 1000) + 2, axis=0)
    solids = Solids(air=serve.air, table=serve.table)
    path, _ = advance(state_of(serve.ball), 0.0, track, solids)
    grid = np.arange(len(path) + 1) * 0.001
    position = np.vstack([serve.ball.position, path[:, :3]])
    return np.stack([np.interp(times, grid, position[:, k]) for k in range(3)], axis=1)


def record(serve, *, begin=0.15, end=0.95, yaw=0.0, noise=0.0, seed=0):
    times = np.arange(begin, end, 1 / RATE)
    c, s = np.cos(yaw), np.sin(yaw)
    points = path_of(serve, times) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    points += np.random.default_rng(seed).normal(0.0, noise, points.shape)
    return Flight("made", times + 7.0, points)


def human(seed):
    return draw(HUMAN, np.random.default_rng(seed))


def write(path, flight, header="time_s,x_m,y_m,z_m\n"):
    rows = np.column_stack([flight.times, flight.positions])
    delimiter = LAYOUTS[header]
    path.write_text(header + "\n".join(delimiter.join(map(repr, row)) for row in rows.tolist()))
    return path


@pytest.mark.parametrize(("seed", "yaw"), [(0, 0.0), (1, 0.9), (2, np.pi / 2), (3, -2.5)])
def test_a_recorded_serve_is_thrown_along_the_curve_that_was_measured(seed, yaw):
    flight = record(human(seed), yaw=yaw)
    (found,) = convert_flight(flight)
    moved = found.placed.moved(flight.positions)
    serve = found.serve
    time, _, contacts = approach(state_of(serve.ball), PLANE_X, Solids(found.fit.air, serve.table))
    thrown = path_of(serve, np.arange(0.0, time, 2e-4))
    inside = (moved[:, 0] < serve.ball.position[0]) & (moved[:, 0] > PLANE_X)
    gaps = [np.linalg.norm(thrown - point, axis=1).min() for point in moved[inside]]
    assert inside.sum() > 0.5 * len(moved)
    assert max(gaps) < 1.5e-3  # the grid of the thrown path itself is 1.4 mm
    assert np.median(gaps) < 1e-3
    assert [contact.solid for contact in contacts] == ["table"]


@pytest.mark.parametrize("seed", range(4))
def test_moving_is_rigid_and_keeps_up_up(seed):
    flight = record(human(seed), yaw=1.0 + seed)
    (found,) = convert_flight(flight)
    points = flight.positions
    moved = found.placed.moved(points)
    for a, b in itertools.combinations(range(0, len(points), 20), 2):
        assert np.isclose(
            np.linalg.norm(moved[a] - moved[b]), np.linalg.norm(points[a] - points[b])
        )
    assert np.ptp(moved[:, 2] - points[:, 2]) < 1e-12
    assert abs(moved[0, 2] - points[0, 2]) < 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_what_comes_out_is_a_whole_legal_serve(seed):
    (found,) = convert_flight(record(human(seed), yaw=2.0, noise=0.003, seed=seed))
    _, _, (touch,) = approach(state_of(found.serve.ball), PLANE_X, Solids(air=found.fit.air))
    assert touch.solid == "table"
    assert touch.position[0] < 0.0
    assert found.serve.ball.position[0] >= PLANE_X + LEAST_AHEAD
    assert found.serve.ball.velocity[0] < 0.0
    assert abs(found.placed.left) < 1e-3
    assert abs(found.placed.up) <= 0.2 + 1e-9
    assert found.placed.bounces == 1


@pytest.mark.parametrize("seed", range(4))
def test_noise_hardly_changes_what_is_found(seed):
    serve = human(seed)
    (found,) = convert_flight(record(serve, begin=0.0, noise=0.002, seed=seed))
    assert np.abs(found.fit.ball.velocity - serve.ball.velocity).max() < 0.1
    assert abs(found.fit.drag - 0.15) < 0.02
    assert found.fit.residual_rms < 0.005


def test_a_flight_seen_only_before_its_bounce_bounces_where_it_is_extended():
    (found,) = convert_flight(record(human(5), begin=0.0, end=0.3))
    assert not found.fit.bounced
    assert found.placed.bounces == 1


def test_a_recording_of_strokes_to_and_fro_gives_a_serve_for_each():
    there = record(human(6), begin=0.0, end=0.55)
    back = record(human(7), begin=0.0, end=0.55, yaw=np.pi)
    positions = back.positions + there.positions[-1] - back.positions[0]
    positions[:, 2] = back.positions[:, 2]
    times = np.concatenate([there.times, there.times[-1] + 0.2 + back.times - back.times[0]])
    flight = Flight("rally", times, np.concatenate([there.positions, positions]))
    assert len(serves_from_flight(flight)) == 2


@pytest.mark.parametrize("header", LAYOUTS)
def test_each_layout_is_read_to_the_last_bit(tmp_path, header):
    flight = record(human(0))
    read = read_flight(write(tmp_path / "flight.txt", flight, header))
    assert np.array_equal(read.times, flight.times)
    assert np.array_equal(read.positions, flight.positions)


def test_windows_line_ends_and_a_byte_order_mark_change_nothing(tmp_path):
    path = write(tmp_path / "flight.csv", record(human(0)))
    other = tmp_path / "other.csv"
    other.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert np.array_equal(read_flight(path).positions, read_flight(other).positions)


def test_in_a_folder_other_files_are_passed_over_and_counted(tmp_path):
    for header, name in zip(LAYOUTS, ("a.csv", "b.csv", "c.txt"), strict=True):
        write(tmp_path / name, record(human(1)), header)
    (tmp_path / "index.csv").write_text("file,spin\na.csv,3\n")
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "folder").mkdir()
    flights, others = read_flights(tmp_path)
    assert (len(flights), others) == (3, 3)
    found = convert(tmp_path)
    assert (len(found.serves), found.files_passed_over, found.flights_passed_over) == (3, 3, 0)


def test_in_a_folder_flights_without_a_serve_are_passed_over_and_counted(tmp_path):
    write(tmp_path / "a.csv", record(human(1)))
    still = np.tile([0.0, 0.0, 0.5], (30, 1))
    write(tmp_path / "b.csv", Flight("still", np.arange(30) / RATE, still))
    found = convert(tmp_path)
    assert (len(found.serves), found.flights_passed_over) == (1, 1)
    (tmp_path / "a.csv").unlink()
    with pytest.raises(InputError, match="no serve in any of its 1 flights"):
        convert(tmp_path)


def test_a_folder_without_flights_is_an_error(tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(InputError, match="1 files, none of them a flight"):
        read_flights(tmp_path)


ROWS = "".join(f"{i / 100},{1 - i * 0.05},0,{0.3 - 0.001 * i}\n" for i in range(20))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"t,x,y,z\n1,2,3,4\n", "begins with 't,x,y,z'"),
        (b"time_s,x_m,y_m,z_m\n", "0 points; expected at least 5"),
        (b"0;0;0;1\n0.1;0;0;1\n0.2;0;0;1\n0.3;0;0;1\n", "4 points"),
        (b"Timestamp,X,Y,Z\n" + ROWS.encode() + b"0.5,nan,0,0\n", "line 22: 'nan'"),
        (b"Timestamp,X,Y,Z\n" + ROWS.encode() + b"0.5,1e999,0,0\n", "line 22: '1e999'"),
        (b"Timestamp,X,Y,Z\n" + ROWS.encode() + b"0.5,a ball,0,0\n", "line 22: 'a ball'"),
        (b"Timestamp,X,Y,Z\n" + ROWS.encode() + b"0.5,1,0\n", "line 22: 3 fields; expected 4"),
        (b"Timestamp,X,Y,Z\n" + ROWS.encode() + b"0.05,0,0,0.2\n", "line 22: time 0.05 s after"),
        (
            b"Timestamp,X,Y,Z\n" + ROWS.encode() + b"0.5,40,0,0.2\n",
            "line 22: 40 m; expected metres",
        ),
        (b"Timestamp,X,Y,Z\n" + b"1,0,0,0\n" * 9, "every time is 1 s"),
        (b"Timestamp,X,Y,Z\n\xff\xfe\x00", "no UTF-8 text"),
        (b"Timestamp,X,Y,Z\n" + ROWS.encode()[:-30] + b"\x00\x00\x00", "expected"),
    ],
)
def test_what_is_no_flight_is_one_line_that_names_file_and_row(tmp_path, data, message):
    path = tmp_path / "bad.csv"
    path.write_bytes(data)
    with pytest.raises(InputError) as error:
        read_flight(path)
    assert message in str(error.value)
    assert "bad.csv" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_flight(tmp_path / "nowhere.csv")


def rising(t):
    return np.stack([1.5 - 4 * t, 0 * t, 0.3 + 2 * t], axis=1)


def passing_high_above(t):
    ball = Ball(np.array([1.5, 0.0, 4.0]), np.array([-7.0, 0.0, 0.0]), np.zeros(3))
    return follow(ball, t, Air(), Table(TABLE_SURFACE), most=0).position


@pytest.mark.parametrize(
    ("curve", "seconds", "message"),
    [
        (rising, 0.8, "no free flight of a ball"),
        (passing_high_above, 0.06, "seen for 0.05"),
        (lambda t: np.stack([0 * t, 0 * t, 3 - 4.905 * t**2], axis=1), 0.4, "wherever it is moved"),
    ],
)
def test_what_cannot_be_a_serve_says_why(curve, seconds, message):
    times = np.arange(0.0, seconds, 1 / RATE)
    with pytest.raises(InputError, match=message) as error:
        convert_flight(Flight("odd.csv", times, curve(times)))
    assert str(error.value).startswith("odd.csv: no serve can be made of it: ")


def test_the_blade_plane_is_where_the_serve_is_aimed():
    (found,) = convert_flight(record(human(2)))
    solids = Solids(air=found.serve.air, table=found.serve.table)
    _, state, _ = approach(state_of(found.serve.ball), PLANE_X, solids)
    assert np.allclose(state[1:3] - HOME_BLADE[1:], [found.placed.left, found.placed.up])
