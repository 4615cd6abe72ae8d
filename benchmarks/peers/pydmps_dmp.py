"""pydmps: discrete DMPs after Schaal (2002), which come to rest at their goal.

It learns the same stroke as positions at 1 kHz, with 20 bases; what it cannot learn is the velocity
at the end. `tau` is its pace: a motion of 1 s at tau lasts 1/tau s.
"""

from typing import Any

import numpy as np

from rotorpong.lab.bench.primitives_rows import (
    RATE,
    REPEATS,
    roll_out_seconds,
    stroke,
    trials,
)
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.primitives import State

SUITE = "primitives"
NAME = "pydmps, DMPs_discrete"


def require() -> None:
    """Raise ImportError while pydmps is not installed."""
    import pydmps  # noqa: F401


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure it and rotorpong in turns and return the rows."""
    asked = trials(3 if quick else REPEATS)
    peer = _taught()
    ours = roll_out_seconds(quick=quick)
    theirs = cpu_seconds(lambda: [_moved(peer, one) for one in asked], quick=quick) / len(asked)
    faster = theirs / ours
    return (
        Row("roll-out, times as fast as pydmps", faster, "1", None, "more", NAME, faster),
        Row("pydmps: roll-out at 1 kHz, random duration", 1e6 * theirs, "us"),
        Row("pydmps: shown again, RMS", _reproduced(), "mm"),
    )


def _taught() -> Any:
    from pydmps.dmp_discrete import DMPs_discrete

    peer = DMPs_discrete(n_dmps=3, n_bfs=20, dt=1.0 / RATE)
    peer.imitate_path(stroke(np.linspace(0.0, 1.0, int(RATE) + 1)).T)
    return peer


def _moved(peer: Any, one: tuple[State, State, float]) -> np.ndarray:
    """Return the positions of one motion."""
    start, goal, duration = one
    peer.y0, peer.goal = start.position.copy(), goal.position.copy()
    return peer.rollout(tau=1.0 / duration)[0]


def _reproduced() -> float:
    """Return how far it is from the stroke that it learnt, mm, RMS."""
    positions = _taught().rollout()[0]
    x = np.arange(1, len(positions) + 1) / RATE
    return float(1000.0 * np.sqrt(np.mean((positions - stroke(x)) ** 2)))
