"""Dead reckoning from navdata: how far the body moved since an instant, and how fast it moves.

Displacement and velocity are in level axes that look where the camera looked at that instant
(right, down, forward), the axes in which hitting points are kept. They come from the velocity that
navdata give (optical flow and vertical); sonar would jump at the table's edge.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import Navdata

SMOOTHING = 0.05  # s over which a velocity is averaged


@dataclass(frozen=True, slots=True)
class Path:
    """Where the body was since an instant, level camera axes of that instant."""

    times: Float[ndarray, "n"]  # s, the first is the instant
    positions: Float[ndarray, "n 3"]  # m, the first is 0
    velocities: Float[ndarray, "n 3"]  # m/s


class Odometer:
    """Collects the navdata of one serve and adds them up."""

    def __init__(self) -> None:
        self._times: list[Float[ndarray, "_"]] = []
        self._velocities: list[Float[ndarray, "_ 3"]] = []
        self._headings: list[Float[ndarray, "_"]] = []

    def add(self, navdata: Navdata) -> None:
        """Take in what was measured since the last call."""
        self._times.append(navdata.times)
        self._velocities.append(navdata.velocity)
        self._headings.append(navdata.attitude[:, 2])

    def velocity(self, time: float) -> Float[ndarray, "3"]:
        """Return the velocity about `time`, in the level camera axes of that time; 0 if unknown."""
        times = self._joined(self._times)
        near = np.abs(times - time) <= SMOOTHING
        if not near.any():
            return np.zeros(3)
        return CAMERA_FROM_BODY_AXES @ np.concatenate(self._velocities)[near].mean(axis=0)

    def path(self, start: float, end: float) -> Path:
        """Return the path from `start` to `end` (s); velocities are held outside the navdata.

        Without any navdata the body stood still, as far as anybody knows.
        """
        if not any(map(len, self._times)):
            return Path(np.array([start, end]), np.zeros((2, 3)), np.zeros((2, 3)))
        times, velocities = self._joined(self._times), self._level(start)
        inside = (times > start) & (times < end)
        instants = np.concatenate([[start], times[inside], [end]])
        flown = np.column_stack([np.interp(instants, times, axis) for axis in velocities.T])
        steps = 0.5 * (flown[1:] + flown[:-1]) * np.diff(instants)[:, None]
        positions = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        return Path(instants, positions, _smoothed(instants, positions))

    def _level(self, start: float) -> Float[ndarray, "n 3"]:
        times, headings = self._joined(self._times), self._joined(self._headings)
        turned = headings - np.interp(start, times, np.unwrap(headings))
        forward, left, up = np.concatenate(self._velocities).T
        cosine, sine = np.cos(turned), np.sin(turned)
        body = np.column_stack([cosine * forward - sine * left, sine * forward + cosine * left, up])
        return body @ CAMERA_FROM_BODY_AXES.T

    @staticmethod
    def _joined(parts: list[Float[ndarray, "_"]]) -> Float[ndarray, "n"]:
        return np.concatenate(parts) if parts else np.empty(0)


def _smoothed(
    times: Float[ndarray, "n"], positions: Float[ndarray, "n 3"]
) -> Float[ndarray, "n 3"]:
    """Return mean velocities over a window about each time, cut at the ends."""
    before = np.maximum(times - SMOOTHING / 2, times[0])
    after = np.minimum(times + SMOOTHING / 2, times[-1])
    gone = [np.interp(after, times, x) - np.interp(before, times, x) for x in positions.T]
    return np.column_stack(gone) / (after - before)[:, None]
