"""The gain eta of the forcing term by the amplitude of what is asked.

eta is a constant in the paper, and 1 here. Scaled, the shape of a demonstration grows and shrinks
with the motion, each coordinate by itself:

    "displacement"  eta = (s_1 - s_0) / (s_1 - s_0)_demonstrated
    "velocity"      eta = (v_1 - v_0) / (v_1 - v_0)_demonstrated

The first is that of Ijspeert et al. (2013), the second B-Human's. A coordinate that hardly changed
in the demonstration has no such ratio and keeps eta = 1. The goal is met whatever eta is.
"""

from dataclasses import replace
from typing import Literal

import numpy as np

from rotorpong.conventions import InputError
from rotorpong.primitives.dmp import Dmp, State, finite_vectors

SMALLEST_SHARE = 0.05  # of the largest coordinate's change; what is smaller has no ratio


def scaled_to(
    dmp: Dmp,
    start: State,
    goal: State,
    *,
    by: Literal["displacement", "velocity"] = "displacement",
) -> Dmp:
    """Return the primitive with eta for each coordinate as this motion's amplitude asks.

    Raises:
        InputError: the primitive does not know the ends of its demonstration, other dimensions, a
            number that is not finite, or an unknown `by`.
    """
    if by not in ("displacement", "velocity"):
        raise InputError(f"by {by!r}: expected displacement or velocity")
    if dmp.ends is None:
        raise InputError("a primitive without the ends of a demonstration: expected a fitted one")
    d = dmp.weights.shape[1]
    vectors = (start.position, start.velocity, np.zeros(d), goal.position, goal.velocity)
    ends = finite_vectors(vectors, d)
    if by == "displacement":
        asked, shown = ends[3] - ends[0], np.diff(dmp.ends.position, axis=0)[0]
    else:
        asked, shown = ends[4] - ends[1], np.diff(dmp.ends.velocity, axis=0)[0]
    changes = np.abs(shown) > SMALLEST_SHARE * np.abs(shown).max()
    ratio = np.where(changes, asked / np.where(changes, shown, 1.0), 1.0)
    return replace(dmp, forcing_gain=dmp.forcing_gain * ratio)
