"""A drone to look at: flat faces that stand where hull, rotors and blade of the simulation are.

The guard's ducts fill the hull that the ball can touch, the blade is the blade. Body frame, metres;
colours are blue, green, red.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.physics.ball import RUBBER
from rotorpong.world.racket import HULL, Racket

Colour = tuple[int, int, int]

CHARCOAL, FOAM, STEEL, GLASS = (62, 58, 56), (92, 86, 80), (150, 150, 150), (40, 30, 24)
TEAL, AIR_COLOUR = (150, 140, 40), (205, 205, 200)
CARDBOARD_COLOUR, CARDBOARD_BACK, RUBBER_COLOUR = (128, 178, 208), (108, 152, 180), (48, 42, 196)
DUCT = HULL.radius / (1 + math.sqrt(2)) - 0.001  # m: four ducts side by side fill the hull
ROTOR = DUCT - 0.012
ARM = DUCT  # m, of a rotor's axis along x and along y
CORNERS = 28  # of a circle


@dataclass(frozen=True, slots=True)
class Face:
    """A flat patch, seen from both sides."""

    points: Float[ndarray, "k 3"]
    colour: Colour
    opacity: float = 1.0


@functools.lru_cache(maxsize=4)
def drone_faces(racket: Racket) -> tuple[Face, ...]:
    """Return the faces of a drone that carries `racket`."""
    axes = [np.array([x * ARM, y * ARM, 0.0]) for x in (-1, 1) for y in (-1, 1)]
    faces = [*_pod()]
    for axis in axes:
        faces += [*_duct(axis), *_rotor(axis), _beam(np.zeros(3), axis, 0.012)]
    return (*faces, *_blade(racket))


def _circle(radius: float, height: float, corners: int = CORNERS) -> Float[ndarray, "corners 3"]:
    angles = np.linspace(0.0, math.tau, corners, endpoint=False)
    level = np.full(corners, height)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), level], axis=1)


def _band(one: ndarray, other: ndarray, colour: Colour) -> list[Face]:
    """Return the faces between two closed lines of equally many corners."""
    quads = zip(one, np.roll(one, -1, 0), np.roll(other, -1, 0), other, strict=True)
    return [Face(np.stack(corners), colour) for corners in quads]


def _duct(axis: Float[ndarray, "3"]) -> list[Face]:
    low, high = _circle(DUCT, -0.022) + axis, _circle(DUCT, 0.026) + axis
    rim = _circle(DUCT - 0.010, 0.026) + axis
    stripe = _circle(DUCT + 0.001, 0.006) + axis, _circle(DUCT + 0.001, 0.015) + axis
    wall, edge = _band(low, high, FOAM), _band(high, rim, FOAM)
    return [*wall, *edge, *_band(*stripe, TEAL)]


def _rotor(axis: Float[ndarray, "3"]) -> list[Face]:
    disc = Face(_circle(ROTOR, 0.012) + axis, AIR_COLOUR, 0.30)
    return [disc, Face(_circle(0.016, 0.016, 10) + axis, STEEL)]


def _beam(start: ndarray, end: ndarray, width: float) -> Face:
    along = (end - start) / np.linalg.norm(end - start)
    side = np.cross(along, [0.0, 0.0, 1.0])
    if np.linalg.norm(side) < 1e-6:
        side = np.array([0.0, 1.0, 0.0])
    half = width / 2 * side / np.linalg.norm(side)
    corners = np.stack([start - half, start + half, end + half, end - half])
    return Face(corners, CHARCOAL)


def _pod() -> list[Face]:
    """Return the body: an ellipsoid, with the camera's window at its nose."""
    rings = []
    for angle in np.linspace(-0.49 * math.pi, 0.49 * math.pi, 8):
        ring = _circle(math.cos(angle), math.sin(angle), 18)
        rings.append(ring[:, [2, 0, 1]] * [0.19, 0.062, 0.046])
    faces = [face for i in range(7) for face in _band(rings[i], rings[i + 1], CHARCOAL)]
    window = _circle(0.016, 0.195, 14)[:, [2, 0, 1]]
    return [*faces, Face(window, GLASS)]


def _blade(racket: Racket) -> list[Face]:
    centre = np.array([racket.x, racket.y, racket.z])
    ring = _circle(1.0, 0.0, 2 * CORNERS)[:, [2, 0, 1]]
    outline = ring * [1.0, racket.half_width, racket.half_height]
    rubber = racket.surface == RUBBER
    front = RUBBER_COLOUR if rubber else CARDBOARD_COLOUR
    back = CHARCOAL if rubber else CARDBOARD_BACK
    thick = np.array([0.006, 0.0, 0.0])
    plates = [
        Face(outline + centre, front),
        Face(outline + centre - thick, back),
    ]
    foot = centre - [0.012, 0.0, racket.half_height - 0.01]
    mast = [_beam(np.array([0.12, dy, 0.03]), foot, 0.014) for dy in (-0.02, 0.02)]
    rim = _band(outline + centre, outline + centre - thick, back)
    return [*plates, *rim, *mast]
