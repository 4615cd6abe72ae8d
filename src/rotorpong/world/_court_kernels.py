"""Table, net and opponent, compiled: layers between room and camera, except the ball."""

import math

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel, spliced_kernel
from rotorpong.world import court
from rotorpong.world._pixel_kernels import (
    AHEAD,
    ASIDE,
    BEYOND,
    BLUE,
    COVER,
    DOWN,
    EYE,
    FAR,
    GREEN,
    HALF,
    LIGHT,
    LINE,
    NEAR,
    NET,
    ONE,
    PITCH,
    QUARTER,
    RED,
    RIGHT,
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
    TINY,
    TWO,
    UP,
    WALL,
    ZERO,
    F,
    T,
    U,
    V,
    X,
    Y,
    Z,
    cross,
    fill,
    inverse,
    lay,
    overlap,
    span,
    step,
    stripes,
)
from rotorpong.world._survey_kernels import (
    BACK_LEGS,
    END,
    FIGURE,
    FIGURE_HALF_WIDTH,
    FIGURE_TOP,
    FRONT_LEGS,
    GROUND,
    LAST_LANE,
    LEG_OUTER,
    LEG_X,
    LENGTH,
    NET_PLANE,
    NET_TOP,
    OPPONENT,
    PIECE,
    POST,
    POST_SIDE,
    RISE_HIGH,
    RISE_LOW,
    SHIFT,
    SLACK,
    THICKNESS,
    TOP,
    TURN_HIGH,
    TURN_LOW,
    WIDTH,
    within,
)

EDGE, MIDDLE = F(court.EDGE_LINE_WIDTH), F(court.CENTER_LINE_WIDTH / 2)
NET_SIDE = F(court.NET_HALF_LENGTH)
TAPE = F(court.NET_HEIGHT - court.NET_TAPE_HEIGHT)
TAPE_HEIGHT = F(court.NET_TAPE_HEIGHT)
CELL, CORD, MARGIN = F(court.NET_CELL), F(court.NET_CORD), F(0.1)
LEG_INNER = F(court.LEG_Y - court.LEG_WIDTH / 2)

RADIUS, SHADE_RADIUS = F(BALL_RADIUS), F(0.026)
SHEEN, FRONT_LIGHT, SIDE_LIGHT = F(0.22), F(0.55), F(0.45)
LIMB_LIGHT, LIMB_SLOPE, LIMB_ROUND = F(1.04), F(0.18), F(0.28)


@spliced_kernel
def layers(tile, n, start, view, ball, paint, scan, top):
    """Lay everything but room and ball over the tile, far to near.

    From above the table's plane the net hides table, the table its edges and they its legs; from
    below the reverse. `top` is what `see_table` returned: what the table hides wholly is spared.
    The tile's first pixel is in column `start`.
    """
    spans, above = scan.spans, view[EYE, UP] >= ZERO
    visible, whole, plain, left, right = top
    first, last = within(spans, FIGURE, start, n)
    if first < last and paint.figure.shape[0] > 0 and not whole:
        opponent(tile[first:], last - first, start + first, view, paint, scan.pieces)
    for turn in range(4):
        layer = turn if above else 3 - turn
        if layer == 0 and not whole:
            legs(tile, n, start, view, paint.colours, spans)
        elif layer == 1 and not whole:
            edges(tile, n, start, view, paint.colours, spans)
        elif layer == 2 and visible:
            table(tile[left:], right - left, plain, view, ball, paint)
        elif layer == 3:
            first, last = within(spans, NET_PLANE, start, n)
            if first < last:
                net(tile[first:], last - first, view, paint.colours)


@kernel
def see_table(tile, n, start, view, ball, spans):
    """Write where rays meet the table, and to TABLE_SEEN the share of the pixel that it covers.

    Return whether the table is to be seen at all, whether, from above, nothing else is, whether
    it shows neither line nor shadow, and of which pixels that is said.
    """
    first, last = within(spans, TOP, start, n)
    height = view[EYE, UP]
    level = ZERO if height >= -THICKNESS * HALF else -THICKNESS
    if first >= last:
        return False, False, False, 0, 0
    part, away = tile[first:], level - height
    eye_x, eye_y = view[EYE, 0], view[EYE, 1]
    right_x, right_y, right_z = view[RIGHT, 0], view[RIGHT, 1], view[RIGHT, 2]
    down_x, down_y, down_z = view[DOWN, 0], view[DOWN, 1], view[DOWN, 2]
    ball_x, ball_y, _, sharp = shade_of(ball)
    visible, gaps, marked = False, False, False
    for i in range(last - first):
        steep = inverse(part[Z + i])
        t, slope_x, slope_y = away * steep, part[X + i] * steep, part[Y + i] * steep
        x, y, scale = eye_x + t * part[X + i], eye_y + t * part[Y + i], t * part[PITCH + i]
        long = span(slope_x, right_x, down_x, right_z, down_z, scale)
        wide = span(slope_y, right_y, down_y, right_z, down_z, scale)
        in_depth = (t > part[NEAR + i]) & (t < part[BEYOND + i]) & (t > ZERO) & (t < FAR)
        seen = overlap(x, -LENGTH, LENGTH, long) * overlap(y, -WIDTH, WIDTH, wide)
        seen = seen if in_depth else ZERO
        part[TABLE_X + i], part[TABLE_Y + i] = x, y
        part[TABLE_LONG + i], part[TABLE_WIDE + i], part[TABLE_SEEN + i] = long, wide, seen
        visible |= seen > ZERO
        gaps |= seen < ONE
        marked |= (abs(x) + HALF * long > LENGTH - EDGE) | (abs(y) + HALF * wide > WIDTH - EDGE)
        marked |= abs(y) - wide < MIDDLE
        u, v = (x - ball_x) * sharp, (y - ball_y) * sharp
        marked |= u * u + v * v < ONE
    whole = (height > ZERO) & (not gaps) & (last - first == n)
    return visible, whole, not (marked | gaps), first, last


@kernel
def shade_of(ball):
    """Return where the ball's shadow is, the root of its share of the most, and 1 / its radius."""
    height = F(ball[2]) - RADIUS
    fade = ONE - TWO * height if ZERO <= height <= HALF else ZERO
    return F(ball[0]), F(ball[1]), fade, inverse(SHADE_RADIUS + QUARTER * height)


@kernel
def table(tile, n, plain, view, ball, paint):
    """Lay the table top with its lines, or its underside."""
    if view[EYE, UP] < -THICKNESS * HALF:
        for i in range(n):
            tile[LIGHT + i], tile[COVER + i] = ONE, tile[TABLE_SEEN + i]
        lay(tile, n, paint.colours[STEEL])
    elif plain:
        plain_top(tile, n, paint.colours)
    else:
        lined_top(tile, n, ball, paint.shadow, paint.colours)


@kernel
def plain_top(tile, n, colours):
    """Lay the blue of the table over whole pixels, and over it the wall that it reflects."""
    blue_b, blue_g, blue_r = colours[TABLE, 0], colours[TABLE, 1], colours[TABLE, 2]
    wall_b, wall_g, wall_r = colours[WALL, 0], colours[WALL, 1], colours[WALL, 2]
    for i in range(n):
        sheen = sheen_of(tile[Z + i])
        tile[BLUE + i] = blue_b + sheen * (wall_b - blue_b)
        tile[GREEN + i] = blue_g + sheen * (wall_g - blue_g)
        tile[RED + i] = blue_r + sheen * (wall_r - blue_r)


@kernel
def lined_top(tile, n, ball, shadow, colours):
    """Lay the table top: blue and line in full light but for the ball's shadow, then sheen.

    Line is all but the blue within. The shadow is softer with height.
    """
    bx, by, fade, sharp = shade_of(ball)
    dark = shadow * fade * fade
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
        tile[T + i] = sheen_of(tile[Z + i])
    lay_top(tile[BLUE:], tile, n, colours[:, 0])
    lay_top(tile[GREEN:], tile, n, colours[:, 1])
    lay_top(tile[RED:], tile, n, colours[:, 2])


@kernel
def sheen_of(fall):
    """Return the share of the light that the table reflects of rays that fall so steeply."""
    grazing = ONE - min(abs(fall), ONE)
    grazing *= grazing * grazing
    return SHEEN * grazing * grazing


@kernel
def lay_top(under, tile, n, colours):
    """Lay the table top in one channel: blue and line under LIGHT, the wall reflected over both."""
    blue, white, wall = colours[TABLE], colours[LINE], colours[WALL]
    for i in range(n):
        top = tile[LIGHT + i] * (blue + tile[COVER + i] * (white - blue))
        top += tile[T + i] * (wall - top)
        seen = tile[TABLE_SEEN + i]
        under[i] = (ONE - seen) * under[i] + seen * top


@spliced_kernel
def edges(tile, n, start, view, colours, spans):
    """Lay the edges of the table top that face the camera."""
    first, last = within(spans, END, start, n)
    if first < last and abs(view[EYE, AHEAD]) > LENGTH:
        end(tile[first:], last - first, view, colours[TABLE])
    if abs(view[EYE, ASIDE]) > WIDTH:
        side(tile, n, view, colours[TABLE])


@kernel
def end(tile, n, view, colour):
    """Lay the table's end that faces the camera."""
    cross(tile, n, view, AHEAD, math.copysign(LENGTH, view[EYE, AHEAD]))
    edge(tile, tile[U:], tile[V:], n, WIDTH)
    fill(tile[LIGHT:], n, FRONT_LIGHT)
    lay(tile, n, colour)


@kernel
def side(tile, n, view, colour):
    """Lay the table's side that faces the camera."""
    cross(tile, n, view, ASIDE, math.copysign(WIDTH, view[EYE, ASIDE]))
    edge(tile, tile[V:], tile[U:], n, LENGTH)
    fill(tile[LIGHT:], n, SIDE_LIGHT)
    lay(tile, n, colour)


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


@spliced_kernel
def legs(tile, n, start, view, colours, spans):
    """Lay the two leg frames, the far one first."""
    far = math.copysign(LEG_X, -view[EYE, AHEAD])
    for x in (far, -far):
        first, last = within(spans, FRONT_LEGS if x > ZERO else BACK_LEGS, start, n)
        if first < last:
            frame(tile[first:], last - first, view, x, colours[STEEL])


@kernel
def frame(tile, n, view, x, colour):
    """Lay a leg frame."""
    cross(tile, n, view, AHEAD, x)
    for i in range(n):
        t, y, z = tile[T + i], tile[U + i], tile[V + i]
        in_depth = (t > tile[NEAR + i]) & (t < tile[BEYOND + i])
        in_depth &= (z > GROUND - MARGIN) & (z < MARGIN)
        cover = overlap(z, GROUND, -THICKNESS, tile[SPAN_V + i])
        cover *= overlap(abs(y), LEG_INNER, LEG_OUTER, tile[SPAN_U + i])
        tile[COVER + i], tile[LIGHT + i] = cover if in_depth else ZERO, ONE
    lay(tile, n, colour)


@kernel
def net(tile, n, view, colours):
    """Lay net, tape and posts."""
    cross(tile, n, view, AHEAD, ZERO)
    if net_cover(tile, n):
        lay_net(tile[BLUE:], tile, n, colours[:, 0])
        lay_net(tile[GREEN:], tile, n, colours[:, 1])
        lay_net(tile[RED:], tile, n, colours[:, 2])


@kernel
def net_cover(tile, n):
    """Write the coverage by cords (COVER), tape (SEEN) and posts (T); return whether any shows."""
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
        tile[SEEN + i] = across * overlap(z, TAPE, NET_TOP, tall)
        posts = seen * overlap(abs(y), NET_SIDE, POST_SIDE, wide)
        tile[T + i] = posts * overlap(z, -POST, NET_TOP, tall)
        visible |= (across > ZERO) | (posts > ZERO)
    return visible


@kernel
def lay_net(under, tile, n, colours):
    """Lay cords, tape and posts in one colour channel."""
    cord, line, steel = colours[NET], colours[LINE], colours[STEEL]
    for i in range(n):
        mesh, tape, post = tile[COVER + i], tile[SEEN + i], tile[T + i]
        colour = (ONE - mesh) * under[i] + mesh * cord
        colour = (ONE - tape) * colour + tape * line
        under[i] = (ONE - post) * colour + post * steel


@kernel
def opponent(tile, n, start, view, paint, pieces):
    """Lay the opponent, a flat figure of tapered limbs: in each piece those that reach into it."""
    cross(tile, n, view, AHEAD, OPPONENT)
    for i in range(n):
        t, y, z = tile[T + i], tile[U + i], tile[V + i]
        inside = (abs(y) < FIGURE_HALF_WIDTH) & (z > GROUND) & (z < FIGURE_TOP)
        seen = inside & (t > tile[NEAR + i]) & (t < tile[BEYOND + i])
        tile[SEEN + i] = ONE if seen else ZERO
        tile[SPAN_U + i] = t * tile[PITCH + i]
    away, eye_y, eye_z = OPPONENT - view[EYE, 0], view[EYE, 1], view[EYE, 2]
    figure, first = paint.figure, 0
    while first < n:
        p = (start + first) // PIECE
        past = min((p + 1) * PIECE - start, n)
        q, k = p >> SHIFT, p & LAST_LANE
        left, right = reached(away, pieces[q, TURN_LOW + k], pieces[q, TURN_HIGH + k], eye_y)
        low, high = reached(away, pieces[q, RISE_LOW + k], pieces[q, RISE_HIGH + k], eye_z)
        for j in range(figure.shape[0]):
            y, z, half_y, half_z = figure[j, 9], figure[j, 10], figure[j, 11], figure[j, 12]
            beside = (right > y - half_y) & (left < y + half_y)
            if beside & (high > z - half_z) & (low < z + half_z):
                show_limb(tile[first:], past - first, figure[j], paint.colours)
        first = past


@kernel
def reached(away, low, high, eye):
    """Return between which coordinates a plane at a distance is met by slopes from low to high."""
    one, other = eye + away * low, eye + away * high
    return min(one, other) - SLACK, max(one, other) + SLACK


@kernel
def show_limb(tile, n, limb, colours):
    """Lay a limb, rounded off and lit from above."""
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
