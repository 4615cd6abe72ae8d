"""Random numbers by counter: number i of a sequence is a function of (key, i) and of nothing else.

A key is drawn once per serve. Whatever is computed from it later does not depend on how often, in
which order or in what portions one asks, and a frozen state that holds the key holds all the noise
still to come. The bits are those of splitmix64 started at the key (Steele, Lea, Flood, "Fast
splittable pseudorandom number generators", 2014); normal numbers follow by Box and Muller.
"""

import numpy as np
from jaxtyping import UInt64
from numpy import ndarray

NODES_PER_TIME = 50  # at which a slow process is drawn, per correlation time

Keys = UInt64[ndarray, "*batch"]


def draw_keys(rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Keys:
    """Draw one key for each sequence of the batch."""
    return np.asarray(rng.integers(0, 2**64, size=shape or None, dtype=np.uint64))
