"""The ball, compiled: which share of a pixel it covers in an exposure, and how bright it is.

A ray d meets the sphere about c where (d.c)^2 >= |d|^2 (|c|^2 - r^2). Pixels of which every point
is inside or outside at an instant need one ray; the others get sub x sub, placed by the local
slopes of the ray table. Loops over pixels and over the rays of one vectorise; what they find is
added up in order.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world._moment_kernels import look_for_ball
from rotorpong.world._pixel_kernels import BALL_COVER, BALL_LIGHT, NEAR, TILE, TWO, F

SUB, SUB_MOVING = np.array([6, 4])  # samples along a pixel's side: at rest, at each instant
AMBIENT = 0.58
MOST_RAYS = int(SUB) ** 2
# Places in the float64 scratch of a tile: sums over instants; a ray, its slopes to the next one
# right and down, half of what a pixel spans; whether it needs more rays than one.
(
    COVERS, DEPTHS, LIGHTS, ACROSS, ALONG, ACROSS_RIGHT, ALONG_RIGHT, ACROSS_DOWN, ALONG_DOWN,
    HALF_WIDE, MIXED,
) = (TILE * row for row in range(11))  # fmt: skip
# And of the rays of one pixel: where they are in it, whether they meet the ball, what they find.
ASIDE, BELOW, HIT, DEPTH, BRIGHT = (TILE * 11 + MOST_RAYS * row for row in range(5))
SUMS_SIZE = BRIGHT + MOST_RAYS


@kernel
def cover_rows(coverage, lens, shutter, moment, work):
    """Write which share of each pixel the ball covers if nothing is in front of it."""
    tile, sums = work[0], work[2]
    for row in range(coverage.shape[0]):
        look_for_ball(moment, shutter, row)
        for start in range(0, coverage.shape[1], TILE):
            n = min(coverage.shape[1] - start, TILE)
            first, last = near_ball(lens.rays, (start, row), (0, n), moment.box)
            if first < last:
                sample_ball(tile, sums, lens.rays, (start, row), (first, last), moment)
                for i in range(first, last):
                    coverage[row, start + i] = tile[BALL_COVER + i]


@kernel
def near_ball(rays, place, part, box):
    """Return the first and one past the last pixel of a part that may show a ball in the box."""
    start, row = place
    left, right, top, bottom = box[0], box[1], box[2], box[3]
    first, last = part[1], part[0]
    for i in range(part[0], part[1]):
        a, b = rays[0, row, start + i], rays[1, row, start + i]
        margin = TWO * rays[2, row, start + i]
        beside = (a > left - margin) & (a < right + margin)
        if beside & (b > top - margin) & (b < bottom + margin):
            first, last = min(first, i), i + 1
    return first, last


@kernel
def sample_ball(tile, sums, rays, place, part, moment):
    """Write which share of pixel and exposure the ball covers in a part of a tile.

    Its brightness goes to BALL_LIGHT, its depth to NEAR.
    """
    count, first, last = moment.balls.shape[0], part[0], part[1]
    place_rays(sums, rays, place, part)
    light = moment.light[0], moment.light[1], moment.light[2]
    sub = SUB if count == 1 else SUB_MOVING
    for s in range(count):
        ball = moment.balls[s, 0], moment.balls[s, 1], moment.balls[s, 2]
        if sample_insides(sums[first:], last - first, ball, light):
            offset = ((s + 0.5) / count, (s * 3 % count + 0.5) / count)  # the mean is the middle
            spread(sums, sub, offset)
            for i in range(first, last):
                if sums[MIXED + i] > 0.0:
                    sample_edge(sums, i, sub * sub, ball, light)
    for i in range(first, last):
        cover = sums[COVERS + i]
        scale = 1.0 / (cover if cover > 0.0 else 1.0)
        tile[BALL_COVER + i], tile[NEAR + i] = F(cover / count), F(sums[DEPTHS + i] * scale)
        tile[BALL_LIGHT + i] = F(sums[LIGHTS + i] * scale)


@kernel
def place_rays(sums, rays, place, part):
    """Write the rays of a part of a tile and their slopes, and clear the sums."""
    column, row = place
    for i in range(part[0], part[1]):
        ax, bx, ay, by = slopes(rays, row, column + i)
        sums[ACROSS_RIGHT + i], sums[ALONG_RIGHT + i] = ax, bx
        sums[ACROSS_DOWN + i], sums[ALONG_DOWN + i] = ay, by
        sums[HALF_WIDE + i] = 0.5 * (abs(ax) + abs(bx) + abs(ay) + abs(by))
        sums[ACROSS + i], sums[ALONG + i] = rays[0, row, column + i], rays[1, row, column + i]
        sums[COVERS + i], sums[DEPTHS + i], sums[LIGHTS + i] = 0.0, 0.0, 0.0


@kernel
def sample_insides(sums, n, ball, toward_light):
    """Add the ball of an instant where it covers pixels wholly; return whether some are mixed.

    Mixed are those that it may cover in part; MIXED tells which.
    """
    x, y, z = ball
    beyond = x**2 + y**2 + z**2 - BALL_RADIUS**2
    some = False
    for i in range(n):
        a, b = sums[ACROSS + i], sums[ALONG + i]
        along, squared = a * x + b * y + z, a * a + b * b + 1.0
        nearness = along / max(squared, 1.0)
        off_axis = math.sqrt(max(beyond + BALL_RADIUS**2 - along * nearness, 0.0))
        reach = sums[HALF_WIDE + i] * nearness
        ahead = (along > 0.0) & (beyond > 0.0)
        inside = ahead & (off_axis + reach < BALL_RADIUS)
        mixed = ahead & (not inside) & (off_axis - reach <= BALL_RADIUS)
        root = math.sqrt(max(along * along - squared * beyond, 0.0))
        depth = (along - root) / max(squared, 1.0)
        light = ball_light(a, b, depth, ball, toward_light)
        sums[COVERS + i] += 1.0 if inside else 0.0
        sums[DEPTHS + i] += depth if inside else 0.0
        sums[LIGHTS + i] += light if inside else 0.0
        sums[MIXED + i] = 1.0 if mixed else 0.0
        some |= mixed
    return some


@kernel
def spread(sums, sub, offset):
    """Write where in a pixel its rays are, -1/2 .. 1/2 to the right and down."""
    for i in range(sub):
        for j in range(sub):
            sums[ASIDE + sub * i + j] = (j + offset[0]) / sub - 0.5
            sums[BELOW + sub * i + j] = (i + offset[1]) / sub - 0.5


@kernel
def sample_edge(sums, place, n, ball, toward_light):
    """Add the ball of an instant to a pixel that it may cover in part, by n rays."""
    x, y, z = ball
    beyond = x**2 + y**2 + z**2 - BALL_RADIUS**2
    a, b = sums[ACROSS + place], sums[ALONG + place]
    ax, bx = sums[ACROSS_RIGHT + place], sums[ALONG_RIGHT + place]
    ay, by = sums[ACROSS_DOWN + place], sums[ALONG_DOWN + place]
    for k in range(n):
        u, v = sums[ASIDE + k], sums[BELOW + k]
        p, q = a + u * ax + v * ay, b + u * bx + v * by
        along, squared = p * x + q * y + z, p * p + q * q + 1.0
        inside = along * along - squared * beyond
        depth = (along - math.sqrt(max(inside, 0.0))) / max(squared, 1.0)
        light = ball_light(p, q, depth, ball, toward_light)
        sums[HIT + k] = 1.0 if inside >= 0.0 else 0.0
        sums[DEPTH + k] = depth if inside >= 0.0 else 0.0
        sums[BRIGHT + k] = light if inside >= 0.0 else 0.0
    hits, depths, lights = 0.0, 0.0, 0.0
    for k in range(n):
        hits += sums[HIT + k]
        depths += sums[DEPTH + k]
        lights += sums[BRIGHT + k]
    if hits > 0.0:
        share = hits / n
        sums[COVERS + place] += share
        sums[DEPTHS + place] += share * (depths / hits)
        sums[LIGHTS + place] += share * (lights / hits)


@kernel
def slopes(rays, row, column):
    """Return how X/Z and Y/Z change from this pixel to the next one right, and down."""
    r0, r1 = max(row - 1, 0), min(row + 1, rays.shape[1] - 1)
    c0, c1 = max(column - 1, 0), min(column + 1, rays.shape[2] - 1)
    right, down = 1.0 / max(c1 - c0, 1), 1.0 / max(r1 - r0, 1)
    return (
        right * (np.float64(rays[0, row, c1]) - rays[0, row, c0]),
        right * (np.float64(rays[1, row, c1]) - rays[1, row, c0]),
        down * (np.float64(rays[0, r1, column]) - rays[0, r0, column]),
        down * (np.float64(rays[1, r1, column]) - rays[1, r0, column]),
    )


@kernel
def ball_light(a, b, depth, ball, toward_light):
    """Return the brightness of the point of the ball that a ray meets: Lambert's.

    That is ambient light and as much of the rest as the cosine to the light.
    """
    across, along = a * depth - ball[0], b * depth - ball[1]
    cosine = across * toward_light[0] + along * toward_light[1]
    cosine = (cosine + (depth - ball[2]) * toward_light[2]) / BALL_RADIUS
    return AMBIENT + (1.0 - AMBIENT) * max(cosine, 0.0)
