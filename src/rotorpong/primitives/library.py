"""The library of hitting motions Pi = {pi_k}, and its file.

The file is one JSON object, `{"format": "rotorpong-library", "version": 1, "primitives": [...]}`;
numbers are written in full, so what is read is what was saved, bit for bit.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.primitives.dmp import Dmp, Motion
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
        primitives = [_plain(dmp) for dmp in self.primitives]
        document = {"format": FORMAT, "version": VERSION, "primitives": primitives}
        try:
            _replace(Path(path), json.dumps(document))
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror})") from error

    @classmethod
    def load(cls, path: str | Path) -> "Library":
        """Read a library that `save` wrote.

        Raises:
            InputError: no such file, or one that is damaged or not a library.
        """
        try:
            document = json.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"{path}: cannot be read ({error.strerror})") from error
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path}: expected a library of primitives, found no JSON") from error
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise InputError(f"{path}: expected a library of primitives, found another format")
        if document.get("version") != VERSION:
            found = document.get("version")
            raise InputError(f"{path}: library version {found!r}, expected {VERSION}")
        try:
            return cls(tuple(_dmp(entry) for entry in document["primitives"]))
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise InputError(f"{path}: damaged library of primitives ({error})") from error


def _plain(dmp: Dmp) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "weights": dmp.weights.tolist(),
        "forcing_gain": float(dmp.forcing_gain),
        "ends": None,
    }
    if dmp.ends is not None:
        entry["ends"] = {
            "times_s": dmp.ends.times.tolist(),
            "position_m": dmp.ends.position.tolist(),
            "velocity_m_s": dmp.ends.velocity.tolist(),
        }
    return entry


def _dmp(entry: Any) -> Dmp:
    weights = _numbers(entry["weights"], dimensions=2)
    gain = float(_numbers(entry["forcing_gain"], dimensions=0))
    if entry["ends"] is None:
        return Dmp(weights, gain)
    times = _numbers(entry["ends"]["times_s"], dimensions=1)
    position = _numbers(entry["ends"]["position_m"], dimensions=2)
    velocity = _numbers(entry["ends"]["velocity_m_s"], dimensions=2)
    if len(times) != 2 or not position.shape == velocity.shape == (2, weights.shape[1]):
        raise ValueError("ends that are not two states")
    return Dmp(weights, gain, Motion(times, position, velocity))


def _numbers(values: Any, *, dimensions: int) -> ndarray:
    array = np.asarray(values, dtype=float)
    if array.ndim != dimensions or array.size == 0 or not np.isfinite(array).all():
        raise ValueError(f"an array of shape {array.shape} where finite numbers should be")
    return array


def _replace(path: Path, text: str) -> None:
    draft = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with draft.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)
