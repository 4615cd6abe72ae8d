"""What every painted surface needs, compiled: spans, coverage, texture, colour.

A picture is painted row by row, layer over layer, far to near, in single precision. A ray is
p(t) = o + t d with d of unit depth in the camera frame, so t is depth. On a plane, what a pixel
spans along an axis is taken as an interval, and its overlap with a line, a cord, a pane is a
length: edges are covered without samples.

Loops that write one array without branches compile to vector instructions; several outputs or a
branch in one loop do not, hence the many small loops. Indices that are handed on are numpy
integers: numba compiles a kernel anew for every plain integer that it meets as a constant.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel

F = np.float32
ZERO, QUARTER, HALF, ONE, TWO = F(0), F(0.25), F(0.5), F(1), F(2)
TINY, FAR = F(1e-9), F(1e9)

X, Y, Z, IX, IY, IZ, PITCH, WALL_T, WALL_Z = np.arange(9)  # rows of Row.ray
RAY_ROWS, TILE = 9, 320
T, U, V, SPAN_U, SPAN_V, SEEN, LIGHT, COVER = np.arange(8)  # rows of Row.work
WORK_ROWS = 8
EYE, RIGHT, DOWN, FORWARD = range(4)  # rows of a view

COLOURS = (
    "ball", "table", "line", "net", "steel", "floor", "seam", "wall", "wainscot", "window",
    "ceiling", "lamp", "shirt", "skin", "trousers", "hair", "shoe", "racket",
)  # fmt: skip
(BALL, TABLE, LINE, NET, STEEL, FLOOR, SEAM, WALL, WAINSCOT, WINDOW, CEILING, LAMP) = range(12)

LIMB_COLUMNS = 13  # start y z, run y z, 1/run^2, radius, its change, colour, tone, box y z w h
TEXELS = 256
TEXELS_PER_METRE, TEXEL = F(28), F(1 / 28)


class Paint(NamedTuple):
    """What surfaces look like."""

    colours: np.ndarray  # (n, 3) float32: blue, green, red in 0 .. 255
    texture: np.ndarray  # (TEXELS^2,) float32, mean 0: relative brightness
    figure: np.ndarray  # (n, LIMB_COLUMNS) float32: the opponent's limbs, back to front
    shadow: F  # of the ball on the table, 0 none .. 1 black


class Row(NamedTuple):
    """One row of n pixels on its way to the picture.

    Layers go to `columns`, first and one past the last, where their depth is in (near, far).
    """

    colour: np.ndarray  # (3, n)
    ray: np.ndarray  # (9, n): direction in the world, its inverse, pitch; depth, height at the wall
    work: np.ndarray  # (8, n): of the layer at hand
    near: np.ndarray  # (n,) depth
    far: np.ndarray  # (n,) depth
    ball: np.ndarray  # (2, n): light and coverage
    columns: np.ndarray  # (2,) uint64: an index that may be negative would cost the vector code


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
def grain(texture, u, v, width):
    """Return the texture at (u, v) metres, interpolated; it fades where pixels outgrow it."""
    u *= TEXELS_PER_METRE
    v *= TEXELS_PER_METRE
    low_u, low_v = np.floor(u), np.floor(v)
    p, q = u - low_u, v - low_v
    j, i = int(low_u) & (TEXELS - 1), (int(low_v) & (TEXELS - 1)) * TEXELS
    m, k = (j + 1) & (TEXELS - 1), (i + TEXELS) & (TEXELS * TEXELS - 1)
    upper = texture[i + j] + p * (texture[i + m] - texture[i + j])
    lower = texture[k + j] + p * (texture[k + m] - texture[k + j])
    return (upper + q * (lower - upper)) * min(TEXEL / max(width, TINY), ONE)


@kernel
def lay(pixels, i, colour, light, cover):
    """Lay a colour under some light over a pixel, as far as it covers."""
    for k in range(3):
        pixels[k, i] = (ONE - cover) * pixels[k, i] + cover * (colour[k] * light)


@kernel
def lay_row(row, colour):
    """Lay a colour under the row's LIGHT over the columns, as far as COVER says."""
    light, cover = row.work[LIGHT], row.work[COVER]
    for k in range(3):
        under, full = row.colour[k], colour[k]
        for i in range(row.columns[0], row.columns[1]):
            under[i] = (ONE - cover[i]) * under[i] + cover[i] * (full * light[i])


@kernel
def fill(row, out, value):
    """Write one value to the columns."""
    for i in range(row.columns[0], row.columns[1]):
        out[i] = value


@kernel
def any_within(row, values, low, high):
    """Tell whether a value in the columns lies within (low, high)."""
    count = 0
    for i in range(row.columns[0], row.columns[1]):
        count += 1 if (values[i] > low) & (values[i] < high) else 0
    return count > 0


@kernel
def follow(row, out, depth, direction, start):
    """Write one coordinate of the points at `depth` along the rays."""
    for i in range(row.columns[0], row.columns[1]):
        out[i] = start + depth[i] * direction[i]


@kernel
def cross(row, view, normal, offset):
    """Write where rays cross the plane at `offset` along the axis `normal`.

    Depth goes to T, the coordinates along the next two axes (in cyclic order) to U and V.
    """
    depth, inverse_direction = row.work[T], row.ray[IX + normal]
    away, u, v = offset - view[EYE, normal], (normal + 1) % 3, (normal + 2) % 3
    for i in range(row.columns[0], row.columns[1]):
        depth[i] = away * inverse_direction[i]
    follow(row, row.work[U], depth, row.ray[u], view[EYE, u])
    follow(row, row.work[V], depth, row.ray[v], view[EYE, v])


@kernel
def spread(row, view, normal, bounded, limits):
    """Write what pixels span along U and V of the plane crossed, and SEEN.

    SEEN is 1 where the depth is in bounds and the row `bounded` of the work within limits, else 0.
    """
    depth, seen, value, (low, high) = row.work[T], row.work[SEEN], row.work[bounded], limits
    spans(row, row.work[SPAN_U], view, ((normal + 1) % 3, normal))
    spans(row, row.work[SPAN_V], view, ((normal + 2) % 3, normal))
    for i in range(row.columns[0], row.columns[1]):
        in_depth = (depth[i] > row.near[i]) & (depth[i] < row.far[i])
        seen[i] = ONE if in_depth & (value[i] > low) & (value[i] < high) else ZERO


@kernel
def spans(row, out, view, axes):
    """Write what pixels span along the first axis on a plane normal to the second."""
    axis, normal = axes
    direction, inverse_direction = row.ray[axis], row.ray[IX + normal]
    right, down = view[RIGHT, axis], view[DOWN, axis]
    right_normal, down_normal = view[RIGHT, normal], view[DOWN, normal]
    depth, pitch = row.work[T], row.ray[PITCH]
    for i in range(row.columns[0], row.columns[1]):
        slope = direction[i] * inverse_direction[i]
        out[i] = span(slope, right, down, right_normal, down_normal, depth[i] * pitch[i])
