"""Which serve is thrown at trial i: drawn from a kind, or read from a file.

A serve file is a CSV with one row per serve and the columns of `SERVE_COLUMNS`; ball i throws row
i modulo rows.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from rotorpong.conventions import InputError
from rotorpong.lab.seeds import run_generator
from rotorpong.world.serves import HUMAN, KINDS, Serve, draw, vary

SERVE_KINDS = ("human", "constant", "hard", "lob")

ServeSource = Callable[[int, np.random.Generator], Serve]
"""Trial index and generator of the trial's serve -> the serve."""


def serve_source(serves: str, seed: int) -> ServeSource:
    """Return what throws the serves of a spec.

    Raises:
        InputError: neither a kind nor a readable file of serves or of a flight.
    """
    if serves in KINDS:
        return lambda _, rng: draw(KINDS[serves], rng)
    if serves == "constant":
        base = draw(HUMAN, run_generator(seed))
        return lambda _, rng: vary(base, rng)
    if not (serves and Path(serves).exists()):
        raise InputError(
            f"serves {serves!r}: expected one of {', '.join(SERVE_KINDS)}, or a CSV file of serves "
            "or of a measured flight"
        )
    from rotorpong.lab.serve_files import read_serves  # fits flights: only where it is needed

    rows = read_serves(Path(serves))
    return lambda index, _: rows[index % len(rows)]
