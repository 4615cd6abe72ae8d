"""One ball, measured to hundredths of a pixel: a matte, its area, its edge.

**Matte.** In linear light a pixel is  c = alpha B b + (1 - alpha) g:  alpha its share of ball, b
the ball's colour (unit length), B its brightness there, g the background. With

    alpha = w.(c - g) / w.D,   w = S^-1 D,   D = B b - g                             Eq. (1)
    S = noise 1 + (shading B)^2 b b^T + scatter of the background                    Eq. (2)

(Fisher's direction) w is orthogonal to b as far as the shading is unknown, so that an orange ball's
pixels give 1 however they are lit, and it avoids what varies behind the ball: brightness on a
textured wall, white lines on a blue table. For a white ball b is grey, and most backgrounds differ
from it in brightness only, so its shading is taken as better known: B = A + max(0, l . normal), a
Lambert ball under one lamp, is fitted to its inside. The same goes for any ball that came through a
stream, in which brightness is sharper than colour (`streamed`). g, S and w are those of 24 sectors
of a thin ring around the ball, alpha is interpolated between them, in 96 directions. A sector whose
ball and background differ by less than their sd, or without pixels in the picture, has no weight.

**Area.** radius = sqrt(sum alpha / pi), centre = centroid of alpha: what a moving ball covers over
the exposure adds up to the ball's area, whatever the blur. It needs the whole ball and a background
known all around. Inside, 2.5 sigma from the edge, alpha is 1 without looking.

**Edge.** Gauss-Newton with Geman-McClure weights on

    alpha = Phi((R - rho) / s),  s^2 = a + b cos 2 phi + c sin 2 phi                  Eq. (3)
    R = r - (a - b cos 2 phi - c sin 2 phi) / (2 r)                                  Eq. (4)

over the pixels around the outline (every second, third, fifth, ... on a lattice, so that some 300
are left), until a step is below 0.2 sd: rho, phi polar coordinates about the centre, s the blur
across the edge, (4) what the blur along a curved edge takes away from it (r + sigma^2 / (2 r)
undoes it). Short streaks of motion are in b, c: L^2 = 24 sqrt(b^2 + c^2). From 2.2 px on (and 3 sd)
the ball is fitted as one that moves: (3) is averaged over the exposure, -u to u, with u unknown up
to its sign. The centre is that of mid exposure.

Both measure where the picture is a circle once `shape` is undone (`sphere.outline_shape`).
Covariances add to that of the pixels what a wrong background of each sector would do. Rendered
before a textured hall, the edge is two to five times better than the area at rest and in motion, so
it is what `measure_ball` returns; the area is its check: `disagreement` is the largest difference
between the two, in sd, and above 3 the background or the blur is not what the model takes it for.

Pixel centres have whole coordinates, in the frame of the whole picture.
"""

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.vision._measure_kernels import ABOUT, FOUND, SPREADS, STREAK, measure
from rotorpong.vision.sphere import symmetric_shape

FIRST_VARIANCE = 0.45  # px^2, of the edge: lens, demosaicing and the pixel itself
MARGIN_PX, MARGIN_SHARE = 7, 0.3  # around a guess: room for its error and the ring
LEAST_RADIUS_PX = 1.2
LEAST_SECTORS = 0.3  # share of the outline that is seen before a background
MOST_RADIUS_SD = 0.2  # relative
MOST_RESIDUAL = 0.2  # rms of alpha along the outline
MOST_ANGLE_SD = 6.0  # between the ball's colour and what is known of it
MOST_GROWTH = 2.5  # of the radius, from the guess
MOST_MOVE = 1.0  # of the centre from the guess, in diameters
BLURRED_PX = 1.0
SHARP_PX = 1.0  # sd of a guess that needs no coarse look
AREA, EDGE = 0, 1  # rows of what is found
STREAMED_SHADING = 0.1  # relative; of three tried (0.35, 0.2, 0.1) the best at 1, 2.5 and 4 m
ROUND = np.eye(2)


@dataclass(frozen=True, slots=True)
class BallColour:
    """What is known of a ball's colour."""

    name: str
    levels_bgr: tuple[float, float, float]  # picture levels of a ball in good light
    tolerance: float = 0.08  # rad in linear light, sd of the colour's direction
    shading: float = 0.35  # relative sd of the brightness about a fitted Lambert ball


ORANGE_BALL = BallColour("orange", (40.0, 128.0, 250.0))
WHITE_BALL = BallColour("white", (238.0, 242.0, 245.0), tolerance=0.05, shading=0.05)
BALL_COLOURS = {colour.name: colour for colour in (ORANGE_BALL, WHITE_BALL)}


@functools.lru_cache(maxsize=8)
def streamed(colour: BallColour) -> BallColour:
    """Return a ball's colour as a stream brings it whose colours have half the resolution."""
    return replace(colour, shading=min(colour.shading, STREAMED_SHADING))


@dataclass(frozen=True, slots=True)
class Guess:
    """Where a ball may be: of a coarse circle, or predicted."""

    x_px: float
    y_px: float
    diameter_px: float
    streak_px: tuple[float, float] = (0.0, 0.0)  # how far it moves in the exposure, if known
    shape: Float[ndarray, "2 2"] | None = None  # of the outline, determinant 1; None: a circle
    sd_px: float = math.inf  # of the centre; if it is small, no coarse look comes first


@dataclass(frozen=True, slots=True)
class BallDisc:
    """A measured ball: centroid and area radius, at mid exposure."""

    x_px: float
    y_px: float
    radius_px: float
    covariance: Float[ndarray, "3 3"]  # of x, y, radius, px^2
    streak_px: tuple[float, float]  # motion in the exposure, up to its sign; 0 if none is seen
    disagreement: float | None  # between area and edge, sd; None if there is only one
    levels_bgr: tuple[float, float, float]  # the ball's own colour, picture levels

    @property
    def blurred(self) -> bool:
        """Whether the ball moved a pixel or more during the exposure."""
        return math.hypot(*self.streak_px) > BLURRED_PX


def measure_ball(
    region: UInt8[ndarray, "height width 3"],
    guess: Guess,
    colour: BallColour = ORANGE_BALL,
    *,
    offset: tuple[int, int] = (0, 0),
    gamma: float = 1.0,
) -> BallDisc | None:
    """Return the ball near a guess, or None if there is none that can be measured.

    Args:
        region: part of a picture, blue, green, red; `region_around` gives a box large enough. What
            lies beyond it counts as outside the picture.
        guess: good to a third of a radius, in the whole picture's pixels.
        colour: of the ball. A smaller tolerance helps where blur leaves no pixel all ball: pass
            `replace(colour, levels_bgr=disc.levels_bgr, tolerance=0.01)` of an earlier disc.
        offset: column and row of the region's first pixel.
        gamma: level = 255 (light / 255)^(1 / gamma).

    Raises:
        InputError: the guess is not finite or has no size, gamma is not above 0, or the ball is
            black or its colour without tolerance.
    """
    found = _measured(region, guess, colour, offset, gamma)
    return None if found is None else _disc(found, EDGE, offset, gamma)


def area_and_edge(
    region: UInt8[ndarray, "height width 3"],
    guess: Guess,
    colour: BallColour = ORANGE_BALL,
    *,
    offset: tuple[int, int] = (0, 0),
    gamma: float = 1.0,
) -> tuple[BallDisc | None, BallDisc | None]:
    """Return both measurements of `measure_ball`: by the area and by the edge."""
    found = _measured(region, guess, colour, offset, gamma)
    if found is None:
        return None, None
    edge = _disc(found, EDGE, offset, gamma)
    return (None if edge.disagreement is None else _disc(found, AREA, offset, gamma)), edge


def region_around(guess: Guess, width: int, height: int) -> tuple[int, int, int, int]:
    """Return the box x0, y0, x1, y1 (ends exclusive) of a picture to measure the guess in.

    It is empty where the guess lies outside.
    """
    room = (0.5 + MARGIN_SHARE) * guess.diameter_px + MARGIN_PX
    half_x = int(room + 0.5 * abs(guess.streak_px[0])) + 1
    half_y = int(room + 0.5 * abs(guess.streak_px[1])) + 1
    x, y = round(guess.x_px), round(guess.y_px)
    x0, y0 = min(max(x - half_x, 0), width), min(max(y - half_y, 0), height)
    return x0, y0, max(min(x + half_x + 1, width), x0), max(min(y + half_y + 1, height), y0)


def without_rolling(disc: BallDisc, row_velocity_px_s: float, row_time: float) -> BallDisc:
    """Return the disc that a camera without rolling shutter would have seen at the centre's time.

    Rows are exposed one after the other, so a ball that falls through the picture is stretched by
    1 / (1 - v t) along its columns, and its area with it. The centre is where the ball was when
    the centre's row was exposed (`physics.camera.row_time`).

    Args:
        disc: as measured.
        row_velocity_px_s: of the ball in the picture, downwards.
        row_time: s from one row to the next: readout over the picture's height.
    """
    shrink = 1.0 - row_velocity_px_s * row_time
    if not shrink > 0.0:
        raise InputError(f"a ball of {row_velocity_px_s} px/s keeps pace with the rolling shutter")
    scale = np.array([1.0, 1.0, math.sqrt(shrink)])
    return replace(
        disc,
        radius_px=disc.radius_px * scale[2],
        covariance=disc.covariance * scale[:, None] * scale,
    )


def rolling_shape(
    shape: Float[ndarray, "2 2"], velocity_px_s: Float[ndarray, "2"], row_time: float
) -> Float[ndarray, "2 2"]:
    """Return the shape of an outline that moves under a rolling shutter: sheared and stretched."""
    across, down = velocity_px_s * row_time
    return symmetric_shape(np.array([[1.0, across / (1 - down)], [0.0, 1 / (1 - down)]]) @ shape)


def _measured(
    region: ndarray, guess: Guess, colour: BallColour, offset: tuple[int, int], gamma: float
) -> list[float] | None:
    """Return what `measure` finds, `None` if that is no ball."""
    numbers = (guess.x_px, guess.y_px, guess.diameter_px, *guess.streak_px)
    if not (all(map(math.isfinite, numbers)) and guess.diameter_px > 0.0 and gamma > 0.0):
        raise InputError(f"{guess}, gamma {gamma}: expected finite numbers, size and gamma above 0")
    if not max(colour.levels_bgr) >= 1.0 or not colour.tolerance > 0.0:
        raise InputError(f"{colour}: a black ball or one without tolerance cannot be measured")
    shape = ROUND if guess.shape is None else np.ascontiguousarray(guess.shape, dtype=float)
    x, y, u = guess.x_px - offset[0], guess.y_px - offset[1], (0.0, 0.0)
    if math.hypot(*guess.streak_px) > 2.0 * BLURRED_PX:
        u = np.linalg.solve(shape, 0.5 * np.array(guess.streak_px))
    state = np.array((x, y, 0.5 * guess.diameter_px, u[0], u[1], FIRST_VARIANCE))
    out = np.zeros(FOUND)
    first = int(guess.sd_px < SHARP_PX)
    pixels = np.ascontiguousarray(region)
    measure(pixels, state, shape, _light(gamma), _paint(colour, gamma), first, out)
    found = out.tolist()
    return found if _is_ball(found, colour, (x, y, guess.diameter_px)) else None


def _is_ball(found: list[float], colour: BallColour, guess: tuple[float, float, float]) -> bool:
    scale, sectors, angle, residual = found[ABOUT : ABOUT + 4]
    x, y, radius = found[3 * EDGE : 3 * EDGE + 3]
    variance = found[SPREADS + 9 * EDGE + 8]
    return (
        scale >= 0.0
        and sectors >= LEAST_SECTORS
        and residual < MOST_RESIDUAL
        and angle < MOST_ANGLE_SD * colour.tolerance
        and radius > LEAST_RADIUS_PX
        and 1.0 / MOST_GROWTH < 2.0 * radius / guess[2] < MOST_GROWTH
        and math.hypot(x - guess[0], y - guess[1]) < MOST_MOVE * guess[2]
        and 0.0 < variance < (MOST_RADIUS_SD * radius) ** 2
    )


def _disc(found: list[float], which: int, offset: tuple[int, int], gamma: float) -> BallDisc:
    x, y, radius = found[3 * which : 3 * which + 3]
    spread = found[SPREADS + 9 * which : SPREADS + 9 * which + 9]
    across, down = found[STREAK : STREAK + 2]
    disagreement = found[ABOUT + 4]
    blue, green, red = (
        255.0 * min(max(light / 255.0, 0.0), 1.0) ** (1.0 / gamma)
        for light in found[ABOUT + 5 : ABOUT + 8]
    )
    return BallDisc(
        x + offset[0],
        y + offset[1],
        radius,
        np.array(spread).reshape(3, 3),
        (across, down),
        None if math.isnan(disagreement) else disagreement,
        (blue, green, red),
    )


@functools.lru_cache(maxsize=8)
def _paint(colour: BallColour, gamma: float) -> Float[ndarray, "5"]:
    """Return the ball's colour in linear light, its tolerance and its shading."""
    light = 255.0 * (np.array(colour.levels_bgr) / 255.0) ** gamma
    return np.array([*light, colour.tolerance, colour.shading])


@functools.lru_cache(maxsize=8)
def _light(gamma: float) -> Float[ndarray, "256"]:
    return 255.0 * (np.arange(256) / 255.0) ** gamma
