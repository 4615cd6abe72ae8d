"""Who touches whom: the ball flown among table, net, floor, blade and hull.

The drone is a track of poses, one per tick, made by the vehicle beforehand; the ball does not push
it. Contacts are exact in time (see `_contact_kernels`). One ball and many go through the same
kernel, and a flight may be cut into legs at any tick: the bits of the result are the same. World
frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.conventions import InputError, Vector3
from rotorpong.physics.ball import Ball
from rotorpong.world import _contact_kernels as kernels
from rotorpong.world import _passing_kernels, _solid_kernels
from rotorpong.world.court import (
    FLOOR_HEIGHT,
    NET_HALF_LENGTH,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rotorpong.world.racket import Hull, Racket
from rotorpong.world.solids import PARTS, SOLIDS, TICK, Part, Solid, parameters
from rotorpong.world.solids import Solids as Solids

COARSE_TICK = 0.004  # s, for flights over the empty court

Track = Float[ndarray, "instants 7"]  # position, quaternion
BallState = Float[ndarray, "9"]  # position, velocity, spin
Contacts = tuple["Contact", ...]
TRACK_LOST = "track of the drone: expected finite poses"
MOST_CONTACTS = 64  # of a piece of flight that are kept
LEG = 250  # ticks, in which a landing is looked for
MOST_BOUNCES = 8  # after which a flight over the court is given up

COURT: tuple[Solid, ...] = ("table", "net", "floor")
TOUCHING = 1e-9  # m by which a ball that rests on something may lie in it


@dataclass(frozen=True, slots=True)
class Contact:
    """One touch of the ball."""

    time: float  # s
    solid: Solid
    part: Part
    position: Float[ndarray, "3"]  # of the ball's centre, world
    velocity: Float[ndarray, "3"]  # just before, world
    spin: Float[ndarray, "3"]  # just before, rad/s
    normal: Float[ndarray, "3"]  # of the solid, towards the ball, world
    surface_velocity: Float[ndarray, "3"]  # of the touched point, world
    velocity_after: Float[ndarray, "3"]
    spin_after: Float[ndarray, "3"]
    facing: float  # normal . blade normal: 1 full face, -1 back; 0 off the drone
    blade_point: tuple[float, float]  # in semi-axes: left, up; (0, 0) off the blade


def state_of(ball: Ball) -> BallState:
    """Return the nine floats of one ball."""
    return np.concatenate([ball.position, ball.velocity, ball.spin])


def advance(
    state: BallState, start_time: float, track: Track, solids: Solids
) -> tuple[Float[ndarray, "ticks 9"], Contacts]:
    """Fly a ball along a drone's track.

    Args:
        state: the ball at the track's first instant.
        start_time: that instant, s.
        track: poses at successive ticks.
        solids: what there is to touch.

    Returns:
        The ball's state after each tick, and its contacts in order.

    Raises:
        InputError: a state or track that is not finite, impossible solids.
    """
    paths, contacts = advance_many(state[None], start_time, track[None], solids)
    return paths[0], contacts[0]


def advance_many(
    states: Float[ndarray, "n 9"],
    start_time: float,
    tracks: Float[ndarray, "n instants 7"],
    solids: Solids | Sequence[Solids],
) -> tuple[Float[ndarray, "n ticks 9"], tuple[Contacts, ...]]:
    """Fly many balls, each along a drone's track of its own: the loop over `advance`, bit for bit.

    Args:
        states: the balls at the tracks' first instant.
        start_time: that instant, s.
        tracks: poses at successive ticks, of as many drones.
        solids: what there is to touch, for all or one for each.

    Returns:
        The balls' states after each tick, and each ball's contacts in order.

    Raises:
        InputError: a state or track that is not finite, impossible solids.
    """
    require_finite(states)
    if not np.isfinite(tracks).all():
        raise InputError(TRACK_LOST)
    return _advance_many(states, start_time, tracks, solids, ticks=tracks.shape[1] - 1)


def solid_at(position: Vector3) -> Solid | None:
    """Return which of table, net and floor a ball with its centre at `position` (m) lies in."""
    x, y, z = (float(value) for value in position)
    for number, solid in enumerate(COURT):
        if _solid_kernels.court_gap(number, x, y, z) < -TOUCHING:
            return solid
    return None


def fly_over_court(state: BallState, ticks: int, solids: Solids) -> Float[ndarray, "ticks 9"]:
    """Fly a ball over the court without a drone; return its state after each tick."""
    return _over_court(state, ticks, solids)[0]


def land(state: BallState, solids: Solids, longest: float = 3.0) -> Contacts:
    """Fly a ball over the court without a drone; return its contacts up to the floor."""
    contacts = _over_court(state, round(longest / TICK), solids)[1]
    floor = next((i for i, c in enumerate(contacts) if c.solid == "floor"), len(contacts))
    return contacts[: floor + 1]


def touch_down(state: BallState, solids: Solids, longest: float = 3.0) -> Contact | None:
    """Fly a ball over the court without a drone; return its first contact off the net, if any.

    Flown in legs, so that a ball costs no more than the time that it is in the air.
    """
    for start in range(0, round(longest / TICK), LEG):
        path, contacts = _over_court(state, LEG, solids, start * TICK)
        down = next((contact for contact in contacts if contact.solid != "net"), None)
        if down is not None:
            return down
        state = path[-1]
    return None


def approach(
    state: BallState, plane_x: float, solids: Solids, longest: float = 3.0
) -> tuple[float | None, BallState, Contacts]:
    """Fly a ball over the empty court until its centre passes x = plane_x.

    The flight is given up after `longest` seconds, or at its eighth contact.

    Returns:
        Time of the crossing (None: it never came), the state there (nan if not), and the contacts
        before.
    """
    require_finite(state)
    crossing, rows = np.full(9, np.nan), np.empty((MOST_BOUNCES, kernels.CONTACT_COLUMNS))
    numbers = parameters(solids._replace(tick=COARSE_TICK))
    time, count = kernels.approach(state.copy(), plane_x, longest, numbers, rows, crossing)
    contacts = tuple(contact_from_row(row) for row in rows[: min(count, len(rows))])
    return (time if time >= 0.0 else None), crossing, contacts


def miss_distances(
    positions: Float[ndarray, "n 3"], track: Track, racket: Racket
) -> Float[ndarray, "n"]:
    """Return the gap between the ball's surface and the blade at each instant, m."""
    out = np.empty(len(positions))
    _passing_kernels.blade_gaps(positions, track, sizes_of(racket), out)
    return out


def time_error(
    positions: Float[ndarray, "n 3"], track: Track, racket: Racket, longest: float = 0.2
) -> float | None:
    """Return by how much the blade was late (early: negative) where the ball passed, s.

    The smallest shift in time at which blade and ball would have met face to face; None if there
    is none within `longest`.
    """
    most = round(longest / TICK)
    lag = _passing_kernels.lateness(positions, track, (0, box_about(track)), sizes_of(racket), most)
    return lag * TICK if lag <= most else None


def box_about(track: Track) -> Float[ndarray, "6"]:
    """Return the lowest and the highest corner of the box about a track's places."""
    return np.concatenate([track[:, :3].min(axis=0), track[:, :3].max(axis=0)])


def drone_touches_court(track: Track, hull: Hull) -> bool:
    """Tell whether the hull of a nearly level drone reached floor, table or net."""
    return bool(drones_touch_court(track[None], hull)[0])


def drones_touch_court(tracks: Float[ndarray, "n instants 7"], hull: Hull) -> Bool[ndarray, "n"]:
    """Tell for many drones what `drone_touches_court` tells for one."""
    x, y, z = tracks[..., 0], tracks[..., 1], tracks[..., 2]
    low = z - hull.half_height
    over_table = (np.abs(x) < TABLE_HALF_LENGTH + hull.radius) & (
        np.abs(y) < TABLE_HALF_WIDTH + hull.radius
    )
    at_net = (np.abs(x) < hull.radius) & (np.abs(y) < NET_HALF_LENGTH + hull.radius)
    hits = (low < FLOOR_HEIGHT) | (over_table & (low < 0.0))
    return np.any(hits | (at_net & (low < NET_HEIGHT)), axis=-1)


def _advance_many(
    states: Float[ndarray, "n 9"],
    start_time: float,
    tracks: Float[ndarray, "n instants 7"],
    solids: Solids | Sequence[Solids],
    *,
    ticks: int,
) -> tuple[Float[ndarray, "n ticks 9"], tuple[Contacts, ...]]:
    n, each = len(states), (solids,) if isinstance(solids, Solids) else tuple(solids)
    if len(each) not in (1, n) or len(tracks) != n:
        raise InputError(
            f"{n} balls, {len(tracks)} tracks and {len(each)} solids: expected as many"
        )
    paths, rows = np.empty((n, ticks, 9)), np.empty((n, MOST_CONTACTS, kernels.CONTACT_COLUMNS))
    counts = np.zeros(n, dtype=np.int64)
    kernels.advance_many(
        np.ascontiguousarray(states, dtype=float),
        float(start_time),
        np.ascontiguousarray(tracks, dtype=float),
        parameters(each[0])[None] if len(each) == 1 else np.array([*map(parameters, each)]),
        rows,
        counts,
        paths,
    )
    kept = np.minimum(counts, MOST_CONTACTS).tolist()
    return paths, tuple(tuple(map(contact_from_row, rows[i, :k])) for i, k in enumerate(kept))


def _over_court(
    state: BallState, ticks: int, solids: Solids, start_time: float = 0.0
) -> tuple[Float[ndarray, "ticks 9"], Contacts]:
    """Fly one ball where there is no drone."""
    require_finite(state)
    no_drone = np.empty((1, 0, 7))
    paths, contacts = _advance_many(state[None], start_time, no_drone, solids, ticks=ticks)
    return paths[0], contacts[0]


def require_finite(states: Float[ndarray, "*n 9"]) -> None:
    """Refuse balls that must not enter the integrator.

    Raises:
        InputError: a state is not finite.
    """
    if not np.isfinite(states).all():
        raise InputError(f"ball {states}: expected finite position, velocity and spin")


def sizes_of(racket: Racket) -> Float[ndarray, "5"]:
    """Return half axes and place of a blade, as the kernels take them, m."""
    return np.array(racket[1:], dtype=float)


def contact_from_row(row: Float[ndarray, "27"]) -> Contact:
    """Return the contact that a kernel wrote down."""
    solid = int(row[kernels.SOLID])
    parts = (row[start : start + 3].copy() for start in range(kernels.POSITION, kernels.FACING, 3))
    return Contact(
        float(row[kernels.TIME]),
        SOLIDS[solid],
        PARTS[solid][int(row[kernels.PART])],
        *parts,
        facing=float(row[kernels.FACING]),
        blade_point=(float(row[kernels.BLADE_POINT]), float(row[kernels.BLADE_POINT + 1])),
    )
