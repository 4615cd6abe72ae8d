"""How a court may look: scenes drawn at random, to train and test eyes on more than one hall.

Hue, saturation and value of every surface are drawn from ranges in which tables, floors, walls and
clothes are found; light from dusk to glare. Nothing moves: geometry is in `court`.
"""

import colorsys
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from rotorpong.world.render import Colour, Scene

BallColour = Literal["orange", "white"]
BALL_COLOURS: tuple[BallColour, ...] = get_args(BallColour)

PLAIN = Scene()
BALLS: Mapping[BallColour, Colour] = {"orange": PLAIN.ball, "white": (233, 239, 242)}
"""As the plain scene shows them; white is the middle of its tint below."""

Range = tuple[float, float]
Tint = tuple[Range, Range, Range]  # hue in degrees, saturation, value

BALL_TINTS: dict[str, Tint] = {
    "orange": ((20.0, 34.0), (0.75, 0.95), (0.90, 1.0)),
    "white": ((20.0, 60.0), (0.0, 0.08), (0.90, 1.0)),
}
TABLES: tuple[Tint, ...] = (
    ((205.0, 225.0), (0.6, 0.9), (0.40, 0.70)),  # blue
    ((130.0, 170.0), (0.4, 0.8), (0.25, 0.50)),  # green
)
FLOORS: tuple[Tint, ...] = (
    ((25.0, 40.0), (0.15, 0.55), (0.45, 0.80)),  # wood
    ((0.0, 15.0), (0.5, 0.8), (0.45, 0.65)),  # the red of tournaments
    ((200.0, 230.0), (0.2, 0.6), (0.30, 0.55)),
    ((0.0, 360.0), (0.0, 0.06), (0.35, 0.65)),  # concrete
)
WALL: Tint = ((0.0, 360.0), (0.0, 0.15), (0.60, 0.95))
WAINSCOT: Tint = ((0.0, 360.0), (0.1, 0.6), (0.30, 0.70))
WINDOW: Tint = ((190.0, 220.0), (0.0, 0.25), (0.70, 1.0))
CLOTH: Tint = ((0.0, 360.0), (0.0, 0.9), (0.10, 0.95))
SKIN: Tint = ((12.0, 30.0), (0.25, 0.60), (0.30, 0.90))
HAIR: Tint = ((15.0, 40.0), (0.1, 0.6), (0.05, 0.50))
SEAM_SHADE = (0.6, 0.85)  # of the floor's colour

BRIGHTNESS = (0.55, 1.25)  # light times exposure
TEXTURE_CONTRAST = (0.01, 0.08)
SHADOW = (0.1, 0.7)
NO_OPPONENT_SHARE = 0.2
TEXTURES = 2**31


def plain_looks(ball: BallColour) -> Scene:
    """Return the plain scene with a ball of this colour."""
    return replace(PLAIN, ball=BALLS[ball])


def draw_looks(rng: np.random.Generator, *, ball: BallColour | None = None) -> Scene:
    """Return a scene drawn at random.

    Args:
        rng: draws everything.
        ball: colour of the ball; orange or white, drawn too, if absent.
    """
    drawn = BALL_COLOURS[rng.integers(len(BALL_COLOURS))]  # drawn in any case: the rest stays
    floor = _tinted(rng, FLOORS[rng.integers(len(FLOORS))])
    shade = rng.uniform(*SEAM_SHADE)
    wall = _tinted(rng, WALL)
    return Scene(
        ball=_tinted(rng, BALL_TINTS[ball or drawn]),
        table=_tinted(rng, TABLES[rng.integers(len(TABLES))]),
        floor=floor,
        seam=(shade * floor[0], shade * floor[1], shade * floor[2]),
        wall=wall,
        ceiling=wall,
        wainscot=_tinted(rng, WAINSCOT),
        window=_tinted(rng, WINDOW),
        shirt=_tinted(rng, CLOTH),
        trousers=_tinted(rng, CLOTH),
        shoe=_tinted(rng, CLOTH),
        skin=_tinted(rng, SKIN),
        hair=_tinted(rng, HAIR),
        brightness=rng.uniform(*BRIGHTNESS),
        texture_contrast=rng.uniform(*TEXTURE_CONTRAST),
        texture_seed=int(rng.integers(TEXTURES)),
        opponent=bool(rng.random() >= NO_OPPONENT_SHARE),
        ball_shadow=rng.uniform(*SHADOW),
    )


def _tinted(rng: np.random.Generator, tint: Tint) -> Colour:
    hue, saturation, value = (rng.uniform(*limits) for limits in tint)
    red, green, blue = colorsys.hsv_to_rgb(hue / 360.0, saturation, value)
    return 255.0 * blue, 255.0 * green, 255.0 * red
