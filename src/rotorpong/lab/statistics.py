"""Rates, how sure of them one can be, and whether two of them differ."""

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


def mcnemar(won: int, lost: int) -> float:
    """Return how likely a split at least as uneven is by chance: McNemar's exact two-sided test.

    Args:
        won: pairs that only the one hit.
        lost: pairs that only the other hit.
    """
    from scipy.stats import binomtest  # takes half a second to load, and few ask for it

    return float(binomtest(won, won + lost).pvalue) if won + lost else 1.0


def skill(rate: float, hover: float, oracle: float) -> float | None:
    """Return a hit rate on the scale from hover (0) to oracle (1); `None` if these are no scale."""
    return (rate - hover) / (oracle - hover) if oracle > hover else None


def rate(hits: int, trials: int) -> float | None:
    """Return hits over trials; `None` of nothing."""
    return hits / trials if trials else None
