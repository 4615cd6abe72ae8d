"""What is worth keeping of a run: who played, what was shown, what became of each serve.

The ball's state at the plane is in the camera frame; a hitting point is the body's displacement
since the trigger (m), its velocity then (m/s) and the duration (s), in the level axes frozen at
the trigger, as labelled; the mixture weights are gamma_k of the primitives. Times are seconds,
everything is SI. No record carries a time of day or a name of a machine, so that a resumed run
equals an uninterrupted one, row for row. Every number is finite: NaN is refused at construction.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import OUTCOMES, Outcome

Scalar = str | int | float | bool | None
COMMAND_COLUMNS = ("time_s", "forward_m_s", "left_m_s", "up_m_s", "yaw_rate_rad_s")
LARGEST_INTEGER = 2**63 - 1  # of an SQLite column


@dataclass(frozen=True, slots=True, eq=False)
class Demonstration:
    """A seed, a spec and the pilot's commands: enough to fly the demonstration again."""

    seed: int
    trial: int
    spec: Mapping[str, Scalar]  # vehicle, serves, ...
    pilot: str  # "scripted", or who was at the controls
    commands: Float[ndarray, "n 5"]  # rows of COMMAND_COLUMNS, oldest first

    def __post_init__(self) -> None:
        """Refuse what could not be flown again."""
        require_integer("seed", self.seed)
        require_integer("trial", self.trial)
        require_array("commands", self.commands, -1, len(COMMAND_COLUMNS))
        if np.any(np.diff(self.commands[:, 0]) <= 0):
            raise InputError("commands: times go backwards or stand still; expected them to rise")
        for key, value in self.spec.items():
            if not isinstance(value, Scalar):
                raise InputError(f"spec {key!r} is {value!r}; expected a text, number or null")
        canonical_json(self.spec)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Demonstration) and _equal_fields(self, other)


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """What the learner needs of one serve that was played at."""

    state: Float[ndarray, "6"]  # ball at the plane, camera frame: position m, velocity m/s
    hitting_point: Float[ndarray, "7"]  # position m, velocity m/s, duration s, as labelled
    mixture_weights: Float[ndarray, "K"]  # gamma_k of each primitive

    def __post_init__(self) -> None:
        """Refuse wrong shapes and numbers that are not finite."""
        require_array("state", self.state, 6)
        require_array("hitting_point", self.hitting_point, 7)
        require_array("mixture_weights", self.mixture_weights, -1)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Attempt) and _equal_fields(self, other)


@dataclass(frozen=True, slots=True)
class Trial:
    """One serve of a run, as the player's side knows it."""

    index: int
    outcome: Outcome
    reward: float
    attempt: Attempt | None  # None: the player never committed itself
    contact_offset: float | None  # on the blade, in semi-axes; None: not known
    contact_time: float | None  # s; None: no contact

    def __post_init__(self) -> None:
        """Refuse what no learner could be rebuilt from."""
        require_integer("index", self.index)
        if self.outcome not in OUTCOMES:
            raise InputError(f"outcome is {self.outcome!r}; expected one of {', '.join(OUTCOMES)}")
        for name in ("reward", "contact_offset", "contact_time"):
            require_finite(name, getattr(self, name))


@dataclass(frozen=True, slots=True)
class Run:
    """Everything that must be equal for a resumed run to be the same run."""

    id: int
    seed: int
    player: str
    eyes: str
    vehicle: str
    camera: str
    serves: str
    version: str  # of rotorpong
    pilot: str  # of the demonstrations it starts from
    spec: Mapping[str, Any]  # anything else that changes results; JSON values only

    def __post_init__(self) -> None:
        """Refuse what cannot be written down and compared."""
        require_integer("run id", self.id)
        require_integer("seed", self.seed)
        canonical_json(self.spec)

    def identity(self) -> dict[str, str]:
        """Return every field and every key of the spec in one text each: equal for the same run.

        Where the spec's `contents` hold a digest of what a field names, the digest counts and not
        the name.
        """
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        spec = dict(named.pop("spec"))
        contents = spec.pop("contents", {})
        named |= {f"spec.{key}": value for key, value in spec.items()}
        texts = {name: canonical_json(value) for name, value in named.items()}
        return texts | {name: f"a file with sha256 {digest}" for name, digest in contents.items()}


def canonical_json(value: Any) -> str:
    """Return the one JSON text of `value`: keys sorted, pure ASCII.

    Raises:
        InputError: `value` holds something that JSON cannot, NaN and infinity included.
    """
    plain = dict(value) if isinstance(value, Mapping) else value
    try:
        return json.dumps(plain, sort_keys=True, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"{value!r} cannot be stored; expected JSON values: {error}") from error


def require_integer(name: str, value: Any) -> None:
    """Raise InputError unless `value` is a non-negative integer that a column can hold."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= LARGEST_INTEGER:
        raise InputError(f"{name} is {value!r}; expected an integer from 0 to {LARGEST_INTEGER}")


def require_finite(name: str, value: float | None) -> None:
    """Raise InputError unless `value` is a finite number, or None."""
    if value is not None and not math.isfinite(value):
        raise InputError(f"{name} is {value!r}; expected a finite number")


def require_array(name: str, value: ndarray, *shape: int) -> None:
    """Raise InputError unless `value` is finite and of that shape; -1 is any length but 0."""
    given = np.shape(value)
    expected = tuple(n if m == -1 else m for n, m in zip(given, shape, strict=False))
    if len(given) != len(shape) or given != expected or 0 in given:
        raise InputError(f"{name} has shape {given}; expected {shape}, -1 for any length")
    if not np.all(np.isfinite(value)):
        raise InputError(f"{name} holds NaN or infinity; expected finite numbers")


def _equal_fields(a: Any, b: Any) -> bool:
    return all(
        np.array_equal(one, two) if isinstance(one, ndarray) else one == two
        for one, two in ((getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    )
