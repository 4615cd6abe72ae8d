"""The frame of measured flights, as the flight filter wants it: the table along x, its height.

Trackers put the origin at the table's centre and z up; along which axis the table lies, and whether
z = 0 is its surface or the ball's centre that lies on it, the recordings tell. A bounce is where
two lines meet, fitted to the heights before and after it with gravity taken off; the table is a
ball's radius below.
"""

import itertools

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.lab.flight_files import Flight
from rotorpong.physics.flight_arcs import Arc

BESIDE = 4  # points on either side that give a line
FEWEST_BOUNCES = 5  # whose median is a table


def along_x(flights: tuple[Flight, ...]) -> tuple[Flight, ...]:
    """Return flights of one frame, turned by 90 degrees about z if they go rather along y."""
    steps = np.concatenate([np.diff(one.positions[:, :2], axis=0) for one in flights])
    ways = np.abs(steps).sum(axis=0)
    if ways[0] >= ways[1]:
        return flights
    return tuple(Flight(one.name, one.times, _turned(one.positions)) for one in flights)


def bounce_heights(flight: Flight, arcs: tuple[Arc, ...]) -> list[float]:
    """Return the table's height at each bounce with enough points on both sides, m."""
    return [
        _height_at(flight, after.first)
        for before, after in itertools.pairwise(arcs)
        if after.follows_bounce and min(before.points, after.points) >= BESIDE
    ]


def heights_by_others(heights: list[list[float]]) -> list[float]:
    """Return the table's height for each flight, by the bounces of all others.

    What is predicted of a flight must not be told by its own bounce. The files' convention, 0,
    where the others have fewer than 5 bounces.
    """
    return [_middle(heights[:i] + heights[i + 1 :]) for i in range(len(heights))]


def _middle(heights: list[list[float]]) -> float:
    known = [height for flight in heights for height in flight]
    return float(np.median(known)) if len(known) >= FEWEST_BOUNCES else 0.0


def _height_at(flight: Flight, index: int) -> float:
    """Return the table's height at the bounce before a point."""
    start = 0.5 * (flight.times[index - 1] + flight.times[index])
    down = _line(flight, slice(index - BESIDE, index), start)
    up = _line(flight, slice(index, index + BESIDE), start)
    time = (down[0] - up[0]) / (up[1] - down[1])
    return float(down[0] + down[1] * time - 0.5 * GRAVITY * time**2) - BALL_RADIUS


def _line(flight: Flight, points: slice, start: float) -> Float[ndarray, "2"]:
    """Return height and vertical speed at a time, gravity taken off."""
    t = flight.times[points] - start
    design = np.stack([np.ones_like(t), t], axis=1)
    risen = flight.positions[points, 2] + 0.5 * GRAVITY * t**2
    return np.linalg.lstsq(design, risen, rcond=None)[0]


def _turned(positions: Float[ndarray, "n 3"]) -> Float[ndarray, "n 3"]:
    return np.stack([positions[:, 1], -positions[:, 0], positions[:, 2]], axis=1)
