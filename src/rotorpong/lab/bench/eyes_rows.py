"""How well one ball is measured in one picture: rows of `rotorpong bench eyes`.

Balls are rendered at random places of the court before random parts of the hall (or an even grey),
with the whole sensor of the AR.Drone's camera at 720p, and measured from the circle of their
outline's guess: by that circle (with its diameter in whole pixels, as in the paper, and as it is
with its bias added), by the matte's area and by its edge. Depth is Z of the camera frame against
truth. The bound is Cramer and Rao's for a blurred edge in white noise,

    sd_r = (sigma / A) sqrt(s / (sqrt(pi) r)),    sd_Z = Z sd_r / r

with s the blur in px, A / sigma the contrast across the ball's own colour over the noise. Times are
processor time of one core; the peer is OpenCV's colour test, outline and our circle.
"""

import importlib.util
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, CAMERA_FROM_BODY_AXES, Picture
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.physics.camera import ARDRONE2_720P, Camera, directions, row_time
from rotorpong.vision.detect import find_blobs
from rotorpong.vision.locate import ball_position
from rotorpong.vision.matte import (
    ORANGE_BALL,
    BallDisc,
    Guess,
    area_and_edge,
    measure_ball,
    streamed,
)
from rotorpong.vision.measure import OUTLINE_BIAS_PX, fit_circle
from rotorpong.vision.sphere import disc_of_sphere, outline_shape, sphere_of_disc
from rotorpong.world.court import OPPONENT_X, TABLE_HALF_LENGTH
from rotorpong.world.exposure import Motion, expose
from rotorpong.world.render import Scene
from rotorpong.world.stream import Stream

DEPTHS = (1.0, 2.5, 4.0)  # m
VIEWS, QUICK_VIEWS = 60, 8
STREAMED, SETTLED, QUICK_STREAMED = 28, 4, 10  # frames of a way; of them not measured
WAYS = (  # of balls through a streamed picture at 1 m: start, step, right and down (m)
    ((0.30, -0.05), (-0.010, -0.002)),
    ((-0.10, -0.20), (0.006, 0.004)),
    ((0.15, -0.15), (-0.012, 0.001)),
    ((-0.30, -0.02), (0.009, -0.003)),
)
COMING = 0.002  # of the depth, per frame
STREAM_MBIT_S = 4.0
GREY = (150.0, 140.0, 120.0)  # blue, green, red
SURFACES = (
    *("table", "line", "net", "steel", "floor", "seam"),
    *("wall", "wainscot", "window", "ceiling", "lamp"),
)
MARGIN_PX = 12  # around a ball and its streak
CLEAR_OF_NET = 0.2  # m above the table, of a line of sight
STEP_S = 0.002
TIMED = 200  # measurements
TIMED_RADII, TIMED_STREAKS, TIMED_VIEWS = (5.0, 9.0, 16.0, 25.0), (0.0, 10.0), 4  # px; px
BOX_PX = 64
METHODS = ("circle, whole px", "circle", "area", "edge")
STATIC_GOALS = {1.0: 0.2, 2.5: 1.5, 4.0: 5.0}  # cm rms before the textured hall
STREAM_GOALS = {1.0: 0.3, 2.5: 1.5, 4.0: 3.5}  # cm, median
BLUR_GOAL, CENTER_GOAL = 1.5, 0.05  # cm; px


@dataclass(frozen=True, slots=True)
class View:
    """A ball in a part of a picture."""

    region: Picture
    offset: tuple[int, int]
    ball: Float[ndarray, "3"]  # m, camera frame, at the exposure of its own row
    velocity: Float[ndarray, "3"]  # m/s, camera frame


def measurement_rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure accuracy and speed of the eyes' measurement: half a minute, or ten seconds."""
    still = replace(ARDRONE2_720P, exposure_s=0.0)
    rows: list[Row] = []
    for gamma in (1.0, 2.2):
        camera = replace(still, gamma=gamma)
        for depth in DEPTHS:
            for textured in (False, True):
                goal = STATIC_GOALS[depth] if textured else None
                rows += _accuracy(camera, depth, textured=textured, goal=goal, quick=quick)
    bounds = [_bound(replace(still, gamma=1.0), depth) for depth in DEPTHS]
    rows += _blurred(quick=quick)
    if importlib.util.find_spec("av") is not None:
        rows += [row for depth in DEPTHS for row in _streamed(depth, quick=quick)]
    return (*rows, *bounds, *_speed(quick=quick))


def views(
    camera: Camera, depth: float, count: int, *, textured: bool, speed: float = 0.0
) -> Iterator[View]:
    """Yield balls at this depth and lateral speed, seen freely from random places.

    Args:
        camera: that sees them.
        depth: Z, m.
        count: how many.
        textured: before the hall with its opponent, or before an even grey.
        speed: m/s, horizontally or not, across the line of sight.
    """
    rng, tries = np.random.default_rng(0), 0
    reach = MARGIN_PX + int(speed * camera.exposure_s * camera.focal_length_px[0] / depth)
    while count > 0:
        tries += 1
        eye, axes = _pose(rng)
        pixel = rng.uniform(0.1, 0.9, 2) * (camera.width_px, camera.height_px)
        ball = depth * np.array([*directions(camera, pixel), 1.0])
        turn = rng.uniform(0.0, 2.0 * np.pi)
        velocity = speed * np.array([math.cos(turn), math.sin(turn), 0.0])
        scene = Scene(opponent=bool(rng.random() < 0.7)) if textured else _grey()
        disc = disc_of_sphere(camera, ball)
        half = int(disc[2]) + reach
        x0, y0 = round(disc[0]) - half, round(disc[1]) - half
        x1, y1 = x0 + 2 * half + 1, y0 + 2 * half + 1
        inside = x0 >= 0 and y0 >= 0 and x1 <= camera.width_px and y1 <= camera.height_px
        if not (inside and _is_seen(eye, eye + axes @ ball)):
            continue
        count -= 1
        motion = _motion(camera, (eye, axes), ball, velocity, float(disc[1]))
        region = expose(camera, motion, 0.0, scene, key=(tries,), region=(x0, y0, x1, y1))
        yield View(region, (x0, y0), ball, velocity)


def _pose(rng: np.random.Generator) -> tuple[ndarray, ndarray]:
    """Return a camera's place on the near side and its axes in the world."""
    eye = rng.uniform((-2.5, -1.0, 0.1), (-1.0, 1.0, 0.7))
    yaw, pitch = rng.normal(0.0, 0.25), rng.normal(0.0, 0.1)
    c, s, up, along = math.cos(yaw), math.sin(yaw), math.sin(pitch), math.cos(pitch)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    tilt = np.array([[along, 0.0, up], [0.0, 1.0, 0.0], [-up, 0.0, along]])
    return eye, turn @ tilt @ CAMERA_FROM_BODY_AXES.T


def _is_seen(eye: ndarray, ball: ndarray) -> bool:
    """Tell whether nothing of the court stands before the ball."""
    in_room = bool(0.03 < ball[2] < 2.9 and abs(ball[1]) < 3.0 and ball[0] < OPPONENT_X - 0.3)
    if ball[2] < 0.15 and abs(ball[0]) > TABLE_HALF_LENGTH - 0.07:
        return False  # sunk behind an edge of the table
    if ball[0] < -0.05:
        return in_room
    height = eye[2] - (ball[2] - eye[2]) * eye[0] / (ball[0] - eye[0])  # where x = 0
    return in_room and bool(height > CLEAR_OF_NET)


def _grey() -> Scene:
    even = replace(Scene(), opponent=False, ball_shadow=0.0, texture_contrast=0.0)
    return replace(even, **dict.fromkeys(SURFACES, GREY))


def _motion(
    camera: Camera,
    pose: tuple[ndarray, ndarray],
    ball: Float[ndarray, "3"],
    velocity: Float[ndarray, "3"],
    row: float,
) -> Motion:
    """Return a ball that passes `ball` when its row is exposed, before a camera at rest."""
    eye, axes = pose
    times = STEP_S * (np.arange(41) - 20)
    since = times - float(row_time(camera, 0.0, np.array(row)))
    balls = eye + (ball + since[:, None] * velocity) @ axes.T
    return Motion(float(times[0]), STEP_S, np.tile(eye, (41, 1)), np.tile(axes, (41, 1, 1)), balls)


def _accuracy(
    camera: Camera, depth: float, *, textured: bool, goal: float | None, quick: bool
) -> list[Row]:
    found = views(camera, depth, QUICK_VIEWS if quick else VIEWS, textured=textured)
    place = f"{depth:g} m, {'hall' if textured else 'grey'}, gamma {camera.gamma:g}"
    errors, centers = _errors(camera, found)
    rows = _depth_rows(errors, place, goal)
    if textured and centers:
        value = float(np.sqrt(np.mean(np.square(centers))))
        rows.append(Row(f"centre by edge, rms, {place}", value, "px", CENTER_GOAL, "less"))
    return rows


def _blurred(*, quick: bool) -> list[Row]:
    """Return rows of balls that cross at 1 and 3 m/s while they are exposed, without readout."""
    rows = []
    count = QUICK_VIEWS if quick else VIEWS
    for speed, exposure in ((1.0, 60), (3.0, 250), (3.0, 60)):
        camera = replace(ARDRONE2_720P, exposure_s=1.0 / exposure, readout_s=0.0)
        for textured in (False, True):
            found = views(camera, 2.5, count, textured=textured, speed=speed)
            place = f"2.5 m, {'hall' if textured else 'grey'}, {speed:g} m/s, 1/{exposure} s"
            goal = None if textured or (speed, exposure) != (3.0, 60) else BLUR_GOAL
            rows += _depth_rows(_errors(camera, found)[0], place, goal)
    return rows


def _depth_rows(errors: dict[str, list[float]], place: str, goal: float | None) -> list[Row]:
    """Return median, rms and 90th percentile of each method's depth, cm; the goal is the edge's."""
    rows = []
    circle = errors["circle"]
    for method in METHODS:
        cm = 100.0 * np.abs(errors[method])
        if len(cm) == 0:
            continue
        rms = float(np.sqrt(np.mean(cm**2)))
        is_edge = method == "edge" and len(circle) > 0
        ratio = 100.0 * float(np.sqrt(np.mean(np.square(circle)))) / rms if is_edge else None
        name = f"depth by {method}"
        rows += [
            Row(f"{name}, median, {place}", float(np.median(cm)), "cm", None, "less"),
            Row(
                f"{name}, rms, {place}",
                rms,
                "cm",
                goal if method == "edge" else None,
                "less",
                "circle" if is_edge else None,
                ratio,
            ),
            Row(f"{name}, 90 %, {place}", float(np.percentile(cm, 90)), "cm", None, "less"),
        ]
    return rows


def _errors(camera: Camera, found: Iterator[View]) -> tuple[dict[str, list[float]], list[float]]:
    """Return errors of Z by method, m, and of the edge's centres, px; what is not seen is out."""
    errors: dict[str, list[float]] = {method: [] for method in METHODS}
    centers: list[float] = []
    for view in found:
        guess = _guess(camera, view)
        if guess is None:
            continue
        truth = disc_of_sphere(camera, view.ball)
        for method, whole in zip(METHODS[:2], (True, False), strict=True):
            errors[method].append(_depth_of_circle(camera, view, whole=whole) - view.ball[2])
        colour = streamed(ORANGE_BALL) if camera.stream_mbit_s else ORANGE_BALL
        area, edge = area_and_edge(
            view.region, guess, colour, offset=view.offset, gamma=camera.gamma
        )
        for method, disc in zip(METHODS[2:], (area, edge), strict=True):
            if disc is not None:
                errors[method].append(_depth_of_disc(camera, disc) - view.ball[2])
        if edge is not None:
            centers += [edge.x_px - truth[0], edge.y_px - truth[1]]
    return errors, centers


def _guess(camera: Camera, view: View) -> Guess | None:
    """Return the circle of the best blob's outline, as the eyes' search gives it."""
    blobs = find_blobs(view.region)
    if not blobs:
        return None
    circle = fit_circle(blobs[0].contour)
    x, y = circle.x_px + view.offset[0], circle.y_px + view.offset[1]
    return Guess(x, y, circle.diameter_px, shape=outline_shape(camera, np.array([x, y])))


def _depth_of_circle(camera: Camera, view: View, *, whole: bool) -> float:
    circle = fit_circle(find_blobs(view.region)[0].contour, whole_pixels=whole)
    pixel = np.array([circle.x_px, circle.y_px]) + view.offset
    diameter = circle.diameter_px + (0.0 if whole else OUTLINE_BIAS_PX)
    return float(ball_position(camera, pixel, np.array(diameter), eq1=False)[2])


def _depth_of_disc(camera: Camera, disc: BallDisc) -> float:
    measured = np.array([disc.x_px, disc.y_px, disc.radius_px])
    return float(sphere_of_disc(camera, measured, disc.covariance).position[2])


def _bound(camera: Camera, depth: float) -> Row:
    """Return the least sd of Z that any method could have before the even grey."""
    ball, grey = np.array(Scene().ball), np.array(GREY)
    noise = np.sqrt(camera.read_noise**2 + camera.shot_noise * 0.5 * (0.8 * ball + grey))
    own, apart = ball / noise, grey / noise
    contrast = float(np.linalg.norm(apart - (apart @ own) / (own @ own) * own))
    aside = math.exp(-0.5 / camera.blur_px**2)
    blur = math.sqrt(2.0 * aside / (1.0 + 2.0 * aside) + 1.0 / 12.0)
    radius = float(disc_of_sphere(camera, np.array([0.0, 0.0, depth]))[2])
    sd = math.sqrt(blur / (math.sqrt(math.pi) * radius)) / contrast
    return Row(f"depth, Cramer-Rao bound, {depth:g} m, grey", 100.0 * depth * sd / radius, "cm")


def _streamed(depth: float, *, quick: bool) -> list[Row]:
    """Return rows of balls that drift by, as H.264 brings them."""
    camera = replace(ARDRONE2_720P, exposure_s=0.0, readout_s=0.0, stream_mbit_s=STREAM_MBIT_S)
    frames = QUICK_STREAMED if quick else STREAMED
    found = [view for way in range(len(WAYS)) for view in _sent(camera, depth, way, frames)]
    errors, _ = _errors(camera, iter(found))
    cm = 100.0 * np.abs(errors["edge"])
    if len(cm) == 0:
        return []
    place = f"{depth:g} m, H.264 at {STREAM_MBIT_S:g} Mbit/s"
    goal = STREAM_GOALS[depth]
    rough = 100.0 * np.abs(errors["circle"])
    ratio = float(np.median(rough) / np.median(cm))
    edge = Row(
        f"depth by edge, median, {place}", float(np.median(cm)), "cm", goal, "less", "circle", ratio
    )
    return [
        edge,
        Row(f"depth by circle, median, {place}", float(np.median(rough)), "cm", None, "less"),
    ]


def _sent(camera: Camera, depth: float, way: int, frames: int) -> Iterator[View]:
    """Yield a ball that drifts by, as the receiver of the camera's stream sees it."""
    stream, eye, axes = Stream(camera), np.array([-1.69, 0.0, 0.2]), CAMERA_FROM_BODY_AXES.T
    start, step = np.array(WAYS[way])
    for k in range(frames):
        ball = depth * np.array([*(start + k * step), 1.0 - k * COMING])
        motion = _motion(camera, (eye, axes), ball, np.zeros(3), camera.height_px / 2)
        key = (way, k)
        picture = stream.send(lambda m=motion, k=key: expose(camera, m, 0.0, Scene(), key=k))()
        if k >= SETTLED:
            x, y, radius = disc_of_sphere(camera, ball)
            half, x0, y0 = int(radius) + 2 * MARGIN_PX, round(x), round(y)
            box = picture[y0 - half : y0 + half, x0 - half : x0 + half]
            yield View(np.ascontiguousarray(box), (x0 - half, y0 - half), ball, np.zeros(3))


def _speed(*, quick: bool) -> list[Row]:
    """Return how long one measurement takes, in a box of 64 pixels and by size, beside OpenCV."""
    camera = replace(ARDRONE2_720P, exposure_s=0.0)
    view = next(views(camera, 2.5, 1, textured=True))
    x, y, radius = disc_of_sphere(camera, view.ball)
    half = (BOX_PX - view.region.shape[0]) // 2 + 1
    box = cv2.copyMakeBorder(view.region, half, half, half, half, cv2.BORDER_REPLICATE)
    box, offset = box[:BOX_PX, :BOX_PX].copy(), (view.offset[0] - half, view.offset[1] - half)
    guess = Guess(x + 0.3, y - 0.2, 2 * radius - 0.7, shape=outline_shape(camera, np.array([x, y])))
    cv2.setNumThreads(1)
    ours = _microseconds(
        lambda: measure_ball(box, guess, offset=offset, gamma=camera.gamma), quick=quick
    )
    theirs = _microseconds(lambda: _opencv_chain(box), quick=quick)
    name = f"measurement of a ball of {2 * radius:.0f} px, box of {BOX_PX} px"
    return [
        Row(name, ours, "us", 100.0, "less", "HSV, outline, circle", theirs / ours),
        *(_speed_by_size(r, streak, quick=quick) for r in TIMED_RADII for streak in TIMED_STREAKS),
    ]


def _speed_by_size(radius: float, streak: float, *, quick: bool) -> Row:
    """Return how long balls of one size take where they are seen before the hall, and OpenCV."""
    camera = replace(ARDRONE2_720P, exposure_s=1 / 60 if streak else 0.0, readout_s=0.0)
    depth = camera.focal_length_px[0] * BALL_RADIUS / radius
    speed = 60.0 * streak * depth / camera.focal_length_px[0]
    seen = views(camera, depth, TIMED_VIEWS, textured=True, speed=speed)
    balls = [(view, guess) for view in seen if (guess := _guess(camera, view)) is not None]

    def ours() -> None:
        for view, guess in balls:
            measure_ball(view.region, guess, offset=view.offset, gamma=camera.gamma)

    def theirs() -> None:
        for view, _ in balls:
            _opencv_chain(view.region)

    spent, chain = (_microseconds(work, quick=quick) / len(balls) for work in (ours, theirs))
    name = f"measurement of a ball of radius {radius:g} px, streak {streak:g} px"
    return Row(name, spent, "us", None, "less", "HSV, outline, circle", chain / spent)


def _opencv_chain(box: Picture) -> float:
    hsv = cv2.cvtColor(box, cv2.COLOR_BGR2HSV)
    mask = cv2.inRange(hsv, (0, 110, 80), (24, 255, 255))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return fit_circle(max(contours, key=len)[:, 0]).diameter_px


def _microseconds(work: Callable[[], object], *, quick: bool) -> float:
    def many() -> None:
        for _ in range(TIMED):
            work()

    return 1e6 * cpu_seconds(many, quick=quick) / TIMED
