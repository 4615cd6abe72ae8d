"""Rows about the ball alone: how fast it is flown, and how exactly it flies and bounces.

The oracles are closed forms and limit cases: the energy that Magnus leaves alone and drag takes,
the instant and the speed of a fall in vacuum, the drop test of the ITTF.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, fly
from rotorpong.world.contact import TICK, Solids, fly_over_court, land
from rotorpong.world.serves import HUMAN, draw

FLIGHT = 0.7  # s, what a serve flies after the 2.5 m plane
FINE_STEPS = 7000  # of 0.1 ms: one RK4 step each
ITTF_DROP = 0.305  # m, from which a ball
ITTF_REBOUND = (0.230, 0.260)  # m, has to come back so high
VACUUM = Air()._replace(drag=0.0, magnus=0.0)


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure and return the rows."""
    count = 100 if quick else 1000
    return (
        *_speed(count, quick=quick),
        Row("ball position error after 0.7 s", _position_error(), "m", 1e-6, "less"),
        *_energy(count),
        *_contact_errors(count),
        *_ittf_drop(),
    )


def some_balls(count: int) -> Ball:
    """Return balls as served, with spins up to professional ones."""
    rng = np.random.default_rng(0)
    parts = (((0.0, 0.0, 1.0), 0.3), ((-7.0, 0.0, 1.5), 1.5), ((0.0, 0.0, 0.0), 60.0))
    return Ball(*(rng.normal(mean, sd, (count, 3)) for mean, sd in parts))


def _speed(count: int, *, quick: bool) -> tuple[Row, ...]:
    balls, rng = some_balls(count), np.random.default_rng(0)
    flights = count / cpu_seconds(lambda: fly(balls, Air(), FLIGHT), quick=quick)
    draws = cpu_seconds(lambda: [draw(HUMAN, rng) for _ in range(20)], quick=quick)
    return (
        Row("ball flights of 0.7 s", flights, "flights/s", 100_000.0),
        Row("human serves drawn", 20 / draws, "serves/s"),
    )


def _position_error() -> float:
    """Return the largest distance from the same flight in steps of 0.1 ms, m."""
    balls = some_balls(50)
    fine = balls
    for _ in range(FINE_STEPS):
        fine = fly(fine, Air(), FLIGHT / FINE_STEPS)
    apart = fly(balls, Air(), FLIGHT).position - fine.position
    return float(np.linalg.norm(apart, axis=1).max())


def _energy(count: int) -> tuple[Row, ...]:
    balls = some_balls(count)
    lifted = fly(balls, VACUUM._replace(magnus=Air().magnus), FLIGHT)
    dragged = fly(balls, Air(), FLIGHT)
    drift = np.abs(_mechanical(lifted) / _mechanical(balls) - 1.0).max()
    gain = (_mechanical(dragged) - _mechanical(balls)).max()
    return (
        Row("energy drift of a flight with lift only, relative", float(drift), "1", 1e-9, "less"),
        Row("largest energy gain of a flight with drag", float(gain), "J/kg", 0.0, "less"),
    )


def _mechanical(balls: Ball) -> np.ndarray:
    """Return kinetic and potential energy over mass, J/kg."""
    return 0.5 * np.sum(balls.velocity**2, axis=1) + GRAVITY * balls.position[:, 2]


def _contact_errors(count: int) -> tuple[Row, ...]:
    """Drop balls in vacuum from heights that put the contact at every phase of a tick."""
    solids, errors = Solids(air=VACUUM), []
    for height in np.random.default_rng(0).uniform(0.1, 1.0, count):
        state = np.array([-0.7, 0.2, height + BALL_RADIUS, 1.0, -0.5, 0.0, 20.0, -30.0, 10.0])
        fall, speed = math.sqrt(2 * height / GRAVITY), math.sqrt(2 * height * GRAVITY)
        contact = land(state, solids, longest=fall + 2 * TICK)[0]
        after = fly_over_court(state, math.ceil(fall / TICK) + 1, solids)[-1, 5]
        elapsed = (math.ceil(fall / TICK) + 1) * TICK - contact.time
        restitution = (after + GRAVITY * elapsed) / speed
        errors.append((contact.time - fall, restitution - TABLE_SURFACE.restitution))
    time, restitution = np.abs(errors).max(axis=0)
    return (
        Row("contact time error, any phase", float(time), "s", 1e-9, "less"),
        Row("restitution error, any phase", float(restitution), "1", 1e-6, "less"),
    )


def _ittf_drop() -> tuple[Row, ...]:
    """Drop the default ball on the default table in the default air."""
    state = np.array([-0.7, 0.2, ITTF_DROP + BALL_RADIUS, *np.zeros(6)])
    path = fly_over_court(state, 600, Solids())
    first = int(np.argmin(path[:300, 2]))
    rebound = float(path[first:, 2].max()) - BALL_RADIUS
    outside = max(ITTF_REBOUND[0] - rebound, rebound - ITTF_REBOUND[1], 0.0)
    return (
        Row("rebound of the ITTF drop from 305 mm", 1000 * rebound, "mm"),
        Row("ITTF rebound outside 230 to 260 mm", 1000 * outside, "mm", 0.0, "less"),
    )
