"""One ball from guess to measurement, compiled; the equations are in `matte`."""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.vision._edge_kernels import edge_covariance, fit_edge
from rotorpong.vision._gather_kernels import BAND, BAND_MARGIN, DIRECTIONS, gather
from rotorpong.vision._linear_kernels import inverted
from rotorpong.vision._matte_kernels import (
    FEWEST_IN_SECTOR,
    LEVELS_PER_SECTOR,
    MATTE_PER_SECTOR,
    Paint,
    Room,
    look,
    mix,
)
from rotorpong.vision._outline_kernels import PLACES, RAMP, SECTORS, box_around, fits
from rotorpong.vision._shade_kernels import shade
from rotorpong.vision._trace_kernels import FIELDS, LANES, PARAMETERS, SUMS

TURNS = 6
FIRST_GAP, GAP, RING = 1.5, 3.0, 3.0  # px; sigma; px: where the background begins, how far it goes
COARSE_RADIUS = 5.0  # px: larger balls are looked at with every other pixel first
CLOSE, FAR = 0.2, 0.5  # px; sd: a turn that moves less is the last
TRUSTED = 0.3  # relative sd of an area to start from
MOST_BAND = 2048  # pixels of an edge
LEAST_MOTION = 1.5  # px, of a streak that is fitted as a motion
SIGNIFICANT = 2.0  # sd, of a streak that is told
MOVING, SURE = 2.2, 3.0  # px; sd: longer streaks are motions, shorter ones an edge of uneven spread


SPREADS, STREAK, ABOUT, FOUND = 6, 24, 26, 34  # where parts of `Found` begin, and its end


class Found(NamedTuple):
    """Two measurements of a ball, by area (0) and by edge (1), in the picture's axes."""

    discs: np.ndarray  # (2, 3): x, y, r
    spreads: np.ndarray  # (2, 3, 3)
    streak: np.ndarray  # (2,): motion in the exposure, up to its sign
    about: np.ndarray  # (8,): fit's scale, share of sectors with a background, angle of the
    # colour to the known one, rms residual of alpha, disagreement (nan: no area), the ball's light


@kernel
def measure(pixels, state, shape, light, paint, first, out):
    """Measure one ball.

    Args:
        pixels: (height, width, 3) uint8.
        state: (6,): x, y, r, ux, uy, the edge's variance: the guess, and the last frame afterwards.
        shape: (2, 2), of the outline.
        light: (256,) linear light of a level.
        paint: (5,): the ball's colour in linear light, and the last two of `Paint`.
        first: turn: 0, a coarse one, or 1 after a guess as good as what that leads to.
        out: (FOUND,), to be written: `Found` in a row. A scale below 0: there is nothing to fit.
    """
    discs, spreads = out[:SPREADS].reshape((2, 3)), out[SPREADS:STREAK].reshape((2, 3, 3))
    found = Found(discs, spreads, out[STREAK:ABOUT], out[ABOUT:])
    told = Paint(light, paint[:3], paint[3], paint[4])
    turn_about(pixels, state, shape, told, first, found)


@kernel
def turn_about(pixels, state, shape, paint, first, found):
    """Look, gather and fit, again from each edge until it stays; write what is found."""
    inverse, room = inverted(shape), room_for(pixels, state, shape)
    edge, covariance, area = np.zeros(PARAMETERS), np.zeros((PARAMETERS, PARAMETERS)), np.zeros(7)
    normal, count = np.zeros((PARAMETERS, PARAMETERS)), 0
    scale, angle, whole, may_move = -1.0, 0.0, False, True
    for turn in range(first, TURNS):
        sigma = math.sqrt(state[5])
        margins, step = (BAND * sigma + BAND_MARGIN, GAP * sigma + BAND_MARGIN, RING), 1
        if turn == 0:
            step = 2 if state[2] > COARSE_RADIUS else 1
            margins = (1.5 + 0.3 * state[2], FIRST_GAP + 0.15 * state[2], RING * step)
        angle = look(pixels, state, shape, inverse, margins, step, paint, room)
        shade(pixels, state, inverse, margins[0], paint, room.ball)
        mix(paint, room)
        count = gather(pixels, state, shape, inverse, margins, step, paint, room, area)
        whole = fits(pixels, state, shape, margins[1]) and area[3] < 0.2 * area[0]
        if turn == 0:
            if whole and area[0] > 3.0 and math.sqrt(area[4]) < TRUSTED * area[0]:
                follow_area(state, shape, area)
            continue
        at_rest = state[3] == 0.0 and state[4] == 0.0
        edge[0], edge[1], edge[2], edge[3] = 0.0, 0.0, state[2], state[5]
        if turn == 1 or not at_rest:
            edge[4], edge[5] = state[3], state[4]
        scale = fit_edge(room, count, state, edge, normal)
        if scale < 0.0:
            break
        moved = math.hypot(edge[0], edge[1]) + abs(edge[2] - state[2])
        uneven, blurred = edge[4] ** 2 + edge[5] ** 2, False
        if moved >= CLOSE or (at_rest and uneven > MOVING**4 / 576.0):
            edge_covariance(room, count, normal, scale, covariance)
            blurred = at_rest and may_move and is_blurred(edge, covariance)
            moved = moved if is_far(state, edge, covariance) else 0.0
        if not at_rest:
            moved = max(moved - CLOSE, 0.5 * math.hypot(edge[4] - state[3], edge[5] - state[4]))
            if 2.0 * math.hypot(edge[4], edge[5]) < LEAST_MOTION:
                state[3], state[4], may_move = 0.0, 0.0, False
                edge[4], edge[5] = 0.0, 0.0
                continue
        if turn == TURNS - 1 or (moved < CLOSE and not blurred):
            break
        follow_edge(state, shape, edge, blurred)
    found.about[0], found.about[2] = scale, angle
    if scale >= 0.0:
        found.about[3] = edge_covariance(room, count, normal, scale, covariance)
    report_edge(state, shape, edge, covariance, found)
    report_area(state, shape, area, whole, found)
    report_matte(room, found)


@kernel
def room_for(pixels, state, shape):
    """Return memory for a measurement that starts here."""
    x0, x1, y0, y1 = box_around(pixels, state, shape, 1.5 * state[2] + 4.0)
    lines = min(max((x1 - x0) * (y1 - y0), 256), MOST_BAND) // LANES
    places = np.zeros(5 * PLACES, np.float32)
    for k in range(PLACES):
        places[RAMP + k] = k
    return Room(
        np.zeros((SECTORS, LEVELS_PER_SECTOR)),
        np.zeros((SECTORS, MATTE_PER_SECTOR)),
        np.zeros((DIRECTIONS, MATTE_PER_SECTOR + 2)),
        np.zeros((SECTORS, 9)),
        np.zeros(8),
        places,
        np.empty((lines, FIELDS * LANES), np.float32),
        np.empty(lines * LANES, np.int64),
        np.empty(SUMS * LANES, np.float32),
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
    """Tell whether the edge's spread is so surely uneven that the ball must have moved."""
    uneven = edge[4] ** 2 + edge[5] ** 2
    sure = SURE**2 * (covariance[4, 4] + covariance[5, 5])
    return uneven > max((MOVING**2 / 24.0) ** 2, sure)


@kernel
def is_far(state, edge, covariance):
    """Tell whether the edge is farther from the state than its sd makes matter."""
    squared = edge[0] ** 2 / covariance[0, 0] + edge[1] ** 2 / covariance[1, 1]
    return squared + (edge[2] - state[2]) ** 2 / covariance[2, 2] > FAR**2


@kernel
def report_edge(state, shape, edge, covariance, found):
    """Write the edge's measurement, and the streak if it is significant."""
    place(state, shape, edge, covariance, found.discs[1], found.spreads[1])
    along, across = 2.0 * edge[4], 2.0 * edge[5]
    if state[3] == 0.0 and state[4] == 0.0:
        uneven = math.hypot(edge[4], edge[5])
        sure = uneven**2 > SIGNIFICANT**2 * (covariance[4, 4] + covariance[5, 5])
        length, angle = math.sqrt(24.0 * uneven), 0.5 * math.atan2(edge[5], edge[4])
        length = length if sure else 0.0
        along, across = length * math.cos(angle), length * math.sin(angle)
    found.streak[0] = shape[0, 0] * along + shape[0, 1] * across
    found.streak[1] = shape[1, 0] * along + shape[1, 1] * across


@kernel
def report_area(state, shape, area, whole, found):
    """Write the area's measurement, and how far it is from the edge's, in sd of x, y, r."""
    n = max(area[0], 1e-6)
    values, spread = np.zeros(3), np.zeros((3, 3))
    values[0], values[1], values[2] = area[1] / n, area[2] / n, math.sqrt(n / math.pi)
    spread[0, 0], spread[1, 1] = area[5] / (n * n), area[6] / (n * n)
    spread[2, 2] = area[4] / (2.0 * math.pi * values[2]) ** 2
    place(state, shape, values, spread, found.discs[0], found.spreads[0])
    found.about[4] = np.nan
    if whole:
        found.about[4] = 0.0
        for k in range(3):
            variance = max(found.spreads[0, k, k] + found.spreads[1, k, k], 1e-12)
            apart = abs(found.discs[0, k] - found.discs[1, k]) / math.sqrt(variance)
            found.about[4] = max(found.about[4], apart)


@kernel
def place(state, shape, values, covariance, disc, spread):
    """Write x, y, r and their covariance in the picture's axes."""
    axes = np.eye(3)
    axes[:2, :2] = shape
    disc[0] = state[0] + shape[0, 0] * values[0] + shape[0, 1] * values[1]
    disc[1] = state[1] + shape[1, 0] * values[0] + shape[1, 1] * values[1]
    disc[2] = values[2]
    for i in range(3):
        for j in range(3):
            spread[i, j] = 0.0
            for a in range(3):
                for b in range(3):
                    spread[i, j] += axes[i, a] * covariance[a, b] * axes[j, b]


@kernel
def report_matte(room, found):
    """Write how much of the outline is before a background, and the ball's own light."""
    usable = 0
    for s in range(SECTORS):
        usable += room.matte[s, 6] >= FEWEST_IN_SECTOR
    found.about[1] = usable / SECTORS
    for k in range(3):
        found.about[5 + k] = room.ball[k] * room.ball[4]
