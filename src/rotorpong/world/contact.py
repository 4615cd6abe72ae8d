"""Who touches whom: the ball flown among table, net, floor, blade and hull.

The drone is a track of poses, one per tick, made by the vehicle beforehand; the ball does not push
it. Contacts are exact in time (see `_contact_kernels`). World frame.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, Surface
from rotorpong.world import _contact_kernels as kernels
from rotorpong.world.court import (
    FLOOR_HEIGHT,
    NET_HALF_LENGTH,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rotorpong.world.racket import HULL, Hull, Racket

TICK = 0.001  # s, the world's clock
COARSE_TICK = 0.004  # s, for flights over the empty court

Solid = Literal["table", "net", "floor", "blade", "hull"]
SOLIDS: tuple[Solid, ...] = ("table", "net", "floor", "blade", "hull")

NET_SURFACE = Surface(0.1, 0.3)  # a mesh that swallows the ball
FLOOR_SURFACE = Surface(0.75, 0.4)

Track = Float[ndarray, "instants 7"]  # position, quaternion
BallState = Float[ndarray, "9"]  # position, velocity, spin
NO_DRONE = np.empty((0, 7))
MOST_CONTACTS = 64  # of a piece of flight that are kept
MOST_BOUNCES = 8  # after which a flight over the court is given up


class Solids(NamedTuple):
    """Everything the ball meets, as the kernels take it."""

    air: Air = Air()
    table: Surface = TABLE_SURFACE
    net: Surface = NET_SURFACE
    floor: Surface = FLOOR_SURFACE
    racket: Racket = Racket()
    hull: Hull = HULL
    tick: float = TICK


@dataclass(frozen=True, slots=True)
class Contact:
    """One touch of the ball."""

    time: float  # s
    solid: Solid
    position: Float[ndarray, "3"]  # of the ball's centre, world
    velocity: Float[ndarray, "3"]  # just before, world
    normal: Float[ndarray, "3"]  # of the solid, towards the ball, world
    facing: float  # normal . blade normal: 1 full face, -1 back; 0 off the drone
    blade_point: tuple[float, float]  # in semi-axes: left, up; (0, 0) off the blade


def state_of(ball: Ball) -> BallState:
    """Return the nine floats of one ball."""
    return np.concatenate([ball.position, ball.velocity, ball.spin])


def advance(
    state: BallState, start_time: float, track: Track, solids: Solids
) -> tuple[Float[ndarray, "ticks 9"], tuple[Contact, ...]]:
    """Fly a ball along a drone's track.

    Args:
        state: the ball at the track's first instant.
        start_time: that instant, s.
        track: poses at successive ticks.
        solids: what there is to touch.

    Returns:
        The ball's state after each tick, and its contacts in order.
    """
    ticks = len(track) - 1
    path, rows = np.empty((ticks, 9)), np.empty((MOST_CONTACTS, 14))
    count = kernels.advance(
        state.copy(), start_time, ticks, track, solids, kernels.make_work(), rows, path
    )
    return path, tuple(contact_from_row(row) for row in rows[: min(count, MOST_CONTACTS)])


def fly_over_court(state: BallState, ticks: int, solids: Solids) -> Float[ndarray, "ticks 9"]:
    """Fly a ball over the court without a drone; return its state after each tick."""
    return advance(state, 0.0, _nobody(ticks), solids)[0]


def land(state: BallState, solids: Solids, longest: float = 3.0) -> tuple[Contact, ...]:
    """Fly a ball over the court without a drone; return its contacts up to the floor."""
    contacts = advance(state, 0.0, _nobody(round(longest / TICK)), solids)[1]
    floor = next((i for i, c in enumerate(contacts) if c.solid == "floor"), len(contacts))
    return contacts[: floor + 1]


def approach(
    state: BallState, plane_x: float, solids: Solids, longest: float = 3.0
) -> tuple[float | None, BallState, tuple[Contact, ...]]:
    """Fly a ball over the empty court until its centre passes x = plane_x.

    The flight is given up after `longest` seconds, or at its eighth contact.

    Returns:
        Time of the crossing (None: it never came), the state there (nan if not), and the contacts
        before.
    """
    crossing, rows = np.full(9, np.nan), np.empty((MOST_BOUNCES, 14))
    time, count = kernels.approach(
        state.copy(), plane_x, longest, _coarse(solids), kernels.make_work(), rows, crossing
    )
    contacts = tuple(contact_from_row(row) for row in rows[: min(count, len(rows))])
    return (time if time >= 0.0 else None), crossing, contacts


def miss_distances(
    positions: Float[ndarray, "n 3"], track: Track, racket: Racket
) -> Float[ndarray, "n"]:
    """Return the gap between the ball's surface and the blade at each instant, m."""
    out = np.empty(len(positions))
    kernels.blade_gaps(positions, track, racket, np.empty((3, 3)), np.empty(3), np.empty(3), out)
    return out


def time_error(
    positions: Float[ndarray, "n 3"], track: Track, racket: Racket, longest: float = 0.2
) -> float | None:
    """Return by how much the blade was late (early: negative) where the ball passed, s.

    The smallest shift in time at which blade and ball would have met face to face; None if there
    is none within `longest`.
    """
    most, scratch = round(longest / TICK), (np.empty((3, 3)), np.empty(3), np.empty(3))
    lag = kernels.lateness(positions, track, racket, most, scratch)
    return lag * TICK if lag <= most else None


def drone_touches_court(track: Track, hull: Hull) -> bool:
    """Tell whether the hull of a nearly level drone reached floor, table or net."""
    x, y, z = track[:, 0], track[:, 1], track[:, 2]
    low = z - hull.half_height
    over_table = (np.abs(x) < TABLE_HALF_LENGTH + hull.radius) & (
        np.abs(y) < TABLE_HALF_WIDTH + hull.radius
    )
    at_net = (np.abs(x) < hull.radius) & (np.abs(y) < NET_HALF_LENGTH + hull.radius)
    hits = (low < FLOOR_HEIGHT) | (over_table & (low < 0.0))
    return bool(np.any(hits | (at_net & (low < NET_HEIGHT))))


def _nobody(ticks: int) -> Track:
    """Return the track of a drone out of everybody's way."""
    return np.tile([0.0, 0.0, 99.0, 1.0, 0.0, 0.0, 0.0], (ticks + 1, 1))


def _coarse(solids: Solids) -> Solids:
    return solids._replace(tick=COARSE_TICK)


def contact_from_row(row: Float[ndarray, "14"]) -> Contact:
    """Return the contact that a kernel wrote down."""
    return Contact(
        time=float(row[0]),
        solid=SOLIDS[int(row[1])],
        position=row[2:5].copy(),
        velocity=row[5:8].copy(),
        normal=row[8:11].copy(),
        facing=float(row[11]),
        blade_point=(float(row[12]), float(row[13])),
    )
