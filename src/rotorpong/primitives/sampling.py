"""Instants at which a motion is sampled: exactly as many as there should be."""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError

ROUNDING = 1e-9  # of a tick: what a duration times a rate may be off from a whole number
MOST_SAMPLES = 10_000_000


def sample_times(duration: float, rate: float) -> Float[ndarray, "n"]:
    """Return the ticks 0, 1/rate, 2/rate ... of a motion, and its end.

    A duration of a whole number of ticks has duration * rate + 1 samples, whatever its rounding
    error. Otherwise the end comes after the last tick, by less than a tick.

    Args:
        duration: s.
        rate: ticks per second.

    Raises:
        InputError: one of them is not a positive number, or there would be over ten million.
    """
    for name, value in (("duration", duration), ("rate", rate)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} {value}: expected a positive number")
    if duration * rate > MOST_SAMPLES:
        raise InputError(
            f"duration {duration} s at {rate} per second: expected at most {MOST_SAMPLES} samples"
        )
    ticks = max(math.ceil(duration * rate - ROUNDING), 1)
    return np.append(np.arange(ticks) / rate, duration)
