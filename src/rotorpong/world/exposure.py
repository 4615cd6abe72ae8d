"""A frame as a real camera takes it: while it is exposed, things move; then lens, chip, response.

    row y is exposed at  t(y) = frame_time + ((y + 1/2) / height - 1/2) readout  +- exposure / 2
    light = mean over the exposure, 8 instants                     the ball only
    picture = 255 (s / 255)^(1 / gamma), s = PSF * light + noise   `_sensor_kernels`

frame_time is the middle of the exposure of the middle of the picture (physics/camera.row_time). The
pose of every row is that at its own time: a rolling shutter. What blurs over the exposure is the
ball, as the camera sees it from where it moves itself; the court is sharp, each row as it lies in
the middle of its exposure. Light is linear from the scene to the response: a scene's colours are
what an ideal picture would show, so they are decoded by the camera's gamma first.

Noise is a fixed sequence of 65,536 normal numbers that every row of every colour enters at a place
drawn from the frame's key: the same key, the same noise, whichever part of the frame is asked for.
"""

import functools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.physics.camera import Camera, require_camera
from rotorpong.world._moment_kernels import Shutter
from rotorpong.world._sensor_kernels import (
    FINENESS,
    LEVELS,
    NORMALS,
    Sensor,
)
from rotorpong.world.render import (
    Region,
    Scene,
    check_pose,
    lens_at_door,
    paint_of,
    region_at_door,
    shutter_of,
    take,
)

INSTANTS = 8  # of the ball in an exposure
SEED_OF_NORMALS = 20


@dataclass(frozen=True, slots=True)
class Motion:
    """Where camera and ball are while a frame is exposed, at even times; world frame.

    Between the times they move evenly, before the first and after the last they rest.
    """

    start: float  # s, time of the first row
    step: float  # s, from row to row
    positions: Float[ndarray, "n 3"]  # m, of the camera
    rotations: Float[ndarray, "n 3 3"]  # world from camera
    balls: Float[ndarray, "n 3"]  # m


def expose(
    camera: Camera,
    motion: Motion,
    frame_time: float,
    scene: Scene,
    *,
    key: tuple[int, ...],
    region: Region | None = None,
) -> Picture:
    """Return the frame that the camera takes with its middle at `frame_time`.

    Args:
        camera: intrinsics, distortion, shutter and sensor.
        motion: camera and ball over the exposure.
        frame_time: middle of the exposure of the middle row, s, on the clock of `motion`.
        scene: colours, light, opponent.
        key: whole numbers that the frame's noise is drawn from; the same, the same noise.
        region: box (x0, y0, x1, y1) to expose, the same pixels as in the whole picture.

    Raises:
        InputError: the motion is not finite, empty or no motion of a camera; the camera cannot
            be; the region is empty or reaches out of the picture.
    """
    require_camera(camera)
    lens = lens_at_door(camera)
    box = region_at_door(camera, region)
    shutter = _shutter(camera, motion, frame_time)
    exposed = shutter, INSTANTS if camera.exposure_s > 0.0 else 1
    return take(lens, box, exposed, paint_of(scene, camera.gamma), _sensor(camera, key))


def _shutter(camera: Camera, motion: Motion, frame_time: float) -> Shutter:
    n = len(motion.positions)
    if n == 0 or not (len(motion.rotations) == len(motion.balls) == n and motion.step > 0.0):
        raise InputError(
            f"a motion of {n} positions, {len(motion.rotations)} rotations, {len(motion.balls)} "
            f"balls every {motion.step} s: expected as many of each, 1 or more, in time's order"
        )
    if not np.isfinite(frame_time + motion.start):
        raise InputError(f"frame time {frame_time}, motion from {motion.start}: expected finite")
    for rotation in (motion.rotations[0], motion.rotations[-1]):
        check_pose(motion.positions[0], rotation, motion.balls[0])
    track = np.concatenate([motion.positions, motion.rotations.reshape(n, 9), motion.balls], axis=1)
    if not np.all(np.isfinite(track)):
        raise InputError("a motion holds numbers that are not finite")
    first = frame_time + (0.5 / camera.height_px - 0.5) * camera.readout_s - motion.start
    return shutter_of(
        np.ascontiguousarray(track, dtype=np.float64),
        first / motion.step,
        camera.readout_s / camera.height_px / motion.step,
        camera.exposure_s / motion.step,
    )


def _sensor(camera: Camera, key: tuple[int, ...]) -> Sensor:
    """Return the kernel's record of the sensor.

    The weight of the 3 x 3 blur is that of a Gauss of blur_px, cut off at one pixel: w / (1 + 2 w).
    """
    weight = np.exp(-0.5 / camera.blur_px**2) if camera.blur_px > 0.0 else 0.0
    starts = np.random.default_rng(key).integers(0, NORMALS, (camera.height_px, 3))
    return Sensor(
        np.float32(weight / (1.0 + 2.0 * weight)),
        np.float32(camera.shot_noise),
        np.float32(camera.read_noise**2),
        starts,
        _normals(camera.width_px),
        _response(camera.gamma),
    )


@functools.lru_cache(maxsize=8)
def _normals(more: int) -> Float32[ndarray, "n"]:
    """Return the fixed sequence, and so much of its beginning again."""
    normals = np.random.default_rng(SEED_OF_NORMALS).standard_normal(NORMALS).astype(np.float32)
    return np.resize(normals, NORMALS + more)


@functools.lru_cache(maxsize=8)
def _response(gamma: float) -> UInt8[ndarray, "levels"]:
    light = np.minimum(np.arange(LEVELS) / float(FINENESS) / 255.0, 1.0)
    return np.rint(255.0 * light ** (1.0 / gamma)).astype(np.uint8)
