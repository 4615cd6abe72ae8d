"""Frames, axes, units, array aliases, constants and errors that every part shares.

World: origin at the centre of the table's playing surface, x towards the opponent, y left,
z up (ROS REP-103). Body: x forward, y left, z up, origin at the centre of mass. Camera: X right,
Y down, Z depth (the paper's X, Y, Z). Inside the code everything is SI and radians; what leaves it
(flags, files, JSON) names its unit.
"""

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray

Vector3 = Float[ndarray, "*batch 3"]
Rotation = Float[ndarray, "*batch 3 3"]
Quaternion = Float[ndarray, "*batch 4"]  # (w, x, y, z), unit norm
Picture = UInt8[ndarray, "height width 3"]  # blue, green, red, as OpenCV keeps them

GRAVITY = 9.81  # m/s^2
LARGEST_SEED = 2**63 - 1
BALL_RADIUS = 0.020  # m, ITTF
BALL_DIAMETER = 2 * BALL_RADIUS  # the paper's h_world

TABLE_HALF_LENGTH = 1.37  # m along x, ITTF
TABLE_HALF_WIDTH = 0.7625  # m along y
TABLE_HEIGHT = 0.76  # m above the floor

CAMERA_FROM_BODY_AXES = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""The one axis map: right = -left, down = -up, depth = forward. `camera = M @ body`."""
CAMERA_FROM_BODY_AXES.setflags(write=False)


class RotorpongError(Exception):
    """Anything that rotorpong reports on purpose."""


class InputError(RotorpongError, ValueError):
    """Something from outside is not usable: says what was given, expected and available."""


class StoreError(RotorpongError):
    """An experience file is damaged, foreign or in the way."""


class UnsolvableServeError(RotorpongError):
    """No launch within the rules meets the target."""


def one_line(text: object) -> str:
    """Return a text, or what an error says, on one line."""
    return " ".join(str(text).split())


def require_seed(seed: int) -> None:
    """Raise InputError unless a generator can start from `seed`."""
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed {seed}: expected a whole number from 0 to {LARGEST_SEED}")
