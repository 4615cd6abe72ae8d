"""Figures and numbers of the lesson: `python docs/lessons/metres_to_prediction.py`.

Writes six PNGs to `docs/images/lessons/` and prints every number that the page quotes.
"""

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, STYLE, drawn
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.ticker import FixedLocator, NullLocator
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from rotorpong.conventions import (
    BALL_DIAMETER,
    BALL_RADIUS,
    CAMERA_FROM_BODY_AXES,
    GRAVITY,
    TABLE_HALF_LENGTH,
)
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, Surface, bounce, fly
from rotorpong.physics.camera import GAZEBO
from rotorpong.vision.flight_filter import (
    HUMAN_PRIOR,
    TUM_ATTITUDE,
    Belief,
    Crossing,
    Prior,
    Sight,
    begin,
    crossing,
    ground,
    place,
    predict,
    read_level,
    update,
)
from rotorpong.vision.sphere import disc_of_sphere, sphere_of_disc

RED = "#d55e00"
EYE = np.array(
    [-1.69, 0.0, 0.20]
)  # m, world: the camera of a drone at home, as in the lesson before
FOCAL = float(GAZEBO.focal_length_px[0])
SDS_PX = np.array([0.1, 0.1, 0.05])  # of a sight: centre x and y, radius; a diameter errs by 0.1 px
SDS = SDS_PX / FOCAL
SPREAD = np.diag(SDS**2)
DT = 1.0 / 30.0  # s between frames
FRAMES = 13  # the last one 0.4 s after the throw, before it bounces
TIMES = DT * np.arange(FRAMES)
END = float(TIMES[-1])
FIRST = 5  # sights that begin a filter, fitted at once
RENEWALS = (7, 10)  # sights after which a filter is begun anew
BLADE = np.array([1.0, 0.0, 0.0]), -1.65  # the plane x = -1.65 m
THROWN = Ball(np.array([2.0, 0.0, 0.25]), np.array([-7.0, 0.0, 2.2]), np.zeros(3))
SPIN_SD = 10.0  # rad/s, each axis
UP = np.array([0.0, 0.0, 1.0])
LEVEL = replace(HUMAN_PRIOR.attitude, start_sd=1e-7, reading_offset_sd=0.0, walk=1e-9)
KNOWN = replace(
    HUMAN_PRIOR, spin_sd=SPIN_SD, drag_sd=1e-6, unmodelled=1e-4, swelling_sd=0.0, attitude=LEVEL
)
"""Attitude and air are known; ball, spin and table are not."""
SERVES = 200
SLACK = 0.3  # m/s^2/sqrt(Hz), of a filter that is told of accelerations that are not there
ROUGH = 3.0  # m/s^2/sqrt(Hz), of the filter of metres, which knows no drag
TILT = math.radians(1.0)  # rad, of a drone that does not hover level
WALK = TUM_ATTITUDE.walk  # rad/sqrt(s)
READING_SD = math.radians(0.2)  # rad, of one reading of the level
ABOVE_GRID = STYLE | {"axes.axisbelow": True}


@dataclass(frozen=True, slots=True)
class Trial:
    """What an estimator said of a serve at its last sight, and what it was wrong by."""

    error: np.ndarray  # (6,) of position and velocity
    nees: float
    nis: float  # mean of the sights after the first fit; nan if there are none


Track = tuple[list[Belief], list[float]]
Estimator = Callable[[Belief, Sequence[Sight], Prior], Track]


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (
        speed_errors, fall_ruler, consistency, through_bounce, window_or_filter, forecast,
    ):  # fmt: skip
        print(f"  {drawn(draw, IMAGES, ABOVE_GRID)}")


def plain(axis: Axis, ticks: Sequence[float]) -> None:
    """Label a logarithmic axis by these numbers, as they are."""
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())


def serve(rng: np.random.Generator) -> Ball:
    """Return a throw like that of the lesson, and spin."""
    position = THROWN.position + [0.0, 0.1, 0.02] * rng.standard_normal(3)
    velocity = THROWN.velocity + [0.3, 0.1, 0.1] * rng.standard_normal(3)
    return Ball(position, velocity, SPIN_SD * rng.standard_normal(3))


def look(positions: np.ndarray, tilts: np.ndarray) -> np.ndarray:
    """Return exact sights (n, 3) by a camera turned by `tilts`, which its gyro does not show."""
    seen = Rotation.from_rotvec(-tilts).apply(positions - EYE) @ CAMERA_FROM_BODY_AXES.T
    radius = np.arcsin(BALL_RADIUS / np.linalg.norm(seen, axis=1))
    return np.column_stack([seen[:, :2] / seen[:, 2:], radius])


def flown(balls: Ball) -> np.ndarray:
    """Return places and velocities at the times of the sights, (*batch, FRAMES, 6)."""
    ends = [fly(balls, Air(), t) for t in TIMES]
    return np.stack([np.concatenate([e.position, e.velocity], axis=-1) for e in ends], axis=-2)


@functools.cache
def all_flown() -> np.ndarray:
    """Return `flown` of all serves: serve k is drawn first from the generator with seed k."""
    balls = [serve(np.random.default_rng(seed)) for seed in range(SERVES)]
    parts = ([getattr(ball, name) for ball in balls] for name in ("position", "velocity", "spin"))
    return flown(Ball(*(np.array(part) for part in parts)))


def one_flown(seed: int) -> tuple[np.ndarray, np.random.Generator]:
    """Return the path of a serve, and the generator from which it was drawn."""
    rng = np.random.default_rng(seed)
    serve(rng)
    return all_flown()[seed], rng


def watch(
    path: np.ndarray, noise: np.ndarray, tilts: np.ndarray, covariance: np.ndarray = SPREAD
) -> list[Sight]:
    """Return the sights of a serve until just before its bounce.

    Args:
        path: as `flown` returns it, (FRAMES, 6).
        noise: of the sights, (FRAMES, 3), rad.
        tilts: as `trials` takes them.
        covariance: of the noise, as told.
    """
    rotation = np.array(CAMERA_FROM_BODY_AXES)
    return [
        Sight(t, seen, covariance, EYE, rotation)
        for t, seen in zip(TIMES.tolist(), look(path[:, :3], tilts) + noise, strict=True)
    ]


def watched(path: np.ndarray, rng: np.random.Generator) -> list[Sight]:
    """Return noisy sights by a level camera."""
    return watch(path, SDS * rng.standard_normal((FRAMES, 3)), np.zeros((FRAMES, 3)))


def filtered(known: Belief, sights: Sequence[Sight], prior: Prior) -> Track:
    """Return the beliefs after the first fit and after each later sight, and their NIS."""
    return _followed(known, sights, prior, ())


def renewed(known: Belief, sights: Sequence[Sight], prior: Prior) -> Track:
    """Return what `filtered` does; now and then all sights so far are fitted at once."""
    return _followed(known, sights, prior, RENEWALS)


def window(known: Belief, sights: Sequence[Sight], prior: Prior) -> Track:
    """Return the belief that fits all sights at once."""
    return [begin(known, sights, prior)], []


def _followed(
    known: Belief, sights: Sequence[Sight], prior: Prior, renewals: tuple[int, ...]
) -> Track:
    beliefs, levels = [begin(known, sights[:FIRST], prior)], []
    for k, sight in enumerate(sights[FIRST:], start=FIRST + 1):
        belief, nis = update(predict(beliefs[-1], sight.time, prior), sight)
        beliefs.append(begin(known, sights[:k], prior) if k in renewals else belief)
        levels.append(nis)
    return beliefs, levels


def kalman(points: np.ndarray, spreads: np.ndarray, rough: float) -> np.ndarray:
    """Return position and velocity after each point, by the linear filter of metres."""
    fall, x = np.array([0.0, 0.0, -GRAVITY]), np.append(points[0], [-6.0, 0.0, 0.5])
    P = np.diag([*np.diag(spreads[0]), 9.0, 2.0, 9.0])
    F, out = np.eye(6), [x]
    F[:3, 3:] = DT * np.eye(3)
    Q = rough**2 * np.kron([[DT**3 / 3, DT**2 / 2], [DT**2 / 2, DT]], np.eye(3))
    for z, R in zip(points[1:], spreads[1:], strict=True):
        x = F @ x + np.concatenate([fall * DT**2 / 2, fall * DT])
        P = F @ P @ F.T + Q
        K = P[:, :3] @ np.linalg.inv(P[:3, :3] + R)
        x = x + K @ (z - x[:3])
        P = P - K @ P[:3]
        out.append(x)
    return np.array(out)


def metres(sights: Sequence[Sight]) -> tuple[np.ndarray, np.ndarray]:
    """Return where the ball seems by each sight, and the covariance of that."""
    known = ground(KNOWN, 0.0)
    points = np.array([place(known, sight).position for sight in sights])
    deep = points[:, 0] - EYE[0]
    sds = np.stack([deep**2 / (FOCAL * BALL_RADIUS) * SDS_PX[2], *[deep * SDS[0]] * 2], axis=1)
    return points, np.square(sds)[:, :, None] * np.eye(3)


def bound(count: int, prior: Prior = KNOWN, sds: np.ndarray = SDS) -> np.ndarray:
    """Return the Cramer-Rao bound of the lesson's throw after `count` sights: a covariance (6, 6).

    The information is taken at the truth: the sights are without noise, and told to have it.
    """
    nothing = np.zeros((FRAMES, 3))
    sights = watch(flown(THROWN), nothing, nothing, np.diag(sds**2))[:count]
    return begin(ground(prior, 0.0), sights, prior).covariance[:6, :6]


def speed_errors(figure: Figure) -> None:
    """Speed towards the camera: one serve, and rms errors of many, by distance."""
    one, many = figure.subplots(1, 2, width_ratios=[1.1, 1])
    errors, shown = _speeds(range(SERVES))
    names = ("finite differences", "Kalman filter of metres", "flight filter")
    starts, colours = (1, 1, FIRST - 1), (GREY, ORANGE, BLUE)
    for name, start, colour, mark in zip(names, starts, colours, ("o", "s", "^"), strict=True):
        one.plot(TIMES[start:], shown[name][start:], mark + "-", color=colour, markersize=3, lw=1)
        rms = np.sqrt(np.mean(np.square(errors[name]), axis=0))
        many.semilogy(
            _depths()[start:], rms[start:], mark + "-", color=colour, markersize=3, label=name
        )
        for k in (5, FRAMES - 1):
            away = f"{k + 1} sights, {_depths()[k]:.2f} m away"
            print(f"vx after {away}, {name}: {100 * rms[k]:.1f} cm/s")
    one.plot(TIMES, shown["truth"], color="black", lw=1.5, label="truth")
    one.set(xlabel="time, s", ylabel="speed towards us, m/s", ylim=(2.5, 9.5))
    one.legend(fontsize=8)
    counts = range(FIRST, FRAMES + 1)
    limits = [math.sqrt(bound(n)[3, 3]) for n in counts]
    many.semilogy(
        _depths()[FIRST - 1 :], limits, "--", color="black", label="Cramér-Rao bound", lw=1
    )
    many.invert_xaxis()
    many.set(
        xlabel="distance, m: the ball flies to the right", ylabel="rms error of the speed, m/s"
    )
    plain(many.yaxis, (0.05, 0.1, 0.2, 0.5, 1, 2, 5))
    many.legend(fontsize=8, loc="lower left")
    far = 2.5**2 / (FOCAL * BALL_DIAMETER) * 0.1
    print(f"two frames at 2.5 m: {math.sqrt(2.0) * far / DT:.2f} m/s")


def _depths() -> np.ndarray:
    """Return how far the lesson's throw is at each sight, m."""
    return flown(THROWN)[:, 0] - EYE[0]


def _speeds(seeds: Sequence[int]) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return errors of vx of all serves by estimator and sight, and the first serve's speeds."""
    errors: dict[str, list[np.ndarray]] = {}
    shown: dict[str, np.ndarray] = {}
    for seed in seeds:
        path, rng = one_flown(seed)
        true, sights = path[:, 3], watched(path, rng)
        points, spreads = metres(sights)
        found = {
            "finite differences": np.append(np.nan, np.diff(points[:, 0]) / DT),
            "Kalman filter of metres": kalman(points, spreads, ROUGH)[:, 3],
            "flight filter": np.append(
                [np.nan] * (FIRST - 1),
                [b.velocity[0] for b in filtered(ground(KNOWN, 0.0), sights, KNOWN)[0]],
            ),
        }
        shown = shown or {"truth": -true, **{name: -v for name, v in found.items()}}
        for name, v in found.items():
            errors.setdefault(name, []).append(v - true)
    return {name: np.array(rows) for name, rows in errors.items()}, shown


def fall_ruler(figure: Figure) -> None:
    """Noise of points, which are rods towards the camera; what the disc and what the fall tell."""
    court, graph = figure.subplots(1, 2, width_ratios=[1.25, 1])
    path = np.array([fly(THROWN, Air(), t).position for t in np.linspace(0.0, 0.52, 60)])
    court.plot(path[:, 0], path[:, 2], color=GREY, lw=1)
    for k in range(FRAMES):
        ball = fly(THROWN, Air(), k * DT)
        spread = _spread_of(ball.position)
        values, vectors = np.linalg.eigh(spread[::2, ::2])
        rod = 2.0 * math.sqrt(values[1]) * vectors[:, 1]
        court.plot(
            *np.stack([ball.position[::2] - rod, ball.position[::2] + rod]).T, color=ORANGE, lw=2
        )
        court.plot(*np.stack([EYE[::2], ball.position[::2]]).T, color=PINK, lw=0.3, zorder=0)
    court.plot(*EYE[::2], "s", color="black")
    court.annotate("camera", EYE[::2], (-1.7, 0.27), ha="center")
    court.plot([-TABLE_HALF_LENGTH, TABLE_HALF_LENGTH], [0, 0], color="black", lw=2)
    court.set(xlabel="x, m", ylabel="z, m", xlim=(-2.1, 2.3), ylim=(-0.1, 0.7))
    court.set_title("places by single sights: 2 sd, to scale", fontsize=9)
    counts = range(3, FRAMES + 1)
    for name, sds, colour, mark in RULERS:
        values = [100 * sds(n) for n in counts]
        graph.semilogy(counts, values, mark + "-", color=colour, markersize=3, label=name)
        for n in (5, 8, 13):
            print(f"depth after {n} sights, {name}: {100 * sds(n):.2f} cm")
    graph.set(xlabel="sights so far", ylabel="sd of the depth, cm", ylim=(0.08, 600))
    plain(graph.yaxis, (0.1, 1, 10, 100))
    graph.legend(fontsize=8, loc="lower left")
    _print_point(np.array([0.81, 0.0, 0.45]))


def _spread_of(position: np.ndarray) -> np.ndarray:
    """Return the covariance, in world axes, of where one sight says a ball is."""
    disc = disc_of_sphere(GAZEBO, CAMERA_FROM_BODY_AXES @ (position - EYE))
    there = sphere_of_disc(GAZEBO, disc, np.diag(SDS_PX**2))
    return CAMERA_FROM_BODY_AXES.T @ there.covariance @ CAMERA_FROM_BODY_AXES


def _print_point(position: np.ndarray) -> None:
    sds = np.sqrt(np.linalg.eigvalsh(_spread_of(position)))
    print(f"a point 2.5 m away: {1000 * sds[2]:.1f} mm deep, {1000 * sds[0]:.2f} mm across")


def by_disc(count: int) -> float:
    """Return the sd of the last depth by a line through the depths of all sights, m."""
    deep, times = _depths()[:count], DT * np.arange(count)
    sds = deep**2 / (FOCAL * BALL_RADIUS) * SDS_PX[2]
    design = np.stack([np.ones(count), times - times[-1]], axis=1) / sds[:, None]
    return math.sqrt(np.linalg.inv(design.T @ design)[0, 0])


def by_fall(count: int) -> float:
    """Return the sd of the last depth by directions alone: the disc tells nothing, m."""
    return math.sqrt(bound(count, _open(), SDS * [1.0, 1.0, 1e4])[0, 0])


def by_both(count: int) -> float:
    """Return the sd of the last depth by directions and disc, m."""
    return math.sqrt(bound(count, _open())[0, 0])


def _open() -> Prior:
    """Return a prior that knows nothing of the velocity, and that there is no spin."""
    return replace(KNOWN, velocity_sd=(30.0, 30.0, 30.0), spin_sd=1e-6)


RULERS = (
    ("the disc, a line through its depths", by_disc, ORANGE, "s"),
    ("the fall, directions alone", by_fall, GREEN, "o"),
    ("both: the flight filter", by_both, BLUE, "^"),
)


def upright(rng: np.random.Generator) -> np.ndarray:
    """Return no tilt."""
    del rng
    return np.zeros((FRAMES, 3))


def leaning(rng: np.random.Generator) -> np.ndarray:
    """Return a constant tilt about x and y."""
    return np.tile(TILT * np.append(rng.standard_normal(2), 0.0), (FRAMES, 1))


def walking(rng: np.random.Generator) -> np.ndarray:
    """Return a tilt that walks at random about all axes, from none."""
    steps = WALK * math.sqrt(DT) * rng.standard_normal((FRAMES, 3))
    steps[0] = 0.0
    return np.cumsum(steps, axis=0)


def trials(
    name: str,
    estimator: Estimator,
    prior: Prior,
    tilts: Callable[[np.random.Generator], np.ndarray] = upright,
    *,
    sds_told: np.ndarray = SDS,
    reading_sd: float | None = None,
) -> list[Trial]:
    """Return what became of all serves, and print their means.

    Args:
        name: to print.
        estimator: of the ball.
        prior: what it is told.
        tilts: draws the true attitude's rotations from the gyro's, (FRAMES, 3), rad.
        sds_told: noise of a sight that it is told.
        reading_sd: rad, of one reading of roll and pitch at the start; None: there is none.
    """
    done = []
    for seed in range(SERVES):
        path, rng = one_flown(seed)
        known, noise = ground(prior, 0.0), rng.standard_normal((FRAMES, 3))
        turned = tilts(rng)
        sights = watch(path, SDS * noise, turned, np.diag(sds_told**2))
        if reading_sd is not None:
            reading = turned[0, :2] + reading_sd * rng.standard_normal(2)
            known = read_level(known, reading, 0.0, reading_sd)
        beliefs, levels = estimator(known, sights, prior)
        error = beliefs[-1].mean[:6] - path[-1]
        nees = float(error @ np.linalg.solve(beliefs[-1].covariance[:6, :6], error))
        done.append(Trial(error, nees, float(np.mean(levels)) if levels else math.nan))
    _print_means(name, done)
    return done


def _print_means(name: str, done: list[Trial]) -> None:
    rms = np.sqrt(np.mean([trial.error**2 for trial in done], axis=0))
    nis, nees = np.mean([t.nis for t in done]), np.mean([t.nees for t in done])
    print(
        f"{name}: NIS {nis:.1f}, NEES {nees:.1f}, x {100 * rms[0]:.2f} cm, "
        f"z {100 * rms[2]:.2f} cm, vx {100 * rms[3]:.1f} cm/s, vz {100 * rms[5]:.1f} cm/s"
    )


def knowing(*, start: float = 1e-7, walk: float = 1e-9, unmodelled: float = 1e-4) -> Prior:
    """Return the prior of a drone that knows how badly it knows its attitude."""
    attitude = replace(LEVEL, start_sd=start, walk=walk)
    return replace(KNOWN, attitude=attitude, unmodelled=unmodelled)


def consistency(figure: Figure) -> None:
    """NIS against NEES, serve by serve: what a filter can see of its own errors."""
    share, graph = figure.subplots(1, 2, width_ratios=[1, 1.25])
    tilted, count = knowing(start=TILT), FRAMES - FIRST
    cases = (
        (trials("told the truth", filtered, KNOWN), BLUE, "told the truth"),
        (
            trials("half the noise", filtered, KNOWN, sds_told=SDS / 2),
            ORANGE,
            "told half the noise",
        ),
        (trials("tilt untold", filtered, KNOWN, leaning), RED, "1° of tilt, untold"),
        (trials("tilt told", filtered, tilted, leaning), GREEN, "1° of tilt, told"),
    )
    trials("tilt told, renewed", renewed, tilted, leaning)
    trials("tilt told, window", window, tilted, leaning)
    trials("tilt told, level read", renewed, tilted, leaning, reading_sd=READING_SD)
    low, high = chi2.ppf([0.025, 0.975], 3 * count) / count
    print(f"95 % band of the mean NIS of {count} sights: {low:.2f} to {high:.2f}")
    for done, colour, name in cases:
        nis, nees = np.array([trial.nis for trial in done]), [trial.nees for trial in done]
        graph.loglog(nis, nees, "o", color=colour, markersize=2.5, alpha=0.6, label=name)
        inside = np.mean((nis > low) & (nis < high))
        print(f"mean NIS in its band, {name}: {100 * inside:.0f} % of serves")
    graph.axvspan(low, high, color="#e8e8e8", zorder=0)
    graph.axhspan(*chi2.ppf([0.025, 0.975], 6), color="#e8e8e8", zorder=0)
    graph.set(xlabel="mean NIS of a serve", ylabel="NEES of its last belief")
    plain(graph.xaxis, (1, 2, 3, 5, 10, 20))
    figure.legend(
        *graph.get_legend_handles_labels(), loc="outside upper center", ncols=4, markerscale=2
    )
    _levels(share, cases, count)


def _levels(axes: Axes, cases: Sequence[tuple[list[Trial], str, str]], count: int) -> None:
    """Draw the share of serves below each mean NIS, against chi-square."""
    grid = np.geomspace(0.8, 25.0, 200)
    for done, colour, _ in cases:
        levels = np.sort([trial.nis for trial in done])
        axes.step(levels, np.arange(1, len(levels) + 1) / len(levels), color=colour)
    axes.semilogx(grid, chi2.cdf(grid * count, 3 * count), color="black", lw=1, label="chi-square")
    axes.set(xlabel="mean NIS of a serve", ylabel="share of serves below")
    plain(axes.xaxis, (1, 2, 3, 5, 10, 20))
    axes.legend(fontsize=8, loc="lower right")


def at_blade(ball: Ball, surface: Surface, height: float) -> tuple[float, np.ndarray]:
    """Return when, from now, and where a ball passes the blade plane after one bounce."""
    normal, offset = BLADE

    def low(time: float) -> float:
        return float(fly(ball, Air(), time).position[2]) - height - BALL_RADIUS

    landing = float(brentq(low, 0.0, 1.0))  # pyright: ignore[reportArgumentType]
    up = bounce(fly(ball, Air(), landing), UP, surface)

    def beyond(time: float) -> float:
        return float(fly(up, Air(), time).position @ normal) - offset

    rest = float(brentq(beyond, 0.0, 1.0))  # pyright: ignore[reportArgumentType]
    return landing + rest, fly(up, Air(), rest).position


def the_belief() -> Belief:
    """Return what the filter believes after all sights of the lesson's throw."""
    sights = watched(flown(THROWN), np.random.default_rng(1))
    return filtered(ground(KNOWN, 0.0), sights, KNOWN)[0][-1]


def certain(prior: Prior, keep: str = "") -> Prior:
    """Return the prior with all of the table known, but for one number."""
    known = {
        name: (getattr(prior, name)[0], 1e-9)
        for name in ("restitution", "friction", "table")
        if name != keep
    }
    return replace(prior, **known)


def through_bounce(figure: Figure) -> None:
    """How far off the ball may be, before and after its bounce, and what the bounce adds."""
    path, parts = figure.subplots(1, 2, width_ratios=[1, 1.15])
    start = the_belief()
    times = np.linspace(END, 0.76, 100)
    ahead = [predict(start, t, KNOWN) for t in times]
    height, sd = (np.array(v) for v in zip(*[_height(b) for b in ahead], strict=True))
    path.fill_between(times, height - 2 * sd, height + 2 * sd, color=BLUE, alpha=0.3, lw=0)
    path.plot(times, height, color=BLUE)
    path.axhline(BALL_RADIUS, color="black", lw=1)
    path.set(xlabel="time, s", ylabel="height of the ball, m: mean and 2 sd")
    flown = np.array([_height(predict(start, t, certain(KNOWN)))[1] for t in times])
    parts.plot(times, 100 * sd, color="black", lw=1.5, label="all")
    parts.plot(times, 100 * flown, color=GREY, label="sights: place, speed, spin")
    for keep, name, colour in CAUSES:
        one = np.array([_height(predict(start, t, certain(KNOWN, keep)))[1] for t in times])
        added = np.sqrt(np.maximum(one**2 - flown**2, 0.0))
        parts.plot(times, 100 * added, color=colour, label=name)
    parts.set(xlabel="time, s", ylabel="sd of the height, cm", ylim=(-0.05, 3.2))
    parts.legend(fontsize=8, loc="upper left")
    _print_causes(start)


CAUSES = (
    ("restitution", "restitution, sd 0.02", ORANGE),
    ("friction", "friction, sd 0.05", PINK),
    ("table", "height of the table, sd 1 cm", GREEN),
)


def _height(belief: Belief) -> tuple[float, float]:
    return float(belief.position[2]), math.sqrt(belief.covariance[2, 2])


def _print_causes(start: Belief) -> None:
    """Print what each cause adds at the blade plane, and what was there before the bounce."""
    before = predict(start, 0.5, KNOWN)
    print(f"before the bounce, t = 0.5 s: sd of the height {1000 * _height(before)[1]:.1f} mm")
    for keep in ("", *[cause[0] for cause in CAUSES]):
        there = crossing(start, *BLADE, certain(KNOWN, keep))
        none = crossing(start, *BLADE, certain(KNOWN))
        assert there is not None
        assert none is not None
        added = there.covariance - none.covariance if keep else none.covariance
        sds = np.sqrt(np.maximum(np.diag(added), 0.0))
        print(f"at the plane, {keep or 'sights'}: {1000 * sds[2]:.1f} mm, {1000 * sds[6]:.1f} ms")
    there = crossing(start, *BLADE, KNOWN)
    assert there is not None
    sds = np.sqrt(np.diag(there.covariance))
    print(f"at the plane, all: {1000 * sds[2]:.1f} mm high, {1000 * sds[1]:.1f} mm sideways")
    print(f"  at {there.time:.3f} s, {1000 * sds[6]:.1f} ms")


def window_or_filter(figure: Figure) -> None:
    """Errors of filter and window under a tilt, and under an attitude that walks."""
    graph, bars = figure.subplots(1, 2, width_ratios=[1, 1.05])
    prior, counts = knowing(start=TILT), range(FIRST, FRAMES + 1)
    limits = [100 * math.sqrt(bound(n, prior)[2, 2]) for n in counts]
    graph.plot(counts, limits, "--", color="black", label="Cramér-Rao bound", lw=1)
    looks = ((ORANGE, "s"), (GREEN, "o"), (BLUE, "^"))
    for (name, error), (colour, mark) in zip(_heights(prior).items(), looks, strict=True):
        rms = 100 * np.sqrt(np.mean(error**2, axis=0))
        graph.plot(counts, rms, mark + "-", color=colour, markersize=4, lw=1, label=name)
        print(f"height after {FRAMES} sights, {name}: {rms[-1]:.2f} cm, bound {limits[-1]:.2f} cm")
    graph.set(xlabel="sights so far", ylabel="rms error of the height, cm")
    graph.set_title("1° of tilt, told", fontsize=9)
    graph.legend(fontsize=8)
    _walks(bars)


def _heights(prior: Prior) -> dict[str, np.ndarray]:
    """Return the errors of the height by estimator, serve and sight, m, of tilted cameras."""
    rows: dict[str, list[np.ndarray]] = {"filter": [], "filter, renewed": [], "window": []}
    for seed in range(SERVES):
        path, rng = one_flown(seed)
        known, noise = ground(prior, 0.0), rng.standard_normal((FRAMES, 3))
        sights = watch(path, SDS * noise, leaning(rng))
        true = path[FIRST - 1 :, 2]
        fits = [begin(known, sights[:n], prior) for n in range(FIRST, FRAMES + 1)]
        found = filtered(known, sights, prior)[0], renewed(known, sights, prior)[0], fits
        for row, beliefs in zip(rows.values(), found, strict=True):
            row.append(np.array([belief.position[2] for belief in beliefs]) - true)
    return {name: np.array(row) for name, row in rows.items()}


def _walks(axes: Axes) -> None:
    """Draw the errors of speed under an attitude that walks, by what was told of it."""
    white = SDS**2 + [WALK**2 * END / 2, WALK**2 * END / 2, 0.0]
    told = knowing(walk=WALK)
    done = {
        "untold: window": trials("walk untold, window", window, KNOWN, walking),
        "untold: filter": trials("walk untold, filter", filtered, KNOWN, walking),
        "untold: slack filter": trials(
            "walk untold, slack filter", filtered, knowing(unmodelled=SLACK), walking
        ),
        "told as white: window": trials(
            "walk told as white, window", window, KNOWN, walking, sds_told=np.sqrt(white)
        ),
        "told: filter": trials("walk told, filter", filtered, told, walking),
        "told: window": trials("walk told, window", window, told, walking),
    }
    for row, (found, colour) in enumerate(
        zip(done.values(), (RED, RED, ORANGE, ORANGE, GREEN, GREEN), strict=True)
    ):
        speed = 100 * math.sqrt(np.mean([trial.error[3] ** 2 for trial in found]))
        axes.barh(row, speed, color=colour, alpha=0.75, height=0.7)
        nees = np.mean([trial.nees for trial in found])
        axes.annotate(
            f"NEES {nees:,.0f}", (speed, row), (4, -3), textcoords="offset points", fontsize=8
        )
    axes.set_yticks(range(len(done)), list(done), fontsize=8)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set(xlabel="rms error of the speed, cm/s", xlim=(0, 28))
    axes.set_title(f"attitude walks {math.degrees(WALK):.2f}° per root second", fontsize=9)


def forecast(figure: Figure) -> None:
    """Where the ball will pass the blade's plane: ellipse and cloud; error by sights."""
    plane, graph = figure.subplots(1, 2, width_ratios=[1, 1.3])
    belief = the_belief()
    there = crossing(belief, *BLADE, KNOWN)
    assert there is not None
    cloud = _cloud(belief, np.random.default_rng(5))
    plane.plot(*(100 * cloud.T), ".", color=GREY, markersize=2, label="500 flights")
    spread = there.covariance[1:3, 1:3]
    plane.add_patch(_ellipse(100 * there.position[1:], 1e4 * spread))
    true = at_blade(THROWN, TABLE_SURFACE, 0.0)[1]
    plane.plot(*(100 * true[1:]), "x", color="black", label="the ball")
    plane.set(xlabel="y, cm (left)", ylabel="z, cm", xlim=(-4, 4), ylim=(25, 35.5), aspect="equal")
    plane.legend(fontsize=8, loc="upper right")
    claimed, drawn = 1000 * np.sqrt(np.diag(spread)), 1000 * np.std(cloud, axis=0)
    print(f"crossing: sideways sd {claimed[0]:.1f} mm, of the cloud {drawn[0]:.1f} mm")
    print(f"crossing: height sd {claimed[1]:.1f} mm, of the cloud {drawn[1]:.1f} mm")
    _misses(graph)


def _ellipse(middle: np.ndarray, spread: np.ndarray) -> Ellipse:
    """Return the ellipse of two standard deviations."""
    values, vectors = np.linalg.eigh(spread)
    angle = math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    size = 4.0 * np.sqrt(values)
    return Ellipse(tuple(middle), size[1], size[0], angle=angle, fill=False, color=BLUE, lw=2)


def _cloud(belief: Belief, rng: np.random.Generator, count: int = 500) -> np.ndarray:
    """Return left and up of crossings drawn from a belief and from what the table may be."""
    root, found = np.linalg.cholesky(belief.covariance[:9, :9]), []
    for _ in range(count):
        state = belief.mean[:9] + root @ rng.standard_normal(9)
        ball = Ball(state[:3], state[3:6], state[6:])
        found.append(at_blade(ball, *some_table(rng))[1][1:])
    return np.array(found)


def some_table(rng: np.random.Generator) -> tuple[Surface, float]:
    """Return a table as the prior has it; none gives energy."""
    pairs = np.array([KNOWN.restitution, KNOWN.friction, KNOWN.table])
    restitution, friction, height = pairs[:, 0] + pairs[:, 1] * rng.standard_normal(3)
    return Surface(min(restitution, 1.0), friction), height


def _misses(axes: Axes) -> None:
    """Draw by how much crossings are missed, by sights, and by how much the filter says."""
    counts, rng = np.arange(FIRST, FRAMES + 1), np.random.default_rng(0)
    rows, inside = ([], [], []), []
    for seed in range(SERVES):
        two, beliefs, true = _forecasts(seed)
        ahead = [crossing(belief, *BLADE, KNOWN) for belief in beliefs]
        spreads = [
            np.full((2, 2), math.inf) if c is None else c.covariance[1:3, 1:3] for c in ahead
        ]
        rows[0].append([_miss(crossing(belief, *BLADE, KNOWN), true) for belief in two])
        rows[1].append([_miss(one, true) for one in ahead])
        rows[2].append([np.linalg.norm(_drawn(spread, rng)) for spread in spreads])
        if ahead[-1] is not None:
            error = (ahead[-1].position - true)[1:]
            inside.append(error @ np.linalg.solve(spreads[-1], error) < 4.0)
    names = ("finite differences", "flight filter", "flight filter: what it claims")
    for name, row, style in zip(names, rows, ("o-", "^-", "--"), strict=True):
        middle = 100 * np.median(row, axis=0)
        colour = GREY if row is rows[0] else BLUE
        axes.semilogy(counts, middle, style, color=colour, markersize=4, lw=1, label=name)
        for n in (8, FRAMES):
            print(f"miss after {n} sights, {name}: median {middle[n - FIRST]:.1f} cm")
    print(f"within the ellipse of 2 sd: {100 * np.mean(inside):.0f} % of serves; 86 % would be")
    axes.set(xlabel="sights so far", ylabel="median miss at the blade's plane, cm")
    plain(axes.yaxis, (1, 2, 5, 10, 20))
    axes.set_ylim(1, 30)
    axes.legend(fontsize=8)


def _forecasts(seed: int) -> tuple[list[Belief], list[Belief], np.ndarray]:
    """Return beliefs from two sights and the filter's, from the fifth sight on, and the truth."""
    rng = np.random.default_rng(seed)
    ball, known = serve(rng), ground(KNOWN, 0.0)
    sights, true = watched(all_flown()[seed], rng), at_blade(ball, *some_table(rng))[1]
    points, two = metres(sights)[0], []
    for k in range(FIRST - 1, FRAMES):
        mean = known.mean.copy()
        mean[:6] = np.concatenate([points[k], (points[k] - points[k - 1]) / DT])
        two.append(Belief(sights[k].time, mean, np.zeros_like(known.covariance)))
    return two, filtered(known, sights, KNOWN)[0], true


def _miss(found: Crossing | None, true: np.ndarray) -> float:
    """Return the distance on the plane, m; inf for a ball that was said to pass nowhere."""
    return math.inf if found is None else float(np.linalg.norm(found.position - true))


def _drawn(spread: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return an error that is distributed as a filter says."""
    if not np.isfinite(spread).all():
        return np.full(2, math.inf)
    return np.linalg.cholesky(spread) @ rng.standard_normal(2)


if __name__ == "__main__":
    main()
