"""Noise by counter in whole arrays, number by number: what kernels draw on the way."""

import math

import numpy as np

from rotorpong.physics._noise_kernels import normal, wander
from rotorpong.physics.noise import NODES_PER_TIME


def normal_samples(key, first, shape):
    """Return the samples first, first + 1, ... (from 0), `shape[1]` channels each."""
    numbers = range(first * shape[1], (first + shape[0]) * shape[1])
    return np.array([normal(key[()], i) for i in numbers]).reshape(shape)


def slow_samples(key, times, correlation_time, channels):
    """Return a process of Ornstein and Uhlenbeck with unit variance at instants from 0, in order.

    It is drawn at nodes, from time 0 on, and runs straight in between, which takes at most 1 % off
    its variance there.
    """
    if not len(times):
        return np.empty((0, channels))
    place = times * (NODES_PER_TIME / correlation_time)
    nodes = np.empty((int(place[-1]) + 2, channels))
    wander(key[()], math.exp(-1.0 / NODES_PER_TIME), nodes)
    before = place.astype(np.int64)
    share = (place - before)[:, None]
    return (1.0 - share) * nodes[before] + share * nodes[before + 1]
