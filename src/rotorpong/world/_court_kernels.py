"""Table, net and opponent, compiled: layers between room and camera, except the ball."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    BEYOND,
    BLUE,
    COVER,
    EYE,
    FAR,
    GREEN,
    HALF,
    IX,
    LIGHT,
    LINE,
    NEAR,
    NET,
    ONE,
    PITCH,
    POST_COVER,
    QUARTER,
    RED,
    SEEN,
    SPAN_U,
    SPAN_V,
    STEEL,
    TABLE,
    TABLE_LONG,
    TABLE_SEEN,
    TABLE_WIDE,
    TABLE_X,
    TABLE_Y,
    TAPE_COVER,
    TINY,
    TWO,
    WALL,
    ZERO,
    F,
    T,
    U,
    V,
    Z,
    cross,
    fill,
    inverse,
    lay,
    overlap,
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
PIECE = 32  # pixels
SLACK = F(1e-3)  # for rounding, where to look or not is only a question of time
AHEAD, ASIDE, UP = np.arange(3)  # axes

RADIUS, SHADE_RADIUS = F(BALL_RADIUS), F(0.026)
SHEEN, FRONT_LIGHT, SIDE_LIGHT = F(0.22), F(0.55), F(0.45)
LIMB_LIGHT, LIMB_SLOPE, LIMB_ROUND = F(1.04), F(0.18), F(0.28)


@kernel
def layers(tile, n, view, ball, paint, seen):
    """Lay everything but room and ball over the tile, far to near.

    From above the table's plane the net hides table, the table its legs; from below the reverse.
    `seen` is what `see_table` returned: what the table hides wholly is spared.
    """
    colours, above = paint.colours, view[EYE, UP] >= ZERO
    visible, whole = seen
    end, figure, net_shows, front_legs, back_legs = survey(tile, n, view)
    if figure and not whole:
        opponent(tile, n, view, paint)
    if above:
        if not whole:
            legs(tile, n, view, colours, (front_legs, back_legs))
            sides(tile, n, view, colours, end)
        if visible:
            table(tile, n, view, ball, paint)
        if net_shows:
            net(tile, n, view, colours)
    else:
        if net_shows:
            net(tile, n, view, colours)
        if visible:
            table(tile, n, view, ball, paint)
        sides(tile, n, view, colours, end)
        legs(tile, n, view, colours, (front_legs, back_legs))


@kernel
def survey(tile, n, view):
    """Tell which planes across the table may be seen: end of the table, figure, net, legs.

    A ray that rises dz/dx meets the plane at x at the height z = o + (x - o_x) dz/dx.
    """
    x, z = view[EYE, 0], view[EYE, 2]
    end_low, end_high = rises(math.copysign(LENGTH, x) - x, -MARGIN - z, MARGIN - z)
    figure_low, figure_high = rises(OPPONENT - x, GROUND - z, FIGURE_TOP - z)
    net_low, net_high = rises(-x, -MARGIN - z, NET_TOP + MARGIN - z)
    front_low, front_high = rises(LEG_X - x, GROUND - MARGIN - z, MARGIN - z)
    back_low, back_high = rises(-LEG_X - x, GROUND - MARGIN - z, MARGIN - z)
    end, figure, net_shows, front, back = False, False, False, False, False
    for i in range(n):
        rise = tile[Z + i] * tile[IX + i]
        end |= (rise > end_low) & (rise < end_high)
        figure |= (rise > figure_low) & (rise < figure_high)
        net_shows |= (rise > net_low) & (rise < net_high)
        front |= (rise > front_low) & (rise < front_high)
        back |= (rise > back_low) & (rise < back_high)
    return end, figure, net_shows, front, back


@kernel
def rises(away, low, high):
    """Return between which rises a plane at a distance is met from low to high, any if near."""
    if abs(away) < SLACK:
        return -FAR * FAR, FAR * FAR
    one, other = low / away, high / away
    return min(one, other) - SLACK, max(one, other) + SLACK


@kernel
def see_table(tile, n, view):
    """Write where rays meet the table, and to TABLE_SEEN the share of the pixel that it covers.

    Return whether the table is to be seen at all, and whether, from above, nothing else is.
    """
    height = view[EYE, UP]
    level = ZERO if height >= -THICKNESS * HALF else -THICKNESS
    away, ahead = level - height, False
    for i in range(n):
        ahead |= away * tile[Z + i] > ZERO
    if not ahead:
        return False, False
    cross(tile, n, view, UP, level)
    visible, gaps = False, False
    for i in range(n):
        t, x, y = tile[T + i], tile[U + i], tile[V + i]
        long, wide = tile[SPAN_U + i], tile[SPAN_V + i]
        in_depth = (t > tile[NEAR + i]) & (t < tile[BEYOND + i]) & (t > ZERO) & (t < FAR)
        seen = overlap(x, -LENGTH, LENGTH, long) * overlap(y, -WIDTH, WIDTH, wide)
        seen = seen if in_depth else ZERO
        tile[TABLE_X + i], tile[TABLE_Y + i] = x, y
        tile[TABLE_LONG + i], tile[TABLE_WIDE + i], tile[TABLE_SEEN + i] = long, wide, seen
        visible |= seen > ZERO
        gaps |= seen < ONE
    return visible, (height > ZERO) & (not gaps)


@kernel
def table(tile, n, view, ball, paint):
    """Lay the table top with its lines, or its underside."""
    if view[EYE, UP] < -THICKNESS * HALF:
        for i in range(n):
            tile[LIGHT + i], tile[COVER + i] = ONE, tile[TABLE_SEEN + i]
        lay(tile, n, paint.colours[STEEL])
        return
    table_light(tile, n, ball, paint.shadow)
    lay_top(tile[BLUE:], tile, n, paint.colours[:, 0])
    lay_top(tile[GREEN:], tile, n, paint.colours[:, 1])
    lay_top(tile[RED:], tile, n, paint.colours[:, 2])


@kernel
def table_light(tile, n, ball, shadow):
    """Write LIGHT, the share COVER of the visible top that is line, and what it reflects to T.

    The light is full but for the ball's shadow, softer with height. Line is all but the blue
    within.
    """
    bx, by, height = F(ball[0]), F(ball[1]), F(ball[2]) - RADIUS
    fade = ONE - TWO * height
    dark = shadow * fade * fade if ZERO <= height <= HALF else ZERO
    sharp = inverse(SHADE_RADIUS + QUARTER * height)
    for i in range(n):
        x, y, long, wide = (
            tile[TABLE_X + i], tile[TABLE_Y + i], tile[TABLE_LONG + i], tile[TABLE_WIDE + i],
        )  # fmt: skip
        u, v = (x - bx) * sharp, (y - by) * sharp
        tile[LIGHT + i] = ONE - dark * max(ONE - u * u - v * v, ZERO)
        blue = overlap(x, EDGE - LENGTH, LENGTH - EDGE, long)
        blue *= overlap(y, EDGE - WIDTH, WIDTH - EDGE, wide)
        blue *= ONE - overlap(y, -MIDDLE, MIDDLE, wide)
        tile[COVER + i] = max(ONE - blue / max(tile[TABLE_SEEN + i], TINY), ZERO)
        grazing = ONE - min(abs(tile[Z + i]), ONE)
        grazing *= grazing * grazing
        tile[T + i] = SHEEN * grazing * grazing


@kernel
def lay_top(under, tile, n, colours):
    """Lay the table top in one channel: blue and line under LIGHT, the wall reflected over both."""
    blue, white, wall = colours[TABLE], colours[LINE], colours[WALL]
    for i in range(n):
        top = tile[LIGHT + i] * (blue + tile[COVER + i] * (white - blue))
        top += tile[T + i] * (wall - top)
        seen = tile[TABLE_SEEN + i]
        under[i] = (ONE - seen) * under[i] + seen * top


@kernel
def sides(tile, n, view, colours, end_shows):
    """Lay the edges of the table top that face the camera."""
    end = math.copysign(LENGTH, view[EYE, AHEAD])
    if end_shows and abs(view[EYE, AHEAD]) > LENGTH:
        cross(tile, n, view, AHEAD, end)
        edge(tile, tile[U:], tile[V:], n, WIDTH)
        fill(tile[LIGHT:], n, FRONT_LIGHT)
        lay(tile, n, colours[TABLE])
    end = math.copysign(WIDTH, view[EYE, ASIDE])
    if abs(view[EYE, ASIDE]) > WIDTH:
        cross(tile, n, view, ASIDE, end)
        edge(tile, tile[V:], tile[U:], n, LENGTH)
        fill(tile[LIGHT:], n, SIDE_LIGHT)
        lay(tile, n, colours[TABLE])


@kernel
def edge(tile, along, up, n, half_length):
    """Write the coverage by an edge of the table, reaching under the top: no light leaks.

    `along` and `up` are the coordinates on the edge's plane; what pixels span follows them at
    the distance of SPAN_U from U.
    """
    wide, tall = along[SPAN_U - U :], up[SPAN_U - U :]
    for i in range(n):
        t, u, z = tile[T + i], along[i], up[i]
        in_depth = (t > tile[NEAR + i]) & (t < tile[BEYOND + i]) & (z > -MARGIN) & (z < MARGIN)
        cover = overlap(u, -half_length, half_length, wide[i])
        cover *= overlap(z, -THICKNESS, HALF * min(tall[i], THICKNESS), tall[i])
        tile[COVER + i] = cover if in_depth else ZERO


@kernel
def legs(tile, n, view, colours, shows):
    """Lay the two leg frames, the far one first."""
    far = math.copysign(LEG_X, -view[EYE, AHEAD])
    for x in (far, -far):
        if shows[0] if x > ZERO else shows[1]:
            cross(tile, n, view, AHEAD, x)
            for i in range(n):
                t, y, z = tile[T + i], tile[U + i], tile[V + i]
                in_depth = (t > tile[NEAR + i]) & (t < tile[BEYOND + i])
                in_depth &= (z > GROUND - MARGIN) & (z < MARGIN)
                cover = overlap(z, GROUND, -THICKNESS, tile[SPAN_V + i])
                cover *= overlap(abs(y), LEG_INNER, LEG_OUTER, tile[SPAN_U + i])
                tile[COVER + i], tile[LIGHT + i] = cover if in_depth else ZERO, ONE
            lay(tile, n, colours[STEEL])


@kernel
def net(tile, n, view, colours):
    """Lay net, tape and posts."""
    cross(tile, n, view, AHEAD, ZERO)
    if not net_cover(tile, n):
        return
    lay_net(tile[BLUE:], tile, n, colours[:, 0])
    lay_net(tile[GREEN:], tile, n, colours[:, 1])
    lay_net(tile[RED:], tile, n, colours[:, 2])


@kernel
def net_cover(tile, n):
    """Write the coverage by cords, tape and posts; return whether any is to be seen."""
    visible = False
    for i in range(n):
        t, y, z, wide, tall = (
            tile[T + i],
            tile[U + i],
            tile[V + i],
            tile[SPAN_U + i],
            tile[SPAN_V + i],
        )
        in_depth = (t > tile[NEAR + i]) & (t < tile[BEYOND + i])
        seen = ONE if in_depth & (z > -MARGIN) & (z < NET_TOP + MARGIN) else ZERO
        holes = (ONE - stripes(y, CELL, CORD, wide)) * (ONE - stripes(z, CELL, CORD, tall))
        across = seen * overlap(y, -NET_SIDE, NET_SIDE, wide)
        under_tape = TAPE + HALF * min(tall, TAPE_HEIGHT)  # no light leaks between the two
        tile[COVER + i] = (ONE - holes) * overlap(z, ZERO, under_tape, tall) * across
        tile[TAPE_COVER + i] = across * overlap(z, TAPE, NET_TOP, tall)
        posts = seen * overlap(abs(y), NET_SIDE, POST_SIDE, wide)
        tile[POST_COVER + i] = posts * overlap(z, -POST, NET_TOP, tall)
        visible |= (across > ZERO) | (posts > ZERO)
    return visible


@kernel
def lay_net(under, tile, n, colours):
    """Lay cords, tape and posts in one colour channel."""
    cord, line, steel = colours[NET], colours[LINE], colours[STEEL]
    for i in range(n):
        mesh, tape, post = tile[COVER + i], tile[TAPE_COVER + i], tile[POST_COVER + i]
        colour = (ONE - mesh) * under[i] + mesh * cord
        colour = (ONE - tape) * colour + tape * line
        under[i] = (ONE - post) * colour + post * steel


@kernel
def opponent(tile, n, view, paint):
    """Lay the opponent, a flat figure of tapered limbs."""
    if paint.figure.shape[0] == 0:
        return
    cross(tile, n, view, AHEAD, OPPONENT)
    visible = False
    for i in range(n):
        t, y, z = tile[T + i], tile[U + i], tile[V + i]
        tile[SPAN_U + i] = t * tile[PITCH + i]
        inside = (abs(y) < FIGURE_HALF_WIDTH) & (z > GROUND) & (z < FIGURE_TOP)
        seen = inside & (t > tile[NEAR + i]) & (t < tile[BEYOND + i])
        tile[SEEN + i] = ONE if seen else ZERO
        visible |= seen
    if visible:
        first, last = 0, n
        while tile[SEEN + first] == ZERO:
            first += 1
        while tile[SEEN + last - 1] == ZERO:
            last -= 1
        limbs(tile[first:], last - first, paint)


@kernel
def limbs(tile, n, paint):
    """Lay the limbs that reach into the tile, in pieces of it as narrow as limbs are."""
    margin = TWO * tile[SPAN_U]
    for k in range(paint.figure.shape[0]):
        limb = paint.figure[k]
        reach, visible = limb[12] + margin, False
        low, high = limb[10] - reach, limb[10] + reach
        for i in range(n):
            visible |= (tile[V + i] > low) & (tile[V + i] < high)
        if visible:
            for start in range(0, n, PIECE):
                show_limb(tile[start:], min(n - start, PIECE), limb, margin, paint.colours)


@kernel
def show_limb(tile, n, limb, margin, colours):
    """Lay a limb, rounded off and lit from above, if it reaches into the tile."""
    low, high, visible = limb[9] - limb[11] - margin, limb[9] + limb[11] + margin, False
    for i in range(n):
        visible |= (tile[U + i] > low) & (tile[U + i] < high)
    if not visible:
        return
    y0, z0, run_y, run_z, shortness = limb[0], limb[1], limb[2], limb[3], limb[4]
    start, taper, tone = limb[5], limb[6], limb[8]
    for i in range(n):
        u, v = tile[U + i] - y0, tile[V + i] - z0
        along = min(max((u * run_y + v * run_z) * shortness, ZERO), ONE)
        u, v, radius = u - along * run_y, v - along * run_z, start + along * taper
        cover = step(radius - math.sqrt(u * u + v * v), tile[SPAN_U + i])
        tile[COVER + i] = tile[SEEN + i] * cover
        sharp = inverse(radius)
        u, v = u * sharp, v * sharp
        tile[LIGHT + i] = tone * (LIMB_LIGHT + LIMB_SLOPE * (v - u) - LIMB_ROUND * (u * u + v * v))
    lay(tile, n, colours[int(limb[7])])
