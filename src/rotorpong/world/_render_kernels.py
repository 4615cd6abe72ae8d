"""The ray caster, compiled: rows of pixels, and the ball between its far and near layers."""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world._court_kernels import layers
from rotorpong.world._pixel_kernels import (
    BALL,
    FAR,
    HALF,
    IX,
    IY,
    ONE,
    PITCH,
    RAY_ROWS,
    TWO,
    WALL_T,
    WALL_Z,
    WORK_ROWS,
    ZERO,
    F,
    Row,
    View,
    X,
    Y,
    Z,
    follow,
    inverse,
    lay,
)
from rotorpong.world._room_kernels import meet_walls, room

WHITEST = F(255)
SUB = 4  # samples along each side of a pixel
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
def paint_rows(picture, rays, corner, position, rotation, ball, paint):
    """Paint a box of the picture whose upper left pixel is (column, row) = corner.

    The pose is asked for row by row: a rolling shutter would hand each row its own.
    """
    width = picture.shape[1]
    row = new_row(width)
    for i in range(picture.shape[0]):
        view, seen = view_of(position, rotation), ball_view(ball, position, rotation)
        place = (corner[0], corner[1] + i)
        cast(row, rays[:, place[1], place[0] : place[0] + width], view)
        room(row, view, paint)
        first, last = ball_columns(rays, place, width, seen)
        bounds = np.zeros((2, max(last - first, 0)), np.float32)
        if first < last:
            sample_columns(row, bounds, rays, place, first, seen)
        layers(row, (0, width), view, ball, paint)
        if first < last:
            for k in range(first, last):
                lay(row.colour, k, paint.colours, BALL, bounds[0, k - first], bounds[1, k - first])
                row.near[k], row.far[k] = ZERO, row.near[k]
            layers(row, (first, last), view, ball, paint)
        expose(picture[i], row.colour)


@kernel
def new_row(width):
    """Return an unpainted row."""
    return Row(
        np.empty((3, width), np.float32),
        np.empty((RAY_ROWS, width), np.float32),
        np.empty((WORK_ROWS, width), np.float32),
        np.empty(width, np.float32),
        np.empty(width, np.float32),
    )


@kernel
def sample_columns(row, samples, rays, place, first, ball):
    """Write the ball's light and coverage, and bound the layers behind it."""
    for k in range(samples.shape[1]):
        cover, depth, light = sample_ball(rays, place[1], place[0] + first + k, ball)
        samples[0, k], samples[1, k], row.near[first + k] = light, cover, depth


@kernel
def cover_rows(coverage, rays, position, rotation, ball):
    """Write which share of each pixel the ball covers if nothing is in front of it."""
    seen = ball_view(ball, position, rotation)
    for row in range(coverage.shape[0]):
        first, last = ball_columns(rays, (0, row), coverage.shape[1], seen)
        for column in range(first, last):
            coverage[row, column] = sample_ball(rays, row, column, seen)[0]


@kernel
def view_of(position, rotation):
    """Return a pose in single precision."""
    return View(
        F(position[0]), F(position[1]), F(position[2]),
        F(rotation[0, 0]), F(rotation[1, 0]), F(rotation[2, 0]),
        F(rotation[0, 1]), F(rotation[1, 1]), F(rotation[2, 1]),
        F(rotation[0, 2]), F(rotation[1, 2]), F(rotation[2, 2]),
    )  # fmt: skip


@kernel
def cast(row, rays, view):
    """Start a row: its rays in the world, where they meet the walls, no bounds."""
    ray = row.ray
    combine(ray[X], rays, view.rx, view.dx, view.fx)
    combine(ray[Y], rays, view.ry, view.dy, view.fy)
    combine(ray[Z], rays, view.rz, view.dz, view.fz)
    for k in range(3):
        invert(ray[IX + k], ray[X + k])
    ray[PITCH] = rays[2]
    meet_walls(ray[WALL_T], ray[IX], ray[IY], view)
    follow(ray[WALL_Z], (0, ray.shape[1]), ray[WALL_T], ray[Z], view.z)
    row.colour[:], row.near[:], row.far[:] = ZERO, ZERO, FAR


@kernel
def combine(out, rays, right, down, forward):
    """Write one world axis of every ray."""
    for i in range(out.shape[0]):
        out[i] = forward + rays[0, i] * right + rays[1, i] * down


@kernel
def invert(out, x):
    """Write 1/x."""
    for i in range(out.shape[0]):
        out[i] = inverse(x[i])


@kernel
def expose(pixels, colour):
    """Round a row to what the picture holds."""
    for i in range(pixels.shape[0]):
        for k in range(3):
            pixels[i, k] = np.uint8(min(colour[k, i], WHITEST) + HALF)


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
    a, b = float(rays[0, row, column]), float(rays[1, row, column])
    ax, bx = slopes(rays, row, column, 0, 1)
    ay, by = slopes(rays, row, column, 1, 0)
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
def slopes(rays, row, column, right, down):
    """Return how (X/Z, Y/Z) changes from this pixel to the next one right or down."""
    r0, c0 = max(row - down, 0), max(column - right, 0)
    r1, c1 = min(row + down, rays.shape[1] - 1), min(column + right, rays.shape[2] - 1)
    scale = 1.0 / max(r1 - r0 + c1 - c0, 1)
    a = float(rays[0, r1, c1]) - float(rays[0, r0, c0])
    b = float(rays[1, r1, c1]) - float(rays[1, r0, c0])
    return a * scale, b * scale


@kernel
def ball_light(a, b, depth, ball):
    """Return the brightness of the point of the ball that a ray meets: ambient and Lambert."""
    x, y, z = a * depth - ball.x, b * depth - ball.y, depth - ball.z
    cosine = (x * ball.light_x + y * ball.light_y + z * ball.light_z) / BALL_RADIUS
    return AMBIENT + (1.0 - AMBIENT) * max(cosine, 0.0)
