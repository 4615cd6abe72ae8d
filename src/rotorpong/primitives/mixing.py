"""Several primitives blended into one (section IV.C).

    pi(delta) = sum_k gamma_k pi_k(delta) / sum_k gamma_k

A roll-out is linear in eta theta, so the blend of the trajectories is the trajectory of the blended
weights, for every start, goal and duration.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.primitives.dmp import Dmp


def mix(dmps: Sequence[Dmp], weights: Float[ndarray, "k"]) -> Dmp:
    """Return the primitive that moves as the weighted mean of `dmps` does.

    Args:
        dmps: primitives with the same number of bases and coordinates.
        weights: gamma, one per primitive, not negative, not all zero.

    Raises:
        InputError: shapes that do not agree, or weights that are negative, infinite or all zero.
    """
    require_alike(dmps)
    if len(weights) != len(dmps):
        raise InputError(f"{len(weights)} weights: expected {len(dmps)}, one per primitive")
    total = weights.sum()
    if not (np.isfinite(total) and (weights >= 0.0).all() and total > 0.0):
        raise InputError(f"weights {weights}: expected finite, none negative, not all zero")
    stack = np.stack([dmp.forcing_gain * dmp.weights for dmp in dmps])
    return Dmp(np.tensordot(weights / total, stack, axes=1))


def require_alike(dmps: Sequence[Dmp]) -> None:
    """Raise InputError unless there are primitives and all have the same shape."""
    shapes = sorted({dmp.weights.shape for dmp in dmps})
    if not shapes:
        raise InputError("no primitives: expected at least one")
    if len(shapes) > 1:
        raise InputError(f"primitives of shapes {shapes}: expected the same bases and coordinates")
