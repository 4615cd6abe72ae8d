"""The flight filter on a ball whose places somebody else measured: one window, one belief.

The estimator is that of `flight_filter`; only its sights differ. A measured place z_i at the stamp
t_i is the ball's, with a covariance that has two parts, the tracker's and the clock's:

    R = s^2 I + s_t^2 v v^T         s of a coordinate, s_t of a stamp, v the window's mean velocity

A tracker also errs grossly now and then, so the noise is taken for Student's t of nu degrees: after
each fit a point that it misses by e is weighted by (nu + 3) / (nu + e^T R^-1 e), and fitted anew.
A fit takes restitution, friction and the table's height for known. Where it bounces, only the
points before are fitted, and the others taken in one by one by the filter, whose prediction over
the bounce is as unsure as these numbers are.

What is believed before the first point is little: where the ball is and how fast, nothing; how it
spins, what spins are like in matches, told by axes of the flight, along it, to its left and up
(positive about the left is topspin). Frame: z up, metres, origin at the table's centre, x along
the table.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.physics.ball import Air
from rotorpong.vision.flight_filter import (
    HUMAN_PRIOR,
    AttitudeQuality,
    Belief,
    Point,
    Prior,
    fit_window,
    ground,
    path,
    predict,
    update,
)

ANY_SPEED = 20.0  # m/s, sd of each coordinate of a velocity of which nothing is known
TABLE_HEIGHT_SD = 0.005  # m, of a measured frame
FREEDOM = 4.0  # nu
ROUNDS = 2  # of weighting
FEWEST_BEFORE = 4  # points before a bounce that are fitted alone
NO_CAMERA = AttitudeQuality(0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Expectation:
    """What is believed of air and spin before a flight is measured; a spread of 0 is certainty."""

    air: Air
    drag_sd: float = 0.0  # 1/m
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)  # rad/s: along the flight, left, up
    spin_sd: tuple[float, float, float] = (0.0, 0.0, 0.0)


GRAVITY_ONLY = Expectation(Air(drag=0.0))
DRAG_ONLY = Expectation(Air(), HUMAN_PRIOR.drag_sd)
MATCH = Expectation(
    Air(), HUMAN_PRIOR.drag_sd, spin=(0.0, 150.0, 0.0), spin_sd=(60.0, 300.0, 125.0)
)
"""Mean and standard deviation of the spin after 727 shots of real matches; the same by 10 rad/s and
a quarter after 747 bounces. No flight that `rotorpong predict` was ever tried on is among them."""


@dataclass(frozen=True, slots=True)
class PointNoise:
    """How well places and times are measured."""

    place_sd: float = 0.0015  # m, each coordinate
    stamp_sd: float = 0.0003  # s: stamps of whole milliseconds


TRACKED = PointNoise()


def prior_of(expectation: Expectation, table_height: float = 0.0) -> Prior:
    """Return the laws that the filter goes by."""
    return replace(
        HUMAN_PRIOR,
        air=expectation.air,
        drag_sd=expectation.drag_sd,
        table=(table_height, TABLE_HEIGHT_SD),
        attitude=NO_CAMERA,
    )


def belief_after(
    times: Float[ndarray, "n"],
    positions: Float[ndarray, "n 3"],
    expectation: Expectation = MATCH,
    *,
    noise: PointNoise = TRACKED,
    table_height: float = 0.0,
    rounds: int = ROUNDS,
) -> Belief:
    """Return the belief at the last point.

    To predict, carry it on with `flight_filter.predict` and `prior_of` the same expectation and
    table.

    Args:
        times: s, increasing, at least 2 that differ.
        positions: m.
        expectation: before the points.
        noise: of the points.
        table_height: m, of the playing surface.
        rounds: of weighting; 0 takes the noise for normal.
    """
    prior = prior_of(expectation, table_height)
    velocity = (positions[-1] - positions[0]) / (times[-1] - times[0])
    known = _known(expectation, prior, float(times[0]), velocity)
    spread = noise.place_sd**2 * np.eye(3) + noise.stamp_sd**2 * np.outer(velocity, velocity)
    root, weights = np.linalg.inv(spread), np.ones(len(times))
    for _ in range(rounds):
        belief, _ = fit_window(known, _points(times, positions, spread, weights), prior)
        missed = positions - path(belief, times, prior)[0]
        weights = (FREEDOM + 3.0) / (FREEDOM + np.sum(missed @ root * missed, axis=1))
    return _in_two_parts(known, _points(times, positions, spread, weights), prior)


def _in_two_parts(known: Belief, points: list[Point], prior: Prior) -> Belief:
    """Return the belief at the last point: fitted until the bounce, then filtered."""
    belief, _ = fit_window(known, points, prior)
    _, bounces = path(belief, np.array([point.time for point in points]), prior)
    before = int(np.sum(bounces == 0))
    if not FEWEST_BEFORE <= before < len(points):
        return predict(belief, points[-1].time, prior)
    belief, _ = fit_window(known, points[:before], prior)
    for point in points[before:]:
        belief, _ = update(predict(belief, point.time, prior), point)
    return belief


def _points(
    times: Float[ndarray, "n"],
    positions: Float[ndarray, "n 3"],
    spread: Float[ndarray, "3 3"],
    weights: Float[ndarray, "n"],
) -> list[Point]:
    rows = zip(times, positions, weights, strict=True)
    return [Point(float(time), place, spread / weight) for time, place, weight in rows]


def _known(
    expectation: Expectation, prior: Prior, time: float, velocity: Float[ndarray, "3"]
) -> Belief:
    """Return what is known before the points, the spin by the axes of a flight."""
    belief = ground(prior, time)
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    turn = _flight_axes(velocity)
    mean[3:6], covariance[3:6, 3:6] = 0.0, ANY_SPEED**2 * np.eye(3)
    mean[6:9] = turn @ np.array(expectation.spin)
    covariance[6:9, 6:9] = turn @ np.diag(np.square(expectation.spin_sd)) @ turn.T
    return Belief(time, mean, covariance)


def _flight_axes(velocity: Float[ndarray, "3"]) -> Float[ndarray, "3 3"]:
    """Return as columns: forward along the ground, left, up; those of the frame if it goes up."""
    along = np.hypot(velocity[0], velocity[1])
    c, s = velocity[:2] / along if along > 0.0 else (1.0, 0.0)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
