"""The library of hitting motions Pi = {pi_k}, and its file.

The file is one JSON object, `{"format": "rotorpong-library", "version": 1, "primitives": [...]}`;
numbers are written in full, so what is read is what was saved, bit for bit. The gain of a primitive
is one number, or one per coordinate.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.primitives.dmp import Dmp, Motion
from rotorpong.primitives.documents import numbers, read_document, write_document
from rotorpong.primitives.mixing import mix, require_alike

FORMAT = "rotorpong-library"
VERSION = 1


@dataclass(frozen=True, slots=True)
class Library:
    """K primitives of the same bases and coordinates."""

    primitives: tuple[Dmp, ...]

    def __post_init__(self) -> None:
        """Check that they can be mixed."""
        require_alike(self.primitives)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.primitives)

    def mix(self, weights: Float[ndarray, "k"]) -> Dmp:
        """Return the blend of all primitives, see `rotorpong.primitives.mix`."""
        return mix(self.primitives, weights)

    def save(self, path: str | Path) -> None:
        """Write the library to `path`, whole or not at all.

        Raises:
            InputError: the file cannot be written.
        """
        primitives = [plain_dmp(dmp) for dmp in self.primitives]
        document = {"format": FORMAT, "version": VERSION, "primitives": primitives}
        write_document(path, document)

    @classmethod
    def load(cls, path: str | Path) -> "Library":
        """Read a library that `save` wrote.

        Raises:
            InputError: no such file, or one that is damaged or not a library.
        """
        document = read_document(path, FORMAT, VERSION, what="library of primitives")
        try:
            return cls(tuple(dmp_of(entry) for entry in document["primitives"]))
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise InputError(f"{path}: damaged library of primitives ({error})") from error


def plain_dmp(dmp: Dmp) -> dict[str, Any]:
    """Return a primitive as a file's entry."""
    entry: dict[str, Any] = {
        "weights": dmp.weights.tolist(),
        "forcing_gain": np.asarray(dmp.forcing_gain, dtype=float).tolist(),
        "ends": None,
    }
    if dmp.ends is not None:
        entry["ends"] = {
            "times_s": dmp.ends.times.tolist(),
            "position_m": dmp.ends.position.tolist(),
            "velocity_m_s": dmp.ends.velocity.tolist(),
        }
    return entry


def dmp_of(entry: Any) -> Dmp:
    """Return the primitive of a file's entry.

    Raises:
        KeyError, TypeError, ValueError, OverflowError: the entry is damaged.
    """
    weights = numbers(entry["weights"], dimensions=2)
    gain = _gain(entry["forcing_gain"], weights.shape[1])
    if entry["ends"] is None:
        return Dmp(weights, gain)
    times = numbers(entry["ends"]["times_s"], dimensions=1)
    position = numbers(entry["ends"]["position_m"], dimensions=2)
    velocity = numbers(entry["ends"]["velocity_m_s"], dimensions=2)
    if len(times) != 2 or not position.shape == velocity.shape == (2, weights.shape[1]):
        raise ValueError("ends that are not two states")
    return Dmp(weights, gain, Motion(times, position, velocity))


def _gain(value: Any, coordinates: int) -> float | ndarray:
    if not isinstance(value, list):
        return float(numbers(value, dimensions=0))
    gain = numbers(value, dimensions=1)
    if len(gain) != coordinates:
        raise ValueError(f"{len(gain)} gains for {coordinates} coordinates")
    return gain
