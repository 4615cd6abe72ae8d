"""Constants as data: what is possible, how far they vary, and drawing them within that.

A set of constants is a NamedTuple of floats, as the kernels take it; beside it stands a mapping
from the name of each that varies to its range (low, high).
"""

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from rotorpong.conventions import InputError

Range = tuple[float, float]
Constants = TypeVar("Constants")  # a NamedTuple


def require_constants(owner: str, constants: Any, limits: Mapping[str, Range]) -> None:
    """Refuse constants that are not finite or lie outside their limits.

    Args:
        owner: who has them, for the message.
        constants: a NamedTuple of floats.
        limits: what is possible, both ends included; names that it lacks must be >= 0, names that
            `constants` lacks are passed over.

    Raises:
        InputError: the first that is impossible.
    """
    for name, value in constants._asdict().items():
        low, high = limits.get(name, (0.0, np.inf))
        if not (np.isfinite(value) and low <= value <= high):
            raise InputError(f"{owner}: {name} {value}: expected a finite number {low} to {high}")


def drawn(constants: Constants, ranges: Mapping[str, Range], rng: np.random.Generator) -> Constants:
    """Return the constants with each that has a range drawn from it, evenly, in field order."""
    fields: Any = constants
    names = [name for name in fields._fields if name in ranges]
    return fields._replace(**{name: float(rng.uniform(*ranges[name])) for name in names})
