"""Rates and how sure of them one can be."""

import math

CONFIDENCE_95 = 1.959963984540054  # standard deviations of a normal distribution


def wilson_interval(hits: int, trials: int) -> tuple[float, float] | None:
    """Return Wilson's 95 % interval of a rate; `None` of nothing."""
    if trials == 0:
        return None
    rate, z2 = hits / trials, CONFIDENCE_95**2
    middle = (rate + z2 / (2 * trials)) / (1 + z2 / trials)
    spread = rate * (1 - rate) / trials + z2 / (4 * trials**2)
    half = CONFIDENCE_95 * math.sqrt(spread) / (1 + z2 / trials)
    return middle - half if hits else 0.0, middle + half if hits < trials else 1.0


def rate(hits: int, trials: int) -> float | None:
    """Return hits over trials; `None` of nothing."""
    return hits / trials if trials else None
