"""The camera as an equation: pinhole with Brown-Conrady distortion, as OpenCV defines it.

    a = X/Z, b = Y/Z, r^2 = a^2 + b^2, q = 1 + k1 r^2 + k2 r^4 + k3 r^6
    x = fx (a q + 2 p1 a b + p2 (r^2 + 2 a^2)) + cx                        Eq. (2a)
    y = fy (b q + p1 (r^2 + 2 b^2) + 2 p2 a b) + cy                        Eq. (2b)

Camera frame: X right, Y down, Z depth. Pixel centres have whole coordinates, (0, 0) is the middle
of the upper left pixel.

The shutter rolls: row y of h is exposed around

    t(y) = frame_time + ((y + 1/2) / h - 1/2) readout                      Eq. (row)
"""

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError, Rotation, Vector3

Pixels = Float[ndarray, "*batch 2"]
Directions = Float[ndarray, "*batch 2"]  # X/Z, Y/Z: a ray of unit depth
Values = Float[ndarray, "*batch"] | float  # a scalar where there is no batch

NO_DISTORTION = (0.0, 0.0, 0.0, 0.0, 0.0)
UNDISTORTION_STEPS = 20
UNDISTORTION_TOLERANCE = 1e-12
LONGEST_DELAY = 10.0  # s
LENS_SAMPLES = 33  # in each direction, at which a lens is tried
ROUND_TRIP_PX = 1e-6


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
    readout_s: float = 0.0  # from the first row's exposure to one past the last's; 0: all at once
    exposure_s: float = 0.0  # of each row
    blur_px: float = 0.0  # sd of lens and demosaicing, cut off beyond the next pixel
    shot_noise: float = 0.0  # variance per level of linear light (0 .. 255)
    read_noise: float = 0.0  # sd, levels of linear light
    gamma: float = 1.0  # level = 255 (light / 255)^(1 / gamma)
    jitter_s: float = 0.0  # most that a frame arrives later than delay_s says, drawn per frame
    drop_share: float = 0.0  # of frames that never arrive
    stream_mbit_s: float = 0.0  # of H.264 that frames travel as; 0: as they are

    @property
    def is_ideal(self) -> bool:
        """Whether frames are taken at an instant, without blur, noise or response."""
        shutter = self.readout_s, self.exposure_s
        return not any((*shutter, self.blur_px, self.shot_noise, self.read_noise, self.gamma - 1.0))


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
    readout_s=0.022,
    exposure_s=0.006,
    blur_px=0.6,
    shot_noise=0.14,
    read_noise=0.4,
    gamma=2.2,
    jitter_s=0.008,
    drop_share=0.01,
)
"""AR.Drone 2.0 live at 720p: tum's 640x360 calibration (ost.ini) times two.

Its rolling shutter is known, its readout time is not: 15 to 30 ms are said. Exposure, blur, noise,
jitter and drops are decisions: a bright hall, 3 levels of noise at middle grey as vision's
measurements had it, a full well of 1,800 electrons; the response is that of every video camera.
"""

ARDRONE2_360P = replace(
    ARDRONE2_720P,
    name="ardrone2_360p",
    width_px=640,
    height_px=360,
    focal_length_px=(561.999, 561.783),
    center_px=(307.434, 190.144),
    distortion=(-0.50758, 0.24911, 0.000579, 0.000996, 0.0),
    blur_px=0.5,
    shot_noise=0.07,  # four pixels of the chip each, less what the encoder costs
    read_noise=0.3,
)
"""AR.Drone 2.0's default stream: tum's calibration (ost.ini) as it is."""

CAMERAS = {camera.name: camera for camera in (GAZEBO, ARDRONE2_360P, ARDRONE2_720P)}

CAMERA_RANGES = {  # what is not known of the AR.Drone's camera: least, most
    "readout_s": (0.015, 0.030),
    "exposure_s": (0.002, 0.012),
    "blur_px": (0.4, 0.8),
    "shot_noise": (0.05, 0.30),
    "read_noise": (0.2, 1.0),
    "gamma": (1.8, 2.4),
    "jitter_s": (0.0, 0.015),
    "drop_share": (0.0, 0.03),
}

LEAST_AND_MOST = {  # beyond them a camera is none
    "frames_per_second": (1.0, 1000.0),
    "camera_pitch_deg": (-90.0, 90.0),
    "readout_s": (0.0, 0.1),
    "exposure_s": (0.0, 0.1),
    "blur_px": (0.0, 2.0),
    "shot_noise": (0.0, 100.0),
    "read_noise": (0.0, 100.0),
    "gamma": (0.2, 5.0),
    "jitter_s": (0.0, 1.0),
    "drop_share": (0.0, 0.9),
    "stream_mbit_s": (0.0, 100.0),
}


def require_camera(camera: Camera) -> Camera:
    """Return the camera if it can be.

    Raises:
        InputError: a constant is not finite or beyond what any camera has.
    """
    for name, (least, most) in LEAST_AND_MOST.items():
        value = getattr(camera, name)
        if not least <= value <= most:
            raise InputError(
                f"camera {camera.name!r}: {name} is {value}; expected {least:g} to {most:g}"
            )
    if camera.width_px < 2 or camera.height_px < 2:
        raise InputError(
            f"camera {camera.name!r}: a picture of {camera.width_px} x {camera.height_px} pixels; "
            "expected at least 2 x 2"
        )
    low, high = camera.delay_s
    if not 0.0 <= low <= high <= LONGEST_DELAY:
        raise InputError(
            f"camera {camera.name!r}: delay_s is {camera.delay_s}; expected least and most, "
            f"0 to {LONGEST_DELAY:g}"
        )
    numbers = (*camera.focal_length_px, *camera.center_px, *camera.distortion, *camera.position_m)
    if not np.all(np.isfinite(numbers)) or min(camera.focal_length_px) <= 0.0:
        raise InputError(
            f"camera {camera.name!r}: focal length {camera.focal_length_px}, centre "
            f"{camera.center_px}, distortion {camera.distortion}, place {camera.position_m}; "
            "expected finite numbers and a focal length above 0"
        )
    require_lens(camera)
    return camera


@functools.lru_cache(maxsize=8)
def require_lens(camera: Camera) -> None:
    """Refuse a distortion that folds back inside the picture: undone and redone, it comes back.

    Raises:
        InputError: some pixels have no ray of their own.
    """
    across = np.linspace(0.0, camera.width_px - 1.0, LENS_SAMPLES)
    down = np.linspace(0.0, camera.height_px - 1.0, LENS_SAMPLES)
    pixels = np.stack(np.meshgrid(across, down), axis=-1)
    with np.errstate(all="ignore"):
        rays = directions(camera, pixels)
        again = project(camera, np.concatenate([rays, np.ones_like(rays[..., :1])], axis=-1))
        error = np.max(np.abs(again - pixels))
    if not error < ROUND_TRIP_PX:
        raise InputError(
            f"distortion {camera.distortion} folds back inside the picture: it cannot be undone"
        )


def draw_camera(camera: Camera, rng: np.random.Generator) -> Camera:
    """Return the camera with everything that is not known of its kind drawn from its range.

    What the camera has not got (0, or gamma 1) it does not get.
    """
    drawn = {name: rng.uniform(*limits) for name, limits in CAMERA_RANGES.items()}
    absent = {"gamma": 1.0}
    had = {n: v for n, v in drawn.items() if getattr(camera, n) != absent.get(n, 0.0)}
    return replace(camera, **had)


def ideal(camera: Camera) -> Camera:
    """Return the same lens at the same place with an ideal shutter and sensor; delay is kept."""
    nothing = dict.fromkeys(CAMERA_RANGES, 0.0) | {"gamma": 1.0, "stream_mbit_s": 0.0}
    return replace(camera, **nothing)


def row_time(
    camera: Camera, frame_time: float, rows: Float[ndarray, "*batch"]
) -> Float[ndarray, "*batch"]:
    """Return when rows were exposed (middle, s), by Eq. (row); rows may be between pixels."""
    return np.asarray(frame_time + ((rows + 0.5) / camera.height_px - 0.5) * camera.readout_s)


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
    a, b = guess[..., 0], guess[..., 1]  # views: what is subtracted from them is from the guess
    for _ in range(UNDISTORTION_STEPS):
        u, v = _newton_step(camera, a, b, distorted)
        a -= u
        b -= v
        if max(_largest(u), _largest(v)) < UNDISTORTION_TOLERANCE:
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
    """Return the steepest X/Z and Y/Z of the picture; beyond them the lens model folds back.

    They lie on its border: a lens that can be undone turns no inner pixel into an extreme.
    """
    columns, rows = np.arange(camera.width_px), np.arange(camera.height_px)
    sides = [(columns, 0), (columns, rows[-1]), (0, rows), (columns[-1], rows)]
    border = np.concatenate([np.stack(np.broadcast_arrays(*side), axis=-1) for side in sides])
    return np.abs(directions(camera, border.astype(float))).max(axis=0)


def camera_from_body(camera: Camera) -> Rotation:
    """Return the rotation from body axes to camera axes, tilted up by the camera's pitch."""
    pitch = math.radians(camera.camera_pitch_deg)
    c, s = math.cos(pitch), math.sin(pitch)
    tilt = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
    return tilt @ CAMERA_FROM_BODY_AXES


def _distort(camera: Camera, rays: Directions) -> Directions:
    a, b = rays[..., 0], rays[..., 1]
    r2 = a * a + b * b
    return np.stack(_bent(camera, a, b, r2, _stretch(camera, r2)), axis=-1)


def _stretch(camera: Camera, r2: Values) -> Values:
    """Return q of Eq. (2)."""
    k1, k2, _, _, k3 = camera.distortion
    return 1 + r2 * (k1 + r2 * (k2 + r2 * k3))


def _bent(camera: Camera, a: Values, b: Values, r2: Values, q: Values) -> tuple[Values, Values]:
    """Return x and y of Eq. (2) but for focal length and centre."""
    _, _, p1, p2, _ = camera.distortion
    x = a * q + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)
    y = b * q + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b
    return x, y


def _newton_step(camera: Camera, a: Values, b: Values, wanted: Directions) -> tuple[Values, Values]:
    k1, k2, p1, p2, k3 = camera.distortion
    r2 = a * a + b * b
    q = _stretch(camera, r2)
    slope = 2 * (k1 + r2 * (2 * k2 + 3 * k3 * r2))
    xx = q + slope * a * a + 2 * p1 * b + 6 * p2 * a
    xy = slope * a * b + 2 * p1 * a + 2 * p2 * b
    yy = q + slope * b * b + 6 * p1 * b + 2 * p2 * a
    x, y = _bent(camera, a, b, r2, q)
    x, y = x - wanted[..., 0], y - wanted[..., 1]
    determinant = xx * yy - xy * xy
    return (yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant


def _largest(values: Values) -> float:
    return float(np.max(np.abs(values), initial=0.0))
