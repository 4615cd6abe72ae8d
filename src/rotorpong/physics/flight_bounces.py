"""What a bounce did to a ball, from measured states: restitution, friction, grip, spin.

With normal z, v before and v' after, the impulse over mass is J = v' - v, its normal part
J_z = v_z' - v_z, its tangential part J_t. The contact point slips with

    u = v_t + w x (-r z)

and the law of `ball` says: J_z = -(1 + e) v_z, J_t = -min(2/5, mu J_z / |u|) u, and
w' - w = -3/(2r) z x J. Each of its numbers is measured by itself:

    restitution = -v_z' / v_z
    removed     = -J_t . u / |u|^2           2/5 where the ball grips
    friction    = -J_t . u / (|u| J_z)       mu where it slides
    coupling    = (w' - w) . p / |p|^2       1 for a thin shell, p = -3/(2r) z x J

World frame; n bounces at once, off a table at rest.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS
from rotorpong.physics.ball import Air, Ball, acceleration
from rotorpong.physics.flight_fit import FlightFit, Table, follow

GRIP = 0.4  # of the slip, that a gripping thin shell loses
SLIDING, GRIPPING = 1.5, 0.8  # slip over the largest that still grips: clearly one, or the other
FIRST_FRICTION = 0.25
ROUNDS = 20
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Bounces:
    """Balls just before and just after they touched a table, arrays of shape (n, 3)."""

    before: Ball
    after: Ball

    @property
    def impulse(self) -> Float[ndarray, "n 3"]:
        """Change of velocity, m/s."""
        return self.after.velocity - self.before.velocity

    @property
    def restitution(self) -> Float[ndarray, "n"]:
        """Normal speed after over normal speed before."""
        return -self.after.velocity[:, 2] / self.before.velocity[:, 2]

    @property
    def slip(self) -> Float[ndarray, "n 3"]:
        """Velocity of the contact point over the table before the bounce, m/s."""
        return slip_of(self.before)

    @property
    def removed(self) -> Float[ndarray, "n"]:
        """Share of the slip that the bounce took away from the ball's velocity."""
        return -_dot(self.impulse, self.slip) / _dot(self.slip, self.slip)

    @property
    def friction(self) -> Float[ndarray, "n"]:
        """Tangential impulse against the slip over normal impulse."""
        return self.removed * np.linalg.norm(self.slip, axis=1) / self.impulse[:, 2]

    @property
    def predicted_spin_change(self) -> Float[ndarray, "n 3"]:
        """Change of spin that the measured impulse gives a thin shell, rad/s."""
        return -1.5 / BALL_RADIUS * np.cross(UP, self.impulse)

    @property
    def coupling(self) -> Float[ndarray, "n"]:
        """Change of spin over the predicted one, along it."""
        predicted = self.predicted_spin_change
        return _dot(self.after.spin - self.before.spin, predicted) / _dot(predicted, predicted)

    def slip_over_grip(self, friction: float) -> Float[ndarray, "n"]:
        """Return the slip over the largest that a surface of this friction stops."""
        return GRIP * np.linalg.norm(self.slip, axis=1) / (friction * self.impulse[:, 2])


def slip_of(ball: Ball) -> Float[ndarray, "n 3"]:
    """Return the velocity of a ball's lowest point along a table, m/s."""
    point = ball.velocity + np.cross(ball.spin, -BALL_RADIUS * UP)
    return point * [1.0, 1.0, 0.0]


def sliding_friction(bounces: Bounces) -> tuple[float, Bool[ndarray, "n"]]:
    """Return the friction of the balls that clearly slide, the median, and which these are.

    Which slide depends on the friction: a fixed point, NaN if no ball slides.
    """
    friction = FIRST_FRICTION
    sliding = bounces.slip_over_grip(friction) > SLIDING
    for _ in range(ROUNDS):
        if not sliding.any():
            return np.nan, sliding
        friction = float(np.median(bounces.friction[sliding]))
        sliding = bounces.slip_over_grip(friction) > SLIDING
    return friction, sliding


def bounce_between(before: FlightFit, after: FlightFit, elapsed: float) -> Bounces:
    """Return the bounce that joins two fitted flights, where their heights meet.

    Gravity cancels in the difference of heights, so it is a straight line to within the difference
    of drag and lift over half the time between two points.

    Args:
        before: until the bounce.
        after: from the bounce on.
        elapsed: s from the first point of the one to the first point of the other.
    """
    down = follow(before.ball, np.array([0.0, elapsed]), before.air, Table(), most=0)
    down = Ball(down.position[1], down.velocity[1], down.spin[1])
    closing = after.ball.velocity[2] - down.velocity[2]
    time = (down.position[2] - after.ball.position[2]) / closing
    return Bounces(_moved(down, before.air, time), _moved(after.ball, after.air, time))


def _moved(ball: Ball, air: Air, time: float) -> Ball:
    """Return one ball, as a batch, a few milliseconds away."""
    pull = acceleration(ball, air)
    position = ball.position + time * ball.velocity + 0.5 * time**2 * pull
    return Ball(position[None], (ball.velocity + time * pull)[None], ball.spin[None])


def _dot(a: Float[ndarray, "n 3"], b: Float[ndarray, "n 3"]) -> Float[ndarray, "n"]:
    return np.sum(a * b, axis=1)
