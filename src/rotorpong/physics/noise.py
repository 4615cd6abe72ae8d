"""Random numbers by counter: number i of a sequence is a function of (key, i) and of nothing else.

A key is drawn once per serve. Whatever is computed from it later does not depend on how often, in
which order or in what portions one asks, and a frozen state that holds the key holds all the noise
still to come. The bits are those of splitmix64 started at the key (Steele, Lea, Flood, "Fast
splittable pseudorandom number generators", 2014); normal numbers follow by Box and Muller.
"""

import math

import numpy as np
from jaxtyping import Float, UInt64
from numpy import ndarray

from rotorpong.physics._noise_kernels import normal_rows, wander

NODES_PER_TIME = 50  # at which a slow process is drawn, per correlation time

Keys = UInt64[ndarray, "*batch"]


def draw_keys(rng: np.random.Generator, shape: tuple[int, ...] = ()) -> Keys:
    """Draw one key for each sequence of the batch."""
    return np.asarray(rng.integers(0, 2**64, size=shape or None, dtype=np.uint64))


def normal_samples(
    key: UInt64[ndarray, ""], first: int, shape: tuple[int, int]
) -> Float[ndarray, "n channels"]:
    """Return standard normal numbers for the samples first, first + 1, ...

    Args:
        key: the sequence.
        first: number of the first sample, from 0.
        shape: how many samples, and how many channels each of them has.
    """
    rows = np.empty(shape)
    normal_rows(key[()], first, rows)
    return rows


def slow_samples(
    key: UInt64[ndarray, ""], times: Float[ndarray, "n"], correlation_time: float, channels: int
) -> Float[ndarray, "n channels"]:
    """Return a process of Ornstein and Uhlenbeck with unit variance at some instants.

    It is drawn at nodes 1/50 of its correlation time apart, from time 0 on, and runs straight in
    between (which takes at most 1 % off its variance there).

    Args:
        key: the sequence.
        times: s, from 0, in order.
        correlation_time: s, after which the correlation has fallen to 1/e.
        channels: how many independent processes.
    """
    if not len(times):
        return np.empty((0, channels))
    place = times * (NODES_PER_TIME / correlation_time)
    nodes = np.empty((int(place[-1]) + 2, channels))
    wander(key[()], math.exp(-1.0 / NODES_PER_TIME), nodes)
    before = place.astype(np.int64)
    share = (place - before)[:, None]
    return (1.0 - share) * nodes[before] + share * nodes[before + 1]
