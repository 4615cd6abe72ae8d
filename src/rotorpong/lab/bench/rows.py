"""One line of a benchmark: what was measured, what was wanted, what a peer does in the same run."""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray


@dataclass(frozen=True, slots=True)
class Row:
    """One measured quantity."""

    name: str
    value: float  # finite
    unit: str
    target: float | None = None
    better: Literal["more", "less"] = "more"  # which side of the target is good
    peer: str | None = None  # what `ratio` compares with
    ratio: float | None = None  # how many times better than the peer, above 1 is better
    interval: tuple[float, float] | None = None  # 95 %, of the value

    @property
    def met(self) -> bool | None:
        """Whether the target is reached; None without a target."""
        if self.target is None:
            return None
        return self.value >= self.target if self.better == "more" else self.value <= self.target

    def as_json(self) -> dict[str, Any]:
        """Return the row as `bench --json` prints it; what is not known is left out.

        Raises:
            ValueError: the value is not finite.
        """
        if not math.isfinite(self.value):
            raise ValueError(f"benchmark row {self.name!r}: value {self.value} is not finite")
        known: dict[str, Any] = {"name": self.name, "value": self.value, "unit": self.unit}
        if self.target is not None:
            known |= {"target": self.target, "met": self.met}
        if self.peer is not None:
            known |= {"peer": self.peer, "ratio": self.ratio}
        if self.interval is not None:
            known |= {"interval": self.interval}
        return known


def quantile_rows(name: str, values: Float[ndarray, "n"], unit: str, *, fewest: int) -> list[Row]:
    """Return median, 10 % and 90 % quantile of what is finite, if that are `fewest` or more."""
    values = values[np.isfinite(values)]
    if len(values) < fewest:
        return []
    low, middle, high = np.quantile(values, [0.1, 0.5, 0.9])
    return [
        Row(f"{name}, median (n = {len(values)})", float(middle), unit),
        Row(f"{name}, 10 %", float(low), unit),
        Row(f"{name}, 90 %", float(high), unit),
    ]
