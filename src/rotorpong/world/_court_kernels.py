"""Table, net and opponent, compiled: layers between room and camera, except the ball."""

import math

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    COVER,
    EYE,
    FAR,
    HALF,
    LIGHT,
    LINE,
    NET,
    ONE,
    PITCH,
    QUARTER,
    SEEN,
    SPAN_U,
    SPAN_V,
    STEEL,
    TABLE,
    TINY,
    TWO,
    WALL,
    ZERO,
    F,
    T,
    U,
    V,
    X,
    Y,
    Z,
    any_within,
    cross,
    fill,
    inverse,
    lay_row,
    overlap,
    spread,
    step,
    stripes,
)

LENGTH, WIDTH = F(court.TABLE_HALF_LENGTH), F(court.TABLE_HALF_WIDTH)
THICKNESS = F(court.TABLE_THICKNESS)
EDGE, MIDDLE = F(court.EDGE_LINE_WIDTH), F(court.CENTER_LINE_WIDTH / 2)
NET_TOP, NET_SIDE = F(court.NET_HEIGHT), F(court.NET_HALF_LENGTH)
POST_SIDE = NET_SIDE + F(court.POST_WIDTH)
TAPE = F(court.NET_HEIGHT - court.NET_TAPE_HEIGHT)
TAPE_HEIGHT = F(court.NET_TAPE_HEIGHT)
CELL, CORD, POST = F(court.NET_CELL), F(court.NET_CORD), F(court.POST_WIDTH)
LEG_X = F(court.LEG_X)
LEG_INNER = F(court.LEG_Y - court.LEG_WIDTH / 2)
LEG_OUTER = F(court.LEG_Y + court.LEG_WIDTH / 2)
GROUND = F(court.FLOOR_HEIGHT)
OPPONENT = F(court.OPPONENT_X)
FIGURE_HALF_WIDTH, FIGURE_TOP, MARGIN = F(0.6), F(1.05), F(0.1)

RADIUS, SHADE_RADIUS = F(BALL_RADIUS), F(0.026)
SHEEN, FRONT_LIGHT, SIDE_LIGHT = F(0.22), F(0.55), F(0.45)
LIMB_LIGHT, LIMB_SLOPE, LIMB_ROUND = F(1.04), F(0.18), F(0.28)


@kernel
def layers(row, view, ball, paint, hidden):
    """Lay everything but room and ball over the columns, far to near.

    From above the table's plane the net hides table, the table its legs; from below the reverse.
    `hidden` spares what is wholly behind the table.
    """
    if not hidden:
        opponent(row, view, paint)
    if view[EYE, Z] >= ZERO:
        if not hidden:
            legs(row, view, paint.colours)
            sides(row, view, paint.colours)
        table(row, view, ball, paint)
        net(row, view, paint.colours)
    else:
        net(row, view, paint.colours)
        table(row, view, ball, paint)
        sides(row, view, paint.colours)
        legs(row, view, paint.colours)


@kernel
def table_hides_all(row, view):
    """Tell whether nothing but the table top can be seen, from above it, in any column."""
    if view[EYE, Z] <= ZERO:
        return False
    see_table(row, view, ZERO)
    return not any_within(row, row.work[SEEN], -ONE, ONE)


@kernel
def see_table(row, view, level):
    """Write where rays meet the table, and to SEEN the share of the pixel that it covers."""
    cross(row, view, Z, level)
    spread(row, view, Z, T, (ZERO, FAR))
    x, y, long, wide = row.work[U], row.work[V], row.work[SPAN_U], row.work[SPAN_V]
    seen = row.work[SEEN]
    for i in range(row.columns[0], row.columns[1]):
        seen[i] *= overlap(x[i], -LENGTH, LENGTH, long[i]) * overlap(y[i], -WIDTH, WIDTH, wide[i])


@kernel
def table(row, view, ball, paint):
    """Lay the table top with its lines, or its underside."""
    above = view[EYE, Z] >= -THICKNESS * HALF
    see_table(row, view, ZERO if above else -THICKNESS)
    if not any_within(row, row.work[SEEN], ZERO, TWO):
        return
    table_light(row, ball, paint.shadow)
    if above:
        table_lines(row)
        table_sheen(row)
        lay_top(row, paint.colours)
    else:
        for i in range(row.columns[0], row.columns[1]):
            row.work[COVER, i] = row.work[SEEN, i]
        lay_row(row, paint.colours[STEEL])


@kernel
def table_light(row, ball, shadow):
    """Write the brightness of the top: full but for the ball's shadow, softer with height."""
    x, y, light = row.work[U], row.work[V], row.work[LIGHT]
    bx, by, height = F(ball[0]), F(ball[1]), F(ball[2]) - RADIUS
    fade = ONE - TWO * height
    dark = shadow * fade * fade if ZERO <= height <= HALF else ZERO
    sharp = inverse(SHADE_RADIUS + QUARTER * height)
    for i in range(row.columns[0], row.columns[1]):
        u, v = (x[i] - bx) * sharp, (y[i] - by) * sharp
        light[i] = ONE - dark * max(ONE - u * u - v * v, ZERO)


@kernel
def table_lines(row):
    """Write to COVER the share of the visible top that is line: all but the blue within."""
    x, y, long, wide = row.work[U], row.work[V], row.work[SPAN_U], row.work[SPAN_V]
    seen, share = row.work[SEEN], row.work[COVER]
    for i in range(row.columns[0], row.columns[1]):
        blue = overlap(x[i], EDGE - LENGTH, LENGTH - EDGE, long[i])
        blue *= overlap(y[i], EDGE - WIDTH, WIDTH - EDGE, wide[i])
        blue *= ONE - overlap(y[i], -MIDDLE, MIDDLE, wide[i])
        share[i] = max(ONE - blue / max(seen[i], TINY), ZERO)


@kernel
def table_sheen(row):
    """Write to T how much of the wall the top reflects."""
    z, sheen = row.ray[Z], row.work[T]
    for i in range(row.columns[0], row.columns[1]):
        grazing = ONE - min(abs(z[i]), ONE)
        grazing *= grazing * grazing
        sheen[i] = SHEEN * grazing * grazing


@kernel
def lay_top(row, colours):
    """Lay the table top: blue and line under LIGHT, the wall's reflection over both."""
    light, line, sheen, seen = row.work[LIGHT], row.work[COVER], row.work[T], row.work[SEEN]
    for k in range(3):
        under, blue, white, wall = (
            row.colour[k],
            colours[TABLE, k],
            colours[LINE, k],
            colours[WALL, k],
        )
        for i in range(row.columns[0], row.columns[1]):
            top = light[i] * (blue + line[i] * (white - blue))
            top += sheen[i] * (wall - top)
            under[i] = (ONE - seen[i]) * under[i] + seen[i] * top


@kernel
def sides(row, view, colours):
    """Lay the edges of the table top that face the camera."""
    if abs(view[EYE, X]) > LENGTH:
        cross(row, view, X, math.copysign(LENGTH, view[EYE, X]))
        if any_within(row, row.work[V], -MARGIN, MARGIN):
            spread(row, view, X, V, (-MARGIN, MARGIN))
            edge(row, (U, SPAN_U, V, SPAN_V), WIDTH)
            fill(row, row.work[LIGHT], FRONT_LIGHT)
            lay_row(row, colours[TABLE])
    if abs(view[EYE, Y]) > WIDTH:
        cross(row, view, Y, math.copysign(WIDTH, view[EYE, Y]))
        if any_within(row, row.work[U], -MARGIN, MARGIN):
            spread(row, view, Y, U, (-MARGIN, MARGIN))
            edge(row, (V, SPAN_V, U, SPAN_U), LENGTH)
            fill(row, row.work[LIGHT], SIDE_LIGHT)
            lay_row(row, colours[TABLE])


@kernel
def edge(row, places, half_length):
    """Write the coverage by an edge of the table, reaching under the top: no light leaks."""
    u, wide, z, tall = (
        row.work[places[0]], row.work[places[1]], row.work[places[2]], row.work[places[3]],
    )  # fmt: skip
    seen, cover = row.work[SEEN], row.work[COVER]
    for i in range(row.columns[0], row.columns[1]):
        high = HALF * min(tall[i], THICKNESS)
        cover[i] = seen[i] * overlap(u[i], -half_length, half_length, wide[i])
        cover[i] *= overlap(z[i], -THICKNESS, high, tall[i])


@kernel
def legs(row, view, colours):
    """Lay the two leg frames, the far one first."""
    far = math.copysign(LEG_X, -view[EYE, X])
    y, z, wide, tall = row.work[U], row.work[V], row.work[SPAN_U], row.work[SPAN_V]
    seen, cover = row.work[SEEN], row.work[COVER]
    for x in (far, -far):
        cross(row, view, X, x)
        if any_within(row, z, GROUND - MARGIN, MARGIN):
            spread(row, view, X, V, (GROUND - MARGIN, MARGIN))
            for i in range(row.columns[0], row.columns[1]):
                cover[i] = seen[i] * overlap(z[i], GROUND, -THICKNESS, tall[i])
                cover[i] *= overlap(abs(y[i]), LEG_INNER, LEG_OUTER, wide[i])
            fill(row, row.work[LIGHT], ONE)
            lay_row(row, colours[STEEL])


@kernel
def net(row, view, colours):
    """Lay net, tape and posts."""
    y, z, wide, tall = row.work[U], row.work[V], row.work[SPAN_U], row.work[SPAN_V]
    seen, cover = row.work[SEEN], row.work[COVER]
    cross(row, view, X, ZERO)
    if not any_within(row, z, -MARGIN, NET_TOP + MARGIN):
        return
    spread(row, view, X, V, (-MARGIN, NET_TOP + MARGIN))
    fill(row, row.work[LIGHT], ONE)
    for i in range(row.columns[0], row.columns[1]):
        cover[i] = (ONE - stripes(y[i], CELL, CORD, wide[i])) * (
            ONE - stripes(z[i], CELL, CORD, tall[i])
        )
    for i in range(row.columns[0], row.columns[1]):
        under_tape = TAPE + HALF * min(tall[i], TAPE_HEIGHT)  # no light leaks between the two
        cover[i] = (ONE - cover[i]) * overlap(z[i], ZERO, under_tape, tall[i])
        cover[i] *= seen[i] * overlap(y[i], -NET_SIDE, NET_SIDE, wide[i])
    lay_row(row, colours[NET])
    for i in range(row.columns[0], row.columns[1]):
        cover[i] = seen[i] * overlap(y[i], -NET_SIDE, NET_SIDE, wide[i])
        cover[i] *= overlap(z[i], TAPE, NET_TOP, tall[i])
    lay_row(row, colours[LINE])
    for i in range(row.columns[0], row.columns[1]):
        cover[i] = seen[i] * overlap(abs(y[i]), NET_SIDE, POST_SIDE, wide[i])
        cover[i] *= overlap(z[i], -POST, NET_TOP, tall[i])
    lay_row(row, colours[STEEL])


@kernel
def opponent(row, view, paint):
    """Lay the opponent, a flat figure of tapered limbs."""
    if paint.figure.shape[0] == 0:
        return
    cross(row, view, X, OPPONENT)
    y, z, soft = row.work[U], row.work[V], row.work[SPAN_U]
    if not any_within(row, z, GROUND, FIGURE_TOP):
        return
    depth, pitch, seen = row.work[T], row.ray[PITCH], row.work[SEEN]
    for i in range(row.columns[0], row.columns[1]):
        soft[i] = depth[i] * pitch[i]
    for i in range(row.columns[0], row.columns[1]):
        inside = (abs(y[i]) < FIGURE_HALF_WIDTH) & (z[i] > GROUND) & (z[i] < FIGURE_TOP)
        seen[i] = ONE if inside & (depth[i] > row.near[i]) & (depth[i] < row.far[i]) else ZERO
    before = (row.columns[0], row.columns[1])
    narrow(row, seen)
    margin = TWO * soft[row.columns[0]]
    for k in range(paint.figure.shape[0]):
        limb = paint.figure[k]
        reach = limb[12] + margin
        if any_within(row, z, limb[10] - reach, limb[10] + reach):
            show_limb(row, limb)
            lay_row(row, paint.colours[int(limb[7])])
    row.columns[0], row.columns[1] = before


@kernel
def narrow(row, seen):
    """Restrict the columns to those from the first to the last that show something."""
    first, last = row.columns[1], row.columns[0]
    for i in range(row.columns[0], row.columns[1]):
        if seen[i] > ZERO:
            first, last = min(first, i), i + 1
    row.columns[0], row.columns[1] = min(first, last), last


@kernel
def show_limb(row, limb):
    """Write coverage and light of a limb, rounded off and lit from above."""
    y, z, soft, seen = row.work[U], row.work[V], row.work[SPAN_U], row.work[SEEN]
    light, cover = row.work[LIGHT], row.work[COVER]
    y0, z0, run_y, run_z, shortness = limb[0], limb[1], limb[2], limb[3], limb[4]
    start, taper, tone = limb[5], limb[6], limb[8]
    for i in range(row.columns[0], row.columns[1]):
        u, v = y[i] - y0, z[i] - z0
        along = min(max((u * run_y + v * run_z) * shortness, ZERO), ONE)
        u, v, radius = u - along * run_y, v - along * run_z, start + along * taper
        cover[i] = seen[i] * step(radius - math.sqrt(u * u + v * v), soft[i])
    for i in range(row.columns[0], row.columns[1]):
        u, v = y[i] - y0, z[i] - z0
        along = min(max((u * run_y + v * run_z) * shortness, ZERO), ONE)
        sharp = inverse(start + along * taper)
        u, v = (u - along * run_y) * sharp, (v - along * run_z) * sharp
        light[i] = tone * (LIMB_LIGHT + LIMB_SLOPE * (v - u) - LIMB_ROUND * (u * u + v * v))
