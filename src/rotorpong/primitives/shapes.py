"""How far apart primitives are as motions, and the few that stand for many.

With the same start, goal and duration two motions differ by Phi(x) (theta_1 - theta_2), eta
included. Their distance is the root of its mean square over x, in metres: what a robot would
notice, which differences of weights are not.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial.distance import cdist

from rotorpong.conventions import InputError
from rotorpong.primitives.basis import response_table
from rotorpong.primitives.dmp import Dmp
from rotorpong.primitives.library import Library
from rotorpong.primitives.mixing import require_alike

Distances = Float[ndarray, "k k"]


def shapes_of(dmps: Sequence[Dmp]) -> Float[ndarray, "k nd"]:
    """Return what each adds to its target, so that root sums of squares are distances in metres.

    Raises:
        InputError: no primitives, or of different shapes.
    """
    require_alike(dmps)
    knots = response_table(len(dmps[0].weights))[0]  # Phi where the pieces begin
    theta = np.stack([dmp.forcing_gain * dmp.weights for dmp in dmps])
    return (knots @ theta).reshape(len(dmps), -1) / np.sqrt(len(knots))


def representatives(library: Library, count: int) -> tuple[int, ...]:
    """Return which primitives stand best for all: the sum of distances to the nearest is least.

    They are built up one by one, then exchanged as long as that helps (k-medoids: PAM, Kaufman and
    Rousseeuw 1990).

    Args:
        library: all of them.
        count: how many to keep.

    Raises:
        InputError: fewer than 1 or more than there are.
    """
    if not 1 <= count <= len(library):
        raise InputError(f"count {count}: expected 1 to {len(library)}, the library's size")
    shapes = shapes_of(library.primitives)
    distances = cdist(shapes, shapes)
    chosen: list[int] = []
    for _ in range(count):
        others = [i for i in range(len(library)) if i not in chosen]
        chosen.append(min(others, key=lambda i: _cost(distances, [*chosen, i])))
    while (better := _exchanged(distances, chosen)) is not None:
        chosen = better
    return tuple(sorted(chosen))


def reduced(library: Library, count: int) -> Library:
    """Return the library of the `representatives`; its errors are theirs."""
    return Library(tuple(library.primitives[i] for i in representatives(library, count)))


def _exchanged(distances: Distances, chosen: list[int]) -> list[int] | None:
    """Return the best choice with one exchanged, `None` if none is better."""
    others = [i for i in range(len(distances)) if i not in chosen]
    swaps = [[*(c for c in chosen if c != old), new] for old in chosen for new in others]
    if not swaps:
        return None
    best = min(swaps, key=lambda swap: _cost(distances, swap))
    return best if _cost(distances, best) < _cost(distances, chosen) * (1.0 - 1e-12) else None


def _cost(distances: Distances, chosen: list[int]) -> float:
    return float(distances[:, chosen].min(axis=1).sum())
