"""Balls of single frames linked over time: which of them are one and the same.

Every track is a Kalman filter in the picture. Of x and y it knows place, velocity and acceleration,
driven by white jerk; of the diameter d its logarithm and that one's slope:

    x'' = a,  a' = noise        (ln d)'' = noise

All its numbers are those of a real ball: a metre at the ball is d / diameter pixels, so that the
same throw is as easy to follow filmed from near or far, small or large, slow or fast. A ball that
bounces or is struck changes its velocity within a frame; so each sight is also tried as one after
a blow, at a cost. Confirmed tracks choose their balls first, all together by the least sum of

    NIS + ln det S        gate: NIS below the 99.9 % of chi-square with 3 degrees

and the others after them. A ball that is nobody's starts a track; one that is not seen for a third
of a second ends. A track has a number once it has three sights.

What is not modelled: gravity's direction, the camera's own motion, balls behind one another.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import linear_sum_assignment

from rotorpong.conventions import BALL_DIAMETER
from rotorpong.vision.located import LocatedBall

GATE = 16.3  # chi-square of 3 degrees, 99.9 %
CONFIRMED = 3  # sights
LONGEST_COAST = 1.0 / 3.0  # s
LEAST_SCORE = 0.05  # of a ball that starts a track
SPEED_SD, ACCELERATION_SD = 8.0, 12.0  # m/s and m/s^2 at the first sight: serves; gravity and drag
JERK = 1000.0  # (m/s^3)^2 s: the acceleration changes by 10 m/s^2 in a tenth of a second
BLOW_SD, BLOW_COST = 6.0, 12.0  # m/s, and what it costs to believe in one
GROWTH_SD, GROWTH_NOISE = 3.0, 10.0  # 1/s; (1/s^2)^2 s: 8 m/s at 2.5 m
CENTER_SD_PX, CENTER_SD = 0.5, 0.05  # px, and of the diameter: blur
SIZE_SD_PX, SIZE_SD = 1.0, 0.1  # px, and of the diameter
NEVER = 1e9  # cost


@dataclass(slots=True, eq=False)
class Track:
    """One thing that moves as a ball may."""

    number: int | None = None  # once it is confirmed
    sights: list[tuple[int, float, float]] = field(default_factory=list)  # frame, x, y
    missed: int = 0  # frames in a row
    place: Float[ndarray, "3 2"] = field(default_factory=lambda: np.zeros((3, 2)))
    place_spread: Float[ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))
    size: Float[ndarray, "2"] = field(default_factory=lambda: np.zeros(2))
    size_spread: Float[ndarray, "2 2"] = field(default_factory=lambda: np.zeros((2, 2)))

    @property
    def diameter_px(self) -> float:
        """How large it appears."""
        return math.exp(float(np.clip(self.size[0], -3.0, 12.0)))


class Linker:
    """Links the balls of one sequence of frames."""

    def __init__(
        self, frames_per_second: float, ball_diameter: float = BALL_DIAMETER, *, first: int = 1
    ) -> None:
        """Begin a sequence.

        Args:
            frames_per_second: of the sequence.
            ball_diameter: of the real balls, m.
            first: number of the first track.
        """
        self._step = 1.0 / frames_per_second
        self._ball_diameter = ball_diameter
        self._longest_coast = max(2, round(LONGEST_COAST * frames_per_second))
        self._tracks: list[Track] = []
        self._frame = -1
        self.next_number = first

    @property
    def tracks(self) -> tuple[Track, ...]:
        """Those that have a number and have not ended."""
        return tuple(track for track in self._tracks if track.number is not None)

    def add(self, balls: Sequence[LocatedBall]) -> tuple[Track | None, ...]:
        """Take in the next frame; return the track of each ball, None where it is no one's."""
        self._frame += 1
        of_ball: list[Track | None] = [None] * len(balls)
        for track in self._tracks:
            self._predict(track)
        confirmed = list(self.tracks)
        self._assign(confirmed, balls, of_ball)
        self._assign([t for t in self._tracks if t.number is None], balls, of_ball)
        for track in self._tracks:
            seen = track.sights[-1][0] == self._frame
            track.missed = 0 if seen else track.missed + 1
        self._tracks = [track for track in self._tracks if not self._is_lost(track)]
        for k, ball in enumerate(balls):
            if of_ball[k] is None and ball.score >= LEAST_SCORE:
                of_ball[k] = self._begun(ball)
        return tuple(of_ball)

    def _is_lost(self, track: Track) -> bool:
        return track.missed > (1 if track.number is None else self._longest_coast)

    def _scale(self, diameter_px: float) -> float:
        """Return how many pixels a metre is at a ball."""
        return diameter_px / self._ball_diameter

    def _begun(self, ball: LocatedBall) -> Track:
        scale, center, size = self._scale(ball.diameter_px), _center_sd(ball), _size_sd(ball)
        track = Track(sights=[(self._frame, ball.x_px, ball.y_px)])
        track.place[0] = ball.x_px, ball.y_px
        track.place_spread = np.diag([center, SPEED_SD * scale, ACCELERATION_SD * scale]) ** 2
        track.size[0] = math.log(ball.diameter_px)
        track.size_spread = np.diag([size, GROWTH_SD]) ** 2
        self._tracks.append(track)
        return track

    def _predict(self, track: Track) -> None:
        t, scale = self._step, self._scale(track.diameter_px)
        move = np.array([[1.0, t, t * t / 2.0], [0.0, 1.0, t], [0.0, 0.0, 1.0]])
        noise = JERK * scale**2 * _jerk_noise(t)
        track.place = move @ track.place
        track.place_spread = move @ track.place_spread @ move.T + noise
        grow = move[:2, :2]
        track.size = grow @ track.size
        noise = GROWTH_NOISE * np.array([[t**3 / 3.0, t * t / 2.0], [t * t / 2.0, t]])
        track.size_spread = grow @ track.size_spread @ grow.T + noise

    def _blown(self, track: Track) -> Float[ndarray, "3 3"]:
        """Return the spread of a track's place if it was struck within the last step."""
        t = self._step
        push = np.array([t, 1.0, 0.0]) * BLOW_SD * self._scale(track.diameter_px)
        return track.place_spread + np.outer(push, push)

    def _assign(
        self, tracks: list[Track], balls: Sequence[LocatedBall], of_ball: list[Track | None]
    ) -> None:
        """Give tracks the free balls that explain them best, and take those in."""
        free = [k for k, track in enumerate(of_ball) if track is None]
        if not tracks or not free:
            return
        tried = [[self._explained(track, balls[k]) for k in free] for track in tracks]
        costs = np.array([[cost for cost, _ in row] for row in tried])
        for i, j in zip(*linear_sum_assignment(costs), strict=True):
            if costs[i, j] < NEVER:
                of_ball[free[j]] = tracks[i]
                self._update(tracks[i], balls[free[j]], tried[i][j][1])

    def _explained(self, track: Track, ball: LocatedBall) -> tuple[float, Float[ndarray, "3 3"]]:
        """Return what it costs to take a ball for a track's, and its spread before that."""
        plain = self._cost(track, ball, track.place_spread), track.place_spread
        if track.number is None:
            return plain
        blown = self._blown(track)
        struck = self._cost(track, ball, blown) + BLOW_COST, blown
        return min(plain, struck, key=lambda one: one[0])

    @staticmethod
    def _cost(track: Track, ball: LocatedBall, place_spread: Float[ndarray, "3 3"]) -> float:
        off = np.array([ball.x_px, ball.y_px]) - track.place[0]
        larger = math.log(ball.diameter_px) - track.size[0]
        s_place = place_spread[0, 0] + _center_sd(ball) ** 2
        s_size = track.size_spread[0, 0] + _size_sd(ball) ** 2
        nis = float(off @ off / s_place + larger**2 / s_size)
        return NEVER if nis > GATE else nis + 2.0 * math.log(s_place) + math.log(s_size)

    def _update(self, track: Track, ball: LocatedBall, place_spread: Float[ndarray, "3 3"]) -> None:
        seen = np.array([ball.x_px, ball.y_px])
        gain = place_spread[:, 0] / (place_spread[0, 0] + _center_sd(ball) ** 2)
        track.place = track.place + np.outer(gain, seen - track.place[0])
        track.place_spread = place_spread - np.outer(gain, place_spread[0])
        gain = track.size_spread[:, 0] / (track.size_spread[0, 0] + _size_sd(ball) ** 2)
        track.size = track.size + gain * (math.log(ball.diameter_px) - track.size[0])
        track.size_spread = track.size_spread - np.outer(gain, track.size_spread[0])
        track.sights.append((self._frame, ball.x_px, ball.y_px))
        if track.number is None and len(track.sights) >= CONFIRMED:
            track.number = self.next_number
            self.next_number += 1


def _center_sd(ball: LocatedBall) -> float:
    return CENTER_SD_PX + CENTER_SD * ball.diameter_px


def _size_sd(ball: LocatedBall) -> float:
    return SIZE_SD + SIZE_SD_PX / ball.diameter_px


def _jerk_noise(t: float) -> Float[ndarray, "3 3"]:
    """Return the covariance that white jerk of density 1 leaves after a time, s."""
    return np.array(
        [
            [t**5 / 20.0, t**4 / 8.0, t**3 / 6.0],
            [t**4 / 8.0, t**3 / 3.0, t**2 / 2.0],
            [t**3 / 6.0, t**2 / 2.0, t],
        ]
    )
