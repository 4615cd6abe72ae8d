"""Alpha about the outline of one ball, compiled: its edge's pixels, its area's moments."""

import math

import numpy as np

from rotorpong.kernels import kernel, spliced_kernel
from rotorpong.vision._matte_kernels import (
    CLIPPED,
    FEWEST_IN_SECTOR,
    MATTE_PER_SECTOR,
    level_variance,
)
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
from rotorpong.vision._trace_kernels import ALPHA, INVERSE, LANES, F, X, Y

FINENESS = 4  # directions per sector in which alpha is taken
DIRECTIONS, FINE = FINENESS * SECTORS, np.float32(FINENESS)
SHARE, OWNER = MATTE_PER_SECTOR, MATTE_PER_SECTOR + 1
LEAST_SHARE = 0.25  # of a pixel's two sectors that must have a background
LEAST_DIVISOR = 0.2
CLIPPED_ALPHA = 0.7  # such a pixel shows the ball
CLAMP = 0.3  # of alpha beyond 0 and 1, in the area
ENOUGH = 340  # pixels of the edge: of larger ones every second, third, ... is left
BAND, BAND_MARGIN = 2.5, 0.5  # edge pixels lie within 2.5 sigma + 0.5 px of the outline


@kernel
def blend(matte, blended):
    """Write the matte in DIRECTIONS, between the middles of the sectors that have one.

    Then what share of a direction's two sectors has one, and which has most of it.
    """
    for m in range(DIRECTIONS):
        place = (m + 0.5) / FINENESS + (SECTORS - 0.5)
        s0 = int(place)
        k1 = place - s0
        s0, s1 = s0 % SECTORS, (s0 + 1) % SECTORS
        k0 = 1.0 - k1 if matte[s0, 6] >= FEWEST_IN_SECTOR else 0.0
        k1 = k1 if matte[s1, 6] >= FEWEST_IN_SECTOR else 0.0
        whole = 1.0 / max(k0 + k1, LEAST_SHARE)
        for k in range(MATTE_PER_SECTOR):
            blended[m, k] = whole * (k0 * matte[s0, k] + k1 * matte[s1, k])
        blended[m, SHARE], blended[m, OWNER] = k0 + k1, s0 if k0 > k1 else s1


@kernel
def gather(pixels, state, shape, inverse, margins, step, paint, room, area):
    """Write the band of pixels around the outline, and the moments of alpha up to the ring.

    `area` gets: sum of alpha, of alpha q; pixels without background; variances of the sums. Return
    how many pixels the band has.
    """
    core, gap, _ = margins
    r, places, band, owners = state[2], room.places, room.band, room.owners
    light, blended, ball, sums = paint.light, room.blended, room.ball, room.moments
    blend(room.matte, blended)
    area[:] = 0.0
    sums[:] = 0.0
    count, deep, outer2 = 0, r - core, F((r + gap) ** 2)
    half = BAND * math.sqrt(state[5]) + BAND_MARGIN
    least, most = F(max(r - half, 0.0) ** 2), F((r + half) ** 2)
    is_shaded = ball[5] != 0.0 or ball[6] != 0.0 or ball[7] != 0.0
    every, stride = thinning(state, half)
    x0, x1, y0, y1 = box_around(pixels, state, shape, r + gap)
    for i in range(y0, y1, step):
        hole, end = deep_span(state, shape, inverse, i, deep)
        hole, end = max(hole, x0), min(end, x1)
        j = x0
        while j < x1:
            if hole <= j < end:
                inside = (end - j + step - 1) // step
                add_inside(state, inverse, i, j, inside, step, area)
                j += inside * step
                continue
            place_row(places, state, inverse, i, j, step)
            ahead = hole if j < hole < end else x1
            until = min((ahead - j + step - 1) // step, PLACES)
            for k in range(until):
                near = places[NEAR + k]
                if near >= outer2:
                    continue
                m = int(places[SECTOR + k] * FINE)
                if blended[m, SHARE] < LEAST_SHARE:
                    area[3] += 1.0
                    continue
                qx, qy = float(places[k]), float(places[PLACES + k])
                bright = brightness(ball, qx / r, qy / r) if is_shaded else -math.inf
                alpha, variance, is_clipped = alpha_of(
                    pixels, i, j + k * step, m, bright, light, blended
                )
                owner = int(blended[m, OWNER])
                add_moments(alpha, variance, qx, qy, owner, sums)
                if is_clipped or not least < near < most or count == owners.shape[0]:
                    continue
                if every == 1 or (i + stride * (j + k * step)) % every == 0:
                    line, lane = count // LANES, count % LANES
                    band[line, X + lane], band[line, Y + lane] = qx, qy
                    band[line, ALPHA + lane] = alpha
                    band[line, INVERSE + lane] = 1.0 / variance
                    owners[count] = owner
                    count += 1
            j += until * step
    fill_line(band, count)
    add_sectors(sums, room.matte, float(step * step), area)
    return count


@kernel
def thinning(state, half):
    """Return of how many pixels of the band one is kept, and on which lattice: enough of them stay.

    Row + stride * column is a multiple of that number: Fibonacci lattices, even in all directions.
    """
    outline = 2.0 * math.pi * state[2] + 4.0 * math.hypot(state[3], state[4])
    share, before, every = 2.0 * half * outline / ENOUGH, 1, 1
    while share > 1.5 * every - 0.5:
        before, every = every, before + every
    return every, max(every - before, 1)


@kernel
def fill_line(band, count):
    """Fill the last line of a band with pixels that count nothing."""
    for n in range(count, (count + LANES - 1) // LANES * LANES):
        line, lane = n // LANES, n % LANES
        band[line, X + lane], band[line, Y + lane] = 0.0, 0.0
        band[line, ALPHA + lane], band[line, INVERSE + lane] = 0.0, 0.0


@spliced_kernel
def add_inside(state, inverse, row, first, count, step, area):
    """Add pixels of a row that are all ball to the area's moments."""
    along, dy = count * (first - state[0] + 0.5 * step * (count - 1)), count * (row - state[1])
    area[0] += count
    area[1] += inverse[0, 0] * along + inverse[0, 1] * dy
    area[2] += inverse[1, 0] * along + inverse[1, 1] * dy


@spliced_kernel
def alpha_of(pixels, i, j, m, bright, light, blended):
    """Return alpha of a pixel in direction m, its variance, and whether it is cut off.

    `bright` is the ball's brightness there, -inf for a ball that is not shaded.
    """
    b, g, e = pixels[i, j, 0], pixels[i, j, 1], pixels[i, j, 2]
    alpha = blended[m, 0] * light[b] + blended[m, 1] * light[g] + blended[m, 2] * light[e]
    alpha -= blended[m, 3]
    if bright > -math.inf:
        alpha /= max(1.0 + blended[m, 8] * (bright - blended[m, 9]), LEAST_DIVISOR)
    is_clipped = max(b, g, e) >= CLIPPED and alpha > CLIPPED_ALPHA
    if is_clipped:
        alpha = 1.0
    under = 1.0 - min(max(alpha, 0.0), 1.0)
    over, noise = 1.0 - under, blended[m, 4]
    variance = noise + under * under * (blended[m, 5] - noise) + over * over * blended[m, 7]
    return alpha, variance, is_clipped


@spliced_kernel
def add_moments(alpha, variance, qx, qy, owner, sums):
    """Add a pixel's alpha and its variance to its sector's moments.

    And 1 - alpha, which is what a level that is off by 1 moves.
    """
    under, held = 1.0 - min(max(alpha, 0.0), 1.0), min(max(alpha, -CLAMP), 1.0 + CLAMP)
    sums[owner, 0] += under
    sums[owner, 1] += under * qx
    sums[owner, 2] += under * qy
    sums[owner, 3] += held
    sums[owner, 4] += held * qx
    sums[owner, 5] += held * qy
    sums[owner, 6] += variance
    sums[owner, 7] += variance * qx * qx
    sums[owner, 8] += variance * qy * qy


@kernel
def add_sectors(sums, matte, share, area):
    """Add the sectors' sums to the area's, and to its variances what wrong backgrounds do.

    Each pixel stands for `share` of them.
    """
    for s in range(SECTORS):
        for k in range(3):
            area[k] += sums[s, 3 + k]
            area[4 + k] += sums[s, 6 + k]
    area *= share
    for s in range(SECTORS):
        if matte[s, 6] >= FEWEST_IN_SECTOR:
            texture = level_variance(matte, s) * share * share
            for k in range(3):
                area[4 + k] += texture * sums[s, k] ** 2
