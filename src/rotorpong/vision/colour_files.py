"""A ball's colour in a file: what `calibrate colour` writes and `detect --colour FILE` reads.

JSON, one object with these fields and no other:

    name      text, 1 to 40 characters without commas or control characters
    core, lower, upper, typical
              each three whole numbers: hue 0 to 180, saturation and value 0 to 255 (OpenCV's HSV)

with lower < upper, and core and typical from lower to upper, each for hue, saturation and value.
Hues do not wrap: a range from 170 over 0 to 10 cannot be said.
"""

import json
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.vision.colour import Colour
from rotorpong.vision.fields import without_doubles

LARGEST_FILE = 2**16  # bytes
LONGEST_NAME = 40
LIMITS = ("core", "lower", "upper", "typical")
FIELDS = ("name", *LIMITS)
CHANNELS = ("hue", "saturation", "value")
LARGEST = (180, 255, 255)

Limits = tuple[int, int, int]


def colour_text(colour: Colour) -> str:
    """Return what a file of the colour holds."""
    fields = {name: getattr(colour, name) for name in FIELDS}
    rows = [f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in fields.items()]
    return "{\n" + ",\n".join(rows) + "\n}\n"


def read_colour(path: str | Path) -> Colour:
    """Return the colour in a file.

    Raises:
        InputError: the file cannot be read or is no colour.
    """
    try:
        return _colour(_fields(Path(path)))
    except InputError as error:
        raise InputError(f"colour {path}: {error}") from None


def require_name(name: str) -> str:
    """Return the name of a colour if it can be one.

    Raises:
        InputError: it is empty, too long, or holds what would break lists and tables.
    """
    if not 1 <= len(name) <= LONGEST_NAME or "," in name or not name.isprintable():
        raise InputError(
            f"name {name[:LONGEST_NAME]!r}; expected 1 to {LONGEST_NAME} printable characters "
            "without commas"
        )
    return name


def _fields(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})") from None
    if len(data) > LARGEST_FILE:
        raise InputError(f"is larger than {LARGEST_FILE} bytes; expected a colour")
    try:
        fields = json.loads(data, object_pairs_hook=without_doubles)
    except InputError:
        raise
    except (ValueError, RecursionError):  # ValueError: neither JSON nor text
        raise InputError(f"is no JSON; expected an object with {', '.join(FIELDS)}") from None
    if not isinstance(fields, dict):
        raise InputError(f"is no JSON object; expected one with {', '.join(FIELDS)}")
    unknown = sorted(fields.keys() - set(FIELDS))
    missing = [name for name in FIELDS if name not in fields]
    if unknown or missing:
        wrong = [f"unknown {', '.join(unknown)[:80]}"] if unknown else []
        wrong += [f"lacks {', '.join(missing)}"] if missing else []
        raise InputError(f"{'; '.join(wrong)}; expected {', '.join(FIELDS)}")
    return fields


def _colour(fields: dict[str, Any]) -> Colour:
    if not isinstance(fields["name"], str):
        raise InputError(f"name is {str(fields['name'])[:40]}; expected text")
    core, lower, upper, typical = (_limits(fields[name], name) for name in LIMITS)
    for i, channel in enumerate(CHANNELS):
        if lower[i] >= upper[i]:
            wraps = "; hues do not wrap" if channel == "hue" else ""
            raise InputError(
                f"{channel}: lower {lower[i]}, upper {upper[i]}; expected lower < upper{wraps}"
            )
        for name, limits in (("core", core), ("typical", typical)):
            if not lower[i] <= limits[i] <= upper[i]:
                raise InputError(
                    f"{channel}: {name} {limits[i]}; expected {lower[i]} (lower) to {upper[i]} "
                    "(upper)"
                )
    return Colour(require_name(fields["name"]), core, lower, upper, typical)


def _limits(value: Any, name: str) -> Limits:
    whole = isinstance(value, list) and len(value) == 3 and all(type(v) is int for v in value)
    if not whole or not all(0 <= v <= most for v, most in zip(value, LARGEST, strict=True)):
        raise InputError(
            f"{name} is {str(value)[:40]}; expected whole numbers [hue 0 to 180, saturation 0 to "
            "255, value 0 to 255]"
        )
    return value[0], value[1], value[2]
