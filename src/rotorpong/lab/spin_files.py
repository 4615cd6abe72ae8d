"""Measured spin of flights: an `index.csv` beside them, `traj_file,x_spin,y_spin,z_spin`, rad/s.

A row belongs to the flight in the same folder whose file name is its number: `7` to `007.csv`.
"""

from pathlib import Path

from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.lab.number_rows import parse_rows, read_lines

NAME = "index.csv"
HEADER = "traj_file,x_spin,y_spin,z_spin"


def read_spins(folder: Path) -> dict[int, Float[ndarray, "3"]]:
    """Return the spin by number of flight that a folder's index tells; none without an index.

    Raises:
        InputError: the index is damaged.
    """
    path = folder / NAME
    if not path.is_file():
        return {}
    lines = read_lines(path)
    if lines[0].replace(" ", "") != HEADER:
        raise InputError(f"{path}: begins with {lines[0][:40]!r}; expected the header {HEADER}")
    rows, _ = parse_rows(path, lines, first=1, delimiter=",", columns=4)
    return {int(row[0]): row[1:].copy() for row in rows}


def spin_of(name: str, known: dict[Path, dict[int, Float[ndarray, "3"]]]) -> ndarray | None:
    """Return the spin of the flight in a file, None if no index tells it.

    Args:
        name: of the flight, its path.
        known: indices by folder, filled as folders are met.
    """
    path = Path(name)
    if path.parent not in known:
        known[path.parent] = read_spins(path.parent)
    return known[path.parent].get(int(path.stem)) if path.stem.isdecimal() else None
