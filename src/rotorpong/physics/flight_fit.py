"""The ball's state, drag, spin and bounce that explain a measured flight.

Least squares over the RK4 flight of `ball` (positions p_i at times t_i, unknowns x):

    min  sum_i rho(|flight(x, t_i) - p_i|^2 / s^2) + sum_j rho((x_j - mean_j)^2 / sd_j^2)

with rho(r^2) = 2 (sqrt(1 + r^2) - 1) for each coordinate, so that a few bad points do not bend the
flight; s is the noise of good 3-D tracking, and the second sum what is known of table tennis before
any measurement (a `Belief`): without it the spin along the direction of flight, which bends
nothing, could be anything. The Magnus coefficient is that of `Air`; only the lift can be measured,
which is its product with the spin, saturated.
Where the flight bounces, restitution, friction and the table's height in the measured frame are
unknown too. World-like frame: z up, metres; the table may lie anywhere horizontally.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import least_squares

from rotorpong.conventions import BALL_RADIUS, GRAVITY, InputError
from rotorpong.physics import _flight_fit_kernels as kernels
from rotorpong.physics.ball import STEP, TABLE_SURFACE, Air, Ball, Surface

NOISE = 0.004  # m, a coordinate of a tracked ball
SPIN_SD = 60.0  # rad/s, each axis
DRAG_MEAN, DRAG_SD, DRAG_RANGE = 0.15, 0.02, (0.11, 0.17)  # 1/m; facts of real flights
RESTITUTION_SD, RESTITUTION_RANGE = 0.03, (0.75, 0.98)
FRICTION_SD, FRICTION_RANGE = 0.1, (0.0, 0.8)
TABLE_HEIGHT_SD = 0.01  # m, by which a measured frame may miss the playing surface
TABLE_HEIGHT_MOST = 0.05
MOST_BOUNCES = 4  # that a rolling ball's may be told apart
FEWEST_POINTS = 5


@dataclass(frozen=True, slots=True)
class Belief:
    """What is believed of air and spin before a flight is measured; a spread of 0 is certainty."""

    drag: float = DRAG_MEAN  # 1/m
    drag_sd: float = DRAG_SD
    drag_range: tuple[float, float] = DRAG_RANGE
    spin_sd: float = SPIN_SD  # rad/s, each axis, about no spin
    saturation: float = Air().saturation  # of the lift, certain; 0: linear in the spin


USUAL = Belief()


@dataclass(frozen=True, slots=True)
class Table:
    """A table without end, at some height of a measured frame."""

    surface: Surface = TABLE_SURFACE
    height: float = 0.0  # m


@dataclass(frozen=True, slots=True)
class FlightFit:
    """A flight, and how well it explains what was measured."""

    ball: Ball  # at the first measured time, in the measured frame
    air: Air
    table: Table  # fitted if the flight bounces, else the usual one
    residual_rms: float  # m, rms distance of the measured points from the flight
    points: int
    bounced: bool

    @property
    def drag(self) -> float:
        """Quadratic drag, 1/m."""
        return self.air.drag

    @property
    def spin(self) -> Float[ndarray, "3"]:
        """Spin before the bounce, rad/s."""
        return self.ball.spin


def fit_flight(
    times: Float[ndarray, "n"],
    positions: Float[ndarray, "n 3"],
    *,
    bounces: bool,
    belief: Belief = USUAL,
) -> FlightFit:
    """Return the flight nearest to measured positions of a ball that nobody touched.

    Args:
        times: s, increasing.
        positions: m, z up.
        bounces: whether it bounces off the table on the way; else it meets nothing.
        belief: about drag and spin, before the measurement.

    Raises:
        InputError: fewer than 5 points.
    """
    if len(times) < FEWEST_POINTS:
        raise InputError(f"flight of {len(times)} points: expected at least {FEWEST_POINTS}")
    means, sds, ranges = _beliefs(belief, 7 if bounces else 4)
    free = sds > 0.0

    def parameters_of(unknowns: Float[ndarray, "k"]) -> Float[ndarray, "m"]:
        parameters = means.copy()
        parameters[free] += sds[free] * unknowns[6:]
        return parameters

    def residuals(unknowns: Float[ndarray, "k"]) -> Float[ndarray, "j"]:
        path = _path(unknowns[:6], parameters_of(unknowns), times, belief)
        return np.r_[((path - positions) / NOISE).ravel(), unknowns[6:]]

    sides = ((ranges[free] - means[free, None]) / sds[free, None]).T
    bounds = tuple(
        np.r_[[sign * np.inf] * 6, side] for sign, side in zip((-1, 1), sides, strict=True)
    )
    start = np.r_[_first_guess(times, positions), np.zeros(int(free.sum()))]
    solved = least_squares(residuals, start, bounds=bounds, loss="soft_l1", x_scale="jac").x
    parameters = parameters_of(solved)
    misses = _path(solved[:6], parameters, times, belief) - positions
    air, table = _medium(parameters, belief)
    return FlightFit(
        ball=Ball(solved[:3], solved[3:6], parameters[:3]),
        air=air,
        table=table,
        residual_rms=float(np.sqrt(np.mean(np.sum(misses**2, axis=1)))),
        points=len(times),
        bounced=bounces,
    )


def follow(
    ball: Ball, times: Float[ndarray, "n"], air: Air, table: Table, most: int = MOST_BOUNCES
) -> Ball:
    """Return one ball at each of the times, bouncing off an endless table.

    Args:
        ball: at the first time, shape (3,).
        times: s, increasing.
        air: what it does to the ball.
        table: what it bounces off.
        most: bounces; after that it falls through.
    """
    state = np.concatenate([ball.position, ball.velocity, ball.spin]).astype(float)
    path = np.empty((len(times), 9))
    kernels.follow(state, times, air, table.surface, table.height + BALL_RADIUS, most, path)
    return _balls(path)


def fall(balls: Ball, air: Air, height: float, longest: float) -> tuple[Ball, Float[ndarray, "n"]]:
    """Return balls where their centres come down to a height, and how long that takes.

    Args:
        balls: n of them, shape (n, 3).
        air: what it does to the ball.
        height: of the centre, m.
        longest: s after which the search ends; the time of a ball that is still above is NaN.
    """
    states = np.concatenate([balls.position, balls.velocity, balls.spin], axis=1).astype(float)
    times = np.empty(len(states))
    kernels.fall(states, air, height, longest, times)
    return _balls(states), times


def rewind(ball: Ball, air: Air, duration: float) -> Ball:
    """Return one ball now, 5 ms ago, 10 ms ago ... in free flight, `duration` seconds back."""
    path = np.empty((int(np.ceil(duration / STEP)) + 1, 9))
    kernels.trace(np.concatenate([ball.position, ball.velocity, ball.spin]), air, -STEP, path)
    return _balls(path)


def _balls(path: Float[ndarray, "n 9"]) -> Ball:
    return Ball(path[:, :3].copy(), path[:, 3:6].copy(), path[:, 6:].copy())


def _beliefs(
    belief: Belief, count: int
) -> tuple[Float[ndarray, "m"], Float[ndarray, "m"], Float[ndarray, "m 2"]]:
    """Return means, spreads and ranges of the first `count` parameters (see `_medium`)."""
    rows = [
        *[(0.0, belief.spin_sd, -np.inf, np.inf)] * 3,
        (belief.drag, belief.drag_sd, *belief.drag_range),
        (TABLE_SURFACE.restitution, RESTITUTION_SD, *RESTITUTION_RANGE),
        (TABLE_SURFACE.friction, FRICTION_SD, *FRICTION_RANGE),
        (0.0, TABLE_HEIGHT_SD, -TABLE_HEIGHT_MOST, TABLE_HEIGHT_MOST),
    ]
    table = np.array(rows[:count])
    return table[:, 0], table[:, 1], table[:, 2:]


def _path(
    launch: Float[ndarray, "6"],
    parameters: Float[ndarray, "m"],
    times: Float[ndarray, "n"],
    belief: Belief,
) -> Float[ndarray, "n 3"]:
    air, table = _medium(parameters, belief)
    state, path = np.r_[launch, parameters[:3]], np.empty((len(times), 9))
    most = int(len(parameters) > 4)
    kernels.follow(state, times, air, table.surface, table.height + BALL_RADIUS, most, path)
    return path[:, :3]


def _medium(parameters: Float[ndarray, "m"], belief: Belief) -> tuple[Air, Table]:
    """Return air and table from (spin, drag[, restitution, friction, height])."""
    air = Air(drag=float(parameters[3]), saturation=belief.saturation)
    if len(parameters) == 4:
        return air, Table()
    restitution, friction, height = (float(value) for value in parameters[4:])
    return air, Table(Surface(restitution, friction), height)


def _first_guess(
    times: Float[ndarray, "n"], positions: Float[ndarray, "n 3"]
) -> Float[ndarray, "6"]:
    """Return position and velocity at the first time from a parabola through the first points."""
    first = max(FEWEST_POINTS - 2, len(times) // 4)
    t = times[:first] - times[0]
    design = np.stack([np.ones_like(t), t], axis=1)
    falling = positions[:first] + 0.5 * GRAVITY * t[:, None] ** 2 * [0.0, 0.0, 1.0]
    return np.linalg.lstsq(design, falling, rcond=None)[0].ravel()
