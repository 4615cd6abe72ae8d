"""Which numbers of the other items' results are ours, and what follows from them.

Results are what `reproduce` returns and results.json holds. They may lack any item, line or key:
what then cannot be told is None, and a sentence about it is empty.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rotorpong.paper import fig7b, real, table1, table2
from rotorpong.paper.trajectory import WHOLE

TABLE1 = {kind: f"gazebo, {kind}, {WHOLE}" for kind in table1.KINDS}
TABLE1_FAST = f"{table1.FAST.name}, centred, {WHOLE}"
TABLE2 = f"{table2.DRAWN}, {table2.CONTROLS[0]}"
ROBOT = {
    real.ONE: ("one primitive, before learning", "one primitive, after the first hits"),
    real.TEN: ("ten primitives, before training", "ten primitives, after 80 hits"),
}
PORTED, LOOP = real.VEHICLES
HIT_PERCENT = "hit_percent"
PLACES = table2.KEYS[:3]  # of Table II
DEPTH_SHARE = table1.ASIDE  # error of X over error of Z in Table I

At = tuple[str, str, str]
"""Item, label of one of our lines, key."""


@dataclass(frozen=True, slots=True)
class Told:
    """What `reproduce` returned."""

    found: Mapping[str, Any]

    def lines(self, item: str) -> list[tuple[str, Mapping[str, Any]]]:
        """Return our lines of an item, by label; none if it is missing."""
        return list(self.found.get(item, {}).get("ours", {}).items())

    def value(self, at: At) -> float | None:
        """Return a number; None if it is missing."""
        item, line, key = at
        found = dict(self.lines(item)).get(line, {}).get(key)
        return None if found is None else float(found)

    def interval(self, at: At) -> list[float] | None:
        """Return a number's 95 % interval; None if it is missing."""
        item, line, key = at
        return dict(self.lines(item)).get(line, {}).get(f"{key}_interval")

    def setting(self, item: str, key: str) -> float | None:
        """Return a number of an item's setting; None if it is missing."""
        found = self.found.get(item, {}).get("setting", {}).get(key)
        return None if found is None else float(found)

    def say(self, sentence: str, *where: At) -> str:
        """Return a sentence with the numbers from there filled in; nothing if one is missing.

        Args:
            sentence: with a field for each; one that says no more than a sign has one digit.
            where: what its fields are.
        """
        values = [self.value(at) for at in where]
        if None in values:
            return ""
        return sentence.replace("{}", "{:.1f}").replace("{:+}", "{:+.1f}").format(*values)


def plateau(label: str, told: Told) -> float | None:
    """Return after how many own hits a curve of Fig. 7b has nine tenths of its gain."""
    lines = [values for name, values in told.lines("fig7b") if name.startswith(f"{label}, ")]
    if not lines:
        return None
    return fig7b.plateau(
        [values["own_hits"] for values in lines], [values[HIT_PERCENT] for values in lines]
    )


def first(label: str, told: Told) -> str:
    """Return which line of Fig. 7b is before learning, with vision or with truth."""
    return _curve(label, told)[0]


def last(label: str, told: Told) -> str:
    """Return which line of Fig. 7b is after most own hits."""
    return _curve(label, told)[-1]


def near_of_misses(told: Told) -> float | None:
    """Return how many of the misses of vision, at the end, are near-hits, per cent."""
    line = last("vision", told)
    near = told.value(("fig7b", line, fig7b.NEAR))
    hits = told.value(("fig7b", line, HIT_PERCENT))
    return None if near is None or hits is None or hits >= 100.0 else 100.0 * near / (100.0 - hits)


def worst_axis(told: Told) -> float | None:
    """Return the execution error of Table II along the axis that has most, cm."""
    errors = [told.value(("table2", TABLE2, key)) for key in PLACES]
    known = [error for error in errors if error is not None]
    return max(known) if len(known) == len(errors) else None


def best_place(label: str, told: Told) -> float | None:
    """Return the least error of Fig. 7a at the end, labels as commanded, cm."""
    found = [
        values["place_last_cm"]
        for name, values in told.lines("fig7a")
        if name.startswith(f"{label}, commanded,") and values.get("place_last_cm") is not None
    ]
    return min(found, default=None)


def _curve(label: str, told: Told) -> list[str]:
    names = [name for name, _ in told.lines("fig7b") if name.startswith(f"{label}, ")]
    return names or [label]
