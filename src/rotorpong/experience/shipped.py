"""Demonstrations as a text file, and the ten of the scripted pilot that ship with the package.

JSON, one command a row, every float with the digits that give it back exactly:

    {"format": "rotorpong demonstrations", "version": 1, "columns": ["time_s", ...],
     "demonstrations": [{"seed": 0, "trial": 0, "pilot": "scripted", "spec": {...},
                         "commands": [[0.0, 0.1, 0.0, 0.0, 0.0], ...]}, ...]}
"""

import json
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from rotorpong.conventions import InputError, StoreError
from rotorpong.experience.database import reporting
from rotorpong.experience.records import (
    COMMAND_COLUMNS,
    Demonstration,
    canonical_json,
    require_integer,
)
from rotorpong.files import write_whole

SHIPPED = Path(__file__).with_name("demonstrations.json")
HEAD = {"format": "rotorpong demonstrations", "version": 1, "columns": list(COMMAND_COLUMNS)}
FIELDS = ("seed", "trial", "pilot", "spec", "commands")


def shipped_demonstrations() -> tuple[Demonstration, ...]:
    """Return the demonstrations that ship: the scripted pilot's, seed 0."""
    return read_demonstrations(SHIPPED)


def read_demonstrations(path: str | PathLike[str]) -> tuple[Demonstration, ...]:
    """Read a file that `write_demonstrations` wrote.

    Raises:
        StoreError: it is missing, damaged, or of another format or version.
    """
    path = Path(path)
    try:
        with reporting(path):
            content = json.loads(path.read_text("utf-8"))
        return tuple(_demonstration(entry) for entry in _entries(content))
    except InputError as error:
        raise StoreError(f"{path}: damaged: {error}") from error
    except (ValueError, OverflowError, RecursionError) as error:
        raise StoreError(f"{path}: damaged: expected JSON text: {error}") from error


def write_demonstrations(
    path: str | PathLike[str], demonstrations: Sequence[Demonstration]
) -> None:
    """Write `demonstrations` in their order, in place of what was there, whole or not at all.

    Raises:
        StoreError: the folder is missing, full or forbidden, or there is no regular file.
    """
    try:
        write_whole(Path(path), _text(demonstrations).encode())
    except InputError as error:
        raise StoreError(str(error)) from error


def _text(demonstrations: Sequence[Demonstration]) -> str:
    entries = ",\n".join(_entry_text(one) for one in demonstrations)
    head = "".join(f" {json.dumps(key)}: {json.dumps(value)},\n" for key, value in HEAD.items())
    return f'{{\n{head} "demonstrations": [\n{entries}\n]}}\n'


def _entry_text(one: Demonstration) -> str:
    rows = ",\n".join(f"  {json.dumps(row)}" for row in one.commands.tolist())
    head = f'"seed": {one.seed}, "trial": {one.trial}, "pilot": {json.dumps(one.pilot)}'
    return f' {{{head}, "spec": {canonical_json(one.spec)}, "commands": [\n{rows}\n ]}}'


def _entries(content: Any) -> list[Any]:
    if not isinstance(content, dict):
        raise InputError(f"a JSON {type(content).__name__}; expected an object")
    for key, expected in HEAD.items():
        if content.get(key) != expected:
            raise InputError(f"{key} is {content.get(key)!r}; expected {expected!r}")
    entries = content.get("demonstrations")
    if not isinstance(entries, list):
        raise InputError("no list of demonstrations")
    return entries


def _demonstration(entry: Any) -> Demonstration:
    if not isinstance(entry, dict) or set(entry) != set(FIELDS):
        raise InputError(f"a demonstration lacks or adds fields; expected {', '.join(FIELDS)}")
    if not isinstance(entry["spec"], dict) or not isinstance(entry["pilot"], str):
        raise InputError("spec or pilot has the wrong type; expected an object and a text")
    require_integer("seed", entry["seed"])
    require_integer("trial", entry["trial"])
    return Demonstration(**{**entry, "commands": _commands(entry["commands"])})


def _commands(rows: Any) -> ndarray:
    width = len(COMMAND_COLUMNS)
    if not isinstance(rows, list) or not all(isinstance(r, list) and len(r) == width for r in rows):
        raise InputError(f"commands are not rows of {width} numbers")
    if not all(type(value) in {int, float} for row in rows for value in row):
        raise InputError("commands hold something that is not a number")
    return np.array(rows, dtype=np.float64).reshape(-1, width)
