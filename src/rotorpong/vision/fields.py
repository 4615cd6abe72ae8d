"""Fields of files that people write: a field that is given twice is a mistake, not a choice."""

from typing import Any

from rotorpong.conventions import InputError


def without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return pairs of name and value as a mapping; what `json.loads` takes as its hook.

    Raises:
        InputError: a name comes twice.
    """
    fields: dict[str, Any] = {}
    for name, value in pairs:
        if name in fields:
            raise InputError(f"gives {name[:40]} twice; expected each field once")
        fields[name] = value
    return fields
