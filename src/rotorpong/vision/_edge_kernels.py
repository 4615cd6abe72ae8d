"""The edge of one ball, compiled; the equations are in `matte`."""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.vision._linear_kernels import back_substitute, solve
from rotorpong.vision._matte_kernels import FEWEST_IN_SECTOR, TEXTURE, level_variance
from rotorpong.vision._outline_kernels import SECTORS

PARAMETERS = 6  # of the edge: x, y, r, a, b, c
STEPS = 6
SMALLEST_STEP = 2e-2  # px: the one after it is far smaller
FIRST_SCALE, LEAST_SCALE = 2.0, 0.25  # of residuals over what is expected of them
CLIP = 2.5  # of residuals, in their sd
LEAST_SPREAD = 0.06  # px^2, variance of the edge: a pixel has 1/12
NODE_SPACING, MOST_NODES = 1.6, 14  # px; of an exposure
FLOOR_SD = 0.008  # px: what sampling and the model of the edge leave

TABLE_REACH, TABLE_FINENESS = 4.5, 128
_GRID = np.arange(int(2 * TABLE_REACH * TABLE_FINENESS) + 2) / TABLE_FINENESS - TABLE_REACH
NORMAL_CDF = np.array([0.5 * math.erfc(-z / math.sqrt(2.0)) for z in _GRID])
NORMAL_PDF = np.exp(-0.5 * _GRID**2) / math.sqrt(2.0 * math.pi)


@kernel
def fit_edge(room, n, state, edge, covariance, about):
    """Fit the edge by robust Gauss-Newton; return how well: mean squared residual over variance.

    `edge` holds x, y, r, a, and b, c of a ball at rest or u of one that moves (state); it is the
    start and the result; x, y are in the ball's frame, from the state's centre. -1 if it fails.
    """
    band, moving = room.band[:n], state[3] != 0.0 or state[4] != 0.0
    normal, lost = np.zeros((PARAMETERS, PARAMETERS)), np.zeros((2, SECTORS, PARAMETERS))
    step, prior = np.zeros(PARAMETERS), np.zeros((2, PARAMETERS))
    length = 2.0 * math.hypot(state[3], state[4])
    nodes = min(int(length / NODE_SPACING) + 2, MOST_NODES) if moving else 0
    scale = FIRST_SCALE
    for iteration in range(STEPS):
        squares, weights = add_up(band, edge, scale, nodes, normal, step)
        know_spread(edge, scale, moving, prior)
        for k in range(PARAMETERS):
            normal[k, k] += prior[0, k]
            step[k] += prior[1, k]
        if not solve(normal, step, PARAMETERS):
            return -1.0
        limit(step, state[2])
        for a in range(PARAMETERS):
            edge[a] += step[a]
        keep_spread(edge, moving)
        scale = max(1.3 * squares / max(weights - 4.0, 1.0), LEAST_SCALE)
        moved = abs(step[0]) + abs(step[1]) + abs(step[2])
        if iteration > 0 and moved < SMALLEST_STEP:
            break
    about[3] = weigh_sectors(band, edge, scale, nodes, lost)
    edge_covariance(normal, lost, scale, room.matte, covariance)
    return scale


@kernel
def add_up(band, edge, scale, nodes, normal, step):
    """Write the normal equations; return the weighted squares and the sum of robust weights.

    Scalars, not arrays: the sums stay in registers.
    """
    h00 = 0.0
    h10 = h11 = 0.0
    h20 = h21 = h22 = 0.0
    h30 = h31 = h32 = h33 = 0.0
    h40 = h41 = h42 = h43 = h44 = 0.0
    h50 = h51 = h52 = h53 = h54 = h55 = 0.0
    g0 = g1 = g2 = g3 = g4 = g5 = 0.0
    squares, weights, clip = 0.0, 0.0, 1.0 / (scale * CLIP * CLIP)
    for i in range(band.shape[0]):
        value, s0, s1, s2, s3, s4, s5 = edge_at(band[i, 0], band[i, 1], edge, nodes)
        residual, inverse = band[i, 2] - value, band[i, 3]
        share = 1.0 / (1.0 + residual * residual * inverse * clip)
        share *= share
        weight = share * inverse
        squares += weight * residual * residual
        weights += share
        p0, p1, p2 = weight * s0, weight * s1, weight * s2
        p3, p4, p5 = weight * s3, weight * s4, weight * s5
        g0, g1, g2 = g0 + p0 * residual, g1 + p1 * residual, g2 + p2 * residual
        g3, g4, g5 = g3 + p3 * residual, g4 + p4 * residual, g5 + p5 * residual
        h00 += p0 * s0
        h10, h11 = h10 + p1 * s0, h11 + p1 * s1
        h20, h21, h22 = h20 + p2 * s0, h21 + p2 * s1, h22 + p2 * s2
        h30, h31, h32 = h30 + p3 * s0, h31 + p3 * s1, h32 + p3 * s2
        h40, h41, h42 = h40 + p4 * s0, h41 + p4 * s1, h42 + p4 * s2
        h50, h51, h52 = h50 + p5 * s0, h51 + p5 * s1, h52 + p5 * s2
        h33 += p3 * s3
        h43, h44 = h43 + p4 * s3, h44 + p4 * s4
        h53, h54, h55 = h53 + p5 * s3, h54 + p5 * s4, h55 + p5 * s5
    normal[0, 0] = h00
    normal[1, 0], normal[1, 1] = h10, h11
    normal[2, 0], normal[2, 1], normal[2, 2] = h20, h21, h22
    normal[3, 0], normal[3, 1], normal[3, 2], normal[3, 3] = h30, h31, h32, h33
    normal[4, 0], normal[4, 1], normal[4, 2], normal[4, 3], normal[4, 4] = h40, h41, h42, h43, h44
    normal[5, 0], normal[5, 1], normal[5, 2] = h50, h51, h52
    normal[5, 3], normal[5, 4], normal[5, 5] = h53, h54, h55
    step[0], step[1], step[2], step[3], step[4], step[5] = g0, g1, g2, g3, g4, g5
    return squares, weights


@kernel
def know_spread(edge, scale, moving, prior):
    """Write weight and pull of what is known of an edge: it keeps small balls' spread."""
    turn_sd = 3.0 if moving else 1.0
    for k in range(3):
        sd, mean = (0.5, 0.4) if k == 0 else (turn_sd, edge[3 + k] if moving else 0.0)
        prior[0, 3 + k] = 1.0 / (sd * sd * scale)
        prior[1, 3 + k] = (mean - edge[3 + k]) / (sd * sd * scale)


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
def weigh_sectors(band, edge, scale, nodes, lost):
    """Write what each sector's background (0) and shading (1), were they off by 1, do to the fit.

    Return the rms residual, by the pixels' own variances.
    """
    squares, weights, clip = 0.0, 1e-9, 1.0 / (scale * CLIP * CLIP)
    for i in range(band.shape[0]):
        value, s0, s1, s2, s3, s4, s5 = edge_at(band[i, 0], band[i, 1], edge, nodes)
        residual, inverse = band[i, 2] - value, band[i, 3]
        share = 1.0 / (1.0 + residual * residual * inverse * clip)
        weight, sector = share * share * inverse, int(band[i, 4])
        squares += inverse * residual * residual
        weights += inverse
        for side in range(2):
            part = weight * (1.0 - value if side == 0 else value)
            lost[side, sector, 0] += part * s0
            lost[side, sector, 1] += part * s1
            lost[side, sector, 2] += part * s2
            lost[side, sector, 3] += part * s3
            lost[side, sector, 4] += part * s4
            lost[side, sector, 5] += part * s5
    return math.sqrt(squares / weights)


@kernel
def edge_covariance(factor, lost, scale, matte, covariance):
    """Write the covariance of the edge: that of the pixels, and of each sector's levels."""
    columns = np.eye(PARAMETERS)
    for k in range(PARAMETERS):
        back_substitute(factor, columns[k], PARAMETERS)
        covariance[k] = scale * columns[k]
    for k in range(3):
        covariance[k, k] += (FLOOR_SD if k < 2 else 0.7 * FLOOR_SD) ** 2
    for side in range(2):
        moved = lost[side] @ columns
        for s in range(SECTORS):
            if matte[s, 6] >= FEWEST_IN_SECTOR:
                variance = level_variance(matte, s) if side == 0 else TEXTURE * matte[s, 7]
                for i in range(PARAMETERS):
                    for j in range(PARAMETERS):
                        covariance[i, j] += variance * moved[s, i] * moved[s, j]


@inlined_kernel
def edge_at(x, y, edge, nodes):
    """Return alpha of the edge and its slopes: of a ball at rest (no nodes) or a moving one."""
    if nodes > 0:
        return moving_edge(x, y, edge, nodes)
    return still_edge(x, y, edge)


@inlined_kernel
def still_edge(x, y, edge):
    """Return alpha and its slopes over x, y, r, a, b, c.

    alpha = Phi((R - rho) / s), s^2 = a + b cos 2 phi + c sin 2 phi across the edge, and the same
    with -b, -c along it, which pulls the edge in: R = r - (a - b cos 2 phi - c sin 2 phi) / (2 r).
    That phi turns with x and y is left out of the slopes: b, c of a ball at rest are small.
    """
    dx, dy, half = x - edge[0], y - edge[1], 0.5 / edge[2]
    rho = math.sqrt(dx * dx + dy * dy) + 1e-12
    inverse = 1.0 / rho
    nx, ny = dx * inverse, dy * inverse
    c2, s2 = nx * nx - ny * ny, 2.0 * nx * ny
    turned = edge[4] * c2 + edge[5] * s2
    s = 1.0 / math.sqrt(edge[3] + turned)
    pull = half * (edge[3] - turned)
    z = (edge[2] - pull - rho) * s
    value, density = normal(z)
    density *= s
    across, along = -0.5 * z * density * s, -half * density
    turn = across - along
    return (
        value,
        density * nx,
        density * ny,
        density * (1.0 + 2.0 * half * pull),
        across + along,
        turn * c2,
        turn * s2,
    )


@inlined_kernel
def moving_edge(x, y, edge, nodes):
    """Return alpha and its slopes over x, y, r, a, u of a ball that moves from -u to u.

    The mean over `nodes` instants of  Phi((r - a / (2 r) - rho) / sqrt(a)).
    """
    r, a = edge[2], edge[3]
    s, pull = 1.0 / math.sqrt(a), a / (2.0 * r)
    spacing, share = 2.0 / nodes, s / nodes
    total, s0, s1, s2, s3, s4, s5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(nodes):
        t = spacing * (k + 0.5) - 1.0
        dx, dy = x - edge[0] - t * edge[4], y - edge[1] - t * edge[5]
        rho = math.sqrt(dx * dx + dy * dy) + 1e-12
        z = (r - pull - rho) * s
        value, density = normal(z)
        total += value
        density *= share
        across = density / rho
        nx, ny = across * dx, across * dy
        s0 += nx
        s1 += ny
        s2 += density
        s3 += density * z
        s4 += t * nx
        s5 += t * ny
    s3 = -0.5 * (s * s3 + s2 / r)
    return total / nodes, s0, s1, s2 * (1.0 + pull / r), s3, s4, s5


@inlined_kernel
def normal(z):
    """Return the normal distribution and density at z, from a table."""
    place = (min(max(z, -TABLE_REACH), TABLE_REACH) + TABLE_REACH) * TABLE_FINENESS
    k = int(place)
    share = place - k
    value = NORMAL_CDF[k] + share * (NORMAL_CDF[k + 1] - NORMAL_CDF[k])
    return value, NORMAL_PDF[k] + share * (NORMAL_PDF[k + 1] - NORMAL_PDF[k])
