"""A fitted flight brought to the drone: turned, moved, and extended to a whole serve.

The flight is turned about the vertical until it comes along -x, moved horizontally, and extended in
time: backwards to a release 3.5 m ahead of the blade plane if it was seen only later, forwards to
the plane. Gravity stays down and nothing is scaled. Heights are kept above the table as the bounce
of the flight itself shows it (a frame that is a few centimetres off is corrected), else above 0.

Of all places along x, 1 cm apart, that serve is taken which touches nothing but the table, once, on
the drone's half (if there is none: which touches nothing), passes within 0.2 m of the blade's
height, or as near to that as can be, and is moved least. Sideways it is centred on the blade.
World frame.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.physics.ball import Ball
from rotorpong.physics.flight_fit import FlightFit, Table, follow, rewind
from rotorpong.world.contact import Contact, Solids, approach, state_of
from rotorpong.world.racket import HOME_BLADE
from rotorpong.world.serves import HUMAN, PLANE_X, Serve

RELEASE_AHEAD = HUMAN.release_ahead[0]  # m before the blade plane
LEAST_AHEAD = 3.0  # m, where the way back ends before that
MOST_AHEAD = 5.5  # m
LOWEST_RELEASE = -0.4  # m
FASTEST_RELEASE = 30.0  # m/s
LONGEST_REWIND = 0.6  # s
LONGEST_FLIGHT = 2.0  # s
LOOK = 0.002  # s between the states among which the plane is looked for
PLACE_STEP = 0.01  # m
UPRIGHT = 0.999  # of the normal at a bounce: off the top of the table, not its edge


@dataclass(frozen=True, slots=True)
class Placed:
    """A serve, and where the flight it was made of went."""

    serve: Serve
    yaw: float  # rad, counter-clockwise, by which the flight was turned about its origin
    shift: tuple[float, float, float]  # m, by which it was moved after that; up: of the table only
    left: float  # m, of the home blade's centre where it passes the blade plane
    up: float  # m
    bounces: int

    def moved(self, positions: Float[ndarray, "*n 3"]) -> Float[ndarray, "*n 3"]:
        """Return points of the measured frame where the serve has them."""
        return _turned(positions, self.yaw) + self.shift

    @property
    def rank(self) -> tuple[bool, float, float]:
        """Smaller is better."""
        return self.bounces == 0, max(abs(self.up) - HUMAN.target_up[1], 0.0), abs(self.shift[0])


def place(fit: FlightFit, direction: Float[ndarray, "2"]) -> Placed | None:
    """Return the best serve that a fitted flight makes; None if it makes none.

    Args:
        fit: in the measured frame.
        direction: horizontal, that shall come along -x.
    """
    yaw = float(math.pi - np.arctan2(direction[1], direction[0]))
    start = _start(fit, yaw)
    before, after = _rewound(start, fit), _extended(start, fit)
    if len(before.position) == 0:
        return None
    nearest = PLANE_X + LEAST_AHEAD - float(before.position[:, 0].max())
    shifts = np.arange(nearest, PLANE_X + MOST_AHEAD - float(start.position[0]), PLACE_STEP)
    best = None
    for shift in sorted(shifts.tolist(), key=abs):
        placed = _placed(before, after, fit, (yaw, shift))
        if placed and (best is None or placed.rank < best.rank):
            best = placed
        if best and best.rank[:2] == (False, 0.0):  # any other is moved more
            return best
    return best


def _start(fit: FlightFit, yaw: float) -> Ball:
    """Return the first measured ball, turned, at its height above the table."""
    ball = fit.ball
    position = _turned(ball.position, yaw) - [0.0, 0.0, fit.table.height]
    return Ball(position, _turned(ball.velocity, yaw), _turned(ball.spin, yaw))


def _turned(vectors: Float[ndarray, "*n 3"], yaw: float) -> Float[ndarray, "*n 3"]:
    c, s = math.cos(yaw), math.sin(yaw)
    return vectors @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _rewound(start: Ball, fit: FlightFit) -> Ball:
    """Return the ball at the start and every 5 ms before, as far as it can have been thrown."""
    speed = float(np.linalg.norm(start.velocity))
    until_fastest = (1.0 / speed - 1.0 / FASTEST_RELEASE) / fit.drag  # drag alone, back in time
    before = rewind(start, fit.air, min(max(until_fastest, 0.0), LONGEST_REWIND))
    sound = before.position[:, 2] >= LOWEST_RELEASE
    end = len(sound) if sound.all() else int(np.argmin(sound))
    return Ball(before.position[:end], before.velocity[:end], before.spin[:end])


def _extended(start: Ball, fit: FlightFit) -> Float[ndarray, "n 3"]:
    """Return the way of the ball over an endless table."""
    times = np.arange(0.0, LONGEST_FLIGHT, LOOK)
    return follow(start, times, fit.air, Table(fit.table.surface)).position


def _placed(
    before: Ball, after: Float[ndarray, "n 3"], fit: FlightFit, move: tuple[float, float]
) -> Placed | None:
    """Return the serve of a flight moved by (yaw, x), None if it is none."""
    yaw, shift = move
    sideways = _sideways(after, PLANE_X - shift)
    release = _release(before, shift)
    if sideways is None or release is None:
        return None
    by = (shift, sideways, 0.0)
    ball = Ball(before.position[release] + by, before.velocity[release], before.spin[release])
    solids = Solids(air=fit.air, table=fit.table.surface)
    time, state, contacts = approach(state_of(ball), PLANE_X, solids)
    if time is None or not _is_legal(contacts):
        return None
    left, up = (float(state[i] - HOME_BLADE[i]) for i in (1, 2))
    serve = Serve(ball, air=fit.air, table=fit.table.surface)
    whole = (shift, sideways, -fit.table.height)
    return Placed(serve, yaw, whole, left, up, len(contacts))


def _sideways(after: Float[ndarray, "n 3"], plane_x: float) -> float | None:
    """Return the move along y that lets a flight pass the plane at the blade's centre."""
    passed = after[:, 0] <= plane_x
    i = int(np.argmax(passed))
    if i == 0:
        return None
    (x0, y0), (x1, y1) = after[i - 1, :2], after[i, :2]
    return float(HOME_BLADE[1] - y0 - (y1 - y0) * (plane_x - x0) / (x1 - x0))


def _release(before: Ball, shift: float) -> int | None:
    """Return at which of the states back in time the ball is released, None if nowhere."""
    ahead = before.position[:, 0] + shift - PLANE_X
    enough = ahead >= RELEASE_AHEAD
    first = int(np.argmax(enough)) if enough.any() else len(ahead) - 1
    return first if ahead[first] >= LEAST_AHEAD else None


def _is_legal(contacts: tuple[Contact, ...]) -> bool:
    """Tell whether a serve touched nothing, or once the table's top on the drone's half."""
    if not contacts:
        return True
    first = contacts[0]
    on_top = first.solid == "table" and first.normal[2] > UPRIGHT
    return bool(len(contacts) == 1 and on_top and first.position[0] < 0.0)
