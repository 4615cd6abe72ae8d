"""Where the ball is, how it flies and where it will be, from sights of it: an iterated EKF.

State, 16 numbers, in a frame with z up that starts where the drone started, level and with its
heading, and moves with what odometry gets wrong of the drone's velocity (which changes nothing: the
laws of flight are the same there):

    p, v, w     position, velocity, spin of the ball
    k           its drag
    b           what angular radii are seen too large by
    t           small rotation of the gyro's attitude to the true one (world axes)
    o           what readings of roll and pitch are wrong by, constant

Between sights p, v, w flow as `physics.ball` says, a bounce off the table included at its exact
instant; with F the slopes of the flow,

    x' = flow(x),   P' = F P F^T + Q

where Q holds unmodelled acceleration, the gyro's random walk, and, if it bounced, what is not known
of restitution, friction and the height of the table. A sight is z = (X/Z, Y/Z, angular radius) with
covariance R, as a camera at a known place, turned by the gyro's attitude and t, sees the ball, or
a `Point`, p itself, as somebody else's cameras measured it:

    S = H P H^T + R,  K = P H^T S^-1,  x <- x0 + K (z - h(x) - H (x0 - x))      iterated
    P <- (I - K H) P (I - K H)^T + K R K^T
    NIS = (z - h(x0))^T S^-1 (z - h(x0))          chi-square of 3 degrees if the filter is right

The same model fitted to a window of sights at once, `fit_window`, is the maximum of the posterior
(Gauss-Newton), with the gyro's walk as correlated noise of the sights; its inverse normal matrix is
the Cramer-Rao bound. The filter is begun by such a fit, and renewed by one now and then: far away a
picture tells directions a hundred times better than distances, and an EKF that was once linear
about a wrong distance stays too sure of itself. Each time it runs through all sights again, linear
about the flight that was fitted.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, GRAVITY, InputError
from rotorpong.physics.ball import TABLE_SURFACE, Air
from rotorpong.vision import _flight_filter_kernels as kernels
from rotorpong.vision import _flight_window_kernels

AIR = Air()
LONGEST_FLIGHT = 3.0  # s
FIRST_SIGHTS = 5  # that show a first velocity
FIRST_FIT = 8  # sights
RENEWALS = (2, 3, 4, 5, 7, 10, 14, 20, 28)  # sights, at which all of them are fitted at once
CERTAIN = 1e-14  # variance of what is known, in any unit
WIDE = 1.0  # m, sd of a place before anything is seen of it


@dataclass(frozen=True, slots=True)
class AttitudeQuality:
    """How well a drone knows its roll and pitch; all in rad."""

    start_sd: float  # how level it hovers at the start
    reading_sd: float  # of one reading, white
    reading_rate: float  # Hz, at which readings are new
    reading_offset_sd: float  # of all readings of a serve alike
    walk: float  # rad/sqrt(s), by which the gyro's attitude runs away
    jitter_sd: float  # white, of the gyro's attitude at a frame


ARDRONE2_ATTITUDE = AttitudeQuality(
    start_sd=math.radians(1.0),
    reading_sd=math.radians(0.05),
    reading_rate=200.0,
    reading_offset_sd=math.radians(0.2),
    walk=math.radians(0.15),
    jitter_sd=math.radians(0.005),
)
"""By its sensors' figures; the walk stands for a constant gyro error of up to 0.2 degrees/s and for
what the own path is wrong by from frame to frame: mean NIS of 40 serves each of seeds 100 and 200
is 2.9 and 3.1."""

TUM_ATTITUDE = AttitudeQuality(
    start_sd=math.radians(1.0),
    reading_sd=math.radians(2.05),
    reading_rate=100.0,
    reading_offset_sd=0.0,
    walk=math.radians(0.43),
    jitter_sd=math.radians(0.085),
)
"""Measured on hovering drones: at each change of a command the simulator's controller kicks the
body by 0.14 degrees within a millisecond, which a gyro that is read every 5 ms seldom shows."""


@dataclass(frozen=True, slots=True)
class Prior:
    """What is known of a serve and its medium before anything is seen."""

    velocity: tuple[float, float, float] = (-6.0, 0.0, 0.5)  # m/s: towards the drone
    velocity_sd: tuple[float, float, float] = (3.0, 1.5, 3.0)
    spin_sd: float = 25.0  # rad/s, each axis
    air: Air = AIR
    drag_sd: float = 0.015  # 1/m
    swelling_sd: float = 0.0  # rad of angular radius, constant
    restitution: tuple[float, float] = (TABLE_SURFACE.restitution, 0.02)  # mean, sd
    friction: tuple[float, float] = (TABLE_SURFACE.friction, 0.05)
    table: tuple[float, float] = (0.0, 0.01)  # m, height of the table in the frame: mean, sd
    unmodelled: float = 0.01  # m/s^2/sqrt(Hz), acceleration
    attitude: AttitudeQuality = ARDRONE2_ATTITUDE


HUMAN_PRIOR = Prior()


@dataclass(frozen=True, slots=True)
class Sight:
    """The ball in one picture, as an angle, and where the camera was."""

    time: float  # s
    seen: Float[ndarray, "3"]  # X/Z, Y/Z of the ball's centre, angular radius (rad)
    covariance: Float[ndarray, "3 3"]
    camera_position: Float[ndarray, "3"]  # m
    camera_from_world: Float[ndarray, "3 3"]  # by the gyro

    @property
    def pose(self) -> Float[ndarray, "12"]:
        """Place and rotation, as the kernels take them."""
        return np.concatenate([self.camera_position, self.camera_from_world.ravel()])


@dataclass(frozen=True, slots=True)
class Point:
    """The ball's place, as somebody else's cameras measured it."""

    time: float  # s
    seen: Float[ndarray, "3"]  # m
    covariance: Float[ndarray, "3 3"]

    @property
    def pose(self) -> Float[ndarray, "12"]:
        """No camera's, as the kernels take it."""
        return np.full(12, math.nan)


@dataclass(frozen=True, slots=True)
class Belief:
    """What is known of the ball at a time."""

    time: float  # s
    mean: Float[ndarray, "16"]
    covariance: Float[ndarray, "16 16"]

    @property
    def position(self) -> Float[ndarray, "3"]:
        """Of the ball, m."""
        return self.mean[:3]

    @property
    def velocity(self) -> Float[ndarray, "3"]:
        """Of the ball, m/s."""
        return self.mean[3:6]

    @property
    def spin(self) -> Float[ndarray, "3"]:
        """Of the ball, rad/s."""
        return self.mean[6:9]

    @property
    def tilt(self) -> Float[ndarray, "3"]:
        """Rotation of the gyro's attitude to the true one, rad, world axes."""
        return self.mean[kernels.TILT : kernels.LEVEL]

    @property
    def tilt_sd(self) -> Float[ndarray, "3"]:
        """Its standard deviations, rad."""
        return np.sqrt(np.diag(self.covariance)[kernels.TILT : kernels.LEVEL])


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where and when the ball will pass a plane."""

    time: float  # s
    position: Float[ndarray, "3"]  # m
    velocity: Float[ndarray, "3"]  # m/s
    covariance: Float[ndarray, "7 7"]  # of position, velocity and time


def ground(prior: Prior, time: float) -> Belief:
    """Return what is known before the ball is seen: of everything but the ball, in truth."""
    sds = [WIDE] * 3 + [*prior.velocity_sd] + [prior.spin_sd] * 3
    level = prior.attitude.start_sd
    sds += [prior.drag_sd, prior.swelling_sd, level, level, 0.0]
    sds += [prior.attitude.reading_offset_sd] * 2
    mean = np.zeros(kernels.SIZE)
    mean[3:6], mean[9] = prior.velocity, prior.air.drag
    return Belief(time, mean, np.diag(np.square(sds)))


def place(belief: Belief, sight: Sight | Point) -> Belief:
    """Return the belief with the ball put where a first sight says, as good as unknown there."""
    position, distance = _place_of(sight)
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    mean[:3] = position
    covariance[:3, :] = covariance[:, :3] = 0.0
    covariance[:3, :3] = (WIDE * max(1.0, distance)) ** 2 * np.eye(3)
    return Belief(sight.time, mean, covariance)


def _place_of(sight: Sight | Point) -> tuple[Float[ndarray, "3"], float]:
    """Return where a sight shows the ball, and how far from the camera."""
    if isinstance(sight, Point):
        return sight.seen, 0.0
    ray = np.append(sight.seen[:2], 1.0)
    distance = BALL_RADIUS / math.sin(max(float(sight.seen[2]), 1e-4))
    toward = sight.camera_from_world.T @ (ray / np.linalg.norm(ray))
    return sight.camera_position + distance * toward, distance


def predict(belief: Belief, time: float, prior: Prior, *, bounces: bool = True) -> Belief:
    """Return the belief at a later time.

    Args:
        belief: now.
        time: s, not before it.
        prior: the laws and what is not known of them.
        bounces: whether the table is there.

    Raises:
        InputError: the time lies before the belief's.
    """
    if not time >= belief.time:
        raise InputError(f"prediction to {time} s from {belief.time} s: expected a later time")
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    if time > belief.time:
        table = _table(prior, bounces=bounces)
        kernels.predict(
            mean, covariance, time - belief.time, prior.air, table[0], table[1],
            _walks(prior),
        )  # fmt: skip
    return Belief(time, mean, covariance)


def path(
    belief: Belief, times: Float[ndarray, "n"], prior: Prior
) -> tuple[Float[ndarray, "n 3"], Int[ndarray, "n"]]:
    """Return where the ball is expected at later times, m, and how often it has bounced by then.

    Args:
        belief: now.
        times: s, increasing, none before it.
        prior: the laws.
    """
    table, _ = _table(prior, bounces=True)
    inputs, work = kernels.inputs_of(belief.mean, table), np.empty((3, kernels.FLOWN))
    places, bounces = np.empty((len(times), 3)), np.zeros(len(times), dtype=int)
    for i, dt in enumerate(np.diff(times, prepend=belief.time)):
        bounces[i] = kernels.flow(inputs, dt, prior.air, work)
        inputs[: kernels.FLOWN] = work[0]
        places[i] = work[0, :3]
    return places, np.cumsum(bounces)


def update(belief: Belief, sight: Sight | Point) -> tuple[Belief, float]:
    """Return the belief with a sight of the same time taken in, and the NIS of the sight."""
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    nis = kernels.update(mean, covariance, sight.seen, sight.covariance, sight.pose)
    return Belief(belief.time, mean, covariance), nis


def begin(known: Belief, sights: Sequence[Sight | Point], prior: Prior) -> Belief:
    """Return the belief at the last of the first few sights.

    While the velocity is unknown the flow is not linear in it, so all of them are fitted at once.

    Args:
        known: of everything but the ball.
        sights: in order of time, at least one.
        prior: the laws.
    """
    return begun(known, sights, prior)[0]


def begun(
    known: Belief, sights: Sequence[Sight | Point], prior: Prior
) -> tuple[Belief, Float[ndarray, "n"]]:
    """Return what `begin` returns, and the NIS of each sight; inf if no flight explains them.

    The fit is only what the filter is linear about: it runs through all sights once more, so that
    all that is not modelled has its place, and the gyro's walk up to the last of them.
    """
    start, (fit, _) = place(known, sights[0]), fit_window(known, sights, prior)
    mean, covariance, levels = fit.mean.copy(), start.covariance.copy(), np.empty(len(sights))
    table, spreads = _table(prior, bounces=True)
    explained = _flight_window_kernels.follow(
        start.mean, _rows(sights), prior.air, table, spreads, _walks(prior), mean, covariance,
        levels,
    )  # fmt: skip
    if not explained:
        levels[:] = math.inf
    return Belief(sights[-1].time, mean, covariance), levels


def seen(belief: Belief, sight: Sight, prior: Prior) -> tuple[Belief, float]:
    """Return the belief after a later sight, and its NIS, by the history that explains it best.

    Of a flight that may have bounced since, both are tried.
    """
    told = update(predict(belief, sight.time, prior), sight)
    if not belief.velocity[2] < 0.0 < told[0].velocity[2]:
        return told
    flown_on = predict(belief, sight.time, prior, bounces=False)
    return min(told, update(flown_on, sight), key=lambda one: one[1])


def renewed(known: Belief, belief: Belief, sights: Sequence[Sight], prior: Prior) -> Belief:
    """Return the belief after `sights`, begun anew if it is time to, after `RENEWALS` of them."""
    if len(sights) not in RENEWALS:
        return belief
    fresh, levels = begun(known, sights, prior)
    return fresh if np.isfinite(levels).all() else belief


def filtered(known: Belief, sights: Sequence[Sight], prior: Prior) -> tuple[Belief, list[float]]:
    """Return the belief after all sights, and the NIS of each of them but the first.

    Args:
        known: of everything but the ball.
        sights: in order of time, at least one.
        prior: the laws.
    """
    belief, _ = update(place(known, sights[0]), sights[0])
    levels = []
    for count in range(2, len(sights) + 1):
        belief, nis = seen(belief, sights[count - 1], prior)
        levels.append(nis)
        belief = renewed(known, belief, sights[:count], prior)
    return belief, levels


def read_level(belief: Belief, reading: Float[ndarray, "2"], heading: float, sd: float) -> Belief:
    """Return the belief with a reading of roll and pitch taken in.

    Args:
        belief: of any time at which tilt and readings were the same.
        reading: roll and pitch, less those of the gyro's attitude, rad.
        heading: of the drone in the frame, rad.
        sd: of what is white in the reading, rad.
    """
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    kernels.level(mean, covariance, reading, heading, sd * sd)
    return Belief(belief.time, mean, covariance)


def crossing(
    belief: Belief, normal: Float[ndarray, "3"], offset: float, prior: Prior
) -> Crossing | None:
    """Return where the ball will pass the plane normal . p = offset; `None` if it never does."""
    out, plane = np.empty((7, 8)), np.append(normal, offset)
    table, spreads = _table(prior, bounces=True)
    time = kernels.crossing(
        belief.mean, belief.covariance, plane, LONGEST_FLIGHT, prior.air, table, spreads, out
    )
    if math.isnan(time):
        return None
    return Crossing(belief.time + time, out[:3, 0].copy(), out[3:6, 0].copy(), out[:, 1:].copy())


def fit_window(
    known: Belief, sights: Sequence[Sight | Point], prior: Prior
) -> tuple[Belief, float]:
    """Return the belief at the first sight that explains all sights best, and its cost.

    The cost is chi-square of 3 degrees a sight if the model is right; inf, and what was known, if
    no flight explains them.

    Args:
        known: of everything but the ball, at the first sight's time, without any of them.
        sights: in order of time, at least one.
        prior: the laws.
    """
    start = place(known, sights[0])
    rows = _rows(sights)
    mean, covariance = start.mean.copy(), start.covariance.copy()
    mean[3:6] = _first_velocity(known, sights)
    table, _ = _table(prior, bounces=True)
    cost = math.inf
    root = np.linalg.inv(start.covariance + CERTAIN * np.eye(kernels.SIZE))
    for count in _growing(len(sights)):
        cost = _flight_window_kernels.window(
            start.mean, root, rows[:count], prior.air, table, prior.attitude.walk, mean, covariance
        )
    return Belief(sights[0].time, mean, covariance), cost


def _growing(count: int) -> list[int]:
    """Return how many sights are fitted in turn: beyond a bounce a first guess leads astray."""
    sizes = [count]
    while sizes[0] > FIRST_FIT:
        sizes.insert(0, (sizes[0] + 1) // 2)
    return sizes


def _first_velocity(known: Belief, sights: Sequence[Sight | Point]) -> Float[ndarray, "3"]:
    """Return the velocity that the first sights show, bare of any filter."""
    first = sights[:FIRST_SIGHTS]
    if len(first) < 2:
        return known.velocity
    times = np.array([sight.time for sight in first]) - first[0].time
    places = np.stack([place(known, sight).position for sight in first])
    places[:, 2] += 0.5 * GRAVITY * times**2
    design = np.stack([np.ones_like(times), times], axis=1)
    return np.linalg.lstsq(design, places, rcond=None)[0][1]


def _walks(prior: Prior) -> Float[ndarray, "2"]:
    return np.array([prior.unmodelled, prior.attitude.walk])


def _rows(sights: Sequence[Sight | Point]) -> Float[ndarray, "n 25"]:
    """Return sights as the kernels take them."""
    return np.stack([_row(sight, sights[0].time) for sight in sights])


def _row(sight: Sight | Point, start: float) -> Float[ndarray, "25"]:
    spread = sight.covariance.ravel()
    return np.concatenate([[sight.time - start], sight.seen, spread, sight.pose])


def _table(prior: Prior, *, bounces: bool) -> tuple[Float[ndarray, "3"], Float[ndarray, "3"]]:
    """Return restitution, friction and height of the table, and their standard deviations."""
    pairs = np.array([prior.restitution, prior.friction, prior.table])
    means, sds = pairs[:, 0].copy(), pairs[:, 1].copy()
    if not bounces:
        means[2] = -1e3
    return means, sds
