"""What the onboard camera sees: a ray caster without OpenGL.

Every pixel casts the ray p(t) = o + t R (a, b, 1) with (a, b) from the camera's own table of
undistorted directions, so that lens distortion is exact and free. Planes (table, net, floor, walls)
answer with closed-form coverage of the pixel's footprint; the ball answers with
(d.c)^2 >= |d|^2 (|c|^2 - r^2) on 6 x 6 rays per pixel of its outline, which puts its centre within
0.02 px (4 x 4, the design's number, leave 0.025 px). Colours are blue, green, red sensor values and
mix linearly: noise, blur, shutter and gamma are those of `exposure`.

The vehicle itself is outside its camera's view. The opponent is a flat figure at x = 2.9 m, for
eyes on the near side of it. A ball that touches the camera's centre is not drawn.
"""

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Int32
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.physics.camera import Camera, pixel_directions
from rotorpong.world._moment_kernels import TRACK_COLUMNS, Moment, Shutter
from rotorpong.world._pixel_kernels import (
    BEYOND,
    COLOURS,
    FAR,
    LIMB_COLUMNS,
    TEXELS,
    TILE,
    TILE_SIZE,
    Paint,
)
from rotorpong.world._sensor_kernels import Lines, Sensor, take_rows
from rotorpong.world._sphere_kernels import SUMS_SIZE, cover_rows
from rotorpong.world._survey_kernels import LANES, PIECE, PLANES, SPANS, Lens, Scan

Colour = tuple[float, float, float]  # blue, green, red in 0 .. 255
Region = tuple[int, int, int, int]  # x0, y0, x1, y1 in pixels, the last two exclusive
Work = tuple[  # of a tile: its quantities, its places in the texture, sums over the ball
    Float32[ndarray, "size"], Int32[ndarray, "pixels"], Float[ndarray, "sums"]
]

IDEAL = Sensor(
    np.float32(0),
    np.float32(0),
    np.float32(0),
    np.zeros((0, 3), np.int64),
    np.zeros(0, np.float32),
    np.zeros(0, np.uint8),
)
ROTATION_TOLERANCE = 1e-6
TEXTURE_OCTAVE_DECAY = 1.2  # amplitude over spatial frequency


@dataclass(frozen=True, slots=True)
class Scene:
    """How the court looks; geometry is in `court`."""

    ball: Colour = (40, 128, 250)
    table: Colour = (150, 88, 34)
    line: Colour = (238, 238, 236)
    net: Colour = (52, 46, 42)
    steel: Colour = (72, 68, 66)
    floor: Colour = (142, 162, 176)
    seam: Colour = (104, 122, 134)
    wall: Colour = (206, 212, 212)
    wainscot: Colour = (132, 118, 92)
    window: Colour = (244, 228, 210)
    ceiling: Colour = (196, 200, 200)
    lamp: Colour = (255, 255, 255)
    shirt: Colour = (96, 104, 78)
    skin: Colour = (142, 160, 192)
    trousers: Colour = (70, 58, 52)
    hair: Colour = (44, 50, 60)
    shoe: Colour = (60, 60, 62)
    racket: Colour = (48, 44, 44)
    brightness: float = 1.0
    texture_contrast: float = 0.035  # standard deviation of relative brightness on the walls
    texture_seed: int = 0
    opponent: bool = True
    ball_shadow: float = 0.5  # on the table, share of the light


# y and z of both ends of a limb, radius at both ends (m), colour, brightness; far limbs first.
OPPONENT = (
    (-0.20, -0.70, -0.25, -0.735, 0.045, 0.035, "shoe", 1.0),
    (0.21, -0.70, 0.26, -0.735, 0.045, 0.035, "shoe", 1.0),
    (-0.17, -0.28, -0.20, -0.68, 0.068, 0.048, "trousers", 0.92),
    (0.18, -0.28, 0.21, -0.68, 0.068, 0.048, "trousers", 0.92),
    (-0.09, 0.12, -0.17, -0.28, 0.100, 0.072, "trousers", 1.0),
    (0.09, 0.12, 0.18, -0.28, 0.100, 0.072, "trousers", 1.0),
    (-0.035, 0.14, 0.035, 0.14, 0.125, 0.125, "trousers", 1.0),
    (0.0, 0.22, 0.0, 0.50, 0.145, 0.175, "shirt", 1.0),
    (-0.14, 0.56, 0.14, 0.56, 0.075, 0.075, "shirt", 1.0),
    (0.0, 0.60, 0.0, 0.70, 0.052, 0.050, "skin", 0.82),
    (0.0, 0.80, 0.0, 0.86, 0.088, 0.096, "hair", 1.0),
    (0.0, 0.755, 0.0, 0.82, 0.074, 0.088, "skin", 1.0),
    (-0.04, 0.905, 0.03, 0.912, 0.052, 0.056, "hair", 1.1),
    (0.20, 0.55, 0.33, 0.34, 0.070, 0.055, "shirt", 0.96),
    (0.335, 0.32, 0.27, 0.17, 0.044, 0.034, "skin", 1.0),
    (0.265, 0.15, 0.25, 0.11, 0.040, 0.036, "skin", 1.0),
    (-0.43, 0.06, -0.45, 0.02, 0.082, 0.082, "racket", 1.0),
    (-0.20, 0.55, -0.34, 0.36, 0.070, 0.055, "shirt", 0.96),
    (-0.345, 0.34, -0.38, 0.19, 0.044, 0.034, "skin", 1.0),
    (-0.385, 0.17, -0.40, 0.14, 0.038, 0.038, "skin", 1.0),
)


def render(
    camera: Camera,
    camera_position: Float[ndarray, "3"],
    world_from_camera: Float[ndarray, "3 3"],
    ball_position: Float[ndarray, "3"],
    scene: Scene,
    *,
    region: Region | None = None,
) -> Picture:
    """Return the camera's picture of court, opponent and ball.

    Args:
        camera: intrinsics and distortion.
        camera_position: m, world.
        world_from_camera: rotation that takes camera axes (right, down, depth) to the world.
        ball_position: centre of the ball, m, world.
        scene: colours, light, opponent.
        region: box (x0, y0, x1, y1) to render, the same pixels as in the whole picture; all if
            absent.

    Raises:
        InputError: a pose is not finite or no rotation, the camera is smaller than 2 x 2 pixels,
            or the region is empty or reaches out of the picture.
    """
    lens = lens_at_door(camera)
    check_pose(camera_position, world_from_camera, ball_position)
    box = region_at_door(camera, region)
    shutter = still(camera_position, world_from_camera, ball_position)
    return take(lens, box, (shutter, 1), paint_of(scene), IDEAL)


def ball_coverage(
    camera: Camera,
    camera_position: Float[ndarray, "3"],
    world_from_camera: Float[ndarray, "3 3"],
    ball_position: Float[ndarray, "3"],
    *,
    instants: int = 1,
) -> Float32[ndarray, "height width"]:
    """Return which share of each pixel the ball covers, as if nothing stood before it.

    Args:
        camera: intrinsics and distortion.
        camera_position: m, world.
        world_from_camera: rotation that takes camera axes to the world.
        ball_position: centre of the ball, m, world.
        instants: how often it is sampled, as in an exposure, with fewer rays each.

    Raises:
        InputError: as for `render`.
    """
    lens = lens_at_door(camera)
    check_pose(camera_position, world_from_camera, ball_position)
    coverage = np.zeros((camera.height_px, camera.width_px), np.float32)
    shutter = still(camera_position, world_from_camera, ball_position)
    cover_rows(coverage, lens, shutter, blank_moment(instants), blank_tile())
    return coverage


def take(
    lens: Lens, box: Region, exposed: tuple[Shutter, int], paint: Paint, sensor: Sensor
) -> Picture:
    """Return a box of the picture.

    Args:
        lens: of the camera.
        box: (x0, y0, x1, y1) in pixels.
        exposed: when, and at how many instants of an exposure the ball is looked at.
        paint: of the scene.
        sensor: what becomes of the light.
    """
    x0, y0, x1, y1 = box
    n = x1 - x0
    picture = np.empty((y1 - y0, 3 * n), np.uint8)
    scan = Scan(
        np.empty((lens.bounds.shape[1], 4 * LANES), np.float32),
        np.empty((PLANES, 4), np.float32),
        np.zeros((SPANS, 2), np.int64),
    )
    lines = Lines(
        np.zeros((3, n + 2), np.float32),
        np.zeros((9, n), np.float32),
        np.zeros((3, n), np.int32),
    )
    shutter, instants = exposed
    moment, work = blank_moment(instants), blank_tile()
    take_rows(picture, lens, (x0, y0), shutter, moment, scan, paint, work, sensor, lines)
    return picture.reshape(y1 - y0, n, 3)


def still(position: ndarray, rotation: ndarray, ball: ndarray) -> Shutter:
    """Return a shutter before which nothing moves."""
    row = np.concatenate([position, rotation.ravel(), ball]).astype(np.float64)
    return shutter_of(row.reshape(1, TRACK_COLUMNS), 0.0, 0.0, 0.0)


def shutter_of(
    track: Float[ndarray, "n columns"], first: float, each: float, window: float
) -> Shutter:
    """Return a shutter with room for the boxes around the ball, to be written."""
    return Shutter(track, np.empty((max(len(track) - 1, 1), 4), np.float32), first, each, window)


def blank_moment(instants: int) -> Moment:
    """Return the kernels' record of what a row sees, to be written."""
    pose, light = np.zeros(TRACK_COLUMNS), np.zeros(3)
    view, box = np.zeros((4, 3), np.float32), np.zeros(4, np.float32)
    return Moment(pose, view, np.zeros((instants, 3)), light, box)


def blank_tile() -> Work:
    """Return the kernels' room for a tile, without bounds in depth: see `Work`."""
    tile = np.zeros(TILE_SIZE, np.float32)
    tile[BEYOND : BEYOND + TILE] = FAR
    return tile, np.zeros(TILE, np.int32), np.empty(SUMS_SIZE)


def lens_at_door(camera: Camera) -> Lens:
    """Return the directions of all pixels, once it is sure that the camera has pixels."""
    if camera.width_px < 2 or camera.height_px < 2:
        raise InputError(
            f"a picture of {camera.width_px} x {camera.height_px} pixels was asked for; "
            "a camera has at least 2 x 2"
        )
    return _lens(camera)


@functools.lru_cache(maxsize=8)
def _lens(camera: Camera) -> Lens:
    """Return X/Z, Y/Z and what a pixel spans of them, for every pixel, and bounds; read-only."""
    directions = pixel_directions(camera)
    (a_down, a_right), (b_down, b_right) = (
        np.gradient(directions[..., k], axis=(0, 1)) for k in range(2)
    )
    pitch = np.sqrt(np.abs(a_right * b_down - a_down * b_right))
    rays = np.stack([directions[..., 0], directions[..., 1], pitch]).astype(np.float32)
    bounds = _bounds(rays)
    for array in (rays, bounds):
        array.setflags(write=False)
    return Lens(rays, bounds)


def _bounds(rays: Float32[ndarray, "3 height width"]) -> Float32[ndarray, "height blocks lanes"]:
    """Return the least and most of X/Z and Y/Z and the widest pitch in every piece of every row.

    The last pixel of a row is repeated until the pieces fill the kernels' blocks.
    """
    _, height, width = rays.shape
    blocks = -(-width // (PIECE * LANES))
    columns = np.minimum(np.arange(blocks * PIECE * LANES), width - 1)
    pieces = rays[:, :, columns].reshape(3, height, blocks, LANES, PIECE)
    least, most = pieces.min(axis=4), pieces.max(axis=4)
    bounds = np.stack([least[0], most[0], least[1], most[1], most[2]], axis=2)
    return bounds.reshape(height, blocks, 5 * LANES)


@functools.lru_cache(maxsize=8)
def paint_of(scene: Scene, gamma: float = 1.0) -> Paint:
    """Return what the kernels need of a scene, in light that is linear for a camera of `gamma`."""
    colours = np.array([getattr(scene, name) for name in COLOURS], np.float32)
    if gamma != 1.0:
        colours = (255.0 * (colours / 255.0) ** gamma).astype(np.float32)
    texture = np.pad(_texture(scene.texture_seed), (0, 1), mode="wrap")
    return Paint(
        colours * np.float32(scene.brightness),
        texture.ravel() * np.float32(scene.texture_contrast),
        _figure() if scene.opponent else np.zeros((0, LIMB_COLUMNS), np.float32),
        np.float32(scene.ball_shadow),
    )


def _texture(seed: int) -> Float32[ndarray, "rows columns"]:
    """Return a seamless cloudy pattern of mean 0 and standard deviation 1."""
    noise = np.random.default_rng(seed).standard_normal((TEXELS, TEXELS))
    frequency = np.hypot(np.fft.fftfreq(TEXELS)[:, None], np.fft.rfftfreq(TEXELS)[None])
    frequency[0, 0] = np.inf  # mean 0
    pattern = np.fft.irfft2(np.fft.rfft2(noise) / frequency**TEXTURE_OCTAVE_DECAY)
    return (pattern / pattern.std()).astype(np.float32)


def _figure() -> Float32[ndarray, "limbs columns"]:
    """Return the opponent's limbs as the kernel reads them: start, run, radii, colour, box."""
    rows = []
    for y0, z0, y1, z1, r0, r1, colour, tone in OPPONENT:
        run = (y1 - y0, z1 - z0)
        inverse_square = 1.0 / max(run[0] ** 2 + run[1] ** 2, 1e-12)
        widest = max(r0, r1)
        box = ((y0 + y1) / 2, (z0 + z1) / 2, abs(run[0]) / 2 + widest, abs(run[1]) / 2 + widest)
        index = COLOURS.index(colour)
        rows.append((y0, z0, *run, inverse_square, r0, r1 - r0, index, tone, *box))
    return np.array(rows, np.float32)


def check_pose(position: ndarray, rotation: ndarray, ball: ndarray) -> None:
    """Raise InputError unless these are two points and a rotation."""
    for name, array, shape in (
        ("camera position", position, (3,)),
        ("rotation of the camera", rotation, (3, 3)),
        ("ball position", ball, (3,)),
    ):
        if array.shape != shape or not all(map(math.isfinite, array.ravel().tolist())):
            raise InputError(f"{name} is {array.tolist()}; expected finite numbers of {shape}")
    if not _is_rotation(*rotation.tolist()):
        raise InputError(f"{rotation.tolist()} is no rotation: its rows are not right-handed axes")


def _is_rotation(x: Sequence[float], y: Sequence[float], z: Sequence[float]) -> bool:
    """Tell whether rows are right-handed axes; in plain numbers, four times as fast."""
    ones, zeros = (_dot(x, x), _dot(y, y), _dot(z, z)), (_dot(x, y), _dot(y, z), _dot(z, x))
    errors = *(one - 1.0 for one in ones), *zeros
    normal = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
    return max(map(abs, errors)) <= ROTATION_TOLERANCE and _dot(normal, z) >= 0.0


def _dot(one: Sequence[float], other: Sequence[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def region_at_door(camera: Camera, region: Region | None) -> Region:
    """Return the region, the whole picture if there is none, or raise InputError."""
    width, height = camera.width_px, camera.height_px
    if region is None:
        return 0, 0, width, height
    x0, y0, x1, y1 = region
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise InputError(
            f"region {region} was given; expected x0 < x1, y0 < y1 within a picture of "
            f"{width} x {height} pixels"
        )
    return region
