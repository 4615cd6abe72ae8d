"""One ball from guess to measurement, compiled; the equations are in `matte`."""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.vision._edge_kernels import fit_edge
from rotorpong.vision._matte_kernels import (
    BAND,
    BAND_MARGIN,
    FEWEST_IN_SECTOR,
    LEVELS_PER_SECTOR,
    MATTE_PER_SECTOR,
    SECTORS,
    Room,
    box_around,
    gather,
    look,
    mix,
    shade,
)

TURNS = 6
FIRST_GAP, GAP, RING = 1.5, 3.0, 3.0  # px; sigma; px: where the background begins, how far it goes
CLOSE = 0.2  # px: a turn that moves less is the last
TRUSTED = 0.3  # relative sd of an area to start from
MOST_BAND = 8192  # pixels of an edge
LEAST_MOTION = 1.5  # px, of a streak that is fitted as a motion
MOVING, SURE = 2.2, 3.0  # px; sd: longer streaks are motions, shorter ones an edge of uneven spread


class Found(NamedTuple):
    """Two measurements of a ball, in its own frame."""

    area: np.ndarray  # (6,): x, y, r and their variances
    edge: np.ndarray  # (6,): x, y, r, a and b, c or u
    covariance: np.ndarray  # (6, 6) of the edge
    about: np.ndarray  # (8,): fit's scale, share of sectors with a background, angle of the
    # colour to the known one, rms residual of alpha, whether all of it is seen, colour


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
        if turn == 1 or not at_rest:
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
                edge[4], edge[5] = 0.0, 0.0
                continue
        if turn == TURNS - 1 or (moved < CLOSE and not blurred):
            break
        follow_edge(state, shape, edge, blurred)
    report(state, area, scale, angle, whole, room, found)


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
def follow_area(state, shape, area):
    """Move the state to centre and radius of the area, by half a radius at most."""
    qx, qy = area[1] / area[0], area[2] / area[0]
    shorten = min(0.5 * state[2] / (math.hypot(qx, qy) + 1e-9), 1.0)
    qx, qy = shorten * qx, shorten * qy
    state[0] += shape[0, 0] * qx + shape[0, 1] * qy
    state[1] += shape[1, 0] * qx + shape[1, 1] * qy
    state[2] = math.sqrt(area[0] / math.pi)


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
def is_blurred(edge, covariance):
    """Tell whether the edge's spread is so uneven that the ball must have moved."""
    uneven = edge[4] ** 2 + edge[5] ** 2
    sure = SURE**2 * (covariance[4, 4] + covariance[5, 5])
    return uneven > max((MOVING**2 / 24.0) ** 2, sure)


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
def inverted(m):
    """Return the inverse of a 2 x 2 matrix."""
    determinant = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    inverse = np.empty((2, 2))
    inverse[0, 0], inverse[0, 1] = m[1, 1] / determinant, -m[0, 1] / determinant
    inverse[1, 0], inverse[1, 1] = -m[1, 0] / determinant, m[0, 0] / determinant
    return inverse


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
