"""What somebody beside the table sees: our own ray caster's court, with the drone drawn into it.

The renderer knows court, opponent and ball. The drone is drawn on top of its picture, the farthest
face first, three times finer than the picture; a ball that is nearer than the blade is put back in
front of it by its coverage. World frame, metres.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from rotorpong.conventions import Picture, Vector3
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.lab.report.model import Face, drone_faces
from rotorpong.physics.camera import Camera, project
from rotorpong.world.court import FLOOR_HEIGHT, TABLE_HALF_LENGTH
from rotorpong.world.racket import HULL, Racket
from rotorpong.world.render import Scene, ball_coverage, render

WIDTH, HEIGHT = 640, 360
FOCAL = 470.0  # px: a horizontal view of 69 degrees
EYE = np.array([-2.2, -2.75, 0.75])  # where a blade hides no ball that it touches
TARGET = np.array([-0.42, 0.0, 0.2])
ONLOOKER = Camera("onlooker", WIDTH, HEIGHT, (FOCAL, FOCAL), (WIDTH / 2 - 0.5, HEIGHT / 2 - 0.5))
FINER = 3
LIGHT = np.array([-0.25, -0.45, 0.86])  # towards the lamps, unit length
DIMMEST = 0.50  # share of its colour that a face shows in the shade
SHADOW = 0.45  # share of the light that the drone keeps from what lies below
TRAIL_COLOUR = (60, 170, 255)
SUBPIXELS = 4  # binary digits behind the point in which OpenCV draws


@dataclass(frozen=True, slots=True)
class Instant:
    """What there is to see at one time."""

    ball: Float[ndarray, "3"]
    body: Float[ndarray, "3"]
    attitude: Float[ndarray, "4"]  # quaternion, body to world
    trail: Float[ndarray, "n 3"]  # where the ball was, oldest first


def gaze(eye: Float[ndarray, "3"], target: Float[ndarray, "3"]) -> Float[ndarray, "3 3"]:
    """Return world_from_camera of an upright camera at `eye` that looks at `target`."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.ascontiguousarray(np.stack([right, np.cross(forward, right), forward], axis=1))


AXES = gaze(EYE, TARGET)


def picture_of(instant: Instant, racket: Racket, scene: Scene) -> Picture:
    """Return the onlooker's picture."""
    court = render(ONLOOKER, EYE, AXES, instant.ball, scene)
    drawn = _trailed(_shadowed(court, instant), instant.trail)
    share = ball_coverage(ONLOOKER, EYE, AXES, instant.ball)[..., None]
    drawn = _mixed(share, court, drawn)
    rotation = rotation_from_quaternion(instant.attitude)
    drawn = _with_drone(drawn, drone_faces(racket), rotation, instant.body)
    blade = instant.body + rotation @ np.array([racket.x, racket.y, racket.z])
    if _depth(instant.ball) < _depth(blade):
        drawn = _mixed(share, court, drawn)
    return drawn


def seen_at(points: Vector3) -> Float[ndarray, "*batch 2"]:
    """Return where points of the world appear in the onlooker's picture, px."""
    return project(ONLOOKER, (points - EYE) @ AXES)


def _mixed(share: ndarray, one: Picture, other: Picture) -> Picture:
    return np.rint(share * one + (1.0 - share) * other).astype(np.uint8)


def _depth(points: Vector3) -> ndarray:
    return np.asarray((points - EYE) @ AXES[:, 2])


def _shadowed(picture: Picture, instant: Instant) -> Picture:
    """Darken the floor or the table below the drone."""
    angles = np.linspace(0.0, math.tau, 40)
    x = instant.body[0] + HULL.radius * np.cos(angles)
    y = instant.body[1] + HULL.radius * np.sin(angles)
    table, floor = np.maximum(x, -TABLE_HALF_LENGTH), np.minimum(x, -TABLE_HALF_LENGTH)
    mask = np.zeros(picture.shape[:2], np.uint8)
    for across, height in ((table, 0.0), (floor, FLOOR_HEIGHT)):
        if np.ptp(across) > 0.0:
            corners = seen_at(np.stack([across, y, np.full_like(y, height)], axis=1))
            cv2.fillPoly(mask, [_fine(corners)], 255, cv2.LINE_AA, SUBPIXELS)
    share = cv2.GaussianBlur(mask, (0, 0), 2.5)[..., None] / 255.0
    return (picture * (1.0 - SHADOW * share)).astype(np.uint8)


def _trailed(picture: Picture, trail: Float[ndarray, "n 3"]) -> Picture:
    """Draw where the ball was, the fainter the longer ago."""
    mask = np.zeros(picture.shape[:2], np.uint8)
    corners, count = _fine(seen_at(trail)), len(trail)
    for i in range(count - 1):
        strength = (i + 1) / count
        start, end = (tuple(int(v) for v in corners[k]) for k in (i, i + 1))
        shade = round(235 * strength**1.3)
        cv2.line(mask, start, end, shade, 1 + round(2 * strength), cv2.LINE_AA, SUBPIXELS)
    share = mask[..., None] / 255.0
    return ((1.0 - share) * picture + share * np.array(TRAIL_COLOUR)).astype(np.uint8)


def _fine(corners: Float[ndarray, "n 2"]) -> ndarray:
    return np.rint(corners * (1 << SUBPIXELS)).astype(np.int32)


def _with_drone(
    picture: Picture,
    faces: Sequence[Face],
    rotation: Float[ndarray, "3 3"],
    body: Float[ndarray, "3"],
) -> Picture:
    sizes = np.array([len(face.points) for face in faces])
    starts = np.cumsum(sizes) - sizes
    placed = np.concatenate([face.points for face in faces]) @ rotation.T + body
    corners = seen_at(placed)
    box = _box(corners, picture)
    if box is None:
        return picture
    x0, y0, x1, y1 = box
    part = picture[y0:y1, x0:x1]
    size = ((x1 - x0) * FINER, (y1 - y0) * FINER)
    canvas = cv2.resize(part, size, interpolation=cv2.INTER_CUBIC)
    flat = _fine((corners - (x0, y0) + 0.5) * FINER - 0.5)
    light = _light(placed, starts, sizes)
    depth = np.add.reduceat(_depth(placed), starts) / sizes
    for k in np.argsort(-depth):
        colour = tuple(round(float(light[k]) * value) for value in faces[k].colour)
        _fill(canvas, flat[starts[k] : starts[k] + sizes[k]], colour, faces[k].opacity)
    drawn = picture.copy()
    drawn[y0:y1, x0:x1] = cv2.resize(canvas, part.shape[1::-1], interpolation=cv2.INTER_AREA)
    return drawn


def _fill(canvas: ndarray, corners: ndarray, colour: tuple[int, ...], opacity: float) -> None:
    if opacity >= 1.0:
        cv2.fillConvexPoly(canvas, corners, colour, cv2.LINE_8, SUBPIXELS)
        return
    mask = np.zeros(canvas.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, corners, 1, cv2.LINE_8, SUBPIXELS)
    inside = mask.astype(bool)
    canvas[inside] = (1.0 - opacity) * canvas[inside] + opacity * np.array(colour)


def _light(
    points: Float[ndarray, "n 3"], starts: Int[ndarray, "faces"], sizes: Int[ndarray, "faces"]
) -> Float[ndarray, "faces"]:
    """Return which share of its colour each face shows on the side that is seen."""
    first, third = points[starts], sizes // 3
    normals = np.cross(points[starts + third] - first, points[starts + sizes - third] - first)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    towards = np.sign(np.sum(normals * (EYE - first), axis=1))
    return DIMMEST + (1.0 - DIMMEST) * np.maximum(towards * (normals @ LIGHT), 0.0)


def _box(corners: Float[ndarray, "n 2"], picture: Picture) -> tuple[int, int, int, int] | None:
    """Return the part of the picture that holds all corners; None if it holds none of them."""
    if not np.isfinite(corners).all():
        return None
    height, width = picture.shape[:2]
    x0, y0 = np.floor(corners.min(axis=0)).astype(int) - 1
    x1, y1 = np.ceil(corners.max(axis=0)).astype(int) + 2
    x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, width), min(y1, height)
    return (int(x0), int(y0), int(x1), int(y1)) if x0 < x1 and y0 < y1 else None
