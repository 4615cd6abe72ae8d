"""Which serve is thrown at trial i: drawn from a kind, by name or one's own, or read from a file.

A serve file is a CSV with one row per serve and the columns of `SERVE_COLUMNS`; ball i throws row
i modulo rows. A file says what its balls are like, so its rows stay as they are whatever medium is
asked for.
"""

from dataclasses import replace
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np

from rotorpong.conventions import InputError
from rotorpong.lab.seeds import run_generator
from rotorpong.world.serves import HUMAN, KINDS, PLAIN_MEDIUM, Medium, Serve, ServeKind, draw, vary

SERVE_KINDS = ("human", "constant", "hard", "lob")


@runtime_checkable
class ServeSource(Protocol):
    """Whatever throws the serve of a trial."""

    def __call__(
        self, index: int, rng: np.random.Generator, medium: Medium = PLAIN_MEDIUM, /
    ) -> Serve:
        """Return the serve of trial `index`, drawn with its generator and solved in `medium`."""
        ...


def serve_source(serves: str | ServeKind, seed: int) -> ServeSource:
    """Return what throws the serves of a spec.

    Raises:
        InputError: neither a kind nor a readable file of serves or of a flight.
    """
    if isinstance(serves, ServeKind):
        return _drawn(serves)
    if serves in KINDS:
        return _drawn(KINDS[serves])
    if serves == "constant":
        base = draw(HUMAN, run_generator(seed))
        return lambda _, rng, medium=PLAIN_MEDIUM: vary(
            replace(base, air=medium.air, table=medium.table), rng
        )
    if not (serves and Path(serves).exists()):
        raise InputError(
            f"serves {serves!r}: expected one of {', '.join(SERVE_KINDS)}, or a CSV file of serves "
            "or of a measured flight"
        )
    from rotorpong.lab.serve_files import read_serves  # fits flights: only where it is needed

    rows = read_serves(Path(serves))
    return lambda index, _, __=PLAIN_MEDIUM: rows[index % len(rows)]


def _drawn(kind: ServeKind) -> ServeSource:
    return lambda _, rng, medium=kind.medium: draw(replace(kind, medium=medium), rng)
