"""A court in perspective, drawn with flat lines: where points of the world appear to an onlooker.

The onlooker stands at `EYE`, looks at `TARGET` and holds the head upright:

    forward = (target - eye) / |target - eye|,  right = forward x up,  above = right x forward
    (h, v) = ((p - eye) . right, (p - eye) . above) / ((p - eye) . forward)

World frame, metres; any leading batch shape.
"""

import math

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from numpy import ndarray

from rotorpong.conventions import Vector3
from rotorpong.lab.report.ink import ink
from rotorpong.world.court import (
    FLOOR_HEIGHT,
    LEG_X,
    LEG_Y,
    NET_HALF_LENGTH,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rotorpong.world.racket import HULL, Racket

EYE = np.array([-3.6, -4.4, 1.9])
TARGET = np.array([0.0, 0.0, 0.0])
UP = np.array([0.0, 0.0, 1.0])
CORNERS = 48  # of a drawn disc


def seen(points: Vector3) -> Float[ndarray, "*batch 2"]:
    """Return where points appear: right and up, as tangents of angles."""
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, UP)
    right /= np.linalg.norm(right)
    apart = points - EYE
    across = np.stack([apart @ right, apart @ np.cross(right, forward)], axis=-1)
    return across / (apart @ forward)[..., None]


def draw_court(axes: Axes) -> None:
    """Draw table, net and the table's shadow on the floor."""
    x, y, net = TABLE_HALF_LENGTH, TABLE_HALF_WIDTH, NET_HALF_LENGTH
    corners = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    _face(axes, corners + FLOOR_HEIGHT * UP, "quiet", 0.13)
    for foot in np.array([(a, b, FLOOR_HEIGHT) for a in (-LEG_X, LEG_X) for b in (-LEG_Y, LEG_Y)]):
        draw_path(axes, np.stack([foot, foot * [1.0, 1.0, 0.0]]), "quiet", 2.0)
    _face(axes, corners, "table", 0.30, outlined=True)
    draw_path(axes, np.array([(-x, 0.0, 0.0), (x, 0.0, 0.0)]), "quiet", 0.6)
    low, high = (0.0, -net, 0.0), (0.0, -net, NET_HEIGHT)
    far = [(0.0, net, NET_HEIGHT), (0.0, net, 0.0)]
    _face(axes, np.array([low, high, *far]), "ink", 0.14, outlined=True)


def draw_drone(axes: Axes, body: Vector3, strength: float) -> None:
    """Draw hull and blade of a level drone whose centre of mass is at `body`."""
    angles = np.linspace(0.0, math.tau, CORNERS, endpoint=False)
    c, s, zero = np.cos(angles), np.sin(angles), np.zeros(CORNERS)
    racket = Racket()
    _face(axes, body + HULL.radius * np.stack([c, s, zero], 1), "quiet", 0.45 * strength)
    blade = np.stack([zero, racket.half_width * c, racket.half_height * s], axis=1)
    _face(axes, body + np.array([racket.x, racket.y, racket.z]) + blade, "blade", 0.8 * strength)


def draw_path(axes: Axes, path: Float[ndarray, "n 3"], role: str, width: float) -> None:
    """Draw a line through points."""
    axes.plot(*seen(path).T, color=ink(role), linewidth=width, solid_capstyle="round")


def draw_shadow(axes: Axes, path: Float[ndarray, "n 3"]) -> None:
    """Draw the line on the table that lies below a path."""
    inside = (np.abs(path[:, 0]) < TABLE_HALF_LENGTH) & (np.abs(path[:, 1]) < TABLE_HALF_WIDTH)
    below = path[inside] * [1.0, 1.0, 0.0]
    axes.plot(*seen(below).T, color=ink("ink"), alpha=0.35, linewidth=1.2)


def _face(
    axes: Axes, corners: Float[ndarray, "n 3"], role: str, alpha: float, *, outlined: bool = False
) -> None:
    flat = seen(corners)
    axes.fill(*flat.T, color=ink(role), alpha=alpha, linewidth=0)
    if outlined:
        closed = np.concatenate([flat, flat[:1]])
        axes.plot(*closed.T, color=ink("quiet"), linewidth=0.9)
