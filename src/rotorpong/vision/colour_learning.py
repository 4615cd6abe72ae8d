"""A ball's colour from pixels of balls and of what surrounds them.

Pixels are OpenCV's HSV; every ball counts the same, however large. Hue h is an angle a = 2 deg h,
measured from the mean direction of the balls' pixels, each with its chroma as weight:

    mean = angle(sum_i w_i chroma_i exp(i a_i)),   w_i = 1 / pixels of its ball

Limits are the quantiles q and 1 - q of the balls' pixels and a margin for noise, with the q that
lets most balls in and most surroundings out (recall less share of the surroundings). Then each
limit opens, step by step, as far as the surroundings allow, for tomorrow's light is another. Balls
without a hue (white ones) take all hues; those with one take no pixel of less than half their
median saturation, for its hue is noise.

The detector's hues do not wrap around red's 0 = 180: limits end there, and balls that are mostly
on the other side are refused, as are balls that nothing tells from their surroundings.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.vision.colour import Colour

QUANTILES = (0.01, 0.02, 0.05, 0.1, 0.15)
NOISE = np.array([3.0, 10.0, 10.0])  # hue, saturation, value: always between quantile and limit
OPEN_DOWN, OPEN_UP = np.array([3.0, 30.0, 30.0]), np.array([3.0, 60.0, 60.0])  # most, beyond that
STEPS = 6  # in which a limit opens
MORE_SURROUNDINGS = 0.002  # that opening a limit may let in, share
LEAST_CONTRAST = 0.5  # recall less share of the surroundings
LEAST_LENGTH = 0.6  # of the mean direction of hue; below, there is no hue
PALEST = 0.5  # of the median saturation, where there is a hue
LEAST_SATURATION = 35.0  # median; below, hue is noise
LEAST_ON_ONE_SIDE = 0.8  # of the balls' pixels, where hues would wrap
FEW_BALLS = 0.05  # may be darker or paler than the core
QUARTER = 0.25  # of a ball's pixels may be below the core, in saturation and in value
HUES = 180.0
FULL = np.array([HUES, 255.0, 255.0])

Pixels = UInt8[ndarray, "_ 3"]  # hue, saturation, value
Values = Float[ndarray, "_ 3"]


@dataclass(frozen=True, slots=True)
class Learnt:
    """A colour, and what it does to the pixels that it was learnt from."""

    colour: Colour
    recall: float  # share of the balls' pixels that it takes, balls weighing the same
    surroundings_taken: int  # pixels
    surroundings: int
    hue_cut: bool  # limits would go around 0, and end there


class _Samples(NamedTuple):
    balls: Values  # hue measured from the mean, -90..90
    weights: Float[ndarray, "_"]
    surroundings: Values


class _Range(NamedTuple):
    lower: Float[ndarray, "3"]
    upper: Float[ndarray, "3"]


def learn_colour(balls: list[Pixels], surroundings: Pixels, name: str) -> Learnt:
    """Return the colour of balls.

    Args:
        balls: pixels of each, at least one.
        surroundings: pixels around them.
        name: of the colour.

    Raises:
        InputError: balls that no colour tells from their surroundings, or whose hues wrap.
    """
    pixels = np.concatenate(balls).astype(float)
    weights = np.concatenate([np.full(len(ball), 1.0 / len(ball)) for ball in balls])
    center = _mean_hue(pixels, weights)
    shift = np.array([0.0 if center is None else center, 0.0, 0.0])
    samples = _Samples(
        _from_hue(pixels, center), weights, _from_hue(surroundings.astype(float), center)
    )
    inner = max(
        (_range(samples, q, center) for q in QUANTILES), key=lambda r: _contrast(samples, r)
    )
    opened = _opened(samples, inner, coloured=center is not None)
    if center is not None:
        opened.lower[1] = max(opened.lower[1], PALEST * _quantile(pixels[:, 1], 0.5, weights))
    lower, upper = np.floor(opened.lower + shift), np.ceil(opened.upper + shift)
    cut = bool(lower[0] < 0.0 or upper[0] > HUES)
    lower, upper = np.maximum(lower, 0.0), np.minimum(upper, FULL)
    inside = _within(pixels, _Range(lower, upper))
    recall = float(weights[inside].sum() / weights.sum())
    if cut and recall < LEAST_ON_ONE_SIDE * _recall(samples, opened):
        raise InputError(
            f"hues around {center:.0f} go over red's 0 = 180, which limits of a colour cannot; "
            "expected balls whose hue stays on one side, such as orange, yellow, green, blue"
        )
    taken = _within(surroundings.astype(float), _Range(lower, upper))
    _require_contrast(recall, float(np.mean(taken)))
    core = np.clip(_core(balls, lower), lower, upper)
    typical = np.clip(_typical(samples, shift), lower, upper)
    colour = Colour(name, _whole(core), _whole(lower), _whole(upper), _whole(typical))
    return Learnt(colour, recall, int(taken.sum()), len(surroundings), cut)


def _require_contrast(recall: float, share: float) -> None:
    if recall - share < LEAST_CONTRAST:
        raise InputError(
            f"no colour tells these balls from what is around them: the best takes "
            f"{100 * recall:.0f} % of their pixels and {100 * share:.0f} % of those around; "
            "expected boxes close around balls of another colour than their surroundings"
        )


def _mean_hue(pixels: Values, weights: Float[ndarray, "_"]) -> float | None:
    """Return the mean hue, 0 to 180; `None` where there is none."""
    saturation = pixels[:, 1]
    chroma = weights * saturation * pixels[:, 2]
    if chroma.sum() == 0.0 or _quantile(saturation, 0.5, weights) < LEAST_SATURATION:
        return None
    angles = 2.0 * np.pi * pixels[:, 0] / HUES
    direction = complex(np.sum(chroma * np.exp(1j * angles)) / chroma.sum())
    if abs(direction) < LEAST_LENGTH:
        return None
    return math.atan2(direction.imag, direction.real) % (2.0 * math.pi) * HUES / (2.0 * math.pi)


def _from_hue(pixels: Values, center: float | None) -> Values:
    """Return pixels with their hue measured from `center`, the shorter way around."""
    if center is None:
        return pixels
    hue = (pixels[:, 0] - center + HUES / 2.0) % HUES - HUES / 2.0
    return np.column_stack([hue, pixels[:, 1:]])


def _range(samples: _Samples, q: float, center: float | None) -> _Range:
    chroma = samples.weights * samples.balls[:, 1] * samples.balls[:, 2]
    weights = (samples.weights if center is None else chroma, samples.weights, samples.weights)
    low, high = (
        np.array([_quantile(samples.balls[:, i], p, weights[i]) for i in range(3)])
        for p in (q, 1.0 - q)
    )
    lower, upper = low - NOISE, high + NOISE
    if center is None:
        lower[0], upper[0] = 0.0, HUES
    return _Range(lower, upper)


def _opened(samples: _Samples, inner: _Range, *, coloured: bool) -> _Range:
    """Return limits opened one after the other, by turns, while the surroundings stay out."""
    lower, upper = inner.lower.copy(), inner.upper.copy()
    most = _share(samples, inner) + MORE_SURROUNDINGS
    sides = [(limit, i, step) for i in range(3) for limit, step in ((lower, -1.0), (upper, 1.0))]
    for limit, i, step in sides if coloured else sides[2:]:
        room = (OPEN_DOWN if step < 0.0 else OPEN_UP)[i] / STEPS
        for _ in range(STEPS):
            limit[i] += step * room
            if _share(samples, _Range(lower, upper)) > most:
                limit[i] -= step * room
                break
    return _Range(lower, upper)


def _within(pixels: Values, limits: _Range) -> Bool[ndarray, "_"]:
    return np.all((pixels >= limits.lower) & (pixels <= limits.upper), axis=1)


def _recall(samples: _Samples, limits: _Range) -> float:
    return float(samples.weights[_within(samples.balls, limits)].sum() / samples.weights.sum())


def _share(samples: _Samples, limits: _Range) -> float:
    return float(np.mean(_within(samples.surroundings, limits)))


def _contrast(samples: _Samples, limits: _Range) -> float:
    return _recall(samples, limits) - _share(samples, limits)


def _core(balls: list[Pixels], lower: Float[ndarray, "3"]) -> Float[ndarray, "3"]:
    """Return limits half the way up to what, of nearly every ball, half the pixels keep."""
    quarters = np.array([np.quantile(ball[:, 1:], QUARTER, axis=0) for ball in balls])
    nearly_all = np.quantile(quarters, FEW_BALLS, axis=0, method="lower")
    return np.array([lower[0], *np.floor((lower[1:] + nearly_all) / 2.0)])


def _typical(samples: _Samples, shift: Float[ndarray, "3"]) -> Float[ndarray, "3"]:
    """Return the mean of the balls' pixels."""
    mean = np.average(samples.balls, axis=0, weights=samples.weights)
    return np.round(mean + shift)


def _quantile(values: Float[ndarray, "_"], q: float, weights: Float[ndarray, "_"]) -> float:
    return float(np.quantile(values, q, weights=weights, method="inverted_cdf"))


def _whole(numbers: Float[ndarray, "3"]) -> tuple[int, int, int]:
    hue, saturation, value = (int(number) for number in numbers)
    return hue, saturation, value
