"""Files of primitives: one JSON object that names its format and version, written whole or not."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from rotorpong.conventions import InputError


def write_document(path: str | Path, document: dict[str, Any]) -> None:
    """Write a document to `path`, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        _replace(Path(path), json.dumps(document))
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error


def read_document(path: str | Path, name: str, version: int, *, what: str) -> dict[str, Any]:
    """Read a document of that format and version.

    Args:
        path: of the file.
        name: of the format, as the document has it.
        version: of the format.
        what: it is, in words.

    Raises:
        InputError: no such file, or one of another kind.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: expected a {what}, found no JSON") from error
    if not isinstance(document, dict) or document.get("format") != name:
        raise InputError(f"{path}: expected a {what}, found another format")
    if document.get("version") != version:
        raise InputError(f"{path}: {what}, version {document.get('version')!r}, expected {version}")
    return document


def numbers(values: Any, *, dimensions: int) -> ndarray:
    """Return an array of a document.

    Raises:
        TypeError, ValueError, OverflowError: something else is there, or nothing.
    """
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
