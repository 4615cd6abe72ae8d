"""How fast and how exact the onboard camera is: rows of `rotorpong bench world`.

Speeds are processor time on one core, medians; the peer is OpenCV's `remap` of a picture of the
same size, measured in turns with ours, which tells a slow machine from a slow renderer. Accuracy is
that of random balls of 8.7 to 30 pixels against the ellipse that OpenCV projects.
"""

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, CAMERA_FROM_BODY_AXES
from rotorpong.drone import Frame
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.physics.camera import (
    ARDRONE2_360P,
    ARDRONE2_720P,
    Camera,
    camera_from_body,
    ideal,
    project,
)
from rotorpong.vision.paper_eyes import PaperEyes
from rotorpong.world.exposure import Motion, expose
from rotorpong.world.render import Scene, ball_coverage, render
from rotorpong.world.simulated_drone import SimulatedDrone

CAMERAS = ((ARDRONE2_360P, "360p", 250.0, 8.0), (ARDRONE2_720P, "720p", 70.0, 2.0))
HOME_CAMERA = np.array([-1.69, 0.0, 0.20])  # m, world: the camera of a drone at home
BALL = np.array([-0.2, 0.1, 0.45])
BALL_VELOCITY = np.array([-6.0, 0.3, -1.0])  # m/s
YAW_RATE = 0.5  # rad/s
REPETITIONS = 15
POSES = 120
DIAMETERS_PX = (8.7, 30.0)
OUTLINE = 720  # points
TRIALS = 3
REGION_TRIALS = 8
REGION_HALF_PX = 24
NEAREST = 0.1  # m


def rows() -> tuple[Row, ...]:
    """Measure rendering: a minute on one core."""
    return (*_speeds(), *_accuracy(), *_trials())


def _speeds() -> list[Row]:
    found = []
    for camera, size, target, _ in CAMERAS:
        moving = _motion(camera)
        pose = moving.positions[len(moving.positions) // 2], CAMERA_FROM_BODY_AXES.T.copy()
        picture = expose(camera, moving, 0.0, Scene(), key=(0,))
        full, sharp, peer = _in_turns(
            lambda c=camera, m=moving: expose(c, m, 0.0, Scene(), key=(0,)),
            lambda c=camera, p=pose: render(c, *p, BALL, Scene()),
            _remap(picture),
        )
        remap = f"cv2.remap {size}"
        found += [
            Row(
                f"render full sensor {size}",
                1 / full,
                "frames/s",
                target,
                "more",
                remap,
                peer / full,
            ),
            Row(
                f"render ideal camera {size}",
                1 / sharp,
                "frames/s",
                None,
                "more",
                remap,
                peer / sharp,
            ),
        ]
    return found


def _motion(camera: Camera) -> Motion:
    """Return 41 ms of a camera that turns and a ball that flies, from home."""
    times = (np.arange(41) - 20) * 0.001
    c, s, zero = np.cos(YAW_RATE * times), np.sin(YAW_RATE * times), np.zeros(41)
    turns = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1.0], axis=1).reshape(41, 3, 3)
    balls = BALL + times[:, None] * BALL_VELOCITY
    axes = turns @ camera_from_body(camera).T
    return Motion(float(times[0]), 0.001, np.tile(HOME_CAMERA, (41, 1)), axes, balls)


def _remap(picture: ndarray) -> Callable[[], Any]:
    grid = np.indices(picture.shape[:2])
    across, along = ((0.99 * axis + 1.3).astype(np.float32) for axis in (grid[1], grid[0]))
    cv2.setNumThreads(1)
    return lambda: cv2.remap(picture, across, along, cv2.INTER_LINEAR)


def _in_turns(*works: Callable[[], Any]) -> list[float]:
    """Return the median processor time of each work, s; all are done once per round."""
    times: list[list[float]] = [[] for _ in works]
    for repetition in range(REPETITIONS + 1):
        for work, spent in zip(works, times, strict=True):
            start = time.process_time()
            work()
            if repetition > 0:
                spent.append(time.process_time() - start)
    return [median(spent) for spent in times]


def _accuracy() -> list[Row]:
    camera = ideal(ARDRONE2_720P)
    rng, diameters, centers, points = np.random.default_rng(0), [], [], []
    down, across = np.indices((camera.height_px, camera.width_px))
    axes = camera_from_body(camera).T.copy()
    while len(diameters) < POSES:
        ball = _random_ball(camera, rng)
        outline = _outline(camera, ball)
        if outline.min() < 2 or np.any(outline > [camera.width_px - 3, camera.height_px - 3]):
            continue
        points.append(np.abs(project(camera, ball) - _opencv(camera, ball[None])[0]).max())
        cover = ball_coverage(camera, HOME_CAMERA, axes, HOME_CAMERA + axes @ ball).astype(float)
        area, center = _area_and_centroid(outline)
        diameters.append(2 * np.sqrt(cover.sum() / np.pi) - 2 * np.sqrt(area / np.pi))
        mean = np.array([(across * cover).sum(), (down * cover).sum()]) / cover.sum()
        centers.append(np.linalg.norm(mean - center))
    return [
        Row("ball diameter error, sd", float(np.std(diameters)), "px", 0.02, "less"),
        Row("ball diameter error, mean", float(abs(np.mean(diameters))), "px", 0.02, "less"),
        Row("ball centre against cv2.projectPoints", float(np.max(centers)), "px", 0.02, "less"),
        Row("point against cv2.projectPoints", float(np.max(points)), "px", 0.02, "less"),
    ]


def _random_ball(camera: Camera, rng: np.random.Generator) -> Float[ndarray, "3"]:
    focal = camera.focal_length_px[0]
    depth = focal * 2 * BALL_RADIUS / rng.uniform(*DIAMETERS_PX)
    half = np.array([camera.width_px, camera.height_px]) / (2 * focal)
    return np.array([*(rng.uniform(-0.9, 0.9, 2) * half), 1.0]) * depth


def _outline(camera: Camera, ball: Float[ndarray, "3"]) -> Float[ndarray, "n 2"]:
    """Return where OpenCV sees the circle along which lines of sight touch the ball."""
    squared = ball @ ball
    along = ball / np.sqrt(squared)
    side = np.cross(along, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    angle = np.linspace(0.0, 2 * np.pi, OUTLINE, endpoint=False)[:, None]
    shrink = 1.0 - BALL_RADIUS**2 / squared
    ring = np.cos(angle) * side + np.sin(angle) * np.cross(along, side)
    return _opencv(camera, ball * shrink + BALL_RADIUS * np.sqrt(shrink) * ring)


def _opencv(camera: Camera, points: Float[ndarray, "n 3"]) -> Float[ndarray, "n 2"]:
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    still, lens = np.zeros(3), np.array(camera.distortion)
    return cv2.projectPoints(np.ascontiguousarray(points), still, still, matrix, lens)[0][:, 0]


def _area_and_centroid(polygon: Float[ndarray, "n 2"]) -> tuple[float, Float[ndarray, "2"]]:
    after = np.roll(polygon, -1, axis=0)
    cross = polygon[:, 0] * after[:, 1] - after[:, 0] * polygon[:, 1]
    center = ((polygon + after) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return float(abs(cross.sum()) / 2.0), center


def _trials() -> list[Row]:
    """Return vision trials per second: paper eyes on every frame, and a box around the ball.

    The world is simulated with them; drawing the serves is not timed.
    """
    found = []
    for camera, size, _, target in CAMERAS:
        rate = _rate(camera, TRIALS, _watch)
        name = f"vision trials {size}, every frame until contact"
        found.append(Row(name, rate, "trials/s", target))
    rate = _rate(ARDRONE2_360P, REGION_TRIALS, _watch_box)
    return [*found, Row("vision trials 360p, a box around the ball", rate, "trials/s", 50.0)]


def _rate(camera: Camera, count: int, watch: Callable[[SimulatedDrone], None]) -> float:
    """Return how many drones can be watched per second of processor time, after a first one."""
    drones = [_drone(camera, index) for index in range(count + 1)]
    watch(drones[0])
    start = time.process_time()
    for drone in drones[1:]:
        watch(drone)
    return count / (time.process_time() - start)


def _drone(camera: Camera, index: int) -> SimulatedDrone:
    spec = Spec("hover", eyes="paper", camera=camera)
    generators = trial_generators(0, "evaluate", index)
    serve = serve_source(spec.serves, 0)(index, generators.serve)
    vehicle, sensors = generators.vehicle, generators.sensors
    return SimulatedDrone(serve, spec.setting(), vehicle_rng=vehicle, sensor_rng=sensors)


def _watch(drone: SimulatedDrone) -> None:
    eyes = PaperEyes(drone.camera)
    while (observation := drone.observe()) is not None:
        eyes.see(observation)


def _watch_box(drone: SimulatedDrone) -> None:
    """Read of every frame the box that a tracker would read: around the ball, four diameters."""
    while (observation := drone.observe()) is not None:
        position, _ = drone.ball_in_camera(observation.frame_time)
        if position[2] > NEAREST:
            _read_box(drone.camera, observation.frame, position)


def _read_box(camera: Camera, frame: Frame, position: Float[ndarray, "3"]) -> None:
    x, y = project(camera, position)
    half = max(REGION_HALF_PX, 4.0 * camera.focal_length_px[0] * BALL_RADIUS / position[2])
    x0, x1 = (int(min(max(x + side * half, 0), frame.width)) for side in (-1, 1))
    y0, y1 = (int(min(max(y + side * half, 0), frame.height)) for side in (-1, 1))
    if x0 < x1 and y0 < y1:
        box = np.ascontiguousarray(frame.region(x0, y0, x1, y1))
        cv2.inRange(cv2.cvtColor(box, cv2.COLOR_BGR2HSV), (5, 100, 100), (25, 255, 255))
