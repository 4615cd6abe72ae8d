"""Observations and actions as tables: name, unit, range and meaning of every number.

The documentation's tables are these.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium import spaces
from jaxtyping import Float, Float32
from numpy import ndarray

from rotorpong.conventions import InputError


@dataclass(frozen=True, slots=True)
class Quantity:
    """One number of an observation or action."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str


def box(quantities: Sequence[Quantity]) -> spaces.Box:
    """Return the space of these numbers; a fresh one for every environment."""
    low = np.array([quantity.low for quantity in quantities], np.float32)
    high = np.array([quantity.high for quantity in quantities], np.float32)
    return spaces.Box(low, high, dtype=np.float32)


def within(values: Float[ndarray, "*batch k"], space: spaces.Box) -> Float32[ndarray, "*batch k"]:
    """Return numbers as an observation, clipped into their ranges."""
    return np.minimum(np.maximum(values, space.low), space.high).astype(np.float32)


def action_of(given: object, shape: tuple[int, ...]) -> Float[ndarray, "*shape"]:
    """Return an action clipped into [-1, 1].

    Raises:
        InputError: not finite, or of another shape.
    """
    try:
        action = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"action {given!r}: expected numbers of shape {shape}") from error
    if action.shape != shape or not np.isfinite(action).all():
        raise InputError(
            f"action {np.array2string(action, threshold=8)} of shape {action.shape}: expected "
            f"finite numbers from -1 to 1, shape {shape}"
        )
    return np.minimum(np.maximum(action, -1.0), 1.0)


def markdown(quantities: Sequence[Quantity]) -> str:
    """Return the quantities as a table of the documentation."""
    lines = ["| Num | Name | Meaning | Unit | Min | Max |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {i} | `{q.name}` | {q.meaning} | {q.unit} | {q.low:g} | {q.high:g} |"
        for i, q in enumerate(quantities)
    ]
    return "\n".join(lines)
