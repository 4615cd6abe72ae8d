"""When the frames of a serve are exposed and when they arrive, in ticks of the world.

Frame k is exposed at phase + k periods and arrives a delay later, which is constant in a serve,
plus its own jitter, and not before it is exposed to its end. Lost frames are left out. One serve
and a batch of them take their frames from here.
"""

import math

import numpy as np
from jaxtyping import Int64
from numpy import ndarray

from rotorpong.physics.camera import Camera
from rotorpong.world.judging import LONGEST_SERVE
from rotorpong.world.solids import TICK

Ticks = Int64[ndarray, "frames"]


def most_frames(camera: Camera) -> int:
    """Return how many frames there are in the longest serve, and one more."""
    return math.ceil(LONGEST_SERVE * TICK * camera.frames_per_second) + 2


def schedule(
    camera: Camera, sensor_rng: np.random.Generator, camera_rng: np.random.Generator | None
) -> tuple[Ticks, Ticks]:
    """Return the ticks of exposure and arrival of all frames that are not lost.

    The last frame is exposed after the longest serve and never lost.

    Args:
        camera: the camera.
        sensor_rng: draws phase and delay.
        camera_rng: draws jitter and losses; None where the camera has neither.
    """
    period = 1.0 / (camera.frames_per_second * TICK)
    phase = sensor_rng.uniform(0.0, period)
    delay = round(sensor_rng.uniform(*camera.delay_s) / TICK)
    n = most_frames(camera)
    exposures = np.maximum(np.rint(phase + np.arange(n) * period), 1.0).astype(np.int64)
    late, kept = np.full(n, delay), np.ones(n, bool)
    if camera_rng is not None:
        lots, lateness = camera_rng.random((n, 2)).T
        late += np.rint(lateness * camera.jitter_s / TICK).astype(np.int64)
        kept = lots >= camera.drop_share
        kept[-1] = True
    arrivals = exposures + np.maximum(late, half_exposure(camera))
    return exposures[kept], arrivals[kept]


def is_regular(camera: Camera) -> bool:
    """Tell whether all frames arrive, each as late as the others."""
    return camera.jitter_s == 0.0 and camera.drop_share == 0.0


def half_exposure(camera: Camera) -> int:
    """Return the ticks from the middle of a frame to its very beginning or end, rounded up."""
    return math.ceil((camera.readout_s + camera.exposure_s) / 2 / TICK)
