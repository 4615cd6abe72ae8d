"""The cells of a suite that are done, kept in a file beside the result until that is whole."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.files import target_of, write_whole

LARGEST_FILE = 2**20  # bytes
EXPECTED = "expected what an interrupted `rotorpong suite` left; without --resume it starts anew"


@dataclass(frozen=True, slots=True)
class Kept:
    """Where a suite's result goes, and meanwhile what is done of it."""

    out: Path
    resume: bool = False  # go on with what is there

    def check(self) -> "Kept":
        """Return this if the result can be written.

        Raises:
            InputError: see `files.target_of`.
        """
        target_of(self.out)
        target_of(self.part)
        return self

    @property
    def part(self) -> Path:
        """The file of what is done."""
        return self.out.with_name(f"{self.out.name}.part")

    def begin(self, head: dict[str, Any]) -> dict[str, Any]:
        """Return the cells that are done, by name.

        Args:
            head: what the result says before its cells; equal for the same run.

        Raises:
            InputError: what is there is of another run, or damaged.
        """
        if not (self.resume and self.part.exists()):
            return {}
        found = self._read()
        if found["head"] != json.loads(json.dumps(head)):
            raise InputError(f"{self.part}: is of another run; {EXPECTED}")
        return found["cells"]

    def keep(self, head: dict[str, Any], cells: dict[str, Any]) -> None:
        """Keep the cells that are done."""
        write_whole(self.part, json.dumps({"head": head, "cells": cells}).encode())

    def finish(self, result: dict[str, Any]) -> None:
        """Write the result, whole; what was kept goes."""
        write_whole(self.out, (json.dumps(result, allow_nan=False, indent=1) + "\n").encode())
        self.part.unlink(missing_ok=True)

    def _read(self) -> dict[str, Any]:
        try:
            with self.part.open("rb") as file:
                found = json.loads(file.read(LARGEST_FILE))
        except (OSError, ValueError, RecursionError):
            found = None
        if isinstance(found, dict) and isinstance(found.get("cells"), dict) and "head" in found:
            return found
        raise InputError(f"{self.part}: cannot be read; {EXPECTED}")
