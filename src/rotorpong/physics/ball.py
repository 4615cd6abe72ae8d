"""Flight of a table tennis ball, and its bounce.

    dv/dt = g - k |v| v + m (w x v) / (1 + s S),   S = r |w x v| / |v|^2
    dw/dt = -c w

with gravity g, quadratic drag k, Magnus coefficient m of a ball that hardly spins, spin ratio S
(surface speed of the spin across the flight, over the ball's speed), lift saturation s and spin
decay c. In the usual terms the lift coefficient is proportional to S / (1 + s S): it grows with
the spin at first, and less and less. s = 0 is the linear law. At a bounce off a surface
with normal n, e its restitution and mu its friction, the ball being a thin shell:

    v_n' = -e v_n
    u    = v_t + w x (-r n)                               slip of the contact point
    j    = min(2/5 |u|, mu (1 + e) |v_n|) against u       tangential impulse over mass
    w'   = w - 3/(2r) n x j

2/5 is the impulse that stops the slip (I = 2/3 m r^2). World frame; every array may carry any
leading batch shape; one ball and many go through the same kernel. Constants: docs/validation.md.
Spin decay: between shot and bounce the spin about the vertical, which the bounce does not change,
falls at a median 0.10 /s in 360 shots of real matches; friction in a laminar boundary layer,
4 pi viscosity r^2 / (m d) with thickness d = 0.4 mm at 7 m/s, gives 0.08.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, GRAVITY, InputError, Vector3
from rotorpong.physics import _ball_kernels

STEP = 0.005  # s; position error after a whole flight < 1e-9 m
MOST = 10.0  # of drag, lift and spin decay, in their units: far beyond any ball's, and RK4 holds
MOST_SATURATION = 1000.0


class Air(NamedTuple):
    """What the air does to a ball."""

    drag: float = 0.15  # 1/m, quadratic; docs/validation.md: 0.149 in matches, 0.156 in flights
    magnus: float = 0.0085  # acceleration = magnus * spin x velocity, at small spin ratios; with
    # the saturation below, 0.0090 in matches, 0.0078 in flights
    spin_decay: float = 0.1  # 1/s, share of the spin lost; 0: spin lasts
    saturation: float = 4.6  # the lift is 1 + saturation * spin ratio times less; 0: linear in spin


class Surface(NamedTuple):
    """What a surface does to a ball that touches it."""

    restitution: float
    friction: float


TABLE_SURFACE = Surface(0.94, 0.23)
"""Restitution: 0.94 on measured flights that go both ways over a table, at 1.5 to 4.5 m/s alike; in
air, ITTF's drop (305 mm to 230-260 mm) gives 0.904-0.963. Friction: 0.225, the median of 364 balls
that slid in matches. Numbers and their commands: docs/validation.md."""
CARDBOARD = Surface(0.1, 0.3)  # the paper's racket stops the ball
RUBBER = Surface(0.8, 0.6)


@dataclass(frozen=True, slots=True)
class Ball:
    """A ball in the world frame."""

    position: Vector3
    velocity: Vector3
    spin: Vector3  # rad/s


def require_air(air: Air) -> None:
    """Raise InputError unless a ball can fly in `air`."""
    within = (
        0.0 <= air.drag <= MOST
        and -MOST <= air.magnus <= MOST
        and 0.0 <= air.spin_decay <= MOST
        and 0.0 <= air.saturation <= MOST_SATURATION
    )
    if not within:
        raise InputError(
            f"{air}: expected drag and spin_decay 0 to {MOST:g}, magnus within {MOST:g} of 0, "
            f"saturation 0 to {MOST_SATURATION:g}"
        )


def require_surface(surface: Surface, what: str = "surface") -> None:
    """Raise InputError unless a ball can bounce off `surface` without gaining energy."""
    if not (0.0 <= surface.restitution <= 1.0 and 0.0 <= surface.friction < math.inf):
        raise InputError(f"{what} {surface}: expected 0 <= restitution <= 1 and friction >= 0")


def acceleration(ball: Ball, air: Air) -> Vector3:
    """Return dv/dt in m/s^2."""
    speed = np.linalg.norm(ball.velocity, axis=-1, keepdims=True)
    across = np.cross(ball.spin, ball.velocity)
    surface = BALL_RADIUS * np.linalg.norm(across, axis=-1, keepdims=True)
    share = speed**2 / (speed**2 + air.saturation * surface + _ball_kernels.NOTHING)
    drag = -air.drag * speed * ball.velocity
    return np.array([0.0, 0.0, -GRAVITY]) + drag + air.magnus * share * across


def fly(ball: Ball, air: Air, duration: float) -> Ball:
    """Return the ball after `duration` seconds of free flight (RK4, steps of at most 5 ms).

    Raises:
        InputError: a negative or not finite duration, impossible air, a state that is not finite.
    """
    require_air(air)
    if not (np.isfinite(duration) and duration >= 0.0):
        raise InputError(f"duration {duration} s: expected a finite number >= 0")
    steps = max(1, int(np.ceil(duration / STEP)))
    states = _states(ball)
    _ball_kernels.fly(states, Air(*map(float, air)), duration / steps, steps)
    return _ball(states, ball.position.shape)


def bounce(ball: Ball, normal: Vector3, surface: Surface) -> Ball:
    """Return the ball just after it touched a resting surface.

    Args:
        ball: just before, moving into the surface.
        normal: unit normal of the surface, shape (3,), towards the ball.
        surface: restitution and friction.

    Raises:
        InputError: an impossible surface, a state that is not finite.
    """
    require_surface(surface)
    states, given = _states(ball), Surface(*map(float, surface))
    for state in states:
        _ball_kernels.bounce(state, normal, np.zeros(3), given)
    return _ball(states, ball.position.shape)


def _states(ball: Ball) -> Float[ndarray, "n 9"]:
    parts = (ball.position, ball.velocity, ball.spin)
    states = np.concatenate([np.reshape(part, (-1, 3)) for part in parts], axis=1).astype(float)
    if not np.isfinite(states).all():
        raise InputError(f"{ball}: expected finite position, velocity and spin")
    return states


def _ball(states: Float[ndarray, "n 9"], shape: tuple[int, ...]) -> Ball:
    return Ball(*(states[:, i : i + 3].reshape(shape) for i in (0, 3, 6)))
