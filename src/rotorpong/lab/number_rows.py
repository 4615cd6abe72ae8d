"""Rows of numbers from a text file of somebody else's, checked at the door."""

import math
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError

LARGEST_FILE = 4 * 2**20  # bytes


def read_lines(path: Path) -> list[str]:
    """Return the lines of a text file, stripped; empty ones stay, to keep the count.

    Raises:
        InputError: it cannot be read, is no UTF-8 text, or is too large.
    """
    try:
        if not path.is_file():
            raise InputError(f"{path}: no such file")
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    if len(data) > LARGEST_FILE:
        raise InputError(f"{path}: expected at most {LARGEST_FILE} bytes")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: no UTF-8 text (byte {error.start}); expected a CSV") from None
    return [line.strip() for line in text.split("\n")]


def parse_rows(
    path: Path, lines: list[str], *, first: int, delimiter: str, columns: int
) -> tuple[Float[ndarray, "n columns"], list[int]]:
    """Return the numbers of all lines from index `first` on, and the line number of each row.

    Raises:
        InputError: a row of another length, or with something that is no finite number.
    """
    rows, numbers = [], []
    for number, line in enumerate(lines[first:], start=first + 1):
        if line:
            rows.append(_row(f"{path}: line {number}", line.split(delimiter), columns))
            numbers.append(number)
    return np.array(rows, dtype=float).reshape(-1, columns), numbers


def _row(where: str, fields: list[str], columns: int) -> list[float]:
    if len(fields) != columns:
        raise InputError(f"{where}: {len(fields)} fields; expected {columns}")
    return [finite_number(f"{where}:", field) for field in fields]


def finite_number(where: str, field: str) -> float:
    """Return the number in a field.

    Args:
        where: what an error begins with.
        field: text.

    Raises:
        InputError: it holds none, or one that is not finite.
    """
    try:
        value = float(field)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where} {field.strip()[:40]!r}; expected a finite number")
    return value
