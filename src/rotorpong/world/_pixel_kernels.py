"""What every painted surface needs, compiled: spans, coverage, texture, colour.

A picture is painted row by row, layer over layer, far to near, in single precision. A ray is
p(t) = o + t d with d of unit depth in the camera frame, so t is depth. On a plane, what a pixel
spans along an axis is taken as an interval, and its overlap with a line, a cord, a pane is a
length: edges are covered without samples.

Loops that write one array without branches compile to vector instructions; several outputs or a
branch in one loop do not, hence the many small loops.
"""

from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel

F = np.float32
ZERO, QUARTER, HALF, ONE, TWO = F(0), F(0.25), F(0.5), F(1), F(2)
TINY, FAR = F(1e-9), F(1e9)

X, Y, Z, IX, IY, IZ, PITCH, WALL_T, WALL_Z = range(9)  # rows of Row.ray
RAY_ROWS, WORK_ROWS = 9, 6

COLOURS = (
    "ball", "table", "line", "net", "steel", "floor", "seam", "wall", "wainscot", "window",
    "ceiling", "lamp", "shirt", "skin", "trousers", "hair", "shoe", "racket",
)  # fmt: skip
(BALL, TABLE, LINE, NET, STEEL, FLOOR, SEAM, WALL, WAINSCOT, WINDOW, CEILING, LAMP) = range(12)

LIMB_COLUMNS = 13  # start y z, run y z, 1/run^2, radius, its change, colour, tone, box y z w h
TEXELS = 256
TEXELS_PER_METRE, TEXEL = F(28), F(1 / 28)


class View(NamedTuple):
    """Where the camera is, and its axes right, down, forward, in the world."""

    x: F
    y: F
    z: F
    rx: F
    ry: F
    rz: F
    dx: F
    dy: F
    dz: F
    fx: F
    fy: F
    fz: F


class Paint(NamedTuple):
    """What surfaces look like."""

    colours: np.ndarray  # (n, 3) float32: blue, green, red in 0 .. 255
    texture: np.ndarray  # (TEXELS^2,) float32, mean 0: relative brightness
    figure: np.ndarray  # (n, LIMB_COLUMNS) float32: the opponent's limbs, back to front
    shadow: F  # of the ball on the table, 0 none .. 1 black


class Row(NamedTuple):
    """One row of n pixels on its way to the picture; layers lie between `near` and `far`."""

    colour: np.ndarray  # (3, n)
    ray: np.ndarray  # (9, n): direction in the world, its inverse, pitch; depth, height at the wall
    work: np.ndarray  # (6, n)
    near: np.ndarray  # (n,) depth
    far: np.ndarray  # (n,) depth


@kernel
def inverse(x):
    """Return 1/x, large but finite where x vanishes."""
    return ONE / (x if abs(x) > TINY else TINY)


@kernel
def span(slope, right, down, right_normal, down_normal, scale):
    """Return the length along an axis that a pixel covers on a plane of normal n, never 0.

    p = o + t d on the plane, so dp/da = t (right - slope right_n) with slope d / d_n; likewise
    for b and down.
    """
    across, along = abs(right - slope * right_normal), abs(down - slope * down_normal)
    return abs(scale) * (across + along) + TINY


@kernel
def overlap(u, low, high, width):
    """Return the share of the interval of `width` about `u` that lies within [low, high]."""
    half = HALF * width
    return max((min(u + half, high) - max(u - half, low)) / max(width, TINY), ZERO)


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
def lay(pixels, i, colours, index, light, cover):
    """Lay a colour under some light over a pixel, as far as it covers."""
    for k in range(3):
        pixels[k, i] += cover * (colours[index, k] * light - pixels[k, i])


@kernel
def lay_row(pixels, columns, colour, light, cover):
    """Lay a colour under `light` over a range of columns, as far as it covers."""
    first, last = columns
    for k in range(3):
        under, full = pixels[k], colour[k]
        for i in range(first, last):
            under[i] += cover[i] * (full * light[i] - under[i])


@kernel
def any_within(values, columns, low, high):
    """Tell whether a value of a range of columns lies within (low, high)."""
    count = 0
    for i in range(columns[0], columns[1]):
        count += 1 if (values[i] > low) & (values[i] < high) else 0
    return count > 0


@kernel
def meet(out, columns, inverse_direction, offset):
    """Write the depth at which rays meet the plane at `offset` from the camera along an axis."""
    for i in range(columns[0], columns[1]):
        out[i] = offset * inverse_direction[i]


@kernel
def follow(out, columns, depth, direction, start):
    """Write one coordinate of the points at `depth` along the rays."""
    for i in range(columns[0], columns[1]):
        out[i] = start + depth[i] * direction[i]


@kernel
def level_places(row, columns, view, level):
    """Write x, y, what a pixel spans of them, and depth, where rays meet a level plane."""
    x, y, long, wide, t = row.work[0], row.work[1], row.work[2], row.work[3], row.work[5]
    rx, ry, iz, pitch = row.ray[X], row.ray[Y], row.ray[IZ], row.ray[PITCH]
    meet(t, columns, iz, level - view.z)
    follow(x, columns, t, rx, view.x)
    follow(y, columns, t, ry, view.y)
    for i in range(columns[0], columns[1]):
        long[i] = span(rx[i] * iz[i], view.rx, view.dx, view.rz, view.dz, t[i] * pitch[i])
    for i in range(columns[0], columns[1]):
        wide[i] = span(ry[i] * iz[i], view.ry, view.dy, view.rz, view.dz, t[i] * pitch[i])
