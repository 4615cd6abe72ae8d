"""How well the flight filter predicts, and how near it comes to the bound: rows of `bench eyes`.

Human serves are seen by a camera at rest (720p, 30 frames/s) as exact angles plus white noise: 0.15
px in the centre, 0.10 px in the radius. The attitude that the filter is told is wrong by a constant
tilt, normal in roll and pitch, of which it knows the spread. At the first frame nearer than 2.5 m
it predicts 0.2 and 0.4 s ahead, over the bounce where there is one. The Cramer-Rao bound is the
inverse information of all sights (`flight_filter.fit_window`) for one who knows more than the
filter: drag, restitution, friction and the table's height exactly, launch and spin as spread as the
serves are (`GENERATED`). Efficiency: the bound over the mean squared error at the plane.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial.transform import Rotation

from rotorpong.conventions import BALL_RADIUS
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.tracking import PRIORS
from rotorpong.physics.camera import ARDRONE2_720P, Camera, camera_from_body, ideal, in_picture
from rotorpong.vision.flight_filter import (
    AttitudeQuality,
    Prior,
    Sight,
    filtered,
    fit_window,
    ground,
    predict,
)
from rotorpong.world.contact import Solids, fly_over_court, state_of
from rotorpong.world.serves import HUMAN, draw

SERVES, QUICK_SERVES = 100, 10
EYE = np.array([-1.69, 0.0, 0.20])  # m, where the camera of a drone at home is
CENTER_SD_PX, RADIUS_SD_PX = 0.15, 0.10
TILTS_DEG = (0.0, 0.1, 0.3, 1.0)
AHEAD = (0.2, 0.4)  # s
GOALS = {(0.1, 0.4): 3.0}  # cm, mean
PLANE = 2.5  # m
FRAME_TICKS = 33
LONGEST = 1500  # ticks
FEWEST = 5  # sights
GENERATED = {  # 400 serves of seed 777, and what `world.serves` draws
    "velocity": (-6.8, 0.0, 2.8), "velocity_sd": (0.5, 0.6, 0.8), "spin_sd": 20.0,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Predicted:
    """One serve: errors and bound."""

    ahead: dict[float, float]  # m, by s
    ahead_bound: dict[float, float]  # m, rms, by s
    error: Float[ndarray, "6"]  # of position and velocity at the plane
    bound: Float[ndarray, "6"]  # variances


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure: a minute, or ten seconds."""
    found: list[Row] = []
    for tilt in TILTS_DEG:
        serves = [_predicted(seed, tilt) for seed in range(QUICK_SERVES if quick else SERVES)]
        good = [one for one in serves if one is not None]
        for ahead in AHEAD:
            errors = 100.0 * np.array([one.ahead[ahead] for one in good if ahead in one.ahead])
            words = f"prediction {ahead:g} s ahead, attitude error {tilt:g} degrees"
            goal = GOALS.get((tilt, ahead))
            found.append(Row(f"{words}: mean", float(errors.mean()), "cm", goal, "less"))
            found.append(Row(f"{words}: median", float(np.median(errors)), "cm"))
            rms = 100.0 * math.sqrt(float(np.mean([one.ahead_bound[ahead] ** 2 for one in good])))
            found.append(Row(f"{words}: rms", float(np.sqrt(np.mean(errors**2))), "cm"))
            found.append(Row(f"{words}: rms, Cramer-Rao bound", rms, "cm"))
        ratio = np.array([one.error**2 / one.bound for one in good])
        efficiency = 1.0 / float(ratio.mean())
        name = f"efficiency at 2.5 m, attitude error {tilt:g} degrees"
        found.append(Row(name, efficiency, "of the Cramer-Rao bound"))
    return tuple(found)


def _predicted(seed: int, tilt_deg: float) -> Predicted | None:
    """Watch and predict one serve; `None` if too little of it is seen before the plane."""
    rng = np.random.default_rng(seed)
    path = fly_over_court(state_of(draw(HUMAN, rng).ball), LONGEST, Solids())
    tilt = np.append(math.radians(tilt_deg) * rng.standard_normal(2), 0.0)
    prior = _prior(math.radians(tilt_deg))
    sights, ticks = _sights(path, Rotation.from_rotvec(tilt).as_matrix(), rng)
    if len(sights) < FEWEST:
        return None
    known = ground(prior, sights[0].time)
    belief, _ = filtered(known, sights, prior)
    told = _all_knowing(prior)
    fit, _ = fit_window(ground(told, sights[0].time), sights, told)
    bound = predict(fit, sights[-1].time, told)
    now = ticks[-1]
    ahead, ahead_bound = {}, {}
    for seconds in AHEAD:
        tick = now + round(1000 * seconds)
        there = predict(belief, 1e-3 * tick, prior).position
        ahead[seconds] = float(np.linalg.norm(there - path[tick, :3]))
        spread = predict(bound, 1e-3 * tick, told).covariance[:3, :3]
        ahead_bound[seconds] = math.sqrt(float(np.trace(spread)))
    error = belief.mean[:6] - path[now, :6]
    return Predicted(ahead, ahead_bound, error, np.diag(bound.covariance)[:6])


def _prior(tilt_sd: float) -> Prior:
    quality = AttitudeQuality(
        start_sd=max(tilt_sd, 1e-7), reading_sd=1.0, reading_rate=1.0, reading_offset_sd=0.0,
        walk=1e-7, jitter_sd=0.0,
    )  # fmt: skip
    return replace(PRIORS["human"], attitude=quality, table=(0.0, 0.001))


def _all_knowing(prior: Prior) -> Prior:
    """Return what one knows who made the world and its serves."""
    known = {name: (getattr(prior, name)[0], 0.0) for name in ("restitution", "friction", "table")}
    return replace(prior, drag_sd=1e-7, unmodelled=0.0, **GENERATED, **known)


def _sights(
    path: Float[ndarray, "n 9"], turned: Float[ndarray, "3 3"], rng: np.random.Generator
) -> tuple[list[Sight], list[int]]:
    """Return noisy sights up to the first one nearer than the plane, and their ticks."""
    camera: Camera = ideal(ARDRONE2_720P)
    told, focal = camera_from_body(camera), camera.focal_length_px[0]
    sds = np.array([CENTER_SD_PX, CENTER_SD_PX, RADIUS_SD_PX]) / focal
    sights, ticks = [], []
    for tick in range(0, LONGEST - round(1000 * max(AHEAD)), FRAME_TICKS):
        ball = told @ turned.T @ (path[tick, :3] - EYE)
        if not in_picture(camera, ball):
            continue
        angle = math.asin(BALL_RADIUS / float(np.linalg.norm(ball)))
        seen = np.array([ball[0] / ball[2], ball[1] / ball[2], angle])
        seen = seen + sds * rng.standard_normal(3)
        sights.append(Sight(1e-3 * tick, seen, np.diag(sds**2), EYE, told))
        ticks.append(tick)
        if ball[2] < PLANE:
            break
    return sights, ticks
