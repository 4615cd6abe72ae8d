"""Where a measured ball was struck or bounced: the kinks of its track.

Around the middle of two neighbouring points (time 0) the track is taken for

    p(t) = a + v t + c t^2 / 2 + k max(t, 0)

with one curvature c for gravity, drag and Magnus force, and a jump k of velocity, all by least
squares over up to 8 points and 0.1 s on either side. A kink is where |k| is large, and large beside
its standard error; of neighbours, the one that explains most. The track between two kinks is an arc
of free flight. Frame: z up, metres; one track at a time.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS
from rotorpong.physics.flight_fit import TABLE_HEIGHT_MOST

WINDOW_POINTS = 8  # on either side
WINDOW_TIME = 0.1  # s, on either side
FEWEST_BESIDE = 3  # points on either side
SMALLEST_JUMP = 1.5  # m/s
SIGNIFICANCE = 4.0  # standard errors
STROKE_TURN = 0.7  # cosine
FROM_REST = 2.0  # of the speed before
LEAST_NOISE = 0.0015  # m
LONGEST_GAP = 0.15  # s unseen, in which anything may have happened

TOUCH_TOLERANCE = TABLE_HEIGHT_MOST + 0.03  # m: a bounce between two points is not seen lowest
STEEPEST_TURN = 0.8  # cosine of the horizontal turn at a bounce
REBOUND = (0.3, 1.2)  # of vertical speed


@dataclass(frozen=True, slots=True)
class Kink:
    """A sudden change of velocity."""

    index: int  # of the first point after it
    position: Float[ndarray, "3"]
    before: Float[ndarray, "3"]  # velocity, m/s
    after: Float[ndarray, "3"]
    gain: float  # m^2 of squared distance that it explains

    @property
    def is_stroke(self) -> bool:
        """Whether a racket did it: the ball turned, or was nearly at rest before."""
        was, became = np.linalg.norm(self.before), np.linalg.norm(self.after)
        turned = self.before @ self.after < STROKE_TURN * was * became
        return bool(turned or np.linalg.norm(self.after - self.before) > FROM_REST * was)

    @property
    def is_table_bounce(self) -> bool:
        """Whether a table at height 0 can have done it."""
        down, up = -self.before[2], self.after[2]
        flat, kept = self.before[:2], self.after[:2]
        turn = flat @ kept / max(np.linalg.norm(flat) * np.linalg.norm(kept), 1e-9)
        low = abs(self.position[2] - BALL_RADIUS) < TOUCH_TOLERANCE
        bouncing = down > 0.0 and REBOUND[0] * down < up < REBOUND[1] * down
        return bool(low and bouncing and turn > STEEPEST_TURN)


@dataclass(frozen=True, slots=True)
class Arc:
    """Points first .. last - 1 of a track, in free flight."""

    first: int
    last: int
    follows_bounce: bool  # off the table, from the arc before

    @property
    def points(self) -> int:
        """How many points were measured."""
        return self.last - self.first


def find_arcs(times: Float[ndarray, "n"], positions: Float[ndarray, "n 3"]) -> tuple[Arc, ...]:
    """Return the arcs of a track, in order of time.

    Args:
        times: s, increasing.
        positions: m, z up, the table's playing surface at about 0.
    """
    arcs: list[Arc] = []
    breaks = np.flatnonzero(np.diff(times) > LONGEST_GAP) + 1
    edges = [0, *breaks.tolist(), len(times)]
    for low, high in itertools.pairwise(edges):
        kinks = _kinks(times, positions, low, high)
        starts = [low, *(kink.index for kink in kinks)]
        bounced = [False, *(kink.is_table_bounce for kink in kinks)]
        ends = [*starts[1:], high]
        arcs += [Arc(*arc) for arc in zip(starts, ends, bounced, strict=True)]
    return tuple(arcs)


def _kinks(
    times: Float[ndarray, "n"], positions: Float[ndarray, "n 3"], low: int, high: int
) -> list[Kink]:
    """Return the kinks between two points, in order; found ones split the search for more."""
    gaps = range(low + FEWEST_BESIDE, high - FEWEST_BESIDE + 1)
    tried = [_kink_at(times, positions, i, low, high) for i in gaps]
    found = _strongest([kink for kink in tried if kink is not None])
    edges = [low, *(kink.index for kink in found), high]
    if not found:
        return []
    more = [_kinks(times, positions, a, b) for a, b in itertools.pairwise(edges)]
    return sorted([*found, *itertools.chain(*more)], key=lambda kink: kink.index)


def _strongest(kinks: list[Kink]) -> list[Kink]:
    """Return kinks that explain more than any other within their windows, in order."""
    kept: list[Kink] = []
    for kink in sorted(kinks, key=lambda kink: -kink.gain):
        if all(abs(kink.index - other.index) > 2 * WINDOW_POINTS for other in kept):
            kept.append(kink)
    return sorted(kept, key=lambda kink: kink.index)


def _kink_at(
    times: Float[ndarray, "n"], positions: Float[ndarray, "n 3"], index: int, low: int, high: int
) -> Kink | None:
    middle = 0.5 * (times[index - 1] + times[index])
    window = _window(times, middle, index, low, high)
    t = times[window] - middle
    design = np.stack([np.ones_like(t), t, 0.5 * t * t, np.maximum(t, 0.0)], axis=1)
    solved = np.linalg.lstsq(design, positions[window], rcond=None)[0]
    misses = positions[window] - design @ solved
    freedom = 3 * max(len(t) - 4, 1)
    noise = max(np.sqrt(np.sum(misses**2) / freedom), LEAST_NOISE)
    spread = np.linalg.pinv(design.T @ design)[3, 3]
    jump = float(np.linalg.norm(solved[3]))
    if jump < max(SMALLEST_JUMP, SIGNIFICANCE * noise * np.sqrt(spread)):
        return None
    gain = jump**2 / float(spread)
    kink = Kink(index, solved[0], solved[1], solved[1] + solved[3], gain)
    return kink if kink.is_table_bounce or kink.is_stroke else None


def _window(times: Float[ndarray, "n"], middle: float, index: int, low: int, high: int) -> slice:
    """Return the points around a gap, at least 3 on either side."""
    begin, end = np.searchsorted(times, [middle - WINDOW_TIME, middle + WINDOW_TIME])
    begin = max(min(int(begin), index - FEWEST_BESIDE), index - WINDOW_POINTS, low)
    end = min(max(int(end), index + FEWEST_BESIDE), index + WINDOW_POINTS, high)
    return slice(begin, end)
