"""Alpha along the outline of one ball and its slopes, compiled; the equations are in `matte`.

Pixels come in lines of LANES: a line holds each of FIELDS numbers of all its pixels in a row, so
that the loops over them become vector instructions. float32: of a place 30 px away that is 2e-6 px.
A pixel whose inverse variance is 0 only fills its line.
"""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel

LANES = 32
FIELDS = 11  # x, y, alpha, one over its variance; the edge's alpha and its six slopes
X, Y, ALPHA, INVERSE, VALUE = 0, LANES, 2 * LANES, 3 * LANES, 4 * LANES  # where they begin
S0, S1, S2, S3, S4, S5 = (k * LANES for k in range(5, 11))
PARAMETERS = 6
SUMS = 29  # of a fit: products of slopes (lower triangle), pulls, weighted squares, robust weights

F = np.float32
ZERO, HALF, ONE, TWO, EIGHTH, TINY = F(0), F(0.5), F(1), F(2), F(0.125), F(1e-20)
FARTHEST = F(4.5)  # sd: from there on alpha is 0 or 1
DENSITY = F(1.0 / math.sqrt(2.0 * math.pi))
E2, E3, E4, E5 = F(1 / 2), F(1 / 6), F(1 / 24), F(1 / 120)
E6, E7, E8, E9 = F(1 / 720), F(1 / 5040), F(1 / 40320), F(1 / 362880)
TAIL = F(0.2316419)  # Abramowitz and Stegun, 26.2.17
B1, B2, B3, B4, B5 = (
    F(b) for b in (0.319381530, -0.356563782, 1.781477937, -1.821255978, 1.330274429)
)


@kernel
def trace(band, edge, nodes):
    """Write alpha of the edge and its slopes at all pixels of a band.

    Args:
        band: (lines, FIELDS * LANES) float32.
        edge: x, y, r, a, and b, c of a ball at rest or u of one that moves.
        nodes: instants over which a moving ball is averaged; 0 for one at rest.
    """
    x, y, r, a = F(edge[0]), F(edge[1]), F(edge[2]), F(edge[3])
    b, c = F(edge[4]), F(edge[5])
    for n in range(band.shape[0]):
        if nodes > 0:
            trace_moving(band[n], x, y, r, a, b, c, nodes)
        else:
            trace_still(band[n], x, y, r, a, b, c)


@inlined_kernel
def trace_still(line, x, y, r, a, b, c):
    """Write alpha and its slopes over x, y, r, a, b, c along a line.

    alpha = Phi((R - rho) / s), s^2 = a + b cos 2 phi + c sin 2 phi across the edge, and the same
    with -b, -c along it, which pulls the edge in: R = r - (a - b cos 2 phi - c sin 2 phi) / (2 r).
    That phi turns with x and y is left out of the slopes: b, c of a ball at rest are small.
    """
    half = HALF / r
    for k in range(LANES):
        dx, dy = line[X + k] - x, line[Y + k] - y
        squared = dx * dx + dy * dy + TINY
        inverse = ONE / math.sqrt(squared)
        rho, nx, ny = squared * inverse, dx * inverse, dy * inverse
        c2, s2 = nx * nx - ny * ny, TWO * nx * ny
        turned = b * c2 + c * s2
        s = ONE / math.sqrt(a + turned)
        pull = half * (a - turned)
        z = (r - pull - rho) * s
        value, density = normal(z)
        density *= s
        across, along = -HALF * z * density * s, -half * density
        line[VALUE + k] = value
        line[S0 + k] = density * nx
        line[S1 + k] = density * ny
        line[S2 + k] = density * (ONE + TWO * half * pull)
        line[S3 + k] = across + along
        line[S4 + k] = (across - along) * c2
        line[S5 + k] = (across - along) * s2


@inlined_kernel
def trace_moving(line, x, y, r, a, ux, uy, nodes):
    """Write alpha and its slopes over x, y, r, a, u of a ball that moves from -u to u.

    The mean over `nodes` instants of  Phi((r - a / (2 r) - rho) / sqrt(a)).
    """
    s, pull = ONE / math.sqrt(a), HALF * a / r
    spacing, share = TWO / F(nodes), ONE / F(nodes)
    for k in range(VALUE, FIELDS * LANES):
        line[k] = ZERO
    for node in range(nodes):
        t = spacing * (F(node) + HALF) - ONE
        x_then, y_then = x + t * ux, y + t * uy
        for k in range(LANES):
            dx, dy = line[X + k] - x_then, line[Y + k] - y_then
            squared = dx * dx + dy * dy + TINY
            inverse = ONE / math.sqrt(squared)
            z = (r - pull - squared * inverse) * s
            value, density = normal(z)
            density *= share * s
            across = density * inverse
            nx, ny = across * dx, across * dy
            line[VALUE + k] += share * value
            line[S0 + k] += nx
            line[S1 + k] += ny
            line[S2 + k] += density
            line[S3 + k] += density * z
            line[S4 + k] += t * nx
            line[S5 + k] += t * ny
    stretch, along = ONE + pull / r, HALF / r
    for k in range(LANES):
        line[S3 + k] = -HALF * s * line[S3 + k] - along * line[S2 + k]
        line[S2 + k] *= stretch


@inlined_kernel
def normal(z):
    """Return the normal distribution and density at z, to 5e-7; 0 or 1, and 0, from 4.5 sd on.

    exp(-z^2 / 2) is the eighth power of a series, the tail Abramowitz and Stegun's 26.2.17.
    """
    far = min(abs(z), FARTHEST)
    t = HALF * EIGHTH * far * far
    t2 = t * t
    t4 = t2 * t2
    e = (ONE - t) + t2 * (E2 - t * E3) + t4 * ((E4 - t * E5) + t2 * (E6 - t * E7))
    e += t4 * t4 * (E8 - t * E9)
    e *= e
    e *= e
    e *= e
    density = DENSITY * e if abs(z) < FARTHEST else ZERO
    t = ONE / (ONE + TAIL * far)
    t2 = t * t
    tail = density * t * ((B1 + t * B2) + t2 * ((B3 + t * B4) + t2 * B5))
    return (tail if z < ZERO else ONE - tail), density


@kernel
def add_up(band, clip, sums, normal_matrix, pulls):
    """Write the normal equations of a traced band; return weighted squares and robust weights.

    Geman-McClure: a pixel counts 1 / (1 + clip residual^2 / variance)^2.

    Args:
        band: as `trace` leaves it.
        clip: one over the squared residual, in its variance, that counts a quarter.
        sums: (SUMS * LANES,) float32, memory.
        normal_matrix: (6, 6), its lower triangle is written.
        pulls: (6,), to be written.
    """
    sums[:] = ZERO
    narrow = F(clip)
    for n in range(band.shape[0]):
        add_line(band[n], narrow, sums)
    totals = np.zeros(SUMS)
    for k in range(LANES):
        for m in range(SUMS):
            totals[m] += sums[m * LANES + k]
    m = 0
    for i in range(PARAMETERS):
        for j in range(i + 1):
            normal_matrix[i, j] = totals[m]
            m += 1
    for i in range(PARAMETERS):
        pulls[i] = totals[m + i]
    return totals[m + PARAMETERS], totals[m + PARAMETERS + 1]


@inlined_kernel
def add_line(line, clip, sums):
    """Add a line's pixels to the sums, lane by lane."""
    for k in range(LANES):
        residual, inverse = line[ALPHA + k] - line[VALUE + k], line[INVERSE + k]
        squared = residual * residual * inverse
        share = ONE / (ONE + squared * clip)
        share *= share
        weight = share * inverse
        s0, s1, s2 = line[S0 + k], line[S1 + k], line[S2 + k]
        s3, s4, s5 = line[S3 + k], line[S4 + k], line[S5 + k]
        p0, p1, p2 = weight * s0, weight * s1, weight * s2
        p3, p4, p5 = weight * s3, weight * s4, weight * s5
        sums[k] += p0 * s0
        sums[LANES + k] += p1 * s0
        sums[2 * LANES + k] += p1 * s1
        sums[3 * LANES + k] += p2 * s0
        sums[4 * LANES + k] += p2 * s1
        sums[5 * LANES + k] += p2 * s2
        sums[6 * LANES + k] += p3 * s0
        sums[7 * LANES + k] += p3 * s1
        sums[8 * LANES + k] += p3 * s2
        sums[9 * LANES + k] += p3 * s3
        sums[10 * LANES + k] += p4 * s0
        sums[11 * LANES + k] += p4 * s1
        sums[12 * LANES + k] += p4 * s2
        sums[13 * LANES + k] += p4 * s3
        sums[14 * LANES + k] += p4 * s4
        sums[15 * LANES + k] += p5 * s0
        sums[16 * LANES + k] += p5 * s1
        sums[17 * LANES + k] += p5 * s2
        sums[18 * LANES + k] += p5 * s3
        sums[19 * LANES + k] += p5 * s4
        sums[20 * LANES + k] += p5 * s5
        sums[21 * LANES + k] += p0 * residual
        sums[22 * LANES + k] += p1 * residual
        sums[23 * LANES + k] += p2 * residual
        sums[24 * LANES + k] += p3 * residual
        sums[25 * LANES + k] += p4 * residual
        sums[26 * LANES + k] += p5 * residual
        sums[27 * LANES + k] += weight * residual * residual
        sums[28 * LANES + k] += share if inverse > ZERO else ZERO
