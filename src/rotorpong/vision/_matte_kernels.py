"""The matte of one ball, compiled; the equations are in `matte`.

All places are in the ball's own frame q = shape^-1 (pixel - centre), in which its outline is a
circle, or a capsule while it moves: the points within r of the segment from -u to u.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel, spliced_kernel
from rotorpong.vision._outline_kernels import (
    NEAR,
    PLACES,
    SECTOR,
    SECTORS,
    box_around,
    deep_span,
    place_row,
)
from rotorpong.vision._shade_kernels import brightness
from rotorpong.vision._trace_kernels import F

LEVELS_PER_SECTOR = 10  # how many pixels; sums of b, g, r; of bb, bg, br, gg, gr, rr
MATTE_PER_SECTOR = 10  # w; w.g; noise's, background's variance of alpha; pixels; shading's variance
# of alpha, w.b, brightness at the rim
FEWEST_IN_SECTOR, FEWEST_IN_CORE = 3, 4  # pixels
NEIGHBOUR = 0.5  # weight of the next sectors in the scatter of the ring
TEXTURE = 2.5  # neighbouring sectors err together
CLIPPED = 254  # levels: from here on the picture may have cut off
LEAST_NOISE = 0.15  # variance in levels of linear light: rounding
CORE_NOISE = 0.05  # relative, of a pixel of the ball
UNMEASURED = 0.8  # brightness of a ball without a core, in that of its paint
UNSHADED = 0.25  # sd of the brightness where it is not
CORE_RADIUS = 12.0  # px: of a core this large every second row and column is read
_ANGLES = (np.arange(SECTORS) + 0.5) * (2.0 * math.pi / SECTORS)
COSINES, SINES = np.cos(_ANGLES), np.sin(_ANGLES)


class Paint(NamedTuple):
    """What is known of the ball's colour and of the picture's response."""

    light: np.ndarray  # (256,) linear light of a level, 0 .. 255
    colour: np.ndarray  # (3,) of the ball, linear light
    tolerance: float  # sd of its direction, rad
    shading: float  # sd of its brightness, relative, about what the fit says


class Room(NamedTuple):
    """Memory for one measurement."""

    levels: np.ndarray  # (SECTORS, LEVELS_PER_SECTOR)
    matte: np.ndarray  # (SECTORS, MATTE_PER_SECTOR)
    blended: np.ndarray  # (DIRECTIONS, MATTE_PER_SECTOR + 2): the matte between sectors; share
    # that is known, sector that has most of it
    moments: np.ndarray  # (SECTORS, 9): sums of 1 - alpha, of alpha, each times 1, q; variances
    ball: np.ndarray  # (8,): direction of the colour, its sd; ambient brightness, lamp x, y, z
    places: np.ndarray  # (5 * PLACES,) float32: of pixels of a row
    band: np.ndarray  # (lines, FIELDS * LANES) float32: q, alpha, one over its variance, ...
    owners: np.ndarray  # (lines * LANES,): their sectors
    sums: np.ndarray  # (SUMS * LANES,) float32: of a fit


@kernel
def look(pixels, state, shape, inverse, margins, step, paint, room):
    """Sum the background's levels per sector of the ring, and the ball's colour over its core.

    Margins are those of core, gap and ring, from the outline and from each other; every `step`-th
    row and column is read, of a large core fewer.
    """
    core, gap, width = margins
    levels, light, places = room.levels, paint.light, room.places
    levels[:] = 0.0
    core_sums = np.zeros((2, 4))
    inner, outer, deep = state[2] + gap, state[2] + gap + width, state[2] - core
    inner2, outer2 = F(inner * inner), F(outer * outer)
    sparse = step * max(int(deep / CORE_RADIUS) // step + 1, 1)
    x0, x1, y0, y1 = box_around(pixels, state, shape, outer)
    for i in range(y0, y1, step):
        if (i - y0) % sparse == 0:
            first, last = deep_span(state, shape, inverse, i, deep)
            for j in range(max(first, x0), min(last, x1), sparse):
                add_core(pixels, i, j, light, core_sums)
        hole, end = deep_span(state, shape, inverse, i, inner)
        j = x0
        while j < x1:
            if hole <= j < end:
                j += (end - j + step - 1) // step * step
                continue
            place_row(places, state, inverse, i, j, step)
            for k in range(min((x1 - j + step - 1) // step, PLACES)):
                if inner2 < places[NEAR + k] < outer2:
                    add_level(pixels, i, j + k * step, light, int(places[SECTOR + k]), levels)
            j += PLACES * step
    if core_sums[0, 0] < max(FEWEST_IN_CORE, 0.2 * core_sums[1, 0]):
        core_sums[0] += core_sums[1]
    return ball_colour(core_sums[0], paint, room.ball)


@spliced_kernel
def add_core(pixels, i, j, light, sums):
    """Add a pixel of the core to the sums: of whole ones, or of those the picture cut off."""
    b, g, e = pixels[i, j, 0], pixels[i, j, 1], pixels[i, j, 2]
    k = 0 if max(b, g, e) < CLIPPED else 1
    sums[k, 0] += 1.0
    sums[k, 1] += light[b]
    sums[k, 2] += light[g]
    sums[k, 3] += light[e]


@spliced_kernel
def add_level(pixels, i, j, light, s, levels):
    """Add a pixel of the ring to its sector's sums."""
    b, g, e = light[pixels[i, j, 0]], light[pixels[i, j, 1]], light[pixels[i, j, 2]]
    levels[s, 0] += 1.0
    levels[s, 1] += b
    levels[s, 2] += g
    levels[s, 3] += e
    levels[s, 4] += b * b
    levels[s, 5] += b * g
    levels[s, 6] += b * e
    levels[s, 7] += g * g
    levels[s, 8] += g * e
    levels[s, 9] += e * e


@kernel
def ball_colour(sums, paint, ball):
    """Write the ball's colour from the sum over its core and what was known; return its angle.

    The core's mean has a direction of sd CORE_NOISE / sqrt(n); a core that is too small has none.
    """
    known = math.sqrt(paint.colour[0] ** 2 + paint.colour[1] ** 2 + paint.colour[2] ** 2)
    n = sums[0]
    if n < FEWEST_IN_CORE:
        for k in range(3):
            ball[k] = paint.colour[k] / known
        ball[3], ball[4] = paint.tolerance, UNMEASURED * known
        return 0.0
    size = math.sqrt(sums[1] ** 2 + sums[2] ** 2 + sums[3] ** 2) + 1e-9
    noise = CORE_NOISE / math.sqrt(n)
    trust = paint.tolerance**2 / (paint.tolerance**2 + noise**2)
    dot, total = 0.0, 0.0
    for k in range(3):
        old, new = paint.colour[k] / known, sums[1 + k] / size
        dot += old * new
        ball[k] = trust * new + (1.0 - trust) * old
        total += ball[k] ** 2
    for k in range(3):
        ball[k] /= math.sqrt(total)
    ball[3], ball[4] = math.sqrt(trust) * noise, size / n
    return math.acos(min(dot, 1.0))


@kernel
def mix(paint, room):
    """Write per sector what turns linear light into alpha.

    alpha = w.(c - g) / w.D, w = S^-1 D, D = ball - background g, and S the scatter of both:
    noise + (shading B)^2 b b^T + that of the ring, pooled with the neighbours'.
    """
    levels, matte, ball = room.levels, room.matte, room.ball
    noise, pooled = ring_noise(levels), np.empty(LEVELS_PER_SECTOR)
    is_shaded = ball[5] != 0.0 or ball[6] != 0.0 or ball[7] != 0.0
    shading = paint.shading if is_shaded else max(paint.shading, UNSHADED)
    matte[:] = 0.0
    for s in range(SECTORS):
        if levels[s, 0] < FEWEST_IN_SECTOR:
            continue
        before, after = levels[(s + SECTORS - 1) % SECTORS], levels[(s + 1) % SECTORS]
        for k in range(LEVELS_PER_SECTOR):
            pooled[k] = levels[s, k] + NEIGHBOUR * (before[k] + after[k])
        bright = max(brightness(ball, COSINES[s], SINES[s]), 1.0)
        mix_sector(levels[s], pooled, ball, bright, shading, noise, matte[s])


@spliced_kernel
def mix_sector(level, pooled, ball, bright, shading, noise, mixed):
    """Write what turns linear light into alpha in one sector.

    `pooled` is the ring's; S is inverted by its cofactors.
    """
    n, total, rest = level[0], pooled[0], 1.0 / (pooled[0] - 1.0)
    g0, g1, g2 = level[1] / n, level[2] / n, level[3] / n
    d0, d1, d2 = bright * ball[0] - g0, bright * ball[1] - g1, bright * ball[2] - g2
    r00 = (pooled[4] - 2.0 * pooled[1] * g0 + total * g0 * g0) * rest
    r01 = (pooled[5] - pooled[1] * g1 - pooled[2] * g0 + total * g0 * g1) * rest
    r02 = (pooled[6] - pooled[1] * g2 - pooled[3] * g0 + total * g0 * g2) * rest
    r11 = (pooled[7] - 2.0 * pooled[2] * g1 + total * g1 * g1) * rest
    r12 = (pooled[8] - pooled[2] * g2 - pooled[3] * g1 + total * g1 * g2) * rest
    r22 = (pooled[9] - 2.0 * pooled[3] * g2 + total * g2 * g2) * rest
    uncertain = (shading * bright) ** 2
    s00 = r00 + noise + uncertain * ball[0] * ball[0]
    s01, s02 = r01 + uncertain * ball[0] * ball[1], r02 + uncertain * ball[0] * ball[2]
    s11 = r11 + noise + uncertain * ball[1] * ball[1]
    s12 = r12 + uncertain * ball[1] * ball[2]
    s22 = r22 + noise + uncertain * ball[2] * ball[2]
    c00, c01, c02 = s11 * s22 - s12 * s12, s02 * s12 - s01 * s22, s01 * s12 - s02 * s11
    c11, c12, c22 = s00 * s22 - s02 * s02, s01 * s02 - s00 * s12, s00 * s11 - s01 * s01
    determinant = s00 * c00 + s01 * c01 + s02 * c02
    w0 = (c00 * d0 + c01 * d1 + c02 * d2) / determinant
    w1 = (c01 * d0 + c11 * d1 + c12 * d2) / determinant
    w2 = (c02 * d0 + c12 * d1 + c22 * d2) / determinant
    size = w0 * d0 + w1 * d1 + w2 * d2
    if size > 1.0:  # more than one sd between ball and background
        w0, w1, w2 = w0 / size, w1 / size, w2 / size
        own = w0 * ball[0] + w1 * ball[1] + w2 * ball[2]
        along = w0 * (w0 * r00 + 2.0 * (w1 * r01 + w2 * r02))
        spread = along + w1 * (w1 * r11 + 2.0 * w2 * r12) + w2 * w2 * r22
        mixed[0], mixed[1], mixed[2] = w0, w1, w2
        mixed[3] = w0 * g0 + w1 * g1 + w2 * g2
        mixed[4] = noise * (w0 * w0 + w1 * w1 + w2 * w2)
        mixed[5] = max(spread, mixed[4])
        mixed[7] = own * own * uncertain
        mixed[6], mixed[8], mixed[9] = n, own, bright


@kernel
def ring_noise(levels):
    """Return the lower quartile over sectors of the variance in the ring, mean of the colours."""
    variances, count = np.zeros(SECTORS), 0
    for s in range(SECTORS):
        n = levels[s, 0]
        if n >= FEWEST_IN_SECTOR:
            total = 0.0
            for k in range(3):
                total -= (levels[s, 1 + k] / n) ** 2
            total += (levels[s, 4] + levels[s, 7] + levels[s, 9]) / n
            variances[count] = total / 3.0 * n / (n - 1.0)
            count += 1
    if count == 0:
        return LEAST_NOISE
    return max(np.sort(variances[:count])[count // 4], LEAST_NOISE)


@kernel
def level_variance(matte, s):
    """Return the variance of alpha that a sector's wrong background makes: texture and noise."""
    return TEXTURE * max(matte[s, 5] - matte[s, 4], 0.0) + matte[s, 4] / matte[s, 6]
