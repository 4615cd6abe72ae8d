"""movement_primitives: DMPWithFinalVelocity, written from the paper that the DMPs here come from.

Both learn the same 80 positions of a stroke with 20 bases, then move to the same random goals,
final velocities and durations at 1 kHz. It returns positions only.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rotorpong.lab.bench.primitives_rows import (
    RATE,
    REPEATS,
    TIMES,
    TRIALS,
    demonstrated,
    reproduction_error,
    roll_out_seconds,
    stroke,
    trials,
)
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.primitives import State

SUITE = "primitives"
PEER = "movement_primitives"
NAME = f"{PEER}, DMPWithFinalVelocity"
TIMES_AS_FAST = 300.0

Trial = tuple[State, State, float]


def require() -> None:
    """Raise ImportError while movement_primitives is not installed."""
    import movement_primitives.dmp  # noqa: F401


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure it and rotorpong in turns and return the rows."""
    asked = trials(3 if quick else REPEATS)
    peer = _taught()
    ours = roll_out_seconds(quick=quick)
    theirs = cpu_seconds(lambda: [_moved(peer, one) for one in asked], quick=quick) / len(asked)
    asked = trials(3 if quick else TRIALS)
    missed = [np.abs(_moved(peer, one)[-1] - one[1].position).max() for one in asked]
    end, own_end = float(np.max(missed)), _own_end(asked)
    shown, own_shown = _reproduced(), 1000.0 * reproduction_error(demonstrated())
    faster = theirs / ours
    return (
        Row(f"roll-out, times as fast as {PEER}", faster, "1", TIMES_AS_FAST, "more", NAME, faster),
        Row(f"{PEER}: roll-out at 1 kHz, random duration", 1e6 * theirs, "us"),
        Row("largest error at the end", own_end, "m", 1e-9, "less", NAME, end / own_end),
        Row(f"{PEER}: largest error at the end", end, "m"),
        Row("shown again, RMS", own_shown, "mm", None, "less", NAME, shown / own_shown),
        Row(f"{PEER}: shown again, RMS", shown, "mm"),
    )


def _taught() -> Any:
    from movement_primitives.dmp import DMPWithFinalVelocity

    peer = DMPWithFinalVelocity(n_dims=3, execution_time=1.0, dt=1.0 / RATE, n_weights_per_dim=20)
    peer.imitate(TIMES, stroke(TIMES))
    return peer


def _moved(peer: Any, one: Trial) -> np.ndarray:
    """Return the positions of one motion."""
    start, goal, duration = one
    peer.execution_time_ = duration
    peer.configure(
        start_y=start.position,
        start_yd=start.velocity,
        start_ydd=np.zeros(3),
        goal_y=goal.position,
        goal_yd=goal.velocity,
        goal_ydd=np.zeros(3),
    )
    times, positions = peer.open_loop()
    return positions[times <= duration + 1e-6]


def _own_end(asked: Sequence[Trial]) -> float:
    """Return our largest error at the end, or what rounding can tell from none."""
    dmp = demonstrated()
    ends = [dmp.roll_out(*one, np.array([one[2]])).position[0] - one[1].position for one in asked]
    return max(float(np.abs(ends).max()), np.finfo(float).eps)


def _reproduced() -> float:
    """Return how far it is from the stroke that it learnt, mm, RMS."""
    times, positions = _taught().open_loop()
    inside = times <= 1.0 + 1e-6
    return float(1000.0 * np.sqrt(np.mean((positions[inside] - stroke(times[inside])) ** 2)))
