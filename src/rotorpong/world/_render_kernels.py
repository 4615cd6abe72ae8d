"""The ray caster, compiled: rows of pixels, and the ball between its far and near layers."""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world._court_kernels import layers, table_hides_all
from rotorpong.world._pixel_kernels import (
    BALL,
    DOWN,
    EYE,
    FAR,
    FORWARD,
    HALF,
    IX,
    ONE,
    PITCH,
    RIGHT,
    TILE,
    TWO,
    WALL_T,
    WALL_Z,
    ZERO,
    F,
    X,
    Z,
    fill,
    follow,
    inverse,
    lay,
)
from rotorpong.world._room_kernels import meet_walls, room

WHITEST = F(255)
SUB = 6  # samples along each side of a pixel
LIGHT = (-0.60, 0.25, 0.76)  # direction to the light, world frame, unit length
AMBIENT = 0.58


class BallView(NamedTuple):
    """The ball in the camera frame, and the box of directions outside which it cannot be seen."""

    x: float
    y: float
    z: float
    light_x: float
    light_y: float
    light_z: float
    left: F
    right: F
    top: F
    bottom: F


@kernel
def paint_rows(picture, rays, corner, pose, ball, paint, row):
    """Paint a box of the picture whose upper left pixel is (column, row) = corner.

    The pose is asked for row by row: a rolling shutter would hand each row its own. A row is
    painted in tiles that fit the processor's first cache.
    """
    position, rotation, view = pose
    for i in range(picture.shape[0]):
        view_of(view, position, rotation)
        seen = ball_view(ball, position, rotation)
        for start in range(0, picture.shape[1], TILE):
            count = min(picture.shape[1] - start, TILE)
            place = (corner[0] + start, corner[1] + i)
            row.columns[0], row.columns[1] = 0, count
            cast(row, rays[:, place[1], place[0] : place[0] + count], view)
            first, last = ball_columns(rays, place, count, seen)
            sample_columns(row, first, last, rays, place, seen)
            hidden = table_hides_all(row, view)
            if not hidden:
                room(row, view, paint)
            layers(row, view, ball, paint, hidden)
            if first < last:
                lay_ball(row, first, last, paint.colours[BALL])
                layers(row, view, ball, paint, hidden)
            expose(picture[i, start : start + count], row.colour)


@kernel
def sample_columns(row, first, last, rays, place, ball):
    """Write the ball's light and coverage, and bound the layers behind it."""
    for i in range(first, last):
        cover, depth, light = sample_ball(rays, place[1], place[0] + i, ball)
        row.ball[0, i], row.ball[1, i], row.near[i] = light, cover, depth


@kernel
def lay_ball(row, first, last, colour):
    """Lay the ball, and make its columns and what is before it the next to be painted."""
    for i in range(first, last):
        lay(row.colour, i, colour, row.ball[0, i], row.ball[1, i])
        row.near[i], row.far[i] = ZERO, row.near[i]
    row.columns[0], row.columns[1] = first, last


@kernel
def cover_rows(coverage, rays, position, rotation, ball):
    """Write which share of each pixel the ball covers if nothing is in front of it."""
    seen = ball_view(ball, position, rotation)
    for row in range(coverage.shape[0]):
        first, last = ball_columns(rays, (0, row), coverage.shape[1], seen)
        for column in range(first, last):
            coverage[row, column] = sample_ball(rays, row, column, seen)[0]


@kernel
def view_of(view, position, rotation):
    """Write a pose in single precision: eye, and axes right, down, forward, in the world."""
    for k in range(3):
        view[EYE, k] = position[k]
        for axis in range(3):
            view[RIGHT + axis, k] = rotation[k, axis]


@kernel
def cast(row, rays, view):
    """Start a row: its rays in the world, where they meet the walls, no bounds."""
    ray, a, b = row.ray, rays[0], rays[1]
    for k in range(3):
        right, down, forward = view[RIGHT, k], view[DOWN, k], view[FORWARD, k]
        direction, inverse_direction = ray[X + k], ray[IX + k]
        for i in range(row.columns[0], row.columns[1]):
            direction[i] = forward + a[i] * right + b[i] * down
        for i in range(row.columns[0], row.columns[1]):
            inverse_direction[i] = inverse(direction[i])
        fill(row, row.colour[k], ZERO)
    for i in range(row.columns[0], row.columns[1]):
        ray[PITCH, i] = rays[2, i]
    meet_walls(row, view)
    follow(row, ray[WALL_Z], ray[WALL_T], ray[Z], view[EYE, Z])
    fill(row, row.near, ZERO)
    fill(row, row.far, FAR)


@kernel
def expose(pixels, colour):
    """Round a row to what the picture holds."""
    for i in range(pixels.shape[0]):
        for k in range(3):
            pixels[i, k] = np.uint8(min(max(colour[k, i], ZERO), WHITEST) + HALF)


@kernel
def ball_view(ball, position, rotation):
    """Return the ball as this pose sees it.

    The outline of a sphere at (X, Y, Z) lies within a = (X Z +- r sqrt(X^2 + Z^2 - r^2)) /
    (Z^2 - r^2), and likewise in b.
    """
    x, y, z = 0.0, 0.0, 0.0
    lx, ly, lz = 0.0, 0.0, 0.0
    for k in range(3):
        offset = ball[k] - position[k]
        x += rotation[k, 0] * offset
        y += rotation[k, 1] * offset
        z += rotation[k, 2] * offset
        lx += rotation[k, 0] * LIGHT[k]
        ly += rotation[k, 1] * LIGHT[k]
        lz += rotation[k, 2] * LIGHT[k]
    r = BALL_RADIUS
    left, right, top, bottom = -1e9, 1e9, -1e9, 1e9
    if z < -r:
        right = left
    elif z > 1.001 * r:
        scale = 1.0 / (z * z - r * r)
        half = r * math.sqrt(x * x + z * z - r * r) * scale
        left, right = x * z * scale - half, x * z * scale + half
        half = r * math.sqrt(y * y + z * z - r * r) * scale
        top, bottom = y * z * scale - half, y * z * scale + half
    return BallView(x, y, z, lx, ly, lz, F(left), F(right), F(top), F(bottom))


@kernel
def ball_columns(rays, place, count, ball):
    """Return the first and one past the last of `count` pixels that may show the ball."""
    start, row = place
    if not any_shows(rays, place, count, ball):
        return 0, 0
    first, last = count, 0
    for i in range(count):
        a, b = rays[0, row, start + i], rays[1, row, start + i]
        margin = TWO * rays[2, row, start + i]
        if (
            a > ball.left - margin
            and a < ball.right + margin
            and b > ball.top - margin
            and b < ball.bottom + margin
        ):
            first, last = min(first, i), i + 1
    return first, last


@kernel
def any_shows(rays, place, count, ball):
    """Tell whether any of `count` pixels may show the ball."""
    a, b = rays[0, place[1], place[0] :], rays[1, place[1], place[0] :]
    pitch, shown = rays[2, place[1], place[0] :], 0
    for i in range(count):
        margin = TWO * pitch[i]
        beside = (a[i] > ball.left - margin) & (a[i] < ball.right + margin)
        above = (b[i] > ball.top - margin) & (b[i] < ball.bottom + margin)
        shown += 1 if beside & above else 0
    return shown > 0


@kernel
def sample_ball(rays, row, column, ball):
    """Return the share of a pixel that the ball covers, its depth there, and its brightness.

    A ray meets the sphere where (d.c)^2 >= |d|^2 (|c|^2 - r^2). Pixels whose every point is inside
    or outside need one ray; the others get SUB x SUB, placed by the local slopes of the ray table.
    """
    a, b = np.float64(rays[0, row, column]), np.float64(rays[1, row, column])
    ax, bx, ay, by = slopes(rays, row, column)
    along = a * ball.x + b * ball.y + ball.z
    squared = a * a + b * b + 1.0
    beyond = ball.x**2 + ball.y**2 + ball.z**2 - BALL_RADIUS**2
    if along <= 0.0 or beyond <= 0.0:
        return ZERO, ZERO, ZERO
    off_axis = math.sqrt(max(beyond + BALL_RADIUS**2 - along * along / squared, 0.0))
    reach = 0.5 * (abs(ax) + abs(bx) + abs(ay) + abs(by)) * along / squared
    if off_axis - reach > BALL_RADIUS:
        return ZERO, ZERO, ZERO
    if off_axis + reach < BALL_RADIUS:
        depth = (along - math.sqrt(along * along - squared * beyond)) / squared
        return ONE, F(depth), F(ball_light(a, b, depth, ball))
    hits, depths, lights = 0, 0.0, 0.0
    for i in range(SUB):
        for j in range(SUB):
            u, v = (j + 0.5) / SUB - 0.5, (i + 0.5) / SUB - 0.5
            p, q = a + u * ax + v * ay, b + u * bx + v * by
            along = p * ball.x + q * ball.y + ball.z
            squared = p * p + q * q + 1.0
            inside = along * along - squared * beyond
            if inside >= 0.0:
                depth = (along - math.sqrt(inside)) / squared
                hits += 1
                depths += depth
                lights += ball_light(p, q, depth, ball)
    if hits == 0:
        return ZERO, ZERO, ZERO
    return F(hits / (SUB * SUB)), F(depths / hits), F(lights / hits)


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
def ball_light(a, b, depth, ball):
    """Return the brightness of the point of the ball that a ray meets: ambient and Lambert."""
    x, y, z = a * depth - ball.x, b * depth - ball.y, depth - ball.z
    cosine = (x * ball.light_x + y * ball.light_y + z * ball.light_z) / BALL_RADIUS
    return AMBIENT + (1.0 - AMBIENT) * max(cosine, 0.0)
