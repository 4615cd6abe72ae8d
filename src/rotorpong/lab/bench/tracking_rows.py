"""How well whole serves are seen: rows of `rotorpong bench eyes`.

Hovering drones watch the same serves with the tracker's eyes and with the paper's, through pictures
of the whole sensor. At the first answer nearer than 2.5 m, errors of position and velocity against
truth (camera frame, means of absolute values; Table I has them along the whole way), and what the
eyes' own covariance expects of the velocity's. Then how far the predicted place on the blade plane
is off, seen from the drone, and when that was. Consistency: the share of serves whose mean NIS lies
in its 95 % band, and the median of the errors' NEES over 6.
Times are processor time of one core per frame that is decoded already; the peer is the plain chain
of OpenCV (HSV, inRange, findContours) and our circle, on the same frames.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from statistics import median

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import chi2

from rotorpong.drone import HOVER, BallEstimate, Eyes, Frame, Observation
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.spec import Spec
from rotorpong.lab.tracking import tracker_eyes
from rotorpong.lab.trial import Stage, new_drone, stage_of
from rotorpong.vision.colour import ORANGE
from rotorpong.vision.measure import fit_circle
from rotorpong.vision.paper_eyes import PaperEyes
from rotorpong.vision.tracker import TrackerEyes
from rotorpong.world.racket import HOME_BLADE

SERVES, QUICK_SERVES = 60, 4
TIMED, QUICK_TIMED = 6, 2
WHITE_SERVES, RIGHT = 20, 0.1  # of serves; of the distance
PLANE = 2.5  # m, depth
PAIRS = (("gazebo", "tum_gazebo"), ("ardrone2_720p", "ardrone2"))
GOALS = {  # at the plane, 720p: facts of vision
    "ardrone2_720p": ((0.2, 0.5, 1.5), (2.0, 3.0, 6.0)),  # cm, cm/s
    "gazebo": ((None,) * 3, (None,) * 3),
}
SPEED_GOALS = {"ardrone2_720p": (1.0, 0.3)}  # ms, search and tracked
TRACKED_SHARE = 0.25  # of the plain chain's time
CONSISTENT = 0.90
SIGHT_DEGREES = 3


@dataclass(frozen=True, slots=True)
class Watched:
    """What eyes made of one serve."""

    at_plane: Float[ndarray, "2 3"] | None  # errors of position (m) and velocity (m/s)
    nees: float
    sds: Float[ndarray, "6"]  # of position and velocity there, by the eyes' own covariance
    ahead: float  # s, from the plane to the blade
    miss: float  # m, of the predicted place on the blade plane
    mean_nis: float
    sights: int


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure: three minutes, or half a minute."""
    cv2.setNumThreads(1)
    found: list[Row] = []
    for camera, vehicle in PAIRS:
        stage = stage_of(Spec("hover", camera=camera, vehicle=vehicle))
        count = QUICK_SERVES if quick else SERVES
        name = f"{camera}, {vehicle}"
        tracked = [_tracked(stage, index) for index in range(count)]
        found += _accuracy(f"{name}, tracker", tracked, *GOALS[camera])
        found += _expected(f"{name}, tracker", tracked)
        found += _consistency(f"{name}, tracker", tracked)
        papers = [_paper(stage, index) for index in range(count)]
        found += _accuracy(f"{name}, paper", papers, (None,) * 3, (None,) * 3)
        found += _white(name, replace(stage.spec, ball="white"), 1 if quick else WHITE_SERVES)
        found += _speed(name, stage, QUICK_TIMED if quick else TIMED, SPEED_GOALS.get(camera))
    return tuple(found)


def _tracked(stage: Stage, index: int) -> Watched:
    """Watch a serve; where the ball passed the blade plane is known at its end."""
    drone = new_drone(stage, index)
    eyes = tracker_eyes(
        drone.camera, stage.spec.vehicle_name, stage.spec.serves_name, stage.spec.colour()
    )
    error, nees, crossing, begin = None, np.nan, None, 0.0
    sds = np.full(6, np.nan)
    levels: list[float] = []  # of the track that lasted longest
    while (seen := drone.observe()) is not None:
        estimate = eyes.see(seen)
        drone.command(HOVER)
        levels = max(levels, eyes.nis, key=len)
        if error is None and estimate is not None:
            position, velocity = drone.ball_in_camera(estimate.time)
            if position[2] < PLANE:
                error, nees = _errors(estimate, position, velocity)
                sds = np.sqrt(np.diag(estimate.covariance))
                crossing = eyes.crossing(np.array([1.0, 0.0, 0.0]), HOME_BLADE[0])
                begin = seen.frame_time
    truth, miss, ahead = drone.truth(), np.nan, np.nan
    passed = np.flatnonzero(truth.ball_path[:, 0] < HOME_BLADE[0])
    if crossing is not None and len(passed):
        tick = int(passed[0])
        seen_from = eyes.place_of_drone(1e-3 * tick)
        there = truth.ball_path[tick] - truth.body_path[tick]
        miss = float(np.linalg.norm((crossing.position - seen_from - there)[1:]))
        ahead = 1e-3 * tick - begin
    mean = float(np.mean(levels)) if levels else np.nan
    return Watched(error, nees, sds, ahead, miss, mean, len(levels))


def _paper(stage: Stage, index: int) -> Watched:
    drone = new_drone(stage, index)
    eyes: Eyes = PaperEyes(drone.camera, colour=stage.spec.colour())
    while (seen := drone.observe()) is not None:
        estimate = eyes.see(seen)
        drone.command(HOVER)
        if estimate is None:
            continue
        position, velocity = drone.ball_in_camera(estimate.time)
        if position[2] < PLANE:
            error, nees = _errors(estimate, position, velocity)
            return Watched(error, nees, np.full(6, np.nan), np.nan, np.nan, np.nan, 0)
    return Watched(None, np.nan, np.full(6, np.nan), np.nan, np.nan, np.nan, 0)


def _errors(
    estimate: BallEstimate, position: Float[ndarray, "3"], velocity: Float[ndarray, "3"]
) -> tuple[Float[ndarray, "2 3"], float]:
    error = np.array([estimate.position - position, estimate.velocity - velocity])
    weight = np.linalg.pinv(estimate.covariance)
    return error, float(error.ravel() @ weight @ error.ravel())


def _white(name: str, spec: Spec, count: int) -> Iterator[Row]:
    """Yield how often a white ball before white walls is where it seems to be at the plane."""
    stage = stage_of(spec)
    for eyes, watch in (("tracker", _tracked), ("paper", _paper)):
        watched = [watch(stage, index) for index in range(count)]
        right = [one for one in watched if one.at_plane is not None and _is_right(one.at_plane)]
        words = f"{name}, {eyes}: white balls placed within 10 % at 2.5 m"
        yield Row(words, len(right) / count, "share of serves")


def _is_right(at_plane: Float[ndarray, "2 3"]) -> bool:
    return bool(np.linalg.norm(at_plane[0]) < RIGHT * PLANE)


def _accuracy(
    name: str,
    watched: list[Watched],
    position_goals: tuple[float | None, ...],
    velocity_goals: tuple[float | None, ...],
) -> Iterator[Row]:
    errors = np.array([one.at_plane for one in watched if one.at_plane is not None])
    share = len(errors) / len(watched)
    yield Row(f"{name}: serves seen at the plane", share, "share")
    if not len(errors):
        return
    for part, words, unit, goals in (
        (0, "position", "cm", position_goals),
        (1, "velocity", "cm/s", velocity_goals),
    ):
        for axis, goal in enumerate(goals):
            mean = 100.0 * float(np.abs(errors[:, part, axis]).mean())
            letter = "XYZ"[axis]
            yield Row(f"{name}: {words} {letter} at 2.5 m, mean error", mean, unit, goal, "less")


def _expected(name: str, watched: list[Watched]) -> Iterator[Row]:
    """Yield the mean error of velocity that the filter expects of itself: sqrt(2 / pi) sd."""
    sds = np.array([one.sds for one in watched if one.at_plane is not None])
    for axis, letter in enumerate("XYZ" if len(sds) else ""):
        mean = 100.0 * float(np.sqrt(2.0 / np.pi) * sds[:, 3 + axis].mean())
        words = f"{name}: velocity {letter} at 2.5 m, mean error by its own covariance"
        yield Row(words, mean, "cm/s")


def _consistency(name: str, watched: list[Watched]) -> Iterator[Row]:
    """Yield the predicted place's error, and whether errors are what the eyes say they are."""
    missed = 100.0 * np.array([one.miss for one in watched if np.isfinite(one.miss)])
    ahead = np.array([one.ahead for one in watched if np.isfinite(one.ahead)])
    if len(missed):
        words = f"{name}: predicted place on the blade plane, {ahead.mean():.2f} s ahead"
        yield Row(f"{words}, median error", float(np.median(missed)), "cm")
        yield Row(f"{words}, 90 %", float(np.quantile(missed, 0.9)), "cm")
    inside = [_in_band(one) for one in watched if one.sights]
    yield Row(f"{name}: mean NIS in its 95 % band", float(np.mean(inside)), "share", CONSISTENT)
    levels = np.array([one.mean_nis for one in watched if one.sights])
    yield Row(f"{name}: NIS over 3, mean", float(levels.mean()) / SIGHT_DEGREES, "1")
    nees = np.array([one.nees for one in watched if np.isfinite(one.nees)])
    yield Row(f"{name}: NEES over 6 at 2.5 m, median", float(np.median(nees)) / 6.0, "1")


def _in_band(one: Watched) -> bool:
    degrees = SIGHT_DEGREES * one.sights
    low, high = chi2.ppf([0.025, 0.975], degrees) / one.sights
    return bool(low <= one.mean_nis <= high)


def _speed(
    name: str, stage: Stage, serves: int, goals: tuple[float, float] | None
) -> tuple[Row, ...]:
    """Time eyes on frames that are made before."""
    search: list[float] = []
    tracked: list[float] = []
    plain: list[float] = []
    for index in range(serves + 1):
        eyes: TrackerEyes | None = None
        for seen in _frames(stage, index):
            if eyes is None:
                lens = stage.setting.camera
                eyes = tracker_eyes(
                    lens, stage.spec.vehicle_name, stage.spec.serves_name, stage.spec.colour()
                )
            searching = eyes.is_searching
            start = time.process_time()
            eyes.see(seen)
            spent = time.process_time() - start
            picture = seen.frame.picture
            start = time.process_time()
            _plain_chain(picture)
            if index > 0:  # the first serve warms up
                (search if searching else tracked).append(1e3 * spent)
                plain.append(1e3 * (time.process_time() - start))
    chain, peer = median(plain), "plain OpenCV chain"
    first, then = goals or (None, None)
    return (
        Row(f"{name}: frame, searched", median(search), "ms", first, "less", peer,
            chain / median(search)),
        Row(f"{name}: frame, tracked", median(tracked), "ms", then, "less", peer,
            chain / median(tracked)),
        Row(f"{name}: frame, tracked, over the plain chain", median(tracked) / chain, "1",
            TRACKED_SHARE, "less"),
    )  # fmt: skip


def _frames(stage: Stage, index: int) -> list[Observation]:
    """Return the observations of a serve, their pictures made."""
    drone, made = new_drone(stage, index), []
    while (seen := drone.observe()) is not None:
        picture, frame = seen.frame.picture, seen.frame
        ready = Frame(frame.width, frame.height, lambda p=picture: p)
        _ = ready.picture  # read once, as by a decoder
        made.append(Observation(ready, seen.frame_time, seen.arrival_time, seen.navdata))
        drone.command(HOVER)
    return made


def _plain_chain(picture: ndarray) -> None:
    """Find the largest orange outline and its circle, as a tutorial does, without its blur."""
    mask = cv2.inRange(cv2.cvtColor(picture, cv2.COLOR_BGR2HSV), ORANGE.lower, ORANGE.upper)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if outlines:
        fit_circle(max(outlines, key=len)[:, 0])
