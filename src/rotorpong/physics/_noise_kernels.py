"""Compiled random numbers by counter; the method is explained in `noise`."""

import math

import numpy as np

from rotorpong.kernels import kernel

STRIDE = np.uint64(0x9E3779B97F4A7C15)  # splitmix64: 2^64 over the golden ratio
FIRST_FACTOR = np.uint64(0xBF58476D1CE4E5B9)
SECOND_FACTOR = np.uint64(0x94D049BB133111EB)
UNIT = 2.0**-53


@kernel
def uniform(key, index):
    """Return number `index` of the sequence `key`, in [0, 1)."""
    z = key + np.uint64(index + 1) * STRIDE
    z = (z ^ (z >> np.uint64(30))) * FIRST_FACTOR
    z = (z ^ (z >> np.uint64(27))) * SECOND_FACTOR
    z ^= z >> np.uint64(31)
    return np.float64(z >> np.uint64(11)) * UNIT


@kernel
def normal(key, index):
    """Return number `index` of the standard normal sequence `key` (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(key, 2 * index)))
    return radius * math.cos(2.0 * math.pi * uniform(key, 2 * index + 1))


@kernel
def wander(key, decay, nodes):
    """Fill `nodes` (n, channels) with a stationary process of unit variance, from node 0 on.

    x_0 = n_0,   x_k = decay x_k-1 + sqrt(1 - decay^2) n_k.
    """
    n, channels = nodes.shape
    fresh = math.sqrt(1.0 - decay * decay)
    for j in range(channels):
        nodes[0, j] = normal(key, j)
        for i in range(1, n):
            nodes[i, j] = decay * nodes[i - 1, j] + fresh * normal(key, i * channels + j)
