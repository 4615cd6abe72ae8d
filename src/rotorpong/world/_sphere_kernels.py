"""The ball, compiled: which share of a pixel it covers while a row is exposed, and how bright it is.

A ray d meets the sphere about c where (d.c)^2 >= |d|^2 (|c|^2 - r^2). Pixels of which every point
is inside or outside at an instant need one ray, and go through a loop that vectorises; the others
get sub x sub rays, placed by the local slopes of the ray table.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world._moment_kernels import look_for_ball
from rotorpong.world._pixel_kernels import BALL_COVER, BALL_LIGHT, NEAR, TILE, TWO, F

SUB, SUB_MOVING = np.array([6, 4])  # samples along a pixel's side: at rest, at each instant
AMBIENT = 0.58
# places in the float64 scratch of a tile: sums over instants, a ray's place, half of what a pixel
# spans, whether it needs more rays than one
COVERS, DEPTHS, LIGHTS, ACROSS, ALONG, HALF_WIDE, MIXED = (TILE * row for row in range(7))
SUMS_SIZE = TILE * 7


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
    """Write of a part of a tile which share of pixel and exposure the ball covers, and how it looks.

    Its brightness goes to BALL_LIGHT, its depth to NEAR.
    """
    column, row = place
    count, first, last = moment.balls.shape[0], part[0], part[1]
    for i in range(first, last):
        ax, bx, ay, by = slopes(rays, row, column + i)
        sums[HALF_WIDE + i] = 0.5 * (abs(ax) + abs(bx) + abs(ay) + abs(by))
        sums[ACROSS + i], sums[ALONG + i] = rays[0, row, column + i], rays[1, row, column + i]
        sums[COVERS + i], sums[DEPTHS + i], sums[LIGHTS + i] = 0.0, 0.0, 0.0
    sub = SUB if count == 1 else SUB_MOVING
    for s in range(count):
        ball = moment.balls[s]
        if sample_insides(sums[first:], last - first, ball, moment.light):
            offset = ((s + 0.5) / count, (s * 3 % count + 0.5) / count)  # the mean is the middle
            for i in range(first, last):
                if sums[MIXED + i] > 0.0:
                    a, b = sums[ACROSS + i], sums[ALONG + i]
                    pixel = (a, b, *slopes(rays, row, column + i))
                    share, far, bright = sample_edge(pixel, ball, moment.light, sub, offset)
                    sums[COVERS + i] += share
                    sums[DEPTHS + i] += share * far
                    sums[LIGHTS + i] += share * bright
    for i in range(first, last):
        cover = sums[COVERS + i]
        scale = 1.0 / (cover if cover > 0.0 else 1.0)
        tile[BALL_COVER + i], tile[NEAR + i] = F(cover / count), F(sums[DEPTHS + i] * scale)
        tile[BALL_LIGHT + i] = F(sums[LIGHTS + i] * scale)


@kernel
def sample_insides(sums, n, ball, toward_light):
    """Add the ball of an instant where it covers pixels wholly; return whether some are mixed.

    Mixed are those that it may cover in part; MIXED tells which.
    """
    x, y, z = ball[0], ball[1], ball[2]
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
def sample_edge(pixel, ball, toward_light, sub, offset):
    """Return the share of a pixel that the ball covers, its depth there, and its brightness."""
    a, b, ax, bx, ay, by = pixel
    beyond = ball[0] ** 2 + ball[1] ** 2 + ball[2] ** 2 - BALL_RADIUS**2
    hits, depths, lights = 0, 0.0, 0.0
    for i in range(sub):
        for j in range(sub):
            u, v = (j + offset[0]) / sub - 0.5, (i + offset[1]) / sub - 0.5
            p, q = a + u * ax + v * ay, b + u * bx + v * by
            along = p * ball[0] + q * ball[1] + ball[2]
            squared = p * p + q * q + 1.0
            inside = along * along - squared * beyond
            if inside >= 0.0:
                depth = (along - math.sqrt(inside)) / squared
                hits += 1
                depths += depth
                lights += ball_light(p, q, depth, ball, toward_light)
    if hits == 0:
        return 0.0, 0.0, 0.0
    return hits / (sub * sub), depths / hits, lights / hits


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
    """Return the brightness of the point of the ball that a ray meets: ambient and Lambert."""
    x, y, z = a * depth - ball[0], b * depth - ball[1], depth - ball[2]
    cosine = (x * toward_light[0] + y * toward_light[1] + z * toward_light[2]) / BALL_RADIUS
    return AMBIENT + (1.0 - AMBIENT) * max(cosine, 0.0)
