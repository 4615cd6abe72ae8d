import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.serve_files import SERVE_COLUMNS, read_serves, write_serves
from rotorpong.physics.ball import Air, Surface
from rotorpong.world.contact import Solids, advance, state_of
from rotorpong.world.serves import HUMAN, Serve, draw

HEADER = ",".join(SERVE_COLUMNS) + "\n"
GOOD = [2.0, 0.1, 0.3, -6.5, -0.2, 0.4, 10.0, -20.0, 30.0, 0.15, 0.88, 0.25]


def made(count):
    rng = np.random.default_rng(5)
    thrown = [draw(HUMAN, rng) for _ in range(count)]
    return [
        Serve(one.ball, Air(drag=rng.uniform(0.11, 0.17)), Surface(*rng.uniform(0.2, 0.9, 2)))
        for one in thrown
    ]


def numbers(serve):
    medium = (serve.air.drag, serve.table.restitution, serve.table.friction)
    return [*state_of(serve.ball), *medium]


def with_row(tmp_path, **changed):
    row = dict(zip(SERVE_COLUMNS, GOOD, strict=True)) | changed
    path = tmp_path / "serves.csv"
    path.write_text(HEADER + ",".join(map(str, GOOD)) + "\n" + ",".join(map(str, row.values())))
    return path


def test_what_is_written_is_read_bit_for_bit(tmp_path):
    serves = made(12)
    write_serves(tmp_path / "serves.csv", serves)
    read = read_serves(tmp_path / "serves.csv")
    assert [numbers(one) for one in read] == [numbers(one) for one in serves]
    write_serves(tmp_path / "again.csv", read)
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "serves.csv").read_bytes()


def test_writing_replaces_the_old_file_and_leaves_nothing_else(tmp_path):
    write_serves(tmp_path / "serves.csv", made(3))
    write_serves(tmp_path / "serves.csv", made(1))
    assert len(read_serves(tmp_path / "serves.csv")) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["serves.csv"]


def test_a_file_that_cannot_be_written_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"missing/serves\.csv: the folder .* does not exist"):
        write_serves(tmp_path / "missing" / "serves.csv", made(1))


def test_a_flight_is_read_as_the_serve_that_it_makes(tmp_path):
    serve = draw(HUMAN, np.random.default_rng(0))
    track = np.repeat([[0.0, 0.0, 99.0, 1.0, 0.0, 0.0, 0.0]], 901, axis=0)
    path, _ = advance(state_of(serve.ball), 0.0, track, Solids())
    rows = np.column_stack([np.arange(len(path)) * 0.001, path[:, :3]])[::6]
    flight = tmp_path / "flight.csv"
    flight.write_text("\n".join(";".join(map(repr, row)) for row in rows.tolist()))
    (read,) = read_serves(flight)
    (from_folder,) = read_serves(tmp_path)
    assert numbers(read) == numbers(from_folder)
    assert abs(read.air.drag - 0.15) < 0.01
    write_serves(tmp_path / "serves.csv", [read])
    assert numbers(read_serves(tmp_path / "serves.csv")[0]) == numbers(read)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"z_m": "nan"}, "'nan'; expected a finite number"),
        ({"vy_m_s": "inf"}, "'inf'; expected a finite number"),
        ({"friction": -0.1}, "friction -0.1; expected 0 to 2"),
        ({"restitution": 1.2}, "restitution 1.2"),
        ({"drag_per_m": -0.1}, "drag_per_m -0.1"),
        ({"vx_m_s": -61.0}, "a speed of 61"),
        ({"vx_m_s": 3.0}, "vx_m_s 3; expected less than 0"),
        ({"x_m": 2000.0}, "expected at most 10"),
        ({"x_m": -1.8}, "ahead of the blade"),
        ({"z_m": -0.9}, "above the floor"),
        ({"wz_rad_s": 1e6}, "a spin of 1e+06"),
    ],
)
def test_a_row_that_is_no_serve_is_named(tmp_path, changed, message):
    with pytest.raises(InputError) as error:
        read_serves(with_row(tmp_path, **changed))
    assert message in str(error.value)
    assert "serves.csv: line 3" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (HEADER.encode(), "a header and no serve"),
        (HEADER.replace("x_m,y_m", "y_m,x_m").encode(), "expected serves, with the columns"),
        (b"x_m,y_m,z_m\n1,2,3\n", "expected serves, with the columns"),
        (HEADER.encode() + b"1,2,3\n", "line 2: 3 fields; expected 12"),
        (b"\x80\x81", "no UTF-8 text"),
    ],
)
def test_a_file_of_something_else_is_named(tmp_path, data, message):
    path = tmp_path / "serves.csv"
    path.write_bytes(data)
    with pytest.raises(InputError) as error:
        read_serves(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)
