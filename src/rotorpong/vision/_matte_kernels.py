"""The matte of one ball, compiled; the equations are in `matte`.

All places are in the ball's own frame q = shape^-1 (pixel - centre), in which its outline is a
circle, or a capsule while it moves: the points within r of the segment from -u to u.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel

SECTORS = 24
LEVELS_PER_SECTOR = 10  # how many pixels; sums of b, g, r; of bb, bg, br, gg, gr, rr
MATTE_PER_SECTOR = (
    8  # weights of b, g, r; offset; noise and background variance of alpha; pixels; shading
)
FEWEST_IN_SECTOR = 3
FEWEST_IN_CORE = 4
CLIPPED = 254  # levels: from here on the picture may have cut off
CLIPPED_ALPHA = 0.7  # such a pixel shows the ball
LEAST_NOISE = 0.15  # variance in levels of linear light: rounding
RIDGE_OF_SHADE = 0.01
BAND, BAND_MARGIN = 2.5, 0.6  # edge pixels lie within 2.5 sigma + 0.6 px of the outline
LEAST_SPREAD = 0.06  # px^2, variance of the edge: a pixel has 1/12
PARAMETERS = 6  # of the edge: x, y, r, a, b, c
STEPS = 6
SMALLEST_STEP = 2e-3  # px
CLIP = 2.5  # of residuals, in their sd
TURNS = 6
NEIGHBOUR = 0.5  # weight of the next sectors in the scatter of the ring
TRUSTED = 0.3  # relative sd of an area to start from
CLAMP = 0.3  # of alpha beyond 0 and 1, in the area
FIRST_GAP, GAP, RING = 1.5, 3.0, 3.0
CLOSE = 0.2
SURE = 3.0  # sd
MOST_BAND = 8192  # pixels of an edge
LEAST_MOTION = 1.5  # px, of a streak that is fitted as a motion
MOVING = 2.2  # px: longer streaks are motions, shorter ones an edge of uneven spread
NODE_SPACING, MOST_NODES = 1.2, 14
TEXTURE = 2.5  # neighbouring sectors err together
FLOOR_SD = 0.004  # px: what sampling and the model of the edge leave

TABLE_REACH, TABLE_FINENESS = 4.5, 128
_GRID = np.arange(int(2 * TABLE_REACH * TABLE_FINENESS) + 2) / TABLE_FINENESS - TABLE_REACH
NORMAL_CDF = np.array([0.5 * math.erfc(-z / math.sqrt(2.0)) for z in _GRID])
NORMAL_PDF = np.exp(-0.5 * _GRID**2) / math.sqrt(2.0 * math.pi)


class Paint(NamedTuple):
    """What is known of the ball's colour and of the picture's response."""

    light: np.ndarray  # (256,) linear light of a level, 0 .. 255
    colour: np.ndarray  # (3,) of the ball, linear light
    tolerance: float  # sd of its direction, rad
    shading: float  # sd of its brightness, relative, about what the fit says


class Found(NamedTuple):
    """Two measurements of a ball, in its own frame."""

    area: np.ndarray  # (6,): x, y, r and their variances
    edge: np.ndarray  # (6,): x, y, r, a and b, c or u
    covariance: np.ndarray  # (6, 6) of the edge
    about: np.ndarray  # (8,): fit's scale, share of sectors with a background, angle of the
    # colour to the known one, rms residual of alpha, whether all of it is seen, colour


class Room(NamedTuple):
    """Memory for one measurement."""

    levels: np.ndarray  # (SECTORS, LEVELS_PER_SECTOR)
    matte: np.ndarray  # (SECTORS, MATTE_PER_SECTOR)
    ball: np.ndarray  # (8,): direction of the colour, its sd, brightness 1, nx, ny, nz
    band: np.ndarray  # (n, 5): q, alpha, variance, sector


@kernel
def sector_of(x, y):
    """Return the angle of (x, y) in sectors, 0 <= s < SECTORS, good to 0.02 of one."""
    ax, ay = abs(x), abs(y)
    small, large = min(ax, ay), max(ax, ay)
    z = small / large if large > 0.0 else 0.0
    angle = z * (0.785398 + 0.273 * (1.0 - z))
    if ay > ax:
        angle = 1.570796 - angle
    if x < 0.0:
        angle = 3.141593 - angle
    if y < 0.0:
        angle = 6.283185 - angle
    s = angle * (SECTORS / 6.283185307)
    return s if s < SECTORS else 0.0


@kernel
def capsule(qx, qy, ux, uy, uu):
    """Return distance from the segment -u .. u, and from the farther of its ends."""
    if uu == 0.0:
        distance = math.sqrt(qx * qx + qy * qy)
        return distance, distance
    along = qx * ux + qy * uy
    t = min(max(along / uu, -1.0), 1.0)
    near = math.hypot(qx - t * ux, qy - t * uy)
    return near, math.sqrt(qx * qx + qy * qy + 2.0 * abs(along) + uu)


@kernel
def sector_around(qx, qy, r, ux, uy, uu):
    """Return the sector of a place as it is seen from a capsule that is squeezed to a circle."""
    if uu == 0.0:
        return sector_of(qx, qy)
    length = math.sqrt(uu)
    along = (qx * ux + qy * uy) / uu * length / (r + length)
    return sector_of(qx - along * ux, qy - along * uy)


@kernel
def box_around(pixels, state, shape, reach):
    """Return x0, x1, y0, y1 (ends exclusive) of the pixels within `reach` of the segment."""
    ux = abs(shape[0, 0] * state[3] + shape[0, 1] * state[4])
    uy = abs(shape[1, 0] * state[3] + shape[1, 1] * state[4])
    half_x = reach * math.hypot(shape[0, 0], shape[0, 1]) + ux
    half_y = reach * math.hypot(shape[1, 0], shape[1, 1]) + uy
    x0, x1 = int(math.floor(state[0] - half_x)), int(math.ceil(state[0] + half_x)) + 1
    y0, y1 = int(math.floor(state[1] - half_y)), int(math.ceil(state[1] + half_y)) + 1
    return max(x0, 0), min(x1, pixels.shape[1]), max(y0, 0), min(y1, pixels.shape[0])


@kernel
def look(pixels, state, shape, inverse, gap, width, core, paint, room):
    """Gather the background's levels per sector from the ring, and the ball's colour from its core.

    The ring is `width` wide and begins `gap` outside the outline; the core is `core` inside it.
    """
    x, y, r, ux, uy = state[0], state[1], state[2], state[3], state[4]
    uu = ux * ux + uy * uy
    levels, light = room.levels, paint.light
    levels[:] = 0.0
    sums, squares, rhs, clipped = np.zeros(4), np.zeros((4, 4)), np.zeros(4), np.zeros(4)
    inner, outer, deep = r + gap, r + gap + width, r - core
    x0, x1, y0, y1 = box_around(pixels, state, shape, outer)
    for i in range(y0, y1):
        for j in range(x0, x1):
            dx, dy = j - x, i - y
            qx, qy = (
                inverse[0, 0] * dx + inverse[0, 1] * dy,
                inverse[1, 0] * dx + inverse[1, 1] * dy,
            )
            near, far = capsule(qx, qy, ux, uy, uu)
            if far < deep:
                b, g, e = pixels[i, j, 0], pixels[i, j, 1], pixels[i, j, 2]
                into = clipped if max(b, g, e) >= CLIPPED else sums
                into[0] += 1.0
                into[1] += light[b]
                into[2] += light[g]
                into[3] += light[e]
            elif inner < near < outer:
                b, g, e = light[pixels[i, j, 0]], light[pixels[i, j, 1]], light[pixels[i, j, 2]]
                level = levels[int(sector_around(qx, qy, r, ux, uy, uu))]
                level[0] += 1.0
                level[1] += b
                level[2] += g
                level[3] += e
                level[4] += b * b
                level[5] += b * g
                level[6] += b * e
                level[7] += g * g
                level[8] += g * e
                level[9] += e * e
    if sums[0] < max(FEWEST_IN_CORE, 0.2 * clipped[0]):
        sums += clipped
    return ball_colour(sums, paint, room.ball)


@kernel
def ball_colour(sums, paint, ball):
    """Write the ball's colour from the sum over its core and what was known; return its angle.

    The core's mean has a direction of sd noise / (brightness sqrt(n)), here 0.05 / sqrt(n), or
    that of the paint if the core is too small.
    """
    known = math.sqrt(paint.colour[0] ** 2 + paint.colour[1] ** 2 + paint.colour[2] ** 2)
    n = sums[0]
    if n < FEWEST_IN_CORE:
        for k in range(3):
            ball[k] = paint.colour[k] / known
        ball[3], ball[4] = paint.tolerance, 0.8 * known
        return 0.0
    size = math.sqrt(sums[1] ** 2 + sums[2] ** 2 + sums[3] ** 2) + 1e-9
    noise = 0.05 / math.sqrt(n)
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
def shade(pixels, state, inverse, core, paint, ball):
    """Write the brightness of the ball over its normal: B = s0 + s1 nx + s2 ny + s3 nz.

    Least squares over the core, a ridge on all but s0; a Lambert ball in diffuse light is that.
    """
    x, y, r = state[0], state[1], state[2]
    squares, rhs, n = np.zeros((4, 4)), np.zeros(4), np.ones(4)
    deep = r - core
    for i in range(max(int(y - deep), 0), min(int(y + deep) + 2, pixels.shape[0])):
        for j in range(max(int(x - deep), 0), min(int(x + deep) + 2, pixels.shape[1])):
            dx, dy = j - x, i - y
            qx = (inverse[0, 0] * dx + inverse[0, 1] * dy) / r
            qy = (inverse[1, 0] * dx + inverse[1, 1] * dy) / r
            squared = qx * qx + qy * qy
            if squared * r * r < deep * deep:
                n[1], n[2], n[3] = qx, qy, math.sqrt(1.0 - squared)
                value = 0.0
                for k in range(3):
                    value += ball[k] * paint.light[pixels[i, j, k]]
                for a in range(4):
                    rhs[a] += n[a] * value
                    for b in range(a + 1):
                        squares[a, b] += n[a] * n[b]
    count = squares[0, 0]
    ball[5], ball[6], ball[7] = 0.0, 0.0, 0.0
    if count < 4 * FEWEST_IN_CORE:
        return
    for a in range(4):
        for b in range(a):
            squares[b, a] = squares[a, b]
        squares[a, a] += RIDGE_OF_SHADE if a > 0 else 0.0
    solve(squares, rhs, 4)
    for a in range(4):
        ball[4 + a] = rhs[a]


@kernel
def solve(m, b, n):
    """Solve m x = b in place for the first n unknowns by Cholesky; return whether m is positive.

    m's lower triangle becomes the factor, b the solution.
    """
    for i in range(n):
        for j in range(i + 1):
            total = m[i, j]
            for k in range(j):
                total -= m[i, k] * m[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                m[i, i] = math.sqrt(total)
            else:
                m[i, j] = total / m[j, j]
    back_substitute(m, b, n)
    return True


@kernel
def back_substitute(factor, b, n):
    """Solve L L^T x = b in place."""
    for i in range(n):
        for k in range(i):
            b[i] -= factor[i, k] * b[k]
        b[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= factor[k, i] * b[k]
        b[i] /= factor[i, i]


@kernel
def mix(paint, room):
    """Write per sector what turns linear light into alpha; return the noise of the light.

    alpha = w.(c - g) / w.D, w = S^-1 D, D = ball - background g, and S the scatter of both:
    noise + (shading B)^2 b b^T + that of the ring, pooled with the neighbours'.
    """
    levels, matte, ball = room.levels, room.matte, room.ball
    noise = ring_noise(levels)
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
        bright = max(ball[4] + ball[5] * math.cos(angle) + ball[6] * math.sin(angle), 1.0)
        for k in range(3):
            g[k] = levels[s, 1 + k] / n
            d[k] = bright * ball[k] - g[k]
            w[k] = d[k]
        ring_scatter(levels, s, g, ring)
        uncertain = (paint.shading * bright) ** 2
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
    return noise


@kernel
def ring_scatter(levels, s, g, ring):
    """Write the scatter of the ring about g, this sector's mean, in the sector and its neighbours."""
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
def gather(pixels, state, shape, inverse, gap, core, paint, room, area):
    """Write the band of pixels around the outline, and the moments of alpha up to `gap` outside.

    `area` gets: sum of alpha, of alpha q, of alpha q q; pixels without background; variances of
    the sum, of the first moments. Return how many pixels the band has.
    """
    x, y, r, ux, uy = state[0], state[1], state[2], state[3], state[4]
    uu = ux * ux + uy * uy
    light, matte, band = paint.light, room.matte, room.band
    area[:] = 0.0
    count, outer, deep = 0, r + gap, r - core
    half = BAND * math.sqrt(state[5]) + BAND_MARGIN
    lost = np.zeros(
        (SECTORS, 3)
    )  # sums of 1 - alpha, and of it times q: what a level's error moves
    x0, x1, y0, y1 = box_around(pixels, state, shape, outer)
    for i in range(y0, y1):
        for j in range(x0, x1):
            dx, dy = j - x, i - y
            qx, qy = (
                inverse[0, 0] * dx + inverse[0, 1] * dy,
                inverse[1, 0] * dx + inverse[1, 1] * dy,
            )
            near, far = capsule(qx, qy, ux, uy, uu)
            if near >= outer:
                continue
            alpha, variance = 1.0, 0.0
            if far >= deep:
                place = sector_around(qx, qy, r, ux, uy, uu) - 0.5
                s0 = int(math.floor(place))
                share = place - s0
                s1 = (s0 + 1) % SECTORS
                s0 %= SECTORS
                m0, m1 = matte[s0], matte[s1]
                k0 = (1.0 - share) if m0[6] >= FEWEST_IN_SECTOR else 0.0
                k1 = share if m1[6] >= FEWEST_IN_SECTOR else 0.0
                if k0 + k1 < 0.25:
                    area[6] += 1.0
                    continue
                b, g, e = pixels[i, j, 0], pixels[i, j, 1], pixels[i, j, 2]
                lb, lg, le = light[b], light[g], light[e]
                a0 = m0[0] * lb + m0[1] * lg + m0[2] * le - m0[3] if k0 > 0.0 else 0.0
                a1 = m1[0] * lb + m1[1] * lg + m1[2] * le - m1[3] if k1 > 0.0 else 0.0
                alpha = (k0 * a0 + k1 * a1) / (k0 + k1)
                noise = (k0 * m0[4] + k1 * m1[4]) / (k0 + k1)
                spread = (k0 * m0[5] + k1 * m1[5]) / (k0 + k1)
                is_clipped = max(b, g, e) >= CLIPPED and alpha > CLIPPED_ALPHA
                if is_clipped:
                    alpha = 1.0
                under = 1.0 - min(max(alpha, 0.0), 1.0)
                shaded = (k0 * m0[7] + k1 * m1[7]) / (k0 + k1)
                over = 1.0 - under
                variance = noise + under * under * (spread - noise) + over * over * shaded
                owner = s0 if k0 > k1 else s1
                lost[owner, 0] += under
                lost[owner, 1] += under * qx
                lost[owner, 2] += under * qy
                if abs(near - r) < half and count < band.shape[0] and not is_clipped:
                    row = band[count]
                    row[0], row[1], row[2], row[3], row[4] = qx, qy, alpha, variance, owner
                    count += 1
            alpha = min(max(alpha, -CLAMP), 1.0 + CLAMP)
            area[0] += alpha
            area[1] += alpha * qx
            area[2] += alpha * qy
            area[3] += alpha * qx * qx
            area[4] += alpha * qx * qy
            area[5] += alpha * qy * qy
            area[7] += variance
            area[8] += variance * qx * qx
            area[9] += variance * qy * qy
    for s in range(SECTORS):
        if matte[s, 6] >= FEWEST_IN_SECTOR:
            texture = level_variance(matte[s])
            area[7] += texture * lost[s, 0] ** 2
            area[8] += texture * lost[s, 1] ** 2
            area[9] += texture * lost[s, 2] ** 2
    return count


@kernel
def fit_edge(room, n, state, edge, covariance, about):
    """Fit the edge by robust Gauss-Newton; return how well: mean squared residual over variance.

    `edge` holds x, y, r, a, and b, c of a ball at rest or u of one that moves (state); it is the
    start and the result; x, y are in the ball's frame, from the state's centre. -1 if it fails.
    """
    band, moving = room.band, state[3] != 0.0 or state[4] != 0.0
    normal, lost = np.zeros((PARAMETERS, PARAMETERS)), np.zeros((SECTORS, PARAMETERS))
    step, slope = np.zeros(PARAMETERS), np.zeros(PARAMETERS)
    scale, plain = 4.0, 0.0
    nodes = min(int(2.0 * math.hypot(state[3], state[4]) / NODE_SPACING) + 2, MOST_NODES)
    for iteration in range(STEPS):
        normal[:] = 0.0
        lost[:] = 0.0
        start_from_prior(normal, step, edge, scale, moving)
        squares, weights, plain = 0.0, 0.0, 0.0
        for i in range(n):
            value = (
                moving_edge(band[i], edge, slope, nodes)
                if moving
                else edge_at(band[i], edge, slope)
            )
            residual = band[i, 2] - value
            plain += residual * residual
            share = 1.0 / (1.0 + residual * residual / (band[i, 3] * scale * CLIP * CLIP))
            share *= share
            weight = share / band[i, 3]
            squares += weight * residual * residual
            weights += share
            sector, under = int(band[i, 4]), 1.0 - value
            for a in range(PARAMETERS):
                part = weight * slope[a]
                step[a] += part * residual
                lost[sector, a] += part * under
                for b in range(a + 1):
                    normal[a, b] += part * slope[b]
        if not solve(normal, step, PARAMETERS):
            return -1.0
        limit(step, state[2])
        for a in range(PARAMETERS):
            edge[a] += step[a]
        keep_spread(edge, moving)
        scale = max(1.3 * squares / max(weights - 4.0, 1.0), 0.25)
        if iteration >= 2 and abs(step[0]) + abs(step[1]) + abs(step[2]) < SMALLEST_STEP:
            break
    about[3] = math.sqrt(plain / max(n, 1))
    edge_covariance(normal, lost, scale, room.matte, covariance)
    return scale


@kernel
def start_from_prior(normal, step, edge, scale, moving):
    """Start the normal equations from what is known of an edge: it keeps small balls' spread."""
    turn_sd = 3.0 if moving else 1.0
    for k in range(3):
        sd, mean = (0.5, 0.4) if k == 0 else (turn_sd, edge[3 + k] if moving else 0.0)
        normal[3 + k, 3 + k] = 1.0 / (sd * sd * scale)
        step[3 + k] = (mean - edge[3 + k]) / (sd * sd * scale)
    for k in range(3):
        step[k] = 0.0


@kernel
def limit(step, r):
    """Shorten a step that goes farther than half a radius or 2 px^2 of spread."""
    size = max(abs(step[0]), abs(step[1]), abs(step[2])) / (0.3 * r)
    size = max(size, max(abs(step[3]), abs(step[4]), abs(step[5])) / 2.0)
    if size > 1.0:
        for a in range(PARAMETERS):
            step[a] /= size


@kernel
def keep_spread(edge, moving):
    """Keep the edge's variance above that of a pixel in every direction."""
    edge[3] = max(edge[3], LEAST_SPREAD)
    if moving:
        return
    turn = math.hypot(edge[4], edge[5])
    if turn > edge[3] - LEAST_SPREAD:
        shrink = (edge[3] - LEAST_SPREAD) / turn
        edge[4] *= shrink
        edge[5] *= shrink


@kernel
def edge_at(row, edge, slope):
    """Return alpha of the edge of a ball at rest, and write its slopes.

    alpha = Phi((R - rho) / s), s^2 = a + b cos 2 phi + c sin 2 phi across the edge, and the same
    with -b, -c along it, which pulls the edge in: R = r - (a - b cos 2 phi - c sin 2 phi) / (2 r).
    """
    dx, dy, r = row[0] - edge[0], row[1] - edge[1], edge[2]
    rho = math.sqrt(dx * dx + dy * dy) + 1e-12
    nx, ny = dx / rho, dy / rho
    c2, s2 = nx * nx - ny * ny, 2.0 * nx * ny
    turned = edge[4] * c2 + edge[5] * s2
    across = edge[3] + turned
    s = math.sqrt(across)
    pull = (edge[3] - turned) / (2.0 * r)
    z = (r - pull - rho) / s
    value, density = normal(z)
    density /= s
    slope[0], slope[1] = density * nx, density * ny
    slope[2] = density * (1.0 + pull / r)
    by_across, by_along = -0.5 * z * density / s, -density / (2.0 * r)
    slope[3] = by_across + by_along
    slope[4], slope[5] = (by_across - by_along) * c2, (by_across - by_along) * s2
    return value


@kernel
def moving_edge(row, edge, slope, nodes):
    """Return alpha of the edge of a ball that moves from -u to u, and write its slopes.

    The mean over `nodes` instants of  Phi((r - a / (2 r) - rho) / sqrt(a)).
    """
    r, a = edge[2], edge[3]
    s, pull = math.sqrt(a), a / (2.0 * r)
    total = 0.0
    for k in range(PARAMETERS):
        slope[k] = 0.0
    for k in range(nodes):
        t = (2.0 * k + 1.0) / nodes - 1.0
        dx, dy = row[0] - edge[0] - t * edge[4], row[1] - edge[1] - t * edge[5]
        rho = math.sqrt(dx * dx + dy * dy) + 1e-12
        z = (r - pull - rho) / s
        value, density = normal(z)
        total += value
        density /= s * nodes
        nx, ny = density * dx / rho, density * dy / rho
        slope[0] += nx
        slope[1] += ny
        slope[2] += density * (1.0 + pull / r)
        slope[3] -= density * (0.5 * z / s + 0.5 / r)
        slope[4] += t * nx
        slope[5] += t * ny
    return total / nodes


@kernel
def normal(z):
    """Return the normal distribution and density at z, from a table."""
    place = (min(max(z, -TABLE_REACH), TABLE_REACH) + TABLE_REACH) * TABLE_FINENESS
    k = int(place)
    share = place - k
    value = NORMAL_CDF[k] + share * (NORMAL_CDF[k + 1] - NORMAL_CDF[k])
    return value, NORMAL_PDF[k] + share * (NORMAL_PDF[k + 1] - NORMAL_PDF[k])


@kernel
def edge_covariance(factor, lost, scale, matte, covariance):
    """Write the covariance of the edge: that of the pixels, and that of each sector's background."""
    columns = np.eye(PARAMETERS)
    for k in range(PARAMETERS):
        back_substitute(factor, columns[k], PARAMETERS)
        covariance[k] = scale * columns[k]
    for k in range(3):
        covariance[k, k] += (FLOOR_SD if k < 2 else 0.7 * FLOOR_SD) ** 2
    for s in range(SECTORS):
        if matte[s, 6] >= FEWEST_IN_SECTOR:
            moved = columns @ lost[s]
            variance = level_variance(matte[s])
            for i in range(PARAMETERS):
                for j in range(PARAMETERS):
                    covariance[i, j] += variance * moved[i] * moved[j]


@kernel
def level_variance(sector):
    """Return the variance of alpha that a sector's wrong background makes: texture and noise."""
    return TEXTURE * max(sector[5] - sector[4], 0.0) + sector[4] / sector[6]


@kernel
def measure(pixels, state, shape, paint, found):
    """Measure one ball; `state` (x, y, r, ux, uy, edge's variance) is the guess and the last frame.

    Places in `found` are in the ball's frame about the state's centre.
    """
    inverse, room = inverted(shape), room_for(pixels, state, shape)
    edge, covariance, area = found.edge, found.covariance, np.zeros(10)
    found.about[:] = 0.0
    scale, angle, whole, may_move = -1.0, 0.0, False, True
    for turn in range(TURNS):
        sigma = math.sqrt(state[5])
        gap, core = GAP * sigma + BAND_MARGIN, BAND * sigma + BAND_MARGIN
        if turn == 0:
            gap, core = FIRST_GAP + 0.15 * state[2], 1.5 + 0.3 * state[2]
        angle = look(pixels, state, shape, inverse, gap, RING, core, paint, room)
        shade(pixels, state, inverse, core, paint, room.ball)
        mix(paint, room)
        count = gather(pixels, state, shape, inverse, gap, core, paint, room, area)
        whole = fits(pixels, state, shape, gap) and area[6] < 0.2 * area[0]
        if turn == 0:
            if whole and area[0] > 3.0 and math.sqrt(area[7]) < TRUSTED * area[0]:
                follow_area(state, shape, area)
            continue
        at_rest = state[3] == 0.0 and state[4] == 0.0
        edge[0], edge[1], edge[2], edge[3] = 0.0, 0.0, state[2], state[5]
        edge[4], edge[5] = state[3], state[4]
        scale = fit_edge(room, count, state, edge, covariance, found.about)
        if scale < 0.0:
            break
        moved = math.hypot(edge[0], edge[1]) + abs(edge[2] - state[2])
        blurred = at_rest and may_move and is_blurred(edge, covariance)
        if not at_rest:
            moved += math.hypot(edge[4] - state[3], edge[5] - state[4])
            if 2.0 * math.hypot(edge[4], edge[5]) < LEAST_MOTION:
                state[3], state[4], may_move = 0.0, 0.0, False
                continue
        if turn == TURNS - 1 or (moved < CLOSE and not blurred):
            break
        follow_edge(state, shape, edge, blurred)
    report(state, area, scale, angle, whole, room, found)


@kernel
def inverted(m):
    """Return the inverse of a 2 x 2 matrix."""
    determinant = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    inverse = np.empty((2, 2))
    inverse[0, 0], inverse[0, 1] = m[1, 1] / determinant, -m[0, 1] / determinant
    inverse[1, 0], inverse[1, 1] = -m[1, 0] / determinant, m[0, 0] / determinant
    return inverse


@kernel
def room_for(pixels, state, shape):
    """Return memory for a measurement that starts here."""
    x0, x1, y0, y1 = box_around(pixels, state, shape, 1.5 * state[2] + 4.0)
    n = min(max((x1 - x0) * (y1 - y0), 256), MOST_BAND)
    return Room(
        np.zeros((SECTORS, LEVELS_PER_SECTOR)),
        np.zeros((SECTORS, MATTE_PER_SECTOR)),
        np.zeros(8),
        np.empty((n, 5)),
    )


@kernel
def is_blurred(edge, covariance):
    """Tell whether the edge's spread is so uneven that the ball must have moved."""
    uneven = edge[4] ** 2 + edge[5] ** 2
    sure = SURE**2 * (covariance[4, 4] + covariance[5, 5])
    return uneven > max((MOVING**2 / 24.0) ** 2, sure)


@kernel
def follow_edge(state, shape, edge, blurred):
    """Move the state to the fitted edge; if it is `blurred`, its streak becomes a motion."""
    state[0] += shape[0, 0] * edge[0] + shape[0, 1] * edge[1]
    state[1] += shape[1, 0] * edge[0] + shape[1, 1] * edge[1]
    state[2] = edge[2]
    spread = edge[3]
    if blurred:
        turned = math.hypot(edge[4], edge[5])
        half, angle = 0.5 * math.sqrt(24.0 * turned), 0.5 * math.atan2(edge[5], edge[4])
        state[3], state[4] = half * math.cos(angle), half * math.sin(angle)
        spread -= turned
    elif state[3] != 0.0 or state[4] != 0.0:
        state[3], state[4] = edge[4], edge[5]
    state[5] = min(max(spread, 0.15), 2.0)


@kernel
def fits(pixels, state, shape, gap):
    """Tell whether outline and gap lie within the pixels."""
    reach = state[2] + gap
    half_x = reach * math.hypot(shape[0, 0], shape[0, 1])
    half_x += abs(shape[0, 0] * state[3] + shape[0, 1] * state[4])
    half_y = reach * math.hypot(shape[1, 0], shape[1, 1])
    half_y += abs(shape[1, 0] * state[3] + shape[1, 1] * state[4])
    x, y = state[0], state[1]
    inside_x = x - half_x >= -0.5 and x + half_x <= pixels.shape[1] - 0.5
    return inside_x and y - half_y >= -0.5 and y + half_y <= pixels.shape[0] - 0.5


@kernel
def follow_area(state, shape, area):
    """Move the state to centre and radius of the area, by half a radius at most."""
    qx, qy = area[1] / area[0], area[2] / area[0]
    shorten = min(0.5 * state[2] / (math.hypot(qx, qy) + 1e-9), 1.0)
    qx, qy = shorten * qx, shorten * qy
    state[0] += shape[0, 0] * qx + shape[0, 1] * qy
    state[1] += shape[1, 0] * qx + shape[1, 1] * qy
    state[2] = math.sqrt(area[0] / math.pi)


@kernel
def report(state, area, scale, angle, whole, room, found):
    """Write the area's measurement and what is said of both."""
    n = max(area[0], 1e-6)
    r = math.sqrt(n / math.pi)
    found.area[0], found.area[1], found.area[2] = area[1] / n, area[2] / n, r
    found.area[3], found.area[4] = area[8] / (n * n), area[9] / (n * n)
    found.area[5] = area[7] / (2.0 * math.pi * r) ** 2
    usable = 0
    for s in range(SECTORS):
        usable += room.matte[s, 6] >= FEWEST_IN_SECTOR
    found.about[0], found.about[1], found.about[2] = scale, usable / SECTORS, angle
    found.about[4] = 1.0 if whole else 0.0
    for k in range(3):
        found.about[5 + k] = room.ball[k] * room.ball[4]
