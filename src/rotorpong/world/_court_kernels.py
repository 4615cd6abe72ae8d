"""Table, net and opponent, compiled: layers between room and camera, except the ball."""

import math

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    FAR,
    HALF,
    IX,
    IY,
    IZ,
    LINE,
    NET,
    ONE,
    PITCH,
    QUARTER,
    STEEL,
    TABLE,
    TWO,
    WALL,
    ZERO,
    F,
    X,
    Y,
    Z,
    any_within,
    follow,
    inverse,
    lay,
    lay_row,
    level_places,
    meet,
    overlap,
    span,
    step,
    stripes,
)

LENGTH, WIDTH = F(court.TABLE_HALF_LENGTH), F(court.TABLE_HALF_WIDTH)
THICKNESS = F(court.TABLE_THICKNESS)
EDGE, MIDDLE = F(court.EDGE_LINE_WIDTH), F(court.CENTER_LINE_WIDTH / 2)
NET_TOP, NET_SIDE = F(court.NET_HEIGHT), F(court.NET_HALF_LENGTH)
TAPE = F(court.NET_HEIGHT - court.NET_TAPE_HEIGHT)
CELL, CORD, POST = F(court.NET_CELL), F(court.NET_CORD), F(court.POST_WIDTH)
LEG_X, LEG_Y, LEG_WIDTH = F(court.LEG_X), F(court.LEG_Y), F(court.LEG_WIDTH / 2)
GROUND = F(court.FLOOR_HEIGHT)
OPPONENT = F(court.OPPONENT_X)
FIGURE_HALF_WIDTH, FIGURE_TOP, MARGIN = F(0.6), F(1.05), F(0.2)

RADIUS, SHADE_RADIUS = F(BALL_RADIUS), F(0.026)
SHEEN, FRONT_LIGHT, SIDE_LIGHT = F(0.22), F(0.55), F(0.45)
LIMB_LIGHT, LIMB_SLOPE, LIMB_ROUND = F(1.04), F(0.18), F(0.28)


@kernel
def layers(row, columns, view, ball, paint):
    """Lay everything but room and ball over a range of columns, far to near.

    From above the table's plane the net hides table, the table its legs; from below the reverse.
    """
    opponent(row, columns, view, paint)
    if view.z >= ZERO:
        legs(row, columns, view, paint.colours)
        sides(row, columns, view, paint.colours)
        table(row, columns, view, ball, paint)
        net(row, columns, view, paint.colours)
    else:
        net(row, columns, view, paint.colours)
        table(row, columns, view, ball, paint)
        sides(row, columns, view, paint.colours)
        legs(row, columns, view, paint.colours)


@kernel
def table(row, columns, view, ball, paint):
    """Lay the table top with its lines, or its underside."""
    level = ZERO if view.z >= -THICKNESS * HALF else -THICKNESS
    x, y, long, wide, cover, light = (
        row.work[0], row.work[1], row.work[2], row.work[3], row.work[4], row.work[5],
    )  # fmt: skip
    level_places(row, columns, view, level)
    for i in range(columns[0], columns[1]):
        on = overlap(x[i], -LENGTH, LENGTH, long[i]) * overlap(y[i], -WIDTH, WIDTH, wide[i])
        cover[i] = on if (light[i] > row.near[i]) & (light[i] < row.far[i]) else ZERO
    if not any_within(cover, columns, ZERO, TWO):
        return
    table_light(light, columns, row.work, ball, paint)
    top = TABLE if level == ZERO else STEEL
    lay_row(row.colour, columns, paint.colours[top], light, cover)
    if level == ZERO:
        table_lines(long, columns, row.work)
        lay_row(row.colour, columns, paint.colours[LINE], light, long)
        table_sheen(wide, columns, row.ray[Z], cover, light)
        lay_row(row.colour, columns, paint.colours[WALL], light, wide)


@kernel
def table_light(out, columns, work, ball, paint):
    """Write the brightness of the top: full but for the ball's shadow."""
    x, y = work[0], work[1]
    out[columns[0] : columns[1]] = ONE
    bx, by, height = F(ball[0]), F(ball[1]), F(ball[2]) - RADIUS
    if height < ZERO or height > HALF:
        return
    sharp = inverse(SHADE_RADIUS + QUARTER * height)
    dark = paint.shadow * (ONE - TWO * height) * (ONE - TWO * height)
    for i in range(columns[0], columns[1]):
        u, v = (x[i] - bx) * sharp, (y[i] - by) * sharp
        out[i] *= ONE - dark * max(ONE - u * u - v * v, ZERO)


@kernel
def table_lines(out, columns, work):
    """Write the coverage by lines: what the top covers less the blue within the lines."""
    x, y, long, wide, cover = work[0], work[1], work[2], work[3], work[4]
    for i in range(columns[0], columns[1]):
        blue = overlap(x[i], EDGE - LENGTH, LENGTH - EDGE, long[i])
        blue *= overlap(y[i], EDGE - WIDTH, WIDTH - EDGE, wide[i])
        blue *= ONE - overlap(y[i], -MIDDLE, MIDDLE, wide[i])
        out[i] = max(cover[i] - blue, ZERO) if cover[i] > ZERO else ZERO


@kernel
def table_sheen(out, columns, z, cover, light):
    """Write how much of the wall the top reflects, and full light for it."""
    for i in range(columns[0], columns[1]):
        grazing = ONE - min(abs(z[i]), ONE)
        grazing *= grazing * grazing
        out[i] = SHEEN * grazing * grazing * cover[i]
    light[columns[0] : columns[1]] = ONE


@kernel
def sides(row, columns, view, colours):
    """Lay the edges of the table top that face the camera."""
    t, z = row.work[0], row.work[1]
    if abs(view.x) > LENGTH:
        meet(t, columns, row.ray[IX], math.copysign(LENGTH, view.x) - view.x)
        follow(z, columns, t, row.ray[Z], view.z)
        if any_within(z, columns, -MARGIN, MARGIN):
            front_edge(row, columns, view, colours)
    if abs(view.y) > WIDTH:
        meet(t, columns, row.ray[IY], math.copysign(WIDTH, view.y) - view.y)
        follow(z, columns, t, row.ray[Z], view.z)
        if any_within(z, columns, -MARGIN, MARGIN):
            side_edge(row, columns, view, colours)


@kernel
def front_edge(row, columns, view, colours):
    """Lay the near or far edge of the table."""
    ray = row.ray
    for i in range(columns[0], columns[1]):
        t, z, ix = row.work[0, i], row.work[1, i], ray[IX, i]
        if row.near[i] < t < row.far[i] and abs(z) < MARGIN:
            y, scale = view.y + t * ray[Y, i], t * ray[PITCH, i]
            wide = span(ray[Y, i] * ix, view.ry, view.dy, view.rx, view.dx, scale)
            tall = span(ray[Z, i] * ix, view.rz, view.dz, view.rx, view.dx, scale)
            lay(row.colour, i, colours, TABLE, FRONT_LIGHT, edge(y, z, WIDTH, wide, tall))


@kernel
def side_edge(row, columns, view, colours):
    """Lay the left or right edge of the table."""
    ray = row.ray
    for i in range(columns[0], columns[1]):
        t, z, iy = row.work[0, i], row.work[1, i], ray[IY, i]
        if row.near[i] < t < row.far[i] and abs(z) < MARGIN:
            x, scale = view.x + t * ray[X, i], t * ray[PITCH, i]
            wide = span(ray[X, i] * iy, view.rx, view.dx, view.ry, view.dy, scale)
            tall = span(ray[Z, i] * iy, view.rz, view.dz, view.ry, view.dy, scale)
            lay(row.colour, i, colours, TABLE, SIDE_LIGHT, edge(x, z, LENGTH, wide, tall))


@kernel
def edge(u, z, half_length, wide, tall):
    """Return the coverage by the table's edge, reaching under the top so that no light leaks."""
    cover = overlap(z, -THICKNESS, HALF * min(tall, THICKNESS), tall)
    return cover * overlap(u, -half_length, half_length, wide)


@kernel
def legs(row, columns, view, colours):
    """Lay the two leg frames, the far one first."""
    far = math.copysign(LEG_X, -view.x)
    for x in (far, -far):
        meet(row.work[0], columns, row.ray[IX], x - view.x)
        follow(row.work[1], columns, row.work[0], row.ray[Z], view.z)
        if any_within(row.work[1], columns, GROUND - LEG_WIDTH, ZERO):
            leg_frame(row, columns, view, colours)


@kernel
def leg_frame(row, columns, view, colours):
    """Lay a pair of legs."""
    ray = row.ray
    for i in range(columns[0], columns[1]):
        t, z, ix = row.work[0, i], row.work[1, i], ray[IX, i]
        y = abs(view.y + t * ray[Y, i])
        if t <= row.near[i] or t >= row.far[i] or abs(y - LEG_Y) > TWO * LEG_WIDTH:
            continue
        scale = t * ray[PITCH, i]
        wide = span(ray[Y, i] * ix, view.ry, view.dy, view.rx, view.dx, scale)
        tall = span(ray[Z, i] * ix, view.rz, view.dz, view.rx, view.dx, scale)
        cover = overlap(y, LEG_Y - LEG_WIDTH, LEG_Y + LEG_WIDTH, wide)
        lay(row.colour, i, colours, STEEL, ONE, cover * overlap(z, GROUND, -THICKNESS, tall))


@kernel
def net(row, columns, view, colours):
    """Lay net, tape and posts."""
    ray = row.ray
    meet(row.work[0], columns, ray[IX], -view.x)
    follow(row.work[1], columns, row.work[0], ray[Z], view.z)
    if not any_within(row.work[1], columns, -TWO * POST, NET_TOP + POST):
        return
    for i in range(columns[0], columns[1]):
        t, z, ix = row.work[0, i], row.work[1, i], ray[IX, i]
        y = view.y + t * ray[Y, i]
        if t <= row.near[i] or t >= row.far[i] or abs(y) > NET_SIDE + TWO * POST:
            continue
        scale = t * ray[PITCH, i]
        wide = span(ray[Y, i] * ix, view.ry, view.dy, view.rx, view.dx, scale)
        tall = span(ray[Z, i] * ix, view.rz, view.dz, view.rx, view.dx, scale)
        across = overlap(y, -NET_SIDE, NET_SIDE, wide)
        gaps = (ONE - stripes(y, CELL, CORD, wide)) * (ONE - stripes(z, CELL, CORD, tall))
        mesh = across * overlap(z, ZERO, TAPE, tall) * (ONE - gaps)
        post = overlap(abs(y), NET_SIDE, NET_SIDE + POST, wide)
        lay(row.colour, i, colours, NET, ONE, mesh)
        lay(row.colour, i, colours, LINE, ONE, across * overlap(z, TAPE, NET_TOP, tall))
        lay(row.colour, i, colours, STEEL, ONE, post * overlap(z, -POST, NET_TOP, tall))


@kernel
def opponent(row, columns, view, paint):
    """Lay the opponent, a flat figure of tapered limbs."""
    ray = row.ray
    meet(row.work[0], columns, ray[IX], OPPONENT - view.x)
    follow(row.work[1], columns, row.work[0], ray[Z], view.z)
    if paint.figure.shape[0] == 0 or not any_within(row.work[1], columns, GROUND, FIGURE_TOP):
        return
    for i in range(columns[0], columns[1]):
        t, z = row.work[0, i], row.work[1, i]
        y = view.y + t * ray[Y, i]
        if row.near[i] < t < row.far[i] and abs(y) < FIGURE_HALF_WIDTH and GROUND < z < FIGURE_TOP:
            limbs(row.colour, i, (y, z, t * ray[PITCH, i]), paint.colours, paint.figure)


@kernel
def limbs(pixels, i, place, colours, figure):
    """Lay every limb near a point of the opponent's plane, rounded off and lit from above."""
    y, z, soft = place
    for k in range(figure.shape[0]):
        limb = figure[k]
        if abs(y - limb[9]) > limb[11] + soft or abs(z - limb[10]) > limb[12] + soft:
            continue
        u, v = y - limb[0], z - limb[1]
        along = min(max((u * limb[2] + v * limb[3]) * limb[4], ZERO), ONE)
        u, v = u - along * limb[2], v - along * limb[3]
        radius = limb[5] + along * limb[6]
        off, sharp = math.sqrt(u * u + v * v), inverse(radius)
        light = LIMB_LIGHT + LIMB_SLOPE * (v - u) * sharp - LIMB_ROUND * off * off * sharp * sharp
        lay(pixels, i, colours, int(limb[7]), light * limb[8], step(radius - off, soft))
