"""What the air does, from states of a ball at the two ends of many free flights.

A leg starts at a measured position with a measured velocity and spin, and ends at a measured
position some time later. Drag k, Magnus coefficient m, lift saturation s and one delay explain all
legs at once:

    min  sum_i rho(|flight(x_i, v_i, w_i; k, m, s)(t_i) - p_i|^2 / n^2),  rho soft_l1 per coordinate

The delay: a velocity taken over the first points after a stroke is that of the middle of these
points, so it belongs to a later moment than the position; flown back by the delay it is the
velocity at the start. World-like frame: z up, metres, right-handed spin in rad/s.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import least_squares

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.physics import _flight_fit_kernels as kernels
from rotorpong.physics.ball import Air, Ball

NOISE = 0.015  # m, a coordinate of a measured position
LONGEST_DELAY = 0.05  # s
# drag, magnus, saturation, delay:
LOWEST = np.array([0.0, -0.1, 0.0, -LONGEST_DELAY])
HIGHEST = np.array([0.5, 0.1, 50.0, LONGEST_DELAY])
SCALES = np.array([0.01, 1e-4, 0.1, 1e-3])
MEETING_ROUNDS = 30  # each leaves about a quarter of the miss


@dataclass(frozen=True, slots=True)
class Legs:
    """Free flights of n balls, each known at its two ends."""

    start: Ball  # arrays of shape (n, 3)
    end: Float[ndarray, "n 3"]  # m
    duration: Float[ndarray, "n"]  # s

    def __len__(self) -> int:
        return len(self.duration)

    def __getitem__(self, which: Any) -> "Legs":
        """Return the legs of a mask or of indices."""
        return Legs(taken(self.start, which), self.end[which], self.duration[which])

    @property
    def spin_ratio(self) -> Float[ndarray, "n"]:
        """Surface speed of the spin that bends the flight, over the ball's speed."""
        across = np.linalg.norm(np.cross(self.start.spin, self.start.velocity), axis=1)
        return BALL_RADIUS * across / np.sum(self.start.velocity**2, axis=1)


@dataclass(frozen=True, slots=True)
class AirFit:
    """The air that explains legs, with standard errors."""

    air: Air
    delay: float  # s by which velocities belong to later moments than positions
    drag_sd: float
    magnus_sd: float
    saturation_sd: float
    delay_sd: float


def fit_air(
    legs: Legs,
    *,
    drag: float | None = None,
    saturation: float | None = None,
    delay: float | None = None,
) -> AirFit:
    """Return the air and the delay of velocities that bring the legs nearest to their ends.

    Args:
        legs: at least 3.
        drag: 1/m if it is known.
        saturation: of the lift, if it is known; 0 for a lift that is linear in the spin.
        delay: s if it is known.
    """
    known = np.array([np.nan if v is None else v for v in (drag, None, saturation, delay)])
    free = np.isnan(known)

    def medium(unknowns: Float[ndarray, "k"]) -> tuple[Air, float]:
        values = known.copy()
        values[free] = unknowns
        k, m, s, late = map(float, values)
        return Air(drag=k, magnus=m, saturation=s), late

    def residuals(unknowns: Float[ndarray, "k"]) -> Float[ndarray, "j"]:
        air, delay = medium(unknowns)
        return ((_ends(legs, air, delay) - legs.end) / NOISE).ravel()

    usual = Air()
    first = np.array([usual.drag, usual.magnus, usual.saturation, 0.0])
    bounds = (LOWEST[free], HIGHEST[free])
    solved = least_squares(
        residuals, first[free], bounds=bounds, loss="soft_l1", x_scale=SCALES[free]
    )
    spreads = np.zeros(len(known))
    spreads[free] = np.sqrt(np.diag(np.linalg.pinv(solved.jac.T @ solved.jac)))
    return AirFit(*medium(solved.x), *(float(sd) for sd in spreads))


def undelayed(ball: Ball, air: Air, delay: float) -> Ball:
    """Return balls with their velocities flown back by `delay` seconds, where they are."""
    return Ball(
        ball.position, _flown(ball, air, np.full(len(ball.spin), -delay)).velocity, ball.spin
    )


def landing(legs: Legs, air: Air) -> tuple[Ball, Ball]:
    """Return the balls at start and end of flights through both measured positions in time.

    The measured velocities are not used but for the first guess; spin is as measured.
    """
    pull = np.array([0.0, 0.0, -GRAVITY])
    lasting = legs.duration[:, None]
    velocity = (legs.end - legs.start.position) / lasting - 0.5 * pull * lasting
    for _ in range(MEETING_ROUNDS):
        ball = Ball(legs.start.position, velocity, legs.start.spin)
        velocity = velocity - (_flown(ball, air, legs.duration).position - legs.end) / lasting
    ball = Ball(legs.start.position, velocity, legs.start.spin)
    return ball, _flown(ball, air, legs.duration)


def taken(ball: Ball, which: Any) -> Ball:
    """Return the balls of a mask or of indices."""
    return Ball(ball.position[which], ball.velocity[which], ball.spin[which])


def _ends(legs: Legs, air: Air, delay: float) -> Float[ndarray, "n 3"]:
    return _flown(undelayed(legs.start, air, delay), air, legs.duration).position


def _flown(ball: Ball, air: Air, durations: Float[ndarray, "n"]) -> Ball:
    states = np.concatenate([ball.position, ball.velocity, ball.spin], axis=1).astype(float)
    kernels.fly_each(states, air, np.ascontiguousarray(durations, dtype=float))
    return Ball(states[:, :3].copy(), states[:, 3:6].copy(), states[:, 6:].copy())
