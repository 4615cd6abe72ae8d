"""What the ball can meet: air, table, net, floor, blade and hull, and what each does to it.

Each solid has parts, told apart by where and how it is touched; parts of the net differ in surface:
the tape along its top is taut and throws the ball back, the mesh swallows it, the posts are steel.
"""

from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.physics.ball import TABLE_SURFACE, Air, Surface, require_air, require_surface
from rotorpong.physics.vehicle import TICK as TICK
from rotorpong.world.racket import HULL, Hull, Racket

Solid = Literal["table", "net", "floor", "blade", "hull"]
SOLIDS: tuple[Solid, ...] = ("table", "net", "floor", "blade", "hull")
Part = Literal[
    "top", "edge", "underside", "mesh", "tape", "post", "floor", "face", "back", "guard"
]  # fmt: skip
PARTS: tuple[tuple[Part, ...], ...] = (
    ("top", "edge", "underside"),
    ("mesh", "tape", "post"),
    ("floor",),
    ("face", "edge", "back"),
    ("guard", "top", "underside"),
)
"""The parts of each solid, as the kernels number them. A hull's guard is its rim."""

MESH = Surface(0.1, 0.3)
TAPE = Surface(0.4, 0.3)  # a decision: between the mesh and a stiff edge
POST = Surface(0.7, 0.3)
FLOOR_SURFACE = Surface(0.75, 0.4)


class Solids(NamedTuple):
    """Everything the ball meets, as the kernels take it."""

    air: Air = Air()
    table: Surface = TABLE_SURFACE
    net: Surface = MESH
    tape: Surface = TAPE
    post: Surface = POST
    floor: Surface = FLOOR_SURFACE
    racket: Racket = Racket()
    hull: Hull = HULL
    tick: float = TICK


@lru_cache(maxsize=1024)
def parameters(solids: Solids) -> Float[ndarray, "k"]:
    """Return the numbers of `solids` in the order of its fields; read only.

    Raises:
        InputError: no ball can meet such solids.
    """
    require_air(solids.air)
    for name in ("table", "net", "tape", "post", "floor"):
        require_surface(getattr(solids, name), name)
    racket, hull = solids.racket, solids.hull
    require_surface(racket.surface, "blade")
    require_surface(hull.surface, "hull")
    sizes = (racket.half_width, racket.half_height, hull.radius, hull.half_height)
    if not (min(sizes) > 0.0 and max(sizes) < 10.0):
        raise InputError(f"{racket}, {hull}: expected sizes between 0 and 10 m")
    if not all(abs(place) < 10.0 for place in (racket.x, racket.y, racket.z)):
        raise InputError(f"{racket}: expected its centre within 10 m of the centre of mass")
    if not 0.0 < solids.tick <= 0.1:
        raise InputError(f"tick {solids.tick} s: expected 0 < tick <= 0.1")
    numbers = np.array(_flat(solids))
    numbers.setflags(write=False)
    return numbers


def _flat(values: Any) -> list[float]:
    if isinstance(values, tuple):
        return [number for value in values for number in _flat(value)]
    return [float(values)]
