"""Names given at the door, against those that are known."""

from collections.abc import Sequence

from rotorpong.conventions import InputError


def require_choice(what: str, given: str, available: Sequence[str], more: str = "") -> None:
    """Raise InputError unless `given` is one of `available`."""
    if given not in available:
        known = ", ".join(available) + (f", {more}" if more else "")
        raise InputError(f"unknown {what} {given!r}: expected one of {known}")
