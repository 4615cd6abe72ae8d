"""The matte of one ball, compiled; the equations are in `matte`.

All places are in the ball's own frame q = shape^-1 (pixel - centre), in which its outline is a
circle, or a capsule while it moves: the points within r of the segment from -u to u.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel, spliced_kernel
from rotorpong.vision._linear_kernels import solve
from rotorpong.vision._outline_kernels import SECTORS, box_around, capsule, sector_around
from rotorpong.vision._shade_kernels import brightness

LEVELS_PER_SECTOR = 10  # how many pixels; sums of b, g, r; of bb, bg, br, gg, gr, rr
MATTE_PER_SECTOR = 10  # w; w.g; noise's, background's variance of alpha; pixels; shading's variance
# of alpha, w.b, brightness at the rim
FEWEST_IN_SECTOR, FEWEST_IN_CORE = 3, 4  # pixels
NEIGHBOUR = 0.5  # weight of the next sectors in the scatter of the ring
TEXTURE = 2.5  # neighbouring sectors err together
CLIPPED = 254  # levels: from here on the picture may have cut off
CLIPPED_ALPHA = 0.7  # such a pixel shows the ball
CLAMP = 0.3  # of alpha beyond 0 and 1, in the area
LEAST_NOISE = 0.15  # variance in levels of linear light: rounding
CORE_NOISE = 0.05  # relative, of a pixel of the ball
UNMEASURED = 0.8  # brightness of a ball without a core, in that of its paint
UNSHADED = 0.25  # sd of the brightness where it is not
LEAST_SHARE = 0.25  # of a pixel's two sectors that must have a background
LEAST_DIVISOR = 0.2
THINNED_RADIUS, THINNED_HALF_STREAK = 12.0, 5.0  # px: then half the edge pixels will do
BAND, BAND_MARGIN = 2.5, 0.5  # edge pixels lie within 2.5 sigma + 0.5 px of the outline


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
    ball: np.ndarray  # (8,): direction of the colour, its sd; ambient brightness, lamp x, y, z
    band: np.ndarray  # (n, 5): q, alpha, one over its variance, sector


@kernel
def look(pixels, state, shape, inverse, margins, step, paint, room):
    """Sum the background's levels per sector of the ring, and the ball's colour over its core.

    Margins are those of core, gap and ring, from the outline and from each other; every `step`-th
    row and column is read.
    """
    core, gap, width = margins
    x, y, r, ux, uy = state[0], state[1], state[2], state[3], state[4]
    uu = ux * ux + uy * uy
    levels, light = room.levels, paint.light
    levels[:] = 0.0
    core_sums = np.zeros((2, 4))
    inner, outer, deep = r + gap, r + gap + width, r - core
    inner2, outer2, deep2 = inner * inner, outer * outer, max(deep, 0.0) ** 2
    x0, x1, y0, y1 = box_around(pixels, state, shape, outer)
    for i in range(y0, y1, step):
        for j in range(x0, x1, step):
            dx, dy = j - x, i - y
            qx, qy = (
                inverse[0, 0] * dx + inverse[0, 1] * dy,
                inverse[1, 0] * dx + inverse[1, 1] * dy,
            )
            squared = qx * qx + qy * qy
            if uu == 0.0 and (squared >= outer2 or deep2 <= squared <= inner2):
                continue
            near, far = capsule(qx, qy, ux, uy, uu)
            if far < deep2:
                b, g, e = pixels[i, j, 0], pixels[i, j, 1], pixels[i, j, 2]
                k = 0 if max(b, g, e) < CLIPPED else 1
                core_sums[k, 0] += 1.0
                core_sums[k, 1] += light[b]
                core_sums[k, 2] += light[g]
                core_sums[k, 3] += light[e]
            elif inner2 < near < outer2:
                b, g, e = light[pixels[i, j, 0]], light[pixels[i, j, 1]], light[pixels[i, j, 2]]
                s = int(sector_around(qx, qy, r, ux, uy, uu))
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
    if core_sums[0, 0] < max(FEWEST_IN_CORE, 0.2 * core_sums[1, 0]):
        core_sums[0] += core_sums[1]
    return ball_colour(core_sums[0], paint, room.ball)


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
    """Write per sector what turns linear light into alpha; return the noise of the light.

    alpha = w.(c - g) / w.D, w = S^-1 D, D = ball - background g, and S the scatter of both:
    noise + (shading B)^2 b b^T + that of the ring, pooled with the neighbours'.
    """
    levels, matte, ball = room.levels, room.matte, room.ball
    noise = ring_noise(levels)
    is_shaded = ball[5] != 0.0 or ball[6] != 0.0 or ball[7] != 0.0
    shading = paint.shading if is_shaded else max(paint.shading, UNSHADED)
    scatter, ring, w, d, g = (
        np.zeros((3, 3)),
        np.zeros((3, 3)),
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
    )
    for s in range(SECTORS):
        n = levels[s, 0]
        matte[s, 6] = n
        if n < FEWEST_IN_SECTOR:
            continue
        angle = (s + 0.5) * (2.0 * math.pi / SECTORS)
        bright = max(brightness(ball, math.cos(angle), math.sin(angle)), 1.0)
        for k in range(3):
            g[k] = levels[s, 1 + k] / n
            d[k] = bright * ball[k] - g[k]
            w[k] = d[k]
        ring_scatter(levels, s, g, ring)
        uncertain = (shading * bright) ** 2
        for i in range(3):
            for j in range(3):
                scatter[i, j] = uncertain * ball[i] * ball[j] + ring[i, j]
            scatter[i, i] += noise
        solve(scatter, w, 3)
        size = w[0] * d[0] + w[1] * d[1] + w[2] * d[2]
        if not size > 1.0:  # less than one sd between ball and background
            matte[s, 6] = 0.0
            continue
        spread, offset, own, squared = 0.0, 0.0, 0.0, 0.0
        for i in range(3):
            w[i] /= size
            offset += w[i] * g[i]
            own += w[i] * ball[i]
            squared += w[i] * w[i]
        for i in range(3):
            for j in range(3):
                spread += w[i] * w[j] * ring[i, j]
            matte[s, i] = w[i]
        matte[s, 3] = offset
        matte[s, 4] = noise * squared
        matte[s, 5] = max(spread, matte[s, 4])
        matte[s, 7] = own * own * uncertain
        matte[s, 8] = own
        matte[s, 9] = bright
    return noise


@kernel
def ring_scatter(levels, s, g, ring):
    """Write the scatter of the ring about g, this sector's mean, in it and its neighbours."""
    total = 0.0
    ring[:] = 0.0
    for step in range(-1, 2):
        level = levels[(s + step) % SECTORS]
        share = NEIGHBOUR if step != 0 else 1.0
        total += share * level[0]
        k = 4
        for i in range(3):
            for j in range(i, 3):
                value = level[k] - level[1 + i] * g[j] - level[1 + j] * g[i]
                ring[i, j] += share * (value + level[0] * g[i] * g[j])
                k += 1
    for i in range(3):
        for j in range(i, 3):
            ring[i, j] /= total - 1.0
            ring[j, i] = ring[i, j]


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
def gather(pixels, state, shape, inverse, margins, step, paint, room, area):
    """Write the band of pixels around the outline, and the moments of alpha up to the ring.

    `area` gets: sum of alpha, of alpha q; pixels without background; variances of the sums. Return
    how many pixels the band has.
    """
    core, gap, _ = margins
    x, y, r, ux, uy = state[0], state[1], state[2], state[3], state[4]
    uu, band, ball = ux * ux + uy * uy, room.band, room.ball
    area[:] = 0.0
    count, outer, outer2, deep2 = 0, r + gap, (r + gap) ** 2, max(r - core, 0.0) ** 2
    is_shaded = ball[5] != 0.0 or ball[6] != 0.0 or ball[7] != 0.0
    is_thinned = r > THINNED_RADIUS or uu > THINNED_HALF_STREAK**2
    half = BAND * math.sqrt(state[5]) + BAND_MARGIN
    lost = np.zeros((SECTORS, 3))  # 1 - alpha, and times q: what a level's error moves
    x0, x1, y0, y1 = box_around(pixels, state, shape, outer)
    for i in range(y0, y1, step):
        for j in range(x0, x1, step):
            dx, dy = j - x, i - y
            qx = inverse[0, 0] * dx + inverse[0, 1] * dy
            qy = inverse[1, 0] * dx + inverse[1, 1] * dy
            near, far = capsule(qx, qy, ux, uy, uu)
            if near >= outer2:
                continue
            alpha, variance = 1.0, 0.0
            if far >= deep2:
                sectors = sector_around(qx, qy, r, ux, uy, uu)
                s0, s1, k0, k1 = sectors_and_shares(room.matte, sectors)
                if k0 + k1 < LEAST_SHARE:
                    area[3] += 1.0
                    continue
                bright = brightness(ball, qx / r, qy / r) if is_shaded else -math.inf
                levels = pixels[i, j, 0], pixels[i, j, 1], pixels[i, j, 2]
                alpha, variance, is_clipped = alpha_of(
                    levels, s0, s1, k0, k1, bright, paint.light, room.matte
                )
                owner, under = s0 if k0 > k1 else s1, 1.0 - min(max(alpha, 0.0), 1.0)
                lost[owner, 0] += under
                lost[owner, 1] += under * qx
                lost[owner, 2] += under * qy
                is_kept = not is_clipped and ((i + j) % 2 == 0 or not is_thinned)
                if abs(math.sqrt(near) - r) < half and count < band.shape[0] and is_kept:
                    band[count, 0], band[count, 1], band[count, 2] = qx, qy, alpha
                    band[count, 3], band[count, 4] = 1.0 / variance, owner
                    count += 1
            add_moments(min(max(alpha, -CLAMP), 1.0 + CLAMP), variance, qx, qy, area)
    area *= float(step * step)
    lost *= float(step * step)
    add_wrong_levels(lost, room.matte, area)
    return count


@spliced_kernel
def sectors_and_shares(matte, sectors):
    """Return the two sectors whose middles a place lies between, and their shares, 0 if unknown."""
    place = sectors - 0.5
    s0 = math.floor(place)
    share = place - s0
    s1 = (s0 + 1) % SECTORS
    s0 %= SECTORS
    k0 = (1.0 - share) if matte[s0, 6] >= FEWEST_IN_SECTOR else 0.0
    k1 = share if matte[s1, 6] >= FEWEST_IN_SECTOR else 0.0
    return s0, s1, k0, k1


@spliced_kernel
def alpha_of(levels, s0, s1, k0, k1, bright, light, matte):
    """Return alpha of a pixel between two sectors, its variance, and whether it is cut off.

    `bright` is the ball's brightness there, -inf for a ball that is not shaded.
    """
    b, g, e = levels
    lb, lg, le = light[b], light[g], light[e]
    a0 = (
        matte[s0, 0] * lb + matte[s0, 1] * lg + matte[s0, 2] * le - matte[s0, 3]
        if k0 > 0.0
        else 0.0
    )
    a1 = (
        matte[s1, 0] * lb + matte[s1, 1] * lg + matte[s1, 2] * le - matte[s1, 3]
        if k1 > 0.0
        else 0.0
    )
    alpha = (k0 * a0 + k1 * a1) / (k0 + k1)
    noise = (k0 * matte[s0, 4] + k1 * matte[s1, 4]) / (k0 + k1)
    spread = (k0 * matte[s0, 5] + k1 * matte[s1, 5]) / (k0 + k1)
    if bright > -math.inf:
        slope = (k0 * matte[s0, 8] + k1 * matte[s1, 8]) / (k0 + k1)
        rim = (k0 * matte[s0, 9] + k1 * matte[s1, 9]) / (k0 + k1)
        alpha /= max(1.0 + slope * (bright - rim), LEAST_DIVISOR)
    is_clipped = max(b, g, e) >= CLIPPED and alpha > CLIPPED_ALPHA
    if is_clipped:
        alpha = 1.0
    under = 1.0 - min(max(alpha, 0.0), 1.0)
    shaded = (k0 * matte[s0, 7] + k1 * matte[s1, 7]) / (k0 + k1)
    over = 1.0 - under
    return alpha, noise + under * under * (spread - noise) + over * over * shaded, is_clipped


@spliced_kernel
def add_moments(alpha, variance, qx, qy, area):
    """Add a pixel's alpha and its variance to the area's moments."""
    area[0] += alpha
    area[1] += alpha * qx
    area[2] += alpha * qy
    if variance > 0.0:
        area[4] += variance
        area[5] += variance * qx * qx
        area[6] += variance * qy * qy


@kernel
def add_wrong_levels(lost, matte, area):
    """Add to the area's variances what each sector's wrong background does."""
    for s in range(SECTORS):
        if matte[s, 6] >= FEWEST_IN_SECTOR:
            texture = level_variance(matte, s)
            area[4] += texture * lost[s, 0] ** 2
            area[5] += texture * lost[s, 1] ** 2
            area[6] += texture * lost[s, 2] ** 2


@kernel
def level_variance(matte, s):
    """Return the variance of alpha that a sector's wrong background makes: texture and noise."""
    return TEXTURE * max(matte[s, 5] - matte[s, 4], 0.0) + matte[s, 4] / matte[s, 6]
