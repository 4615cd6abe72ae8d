"""Primitives, states and strategies that several files of tests share."""

import numpy as np
from hypothesis import strategies as st

from rotorpong.primitives import Dmp, State, fit_dmp

DEMONSTRATION_TIMES = np.linspace(0.0, 1.0, 80)
START = State(np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.0, -0.4]))
GOAL = State(np.array([0.4, 0.3, -0.1]), np.array([-0.3, 1.0, 0.6]))
REST = State(np.zeros(3), np.zeros(3))

durations = st.floats(0.2, 5.0)
vectors = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)
states = st.builds(State, vectors, vectors)


def stroke(x):
    """A back-swing, then a stroke that ends in motion."""
    forward = 0.3 * x**3 - 0.15 * np.sin(np.pi * x) ** 2 * (1 - x)
    left = 0.1 * x**2 - 0.05 * np.sin(2 * np.pi * x) ** 2
    up = 0.3 * x**4 + 0.7 * x**5 - 0.2 * x**3
    return np.stack([forward, left, up], axis=-1)


FITTED = fit_dmp(DEMONSTRATION_TIMES, stroke(DEMONSTRATION_TIMES))
PAPER = fit_dmp(DEMONSTRATION_TIMES, stroke(DEMONSTRATION_TIMES), method="lwr")


def some_dmps(count, seed=0, *, basis=20, d=3):
    """Primitives of no demonstration, which end where they like."""
    rng = np.random.default_rng(seed)
    return tuple(Dmp(50.0 * rng.normal(size=(basis, d))) for _ in range(count))
