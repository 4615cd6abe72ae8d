"""What a trial meets under `--randomize`: a drone, a ball, a camera and a room of its own.

Everything is drawn from the range in which the real thing is known to lie, evenly. The player knows
only the nominal: its eyes are told the camera as it should be, and nobody tells it the rest. All of
it comes from one generator of the trial, which each part of the world splits off its own, so that
a part that draws more does not change the others.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from rotorpong.conventions import InputError
from rotorpong.physics.ball import Air, Surface
from rotorpong.physics.camera import Camera
from rotorpong.physics.camera import draw_camera as draw_sensor
from rotorpong.physics.constants import Range, drawn
from rotorpong.physics.vehicle import Vehicle
from rotorpong.world.looks import BallColour, draw_looks
from rotorpong.world.serves import PLAIN_MEDIUM, Medium
from rotorpong.world.simulated_drone import Setting

AIR_RANGES: Mapping[str, Range] = {
    "drag": (0.11, 0.17),  # 1/m, real flights and the textbook
    "magnus": (0.005, 0.012),  # textbook's lift, and twice it; 0.0078 and 0.0090 are measured
    "saturation": (3.0, 6.5),  # at these, matches want a magnus of 0.006-0.012: docs/validation.md
}
TABLE_RANGES: Mapping[str, Range] = {
    "restitution": (0.89, 0.96),  # matches as given, ITTF's drop in air: docs/validation.md
    "friction": (0.15, 0.35),  # about that of real matches; the width is assumed
}
FOCAL_ERROR = 0.015  # relative, +-: two published calibrations of the AR.Drone differ by 1.4 %
CENTER_ERROR = 0.00625  # of the picture's width, +-: 4 px of 640; assumed
PLACE_ERROR = 0.005  # m, +-, each axis: a camera that is mounted with care
PITCH_ERROR_DEG = 0.5  # +-
DELAY_FACTOR: Range = (0.8, 1.2)  # of what the profile says, which is drawn per serve as well


@runtime_checkable
class Randomizable(Protocol):
    """A vehicle that knows how far others of its kind may differ from it."""

    def randomized(self, rng: np.random.Generator) -> Vehicle:
        """Return another of its kind, constants and sensor noise drawn from their ranges."""
        ...


def draw_trial(
    setting: Setting, rng: np.random.Generator, *, ball: BallColour = "orange"
) -> tuple[Setting, Callable[[], Medium]]:
    """Return what one trial really meets, and what draws its ball.

    A slow ball on a dead table cannot be thrown at every target; then the next is taken.

    Args:
        setting: the nominal.
        rng: the trial's generator of the world.
        ball: its colour.

    Raises:
        InputError: the vehicle cannot be drawn.
    """
    vehicle_rng, ball_rng, camera_rng, looks_rng = rng.spawn(4)
    drawn_setting = replace(
        setting,
        vehicle=require_randomizable(setting.vehicle).randomized(vehicle_rng),
        camera=draw_camera(setting.camera, camera_rng),
        scene=draw_looks(looks_rng, ball=ball),  # eyes know the colour
    )
    return drawn_setting, lambda: draw_medium(ball_rng)


def draw_medium(rng: np.random.Generator) -> Medium:
    """Return a ball's air and table, drawn."""
    air: Air = drawn(PLAIN_MEDIUM.air, AIR_RANGES, rng)
    table: Surface = drawn(PLAIN_MEDIUM.table, TABLE_RANGES, rng)
    return Medium(air, table)


def draw_camera(camera: Camera, rng: np.random.Generator) -> Camera:
    """Return a camera that is nearly the nominal one: lens, place, delay, and its sensor."""
    focal = 1.0 + rng.uniform(-FOCAL_ERROR, FOCAL_ERROR)
    shift_x, shift_y = rng.uniform(-CENTER_ERROR, CENTER_ERROR, 2) * camera.width_px
    x, y, z = np.array(camera.position_m) + rng.uniform(-PLACE_ERROR, PLACE_ERROR, 3)
    pitch = camera.camera_pitch_deg + rng.uniform(-PITCH_ERROR_DEG, PITCH_ERROR_DEG)
    later = rng.uniform(*DELAY_FACTOR)
    nearly = replace(
        camera,
        focal_length_px=(camera.focal_length_px[0] * focal, camera.focal_length_px[1] * focal),
        center_px=(camera.center_px[0] + float(shift_x), camera.center_px[1] + float(shift_y)),
        position_m=(float(x), float(y), float(z)),
        camera_pitch_deg=pitch,
        delay_s=(camera.delay_s[0] * later, camera.delay_s[1] * later),
    )
    return draw_sensor(nearly, rng)


def require_randomizable(vehicle: Vehicle) -> Randomizable:
    """Return the vehicle if others of its kind can be drawn.

    Raises:
        InputError: it has no `randomized`.
    """
    if not isinstance(vehicle, Randomizable):
        raise InputError(
            f"--randomize with vehicle {vehicle.name!r}: expected one with randomized(rng), which "
            "returns another of its kind"
        )
    return vehicle
