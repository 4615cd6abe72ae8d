"""What every painted surface needs, compiled: spans, coverage, texture, colour.

A picture is painted in tiles, parts of a row, layer over layer, far to near, in single precision.
What one layer needs of a tile fits the processor's first cache; in shorter tiles all of it would,
but each call of a kernel costs as much as twenty pixels. A ray is p(t) = o + t d with d of unit
depth in the camera frame, so t is depth. On a plane, what a pixel spans along an axis is taken as
an interval, and its overlap with a line, a cord, a pane is a length: edges are covered without
samples.

All that is known of a tile lies in one flat array, one quantity after the other, at offsets that
are constants of the compiler: it then knows that no two of them overlap, and a loop without
branches becomes vector instructions however many of them it reads and writes. A part of a tile is
a slice of that array. Found or not is collected with `|`, which vectorises where counting and
comparing do not. Axes that are handed on are numpy integers: numba compiles a kernel anew for
every plain integer that it meets as a constant.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel

F = np.float32
ZERO, QUARTER, HALF, ONE, TWO = F(0), F(0.25), F(0.5), F(1), F(2)
TINY, FAR = F(1e-9), F(1e9)

TILE = 640  # pixels
(
    BLUE, GREEN, RED,  # the colour so far
    X, Y, Z, PITCH,  # direction of the ray in the world, pixel's angle
    WALL_Z, SOFT,  # height at which the ray meets the nearest wall, pixel's width there
    NEAR, BEYOND,  # depths between which layers are laid
    BALL_LIGHT, BALL_COVER,
    TABLE_X, TABLE_Y, TABLE_LONG, TABLE_WIDE, TABLE_SEEN,
    P, Q, FADE,  # place between texels, how much of the texture a pixel resolves
    SEEN, LIGHT, COVER,
    T, U, V, SPAN_U, SPAN_V,  # of the plane at hand: depth, place, what a pixel spans
) = (TILE * row for row in range(29))  # fmt: skip
TILE_SIZE = TILE * 29
EYE, RIGHT, DOWN, FORWARD = range(4)  # rows of a view
AHEAD, ASIDE, UP = np.arange(3)  # its columns, the axes of the world

COLOURS = (
    "ball", "table", "line", "net", "steel", "floor", "seam", "wall", "wainscot", "window",
    "ceiling", "lamp", "shirt", "skin", "trousers", "hair", "shoe", "racket",
)  # fmt: skip
(BALL, TABLE, LINE, NET, STEEL, FLOOR, SEAM, WALL, WAINSCOT, WINDOW, CEILING, LAMP) = range(12)

LIMB_COLUMNS = 13  # start y z, run y z, 1/run^2, radius, its change, colour, tone, box y z w h
TEXELS = 256
PADDED = TEXELS + 1  # the first row and column again behind the last: no neighbour wraps
TEXELS_PER_METRE, TEXEL = F(28), F(1 / 28)
LAST_TEXEL, ROW_OF_TEXELS = np.int32(TEXELS - 1), np.int32(PADDED)
NEXT, BELOW, BELOW_NEXT = np.uint32(1), np.uint32(PADDED), np.uint32(PADDED + 1)


class Paint(NamedTuple):
    """What surfaces look like."""

    colours: np.ndarray  # (n, 3) float32: blue, green, red in 0 .. 255
    texture: np.ndarray  # (PADDED^2,) float32, mean 0: relative brightness
    figure: np.ndarray  # (n, LIMB_COLUMNS) float32: the opponent's limbs, back to front
    shadow: F  # of the ball on the table, 0 none .. 1 black


@kernel
def inverse(x):
    """Return 1/x, large but finite where x vanishes."""
    return ONE / (x if abs(x) > TINY else TINY)


@kernel
def span(slope, right, down, right_normal, down_normal, scale):
    """Return the length along an axis that a pixel covers on a plane of normal n, never 0.

    p = o + t d on the plane, so dp/da = t (right - slope right_n) with slope d / d_n; likewise
    for b and down. The length is that of the interval with the same variance as the pixel.
    """
    across, along = right - slope * right_normal, down - slope * down_normal
    return abs(scale) * math.sqrt(across * across + along * along) + TINY


@kernel
def overlap(u, low, high, width):
    """Return the share of the interval of `width` about `u` within [low, high], all exactly 1."""
    half = HALF * width
    outside = max(low - (u - half), ZERO) + max(u + half - high, ZERO)
    return max(ONE - outside / max(width, TINY), ZERO)


@kernel
def step(u, width):
    """Return the share of the interval of `width` about `u` that is above 0."""
    return min(max(u / max(width, TINY) + HALF, ZERO), ONE)


@kernel
def stripes(u, period, thickness, width):
    """Return the share of the interval about `u` covered by stripes that start at multiples."""
    half, frequency = HALF * width, ONE / max(period, TINY)
    low, high = np.floor((u - half) * frequency), np.floor((u + half) * frequency)
    before = low * thickness + min(u - half - low * period, thickness)
    after = high * thickness + min(u + half - high * period, thickness)
    return (after - before) / max(width, TINY)


@kernel
def texel(u, v):
    """Return the place in the texture of the upper left neighbour of (u, v), in texels."""
    column, row = np.int32(np.floor(u)) & LAST_TEXEL, np.int32(np.floor(v)) & LAST_TEXEL
    return np.int32(np.int32(row) * ROW_OF_TEXELS + column)


@kernel
def grain(tile, texels, texture, n):
    """Write the texture to LIGHT, interpolated between texels at P, Q, where it shows: FADE."""
    for i in range(n):
        k, p = np.uint32(texels[i]), tile[P + i]
        upper = texture[k] + p * (texture[k + NEXT] - texture[k])
        lower = texture[k + BELOW] + p * (texture[k + BELOW_NEXT] - texture[k + BELOW])
        tile[LIGHT + i] = (upper + tile[Q + i] * (lower - upper)) * tile[FADE + i]


@kernel
def lay(tile, n, colour):
    """Lay a colour under LIGHT over the tile, as far as COVER says."""
    blue, green, red = colour[0], colour[1], colour[2]
    for i in range(n):
        light, cover = tile[LIGHT + i], tile[COVER + i]
        under = ONE - cover
        tile[BLUE + i] = under * tile[BLUE + i] + cover * (blue * light)
        tile[GREEN + i] = under * tile[GREEN + i] + cover * (green * light)
        tile[RED + i] = under * tile[RED + i] + cover * (red * light)


@kernel
def fill(tile, n, value):
    """Write one value to the first n of a quantity."""
    for i in range(n):
        tile[i] = value


@kernel
def cross(tile, n, view, normal, offset):
    """Write where rays cross the plane at `offset` along the axis `normal`.

    Depth goes to T, the coordinates along the next two axes (in cyclic order) to U and V, what
    pixels span along them to SPAN_U and SPAN_V.
    """
    u, v = (normal + 1) % 3, (normal + 2) % 3
    toward = tile[X + TILE * normal :]
    along_u, along_v = tile[X + TILE * u :], tile[X + TILE * v :]
    away, start_u, start_v = offset - view[EYE, normal], view[EYE, u], view[EYE, v]
    right_u, right_v, right_n = view[RIGHT, u], view[RIGHT, v], view[RIGHT, normal]
    down_u, down_v, down_n = view[DOWN, u], view[DOWN, v], view[DOWN, normal]
    for i in range(n):
        inverse_direction = inverse(toward[i])
        t = away * inverse_direction
        tile[T + i] = t
        tile[U + i] = start_u + t * along_u[i]
        tile[V + i] = start_v + t * along_v[i]
        slope_u, slope_v = along_u[i] * inverse_direction, along_v[i] * inverse_direction
        scale = t * tile[PITCH + i]
        tile[SPAN_U + i] = span(slope_u, right_u, down_u, right_n, down_n, scale)
        tile[SPAN_V + i] = span(slope_v, right_v, down_v, right_n, down_n, scale)
