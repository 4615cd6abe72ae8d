"""What each piece of a row may show, compiled: nothing is looked for where it provably is not.

A row is cut into pieces of 32 pixels, of which the camera's table knows the bounds of X/Z and Y/Z.
On a box of these the slopes of a ray in the world, its rise dz/dx and its turn dy/dx, are quotients
of linear functions: their extremes lie in the corners. A plane at a distance along x is met between
two heights and two widths only by rays with rises and turns between two bounds each. `spans` tells
for each plane from which to which column that may be. Where the answer is not sure, it is yes.
"""

from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    AHEAD,
    ASIDE,
    DOWN,
    EYE,
    FAR,
    FORWARD,
    ONE,
    RIGHT,
    TINY,
    TWO,
    UP,
    ZERO,
    F,
)

PIECE = 32  # pixels
LANES, SHIFT = 16, 4  # pieces in a block, and its logarithm: loops over a block leave no rest
LAST_LANE = LANES - 1
A_LOW, A_HIGH, B_LOW, B_HIGH, WIDEST = (LANES * k for k in range(5))  # of pieces: rays and pitch
RISE_LOW, RISE_HIGH, TURN_LOW, TURN_HIGH = (LANES * k for k in range(4))  # of pieces in a pose
END, FIGURE, NET_PLANE, FRONT_LEGS, BACK_LEGS, TOP, BALL_BOX = np.arange(7)  # rows of spans
PLANES, SPANS = 6, 7

LENGTH, WIDTH = F(court.TABLE_HALF_LENGTH), F(court.TABLE_HALF_WIDTH)
NET_TOP, POST, POST_SIDE = (
    F(court.NET_HEIGHT),
    F(court.POST_WIDTH),
    F(court.NET_HALF_LENGTH + court.POST_WIDTH),
)
LEG_X, LEG_OUTER = F(court.LEG_X), F(court.LEG_Y + court.LEG_WIDTH / 2)
THICKNESS, GROUND = F(court.TABLE_THICKNESS), F(court.FLOOR_HEIGHT)
OPPONENT, FIGURE_HALF_WIDTH, FIGURE_TOP = F(court.OPPONENT_X), F(0.6), F(1.05)
SLACK = F(1e-3)  # for rounding, where to look or not is only a question of time
NARROW = F(1e-2)  # a ray that goes less along x may meet any plane across it
HALF_TOP = THICKNESS * F(0.5)


class Lens(NamedTuple):
    """What is known of a camera's rays."""

    rays: np.ndarray  # (3, height, width) float32: X/Z, Y/Z, what a pixel spans of them
    bounds: np.ndarray  # (height, blocks, 5 LANES) float32: least and most of them in a piece


class Scan(NamedTuple):
    """What is known of a row before it is painted; written anew for every row."""

    pieces: np.ndarray  # (blocks, 4 LANES) float32
    limits: np.ndarray  # (PLANES, 4) float32: least and most rise, least and most turn
    spans: np.ndarray  # (SPANS, 2) int64: first column and one past the last, of the picture


@kernel
def survey(scan, lens, row, columns, view):
    """Write in which of the columns (first, one past the last) of a row planes may be seen."""
    limits, pieces, spans = scan.limits, scan.pieces, scan.spans
    set_limits(limits, view)
    for block in range(pieces.shape[0]):
        measure(pieces[block], lens.bounds[row, block], view)
    begin, end = columns[0] // PIECE, (columns[1] - 1) // PIECE + 1
    for k in range(PLANES):
        low, high, left, right = limits[k, 0], limits[k, 1], limits[k, 2], limits[k, 3]
        first, last = begin, end
        while first < last and not meets(pieces, first, low, high, left, right):
            first += 1
        while first < last and not meets(pieces, last - 1, low, high, left, right):
            last -= 1
        spans[k, 0], spans[k, 1] = PIECE * first, PIECE * last


@kernel
def set_limits(limits, view):
    """Write between which rises and turns each plane is met where something is on it."""
    x, y, z = view[EYE, 0], view[EYE, 1], view[EYE, 2]
    end = (LENGTH if x >= ZERO else -LENGTH) - x
    limit(
        limits,
        END,
        slopes_to(end, -THICKNESS - z, THICKNESS - z),
        slopes_to(end, -WIDTH - y, WIDTH - y),
    )
    away = OPPONENT - x
    rises = slopes_to(away, GROUND - z, FIGURE_TOP - z)
    limit(limits, FIGURE, rises, slopes_to(away, -FIGURE_HALF_WIDTH - y, FIGURE_HALF_WIDTH - y))
    rises = slopes_to(-x, -POST - z, NET_TOP - z)
    limit(limits, NET_PLANE, rises, slopes_to(-x, -POST_SIDE - y, POST_SIDE - y))
    away = LEG_X - x
    rises = slopes_to(away, GROUND - z, -THICKNESS - z)
    limit(limits, FRONT_LEGS, rises, slopes_to(away, -LEG_OUTER - y, LEG_OUTER - y))
    away = -LEG_X - x
    rises = slopes_to(away, GROUND - z, -THICKNESS - z)
    limit(limits, BACK_LEGS, rises, slopes_to(away, -LEG_OUTER - y, LEG_OUTER - y))
    limit(limits, TOP, slopes_to_top(x, z), (-FAR, FAR))


@kernel
def limit(limits, k, rises, turns):
    """Write the limits of a plane."""
    limits[k, 0], limits[k, 1] = rises
    limits[k, 2], limits[k, 3] = turns


@kernel
def measure(pieces, bounds, view):
    """Write which rises and turns the rays of a block of pieces have, and what pixels span added.

    A pixel that spans p of X/Z spans less than p (1 + |turn|) sqrt(2) / |dx| of a turn. Rays of
    which some go ahead and some back have any.
    """
    x, y, z = axis_of(view, AHEAD), axis_of(view, ASIDE), axis_of(view, UP)
    for p in range(LANES):
        left, right = bounds[A_LOW + p], bounds[A_HIGH + p]
        low, high = bounds[B_LOW + p], bounds[B_HIGH + p]
        x0, x1 = toward(left, low, x), toward(left, high, x)
        x2, x3 = toward(right, low, x), toward(right, high, x)
        y0, y1 = toward(left, low, y), toward(left, high, y)
        y2, y3 = toward(right, low, y), toward(right, high, y)
        z0, z1 = toward(left, low, z), toward(left, high, z)
        z2, z3 = toward(right, low, z), toward(right, high, z)
        least = min(min(x0, x1), min(x2, x3))
        most = max(max(x0, x1), max(x2, x3))
        sure = (least > NARROW) | (most < -NARROW)
        i0, i1, i2, i3 = steep(x0), steep(x1), steep(x2), steep(x3)
        y0, y1, y2, y3 = y0 * i0, y1 * i1, y2 * i2, y3 * i3
        z0, z1, z2, z3 = z0 * i0, z1 * i1, z2 * i2, z3 * i3
        turn_low, turn_high = min(min(y0, y1), min(y2, y3)), max(max(y0, y1), max(y2, y3))
        rise_low, rise_high = min(min(z0, z1), min(z2, z3)), max(max(z0, z1), max(z2, z3))
        steepest = max(max(abs(i0), abs(i1)), max(abs(i2), abs(i3)))
        slant = ONE + max(abs(turn_low), abs(turn_high)) + max(abs(rise_low), abs(rise_high))
        around = SLACK + TWO * bounds[WIDEST + p] * slant * steepest
        pieces[RISE_LOW + p] = rise_low - around if sure else -FAR
        pieces[RISE_HIGH + p] = rise_high + around if sure else FAR
        pieces[TURN_LOW + p] = turn_low - around if sure else -FAR
        pieces[TURN_HIGH + p] = turn_high + around if sure else FAR


@kernel
def axis_of(view, k):
    """Return coordinate k of a view's axes forward, right and down: loops read no array twice."""
    return view[FORWARD, k], view[RIGHT, k], view[DOWN, k]


@kernel
def toward(a, b, axes):
    """Return a coordinate in the world of the ray (a, b, 1) of the camera, of `axis_of`."""
    return axes[0] + a * axes[1] + b * axes[2]


@kernel
def steep(x):
    """Return 1/x, finite where x vanishes."""
    return ONE / (x if abs(x) > TINY else TINY)


@kernel
def slopes_to(away, low, high):
    """Return between which slopes a plane at a distance is met from low to high, any if near."""
    if abs(away) < SLACK:
        return -FAR, FAR
    one, other = low / away, high / away
    return min(one, other) - SLACK, max(one, other) + SLACK


@kernel
def slopes_to_top(x, z):
    """Return between which rises the table's plane is met on the table, any from above it.

    A ray meets the plane at x + (level - z) / rise. Towards the horizon, where it rises by 0, a
    pixel spans more and more of the plane and so ever a little of the table.
    """
    away = (ZERO if z >= -HALF_TOP else -THICKNESS) - z
    if abs(x) < LENGTH + SLACK or abs(away) < SLACK:
        return -FAR, FAR
    one, other = away / (LENGTH - x), away / (-LENGTH - x)
    return min(min(one, other), ZERO) - SLACK, max(max(one, other), ZERO) + SLACK


@kernel
def meets(pieces, p, low, high, left, right):
    """Tell whether rays of a piece may rise by low to high and turn by left to right."""
    b, k = p >> SHIFT, p & LAST_LANE
    steeply = (pieces[b, RISE_HIGH + k] > low) & (pieces[b, RISE_LOW + k] < high)
    return steeply & (pieces[b, TURN_HIGH + k] > left) & (pieces[b, TURN_LOW + k] < right)


@kernel
def within(spans, k, start, n):
    """Return which of n pixels from column `start` on are of a span."""
    return max(spans[k, 0] - start, 0), min(spans[k, 1] - start, n)


@kernel
def find_ball(scan, lens, row, columns, box):
    """Write in which columns of a row a ball may be seen whose outline lies in a box."""
    bounds, spans = lens.bounds, scan.spans
    first, last = columns[0] // PIECE, (columns[1] - 1) // PIECE + 1
    while first < last and not holds(bounds, row, first, box):
        first += 1
    while first < last and not holds(bounds, row, last - 1, box):
        last -= 1
    spans[BALL_BOX, 0], spans[BALL_BOX, 1] = PIECE * first, PIECE * last
    return first < last


@kernel
def holds(bounds, row, p, box):
    """Tell whether a piece of a row reaches into a box (left, right, top, bottom) of rays."""
    q, k = p >> SHIFT, p & LAST_LANE
    margin = TWO * bounds[row, q, WIDEST + k]
    beside = bounds[row, q, A_HIGH + k] > box[0] - margin
    beside &= bounds[row, q, A_LOW + k] < box[1] + margin
    level = bounds[row, q, B_HIGH + k] > box[2] - margin
    level &= bounds[row, q, B_LOW + k] < box[3] + margin
    return beside & level
