"""Serves in a file: one row per serve, in SI units and the world frame.

Columns, comma separated, in the order of `SERVE_COLUMNS`: where, how fast and with what spin the
ball is released, the drag it meets, restitution and friction of the table. What is written is read
back bit for bit; the Magnus coefficient is that of `Air`.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError
from rotorpong.files import write_whole
from rotorpong.lab.flight_files import FARTHEST, FASTEST, LAYOUTS, flight_from_lines, is_flight
from rotorpong.lab.from_flight import convert, serves_from_flight
from rotorpong.lab.number_rows import parse_rows, read_lines
from rotorpong.physics.ball import Air, Ball, Surface
from rotorpong.world.court import FLOOR_HEIGHT
from rotorpong.world.serves import PLANE_X, Serve

SERVE_COLUMNS = (
    "x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s",
    "drag_per_m", "restitution", "friction",
)  # fmt: skip
SPINNIEST = 2000.0  # rad/s
MOST_DRAG = 1.0  # 1/m
MOST_FRICTION = 2.0


def read_serves(path: Path) -> tuple[Serve, ...]:
    """Return the serves in a file of serves, or those that a measured flight or a folder makes.

    Raises:
        InputError: the file is unreadable, neither kind of file, or one of its rows is no serve.
    """
    if path.is_dir():
        return tuple(found.serve for found in convert(path).serves)
    lines = read_lines(path)
    if is_flight(lines):
        return serves_from_flight(flight_from_lines(path, lines))
    header = next((i for i, line in enumerate(lines) if line), None)
    if header is None:
        raise InputError(f"{path}: is empty; expected serves or a flight ({LAYOUTS})")
    if tuple(lines[header].replace(" ", "").split(",")) != SERVE_COLUMNS:
        raise InputError(
            f"{path}: begins with {lines[header][:40]!r}; expected serves, with the columns "
            f"{','.join(SERVE_COLUMNS)}, or a flight: {LAYOUTS}"
        )
    columns = len(SERVE_COLUMNS)
    rows, numbers = parse_rows(path, lines, first=header + 1, delimiter=",", columns=columns)
    if not numbers:
        raise InputError(f"{path}: a header and no serve; expected at least one row")
    for row, number in zip(rows, numbers, strict=True):
        _check(row, f"{path}: line {number}")
    return tuple(_serve(row) for row in rows)


def write_serves(path: Path, serves: Sequence[Serve]) -> None:
    """Write serves to a file; an older file stays whole until the new one is.

    Raises:
        InputError: the file cannot be written, or what is there is no regular file.
    """
    lines = [",".join(SERVE_COLUMNS), *(",".join(map(repr, _row(serve))) for serve in serves)]
    write_whole(path, ("\n".join(lines) + "\n").encode())


def _row(serve: Serve) -> list[float]:
    ball = np.concatenate([serve.ball.position, serve.ball.velocity, serve.ball.spin])
    medium = (serve.air.drag, serve.table.restitution, serve.table.friction)
    return [float(value) for value in (*ball, *medium)]


def _serve(row: Float[ndarray, "12"]) -> Serve:
    drag, restitution, friction = (float(value) for value in row[9:])
    ball = Ball(row[:3].copy(), row[3:6].copy(), row[6:9].copy())
    return Serve(ball, air=Air(drag=drag), table=Surface(restitution, friction))


def _check(row: Float[ndarray, "12"], where: str) -> None:
    """Raise InputError unless a ball can be thrown at the drone like this."""
    speed, spin = np.linalg.norm(row[3:6]), np.linalg.norm(row[6:9])
    drag, restitution, friction = row[9:]
    floor = FLOOR_HEIGHT + BALL_RADIUS
    checks = (
        (np.abs(row[:3]).max() <= FARTHEST, f"position {row[:3]} m", f"at most {FARTHEST:g}"),
        (row[0] > PLANE_X, f"x_m {row[0]:g}", f"more than {PLANE_X:g}, ahead of the blade"),
        (row[2] >= floor, f"z_m {row[2]:g}", f"at least {floor:g}, above the floor"),
        (row[3] < 0.0, f"vx_m_s {row[3]:g}", "less than 0, towards the drone"),
        (speed <= FASTEST, f"a speed of {speed:g} m/s", f"at most {FASTEST:g}"),
        (spin <= SPINNIEST, f"a spin of {spin:g} rad/s", f"at most {SPINNIEST:g}"),
        (0.0 <= drag <= MOST_DRAG, f"drag_per_m {drag:g}", f"0 to {MOST_DRAG:g}"),
        (0.0 < restitution <= 1.0, f"restitution {restitution:g}", "above 0, at most 1"),
        (0.0 <= friction <= MOST_FRICTION, f"friction {friction:g}", f"0 to {MOST_FRICTION:g}"),
    )
    for fine, given, expected in checks:
        if not fine:
            raise InputError(f"{where}: {given}; expected {expected}")
