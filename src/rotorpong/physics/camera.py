"""The camera as an equation: pinhole with Brown-Conrady distortion, as OpenCV defines it.

    a = X/Z, b = Y/Z, r^2 = a^2 + b^2, q = 1 + k1 r^2 + k2 r^4 + k3 r^6
    x = fx (a q + 2 p1 a b + p2 (r^2 + 2 a^2)) + cx                        Eq. (2a)
    y = fy (b q + p1 (r^2 + 2 b^2) + 2 p2 a b) + cy                        Eq. (2b)

Camera frame: X right, Y down, Z depth. Pixel centres have whole coordinates, (0, 0) is the middle
of the upper left pixel.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.conventions import CAMERA_FROM_BODY_AXES, Rotation, Vector3

Pixels = Float[ndarray, "*batch 2"]
Directions = Float[ndarray, "*batch 2"]  # X/Z, Y/Z: a ray of unit depth

NO_DISTORTION = (0.0, 0.0, 0.0, 0.0, 0.0)
UNDISTORTION_STEPS = 20
UNDISTORTION_TOLERANCE = 1e-12


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera and how it sits on the body."""

    name: str
    width_px: int
    height_px: int
    focal_length_px: tuple[float, float]  # fx, fy: the paper's f/m
    center_px: tuple[float, float]  # cx, cy
    distortion: tuple[float, float, float, float, float] = NO_DISTORTION  # k1 k2 p1 p2 k3
    frames_per_second: float = 30.0
    delay_s: tuple[float, float] = (0.0, 0.0)  # from exposure to arrival, drawn once per serve
    position_m: tuple[float, float, float] = (0.21, 0.0, 0.01)  # in the body frame
    camera_pitch_deg: float = 0.0  # upwards


GAZEBO = Camera("gazebo", 640, 360, (374.7, 374.7), (320.5, 180.5))
"""tum_simulator's front camera: hfov 81 degrees, ideal. 30 frames/s here, 60 there."""

ARDRONE2_720P = Camera(
    "ardrone2_720p",
    1280,
    720,
    (1124.0, 1123.6),
    (614.9, 380.3),
    distortion=(-0.50758, 0.24911, 0.000579, 0.000996, 0.0),
    delay_s=(0.075, 0.130),
)
"""AR.Drone 2.0 live at 720p: tum's 640x360 calibration times two."""

CAMERAS = {camera.name: camera for camera in (GAZEBO, ARDRONE2_720P)}


def project(camera: Camera, points: Vector3) -> Pixels:
    """Return where points of the camera frame appear, in pixels; nan behind the camera."""
    depth = points[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        directions = points[..., :2] / np.where(depth > 0.0, depth, np.nan)[..., None]
    return _distort(camera, directions) * camera.focal_length_px + camera.center_px


def directions(camera: Camera, pixels: Pixels) -> Directions:
    """Return the undistorted (X/Z, Y/Z) of pixels, by Newton's method on Eq. (2)."""
    distorted = (pixels - np.array(camera.center_px)) / camera.focal_length_px
    if not any(camera.distortion):
        return distorted
    guess = np.array(distorted, dtype=float)
    for _ in range(UNDISTORTION_STEPS):
        step = _newton_step(camera, guess, distorted)
        guess -= step
        if np.max(np.abs(step), initial=0.0) < UNDISTORTION_TOLERANCE:
            break
    return guess


@functools.lru_cache(maxsize=8)
def pixel_directions(camera: Camera) -> Float[ndarray, "height width 2"]:
    """Return the undistorted (X/Z, Y/Z) of every pixel; computed once per camera, read-only."""
    columns, rows = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    table = directions(camera, np.stack([columns, rows], axis=-1).astype(float))
    table.setflags(write=False)
    return table


def in_picture(camera: Camera, points: Vector3) -> Bool[ndarray, "*batch"]:
    """Tell which points of the camera frame have their image inside the picture."""
    x, y = np.moveaxis(project(camera, points), -1, 0)
    inside = (x >= 0) & (x <= camera.width_px - 1) & (y >= 0) & (y <= camera.height_px - 1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rays = np.abs(points[..., :2] / points[..., 2:])
    return np.asarray(inside & np.all(rays <= _widest(camera), axis=-1))


@functools.lru_cache(maxsize=8)
def _widest(camera: Camera) -> Float[ndarray, "2"]:
    """Return the steepest X/Z and Y/Z of the picture; beyond them the lens model folds back."""
    return np.abs(pixel_directions(camera)).max(axis=(0, 1))


def camera_from_body(camera: Camera) -> Rotation:
    """Return the rotation from body axes to camera axes, tilted up by the camera's pitch."""
    pitch = math.radians(camera.camera_pitch_deg)
    c, s = math.cos(pitch), math.sin(pitch)
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    return tilt @ CAMERA_FROM_BODY_AXES


def _distort(camera: Camera, rays: Directions) -> Directions:
    k1, k2, p1, p2, k3 = camera.distortion
    a, b = rays[..., 0], rays[..., 1]
    r2 = a * a + b * b
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    x = a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)
    y = b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b
    return np.stack([x, y], axis=-1)


def _newton_step(camera: Camera, guess: Directions, wanted: Directions) -> Directions:
    k1, k2, p1, p2, k3 = camera.distortion
    a, b = guess[..., 0], guess[..., 1]
    r2 = a * a + b * b
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + 3 * k3 * r2))
    xx = radial + slope * a * a + 2 * p1 * b + 6 * p2 * a
    xy = slope * a * b + 2 * p1 * a + 2 * p2 * b
    yy = radial + slope * b * b + 6 * p1 * b + 2 * p2 * a
    error = _distort(camera, guess) - wanted
    determinant = xx * yy - xy * xy
    u = (yy * error[..., 0] - xy * error[..., 1]) / determinant
    v = (xx * error[..., 1] - xy * error[..., 0]) / determinant
    return np.stack([u, v], axis=-1)
