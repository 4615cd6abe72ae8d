"""How far a vehicle can bring a plate that is fixed to it, by the time left.

An outer bound, for any vehicle. From its state at the decision, and with its noise to come, the
vehicle is flown under every corner of its commands (each axis at minus its limit, zero or plus its
limit; the vertical one never at zero), a little beyond the limits so that the noise of a message
cannot weaken them, and under horizontal commands that swing from one limit to the other. With p the
centre of mass and roll, pitch, yaw the attitude of these flights, k ticks after the decision:

    p_low(k) = min p(k) - m(k),   p_high(k) = max p(k) + m(k)       per axis, over all flights
    each angle within its extremes over all flights and all ticks <= k
    bound(k) = [p_low, p_high] + { R(roll, pitch, yaw) r }          r on the plate

The angles' extremes run on because what a command does to the attitude now it can do later as well.
m(k) = MARGIN + DRIFT t covers what these flights leave out: the noise of messages that were or were
not sent, and the kicks that a controller with a derivative term gives at every change of a command.
It is checked by flying against it (`rotorpong.lab.bench.reach_rows`).

World frame; body frame for points of the plate. A bound is a box per tick.
"""

import itertools
from dataclasses import dataclass, fields, replace

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError
from rotorpong.geometry import (
    euler_from_quaternion,
    quaternion_from_euler,
    rotation_from_quaternion,
)
from rotorpong.physics._reach_kernels import crossings
from rotorpong.physics.vehicle import Track, Vehicle, VehicleState

MARGIN = 0.010  # m
DRIFT = 0.030  # m/s
BEYOND = 0.1  # m/s and rad/s beyond the limits: more than the noise of any message
SWINGS = (0.1, 0.2, 0.35, 0.5)  # s after which a horizontal command is turned round
ANGLE_STEPS = 5  # of each angle's range, at which the plate is looked at
BLOCK = 20  # ticks that share the extremes of the angles

Points = Float[ndarray, "m 3"]


@dataclass(frozen=True, slots=True)
class Bound:
    """Boxes that hold every point of the plate, k ticks after the decision."""

    low: Float[ndarray, "n 3"]  # m, world
    high: Float[ndarray, "n 3"]

    def touched_by(
        self, ball: Float[ndarray, "n 3"], radius: float = BALL_RADIUS
    ) -> Bool[ndarray, "n"]:
        """Tell at which ticks a ball's surface can be at the plate."""
        return np.all((ball >= self.low - radius) & (ball <= self.high + radius), axis=1)


@dataclass(frozen=True, slots=True)
class Crossings:
    """Where a ball passes the planes of b plates; nan where it does not."""

    tick: Float[ndarray, "b"]  # when its surface reaches the plane from ahead
    left: Float[ndarray, "b"]  # m, of the plate's centre, in body axes
    up: Float[ndarray, "b"]  # m
    hull_gap: Float[ndarray, "b"]  # m, how near the ball came to the hull before


def plate_bound(vehicle: Vehicle, state: VehicleState, ticks: int, plate: Points) -> Bound:
    """Return the outer bound of a plate's places from now on.

    Args:
        vehicle: who flies.
        state: one vehicle, at the decision.
        ticks: how far to look, at least 1.
        plate: points whose convex hull holds the plate, in the body frame, m.

    Raises:
        InputError: no tick to look at, or a plate without points.
    """
    if ticks < 1 or len(plate) < 1:
        raise InputError(f"{ticks} ticks, {len(plate)} points: expected at least one of each")
    low, high, angles_low, angles_high = _extremes(vehicle, state, ticks)
    margin = (MARGIN + DRIFT * 1e-3 * np.arange(ticks + 1))[:, None]
    offset_low, offset_high = _offsets(angles_low, angles_high, plate)
    return Bound(low - margin + offset_low, high + margin + offset_high)


def corner_commands(vehicle: Vehicle) -> Float[ndarray, "n 4"]:
    """Return every combination of -1, 0, 1 times the limits, vertical always at a limit."""
    signs = itertools.product((-1, 0, 1), (-1, 0, 1), (-1, 1), (-1, 0, 1))
    return np.array(list(signs)) * (vehicle.limits + BEYOND)


def fly_all(
    vehicle: Vehicle,
    state: VehicleState,
    commands: Float[ndarray, "b 4"],
    ticks: int,
    *,
    new_command: bool = True,
) -> tuple[VehicleState, Track]:
    """Fly one vehicle under b commands at once, from the same state with the same noise."""
    return vehicle.advance(
        repeated(state, len(commands)), commands, ticks=ticks, new_command=new_command
    )


def repeated(state: VehicleState, count: int) -> VehicleState:
    """Return `count` copies of one vehicle's state as a batch."""
    parts = {field.name: _tiled(getattr(state, field.name), count) for field in fields(state)}
    return replace(state, **parts)


def plate_crossings(
    ball: Float[ndarray, "n 3"],
    track: Track,
    centre: tuple[float, float, float],
    hull: tuple[float, float],
) -> Crossings:
    """Return where a ball passes the planes of plates that face forward.

    Args:
        ball: its centre at the track's instants, m.
        track: b vehicles.
        centre: of the plate in the body frame, m.
        hull: radius and half height of a flat cylinder about the centre of mass, m.
    """
    out = np.empty((len(track.position), 4))
    crossings(ball, track.position, track.quaternion, (*centre, BALL_RADIUS), hull, out)
    return Crossings(*out.T.copy())


def _extremes(
    vehicle: Vehicle, state: VehicleState, ticks: int
) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    corners = fly_all(vehicle, state, corner_commands(vehicle), ticks)[1]
    position, quaternion = [corners.position], [corners.quaternion]
    for turn in SWINGS:
        swung = _swing(vehicle, state, round(turn * 1e3), ticks)
        position.append(swung[0])
        quaternion.append(swung[1])
    centres = np.concatenate(position)
    angles = euler_from_quaternion(np.concatenate(quaternion))
    angles[..., 2] = np.unwrap(angles[..., 2], axis=1)
    return (
        centres.min(axis=0),
        centres.max(axis=0),
        np.minimum.accumulate(angles.min(axis=0)),
        np.maximum.accumulate(angles.max(axis=0)),
    )


def _swing(vehicle: Vehicle, state: VehicleState, turn: int, ticks: int) -> tuple[ndarray, ndarray]:
    """Fly horizontal commands that are turned round after `turn` ticks."""
    limits = vehicle.limits + BEYOND
    signs = np.array([[1, 0, 0, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, -1, 0, 0]]) * limits
    first = min(turn, ticks)
    there, out = fly_all(vehicle, state, signs, first)
    if first == ticks:
        return out.position, out.quaternion
    _, back = vehicle.advance(there, -signs, ticks=ticks - first, new_command=True)
    return (
        np.concatenate([out.position, back.position[:, 1:]], axis=1),
        np.concatenate([out.quaternion, back.quaternion[:, 1:]], axis=1),
    )


def _offsets(
    low: Float[ndarray, "n 3"], high: Float[ndarray, "n 3"], plate: Points
) -> tuple[Float[ndarray, "n 3"], Float[ndarray, "n 3"]]:
    """Return the extremes of the plate's points about the centre of mass, block by block."""
    n = len(low)
    blocks = -(-n // BLOCK)
    ends = np.minimum(np.arange(1, blocks + 1) * BLOCK, n) - 1
    share = np.linspace(0.0, 1.0, ANGLE_STEPS)
    grid = np.array(list(itertools.product(share, repeat=3)))
    angles = low[ends, None] + grid * (high[ends] - low[ends])[:, None]
    turned = rotation_from_quaternion(quaternion_from_euler(angles))
    points = np.einsum("bgij,mj->bgmi", turned, plate)
    rows = np.arange(n) // BLOCK
    return points.min(axis=(1, 2))[rows], points.max(axis=(1, 2))[rows]


def _tiled(part: ndarray, count: int) -> ndarray:
    return np.broadcast_to(part, (count, *part.shape)).copy()
