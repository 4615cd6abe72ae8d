"""The edge of one ball, compiled; the equations are in `matte`."""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.vision._linear_kernels import back_substitute, solve
from rotorpong.vision._matte_kernels import FEWEST_IN_SECTOR, TEXTURE, level_variance
from rotorpong.vision._outline_kernels import SECTORS
from rotorpong.vision._trace_kernels import (
    ALPHA,
    INVERSE,
    LANES,
    PARAMETERS,
    S0,
    VALUE,
    add_up,
    trace,
)

STEPS = 6
SMALLEST_STEP, SMALLEST_SD = 2e-2, 0.2  # px; sd: the step after it is far smaller
FIRST_SCALE, LEAST_SCALE = 2.0, 0.25  # of residuals over what is expected of them
CLIP = 2.5  # of residuals, in their sd
LEAST_SPREAD = 0.06  # px^2, variance of the edge: a pixel has 1/12
NODE_SPACING, MOST_NODES = 1.6, 14  # px; of an exposure
FLOOR_SD = 0.008  # px: what sampling and the model of the edge leave


@kernel
def fit_edge(room, n, state, edge, normal):
    """Fit the edge by robust Gauss-Newton; return how well: mean squared residual over variance.

    `edge` holds x, y, r, a, and b, c of a ball at rest or u of one that moves (state); it is the
    start and the result; x, y are in the ball's frame, from the state's centre. -1 if it fails.
    `normal` is left as the factor of the last normal equations, the first n pixels of the band as
    the last step began.
    """
    band, moving = room.band[: (n + LANES - 1) // LANES], state[3] != 0.0 or state[4] != 0.0
    step, prior, scale = np.zeros(PARAMETERS), np.zeros((2, PARAMETERS)), FIRST_SCALE
    pulls = np.zeros(PARAMETERS)
    length = 2.0 * math.hypot(state[3], state[4])
    nodes = min(int(length / NODE_SPACING) + 2, MOST_NODES) if moving else 0
    for iteration in range(STEPS):
        trace(band, edge, nodes)
        clip = 1.0 / (scale * CLIP * CLIP)
        squares, weights = add_up(band, clip, room.sums, normal, step)
        know_spread(edge, scale, moving, prior)
        for k in range(PARAMETERS):
            normal[k, k] += prior[0, k]
            step[k] += prior[1, k]
            pulls[k] = step[k]
        if not solve(normal, step, PARAMETERS):
            return -1.0
        limit(step, state[2])
        for a in range(PARAMETERS):
            edge[a] += step[a]
        keep_spread(edge, moving)
        scale = max(1.3 * squares / max(weights - 4.0, 1.0), LEAST_SCALE)
        moved = abs(step[0]) + abs(step[1]) + abs(step[2])
        in_sd = 0.0
        for k in range(PARAMETERS):
            in_sd += pulls[k] * step[k] / scale
        if iteration > 0 and (moved < SMALLEST_STEP or in_sd < SMALLEST_SD**2):
            break
    return scale


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
def weigh_sectors(room, n, scale, lost):
    """Write what each sector's background (0) and shading (1), were they off by 1, do to the fit.

    Return the rms residual, by the pixels' own variances.
    """
    squares, weights, clip = 0.0, 1e-9, 1.0 / (scale * CLIP * CLIP)
    band, owners = room.band, room.owners
    for i in range(n):
        line, k = i // LANES, i % LANES
        value, inverse = float(band[line, VALUE + k]), float(band[line, INVERSE + k])
        residual = band[line, ALPHA + k] - value
        share = 1.0 / (1.0 + residual * residual * inverse * clip)
        weight, sector = share * share * inverse, owners[i]
        squares += inverse * residual * residual
        weights += inverse
        behind, before = weight * (1.0 - value), weight * value
        for a in range(PARAMETERS):
            slope = band[line, S0 + a * LANES + k]
            lost[0, sector, a] += behind * slope
            lost[1, sector, a] += before * slope
    return math.sqrt(squares / weights)


@kernel
def edge_covariance(room, n, factor, scale, covariance):
    """Write the covariance of the edge: that of the pixels, and of each sector's levels.

    Return the rms residual.
    """
    matte, columns, lost = room.matte, np.eye(PARAMETERS), np.zeros((2, SECTORS, PARAMETERS))
    residual = weigh_sectors(room, n, scale, lost)
    for k in range(PARAMETERS):
        back_substitute(factor, columns[k], PARAMETERS)
        for i in range(PARAMETERS):
            covariance[k, i] = scale * columns[k, i]
    for k in range(3):
        covariance[k, k] += (FLOOR_SD if k < 2 else 0.7 * FLOOR_SD) ** 2
    moved = np.zeros(PARAMETERS)
    for s in range(SECTORS):
        if matte[s, 6] < FEWEST_IN_SECTOR:
            continue
        for side in range(2):
            variance = level_variance(matte, s) if side == 0 else TEXTURE * matte[s, 7]
            for i in range(PARAMETERS):
                moved[i] = 0.0
                for k in range(PARAMETERS):
                    moved[i] += lost[side, s, k] * columns[k, i]
            for i in range(PARAMETERS):
                for j in range(i + 1):
                    covariance[i, j] += variance * moved[i] * moved[j]
    for i in range(PARAMETERS):
        for j in range(i):
            covariance[j, i] = covariance[i, j]
    return residual
