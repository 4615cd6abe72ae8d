"""The ray caster, compiled: tiles of pixels, and the ball between its far and near layers."""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world import court
from rotorpong.world._court_kernels import layers, see_table
from rotorpong.world._pixel_kernels import (
    BALL,
    BALL_COVER,
    BALL_LIGHT,
    BEYOND,
    BLUE,
    COVER,
    DOWN,
    EYE,
    FAR,
    FORWARD,
    GREEN,
    HALF,
    IX,
    IY,
    IZ,
    LIGHT,
    NEAR,
    PITCH,
    RED,
    RIGHT,
    SOFT,
    TILE,
    TWO,
    WALL_T,
    WALL_Z,
    ZERO,
    F,
    X,
    Y,
    Z,
    inverse,
    lay,
)
from rotorpong.world._room_kernels import room

WHITEST = F(255)
SUB, SUB_MOVING = np.array([6, 4])  # samples along a pixel's side: at rest, at each instant
LIGHT_DIRECTION = (-0.60, 0.25, 0.76)  # to the light, world frame, unit length
AMBIENT = 0.58
BACK, FRONT, SIDE = F(court.ROOM_BACK), F(court.ROOM_FRONT), F(court.ROOM_HALF_WIDTH)
POSITION, ROTATION, BALL_POSITION, TRACK_COLUMNS = 0, 3, 12, 15  # columns of a track


class Shutter(NamedTuple):
    """When each row of the picture is exposed, in rows of the track: a global or a rolling one."""

    track: np.ndarray  # (n, TRACK_COLUMNS) float64: camera's place and axes, ball; even in time
    first: float  # middle of the exposure of row 0
    each: float  # from a row to the next
    window: float  # exposure


class Moment(NamedTuple):
    """What a row sees at its time; written anew for every row."""

    pose: np.ndarray  # (TRACK_COLUMNS,) float64: a row of the track, in the middle of the exposure
    axes: np.ndarray  # (4, 3) float32: eye, and axes right, down, forward, in the world
    balls: np.ndarray  # (n, 3) float64: the ball in the camera frame, evenly over the exposure
    light: np.ndarray  # (3,) float64: direction to the light in the camera frame
    box: np.ndarray  # (4,) float32: left, right, top, bottom directions around all balls


@kernel
def paint_rows(picture, rays, corner, shutter, moment, paint, work):
    """Paint a box of the picture, rows of bytes, whose upper left pixel is (column, row) = corner.

    A row is painted in tiles that fit the processor's first cache.
    """
    width = picture.shape[1] // 3
    for i in range(picture.shape[0]):
        look(moment, shutter, corner[1] + i)
        for start in range(0, width, TILE):
            n = min(width - start, TILE)
            paint_tile(work, n, rays, (corner[0] + start, corner[1] + i), moment, paint)
            expose(picture[i, 3 * start : 3 * (start + n)], work[0], n)


@kernel
def paint_tile(work, n, rays, place, moment, paint):
    """Write the colours of n pixels from `place` on, linear and unbounded."""
    tile, texels = work
    column, row = place
    view, ball = moment.axes, moment.pose[BALL_POSITION:]
    cast(tile, n, rays[0, row, column:], rays[1, row, column:], rays[2, row, column:], view)
    first, last = ball_columns(tile, rays, place, n, moment)
    table = see_table(tile, n, view)
    if not table[1]:
        room(tile, n, texels, view, paint)
    layers(tile, n, view, ball, paint, table)
    if first < last:
        part, count = tile[first:], last - first
        for i in range(count):
            part[LIGHT + i], part[COVER + i] = part[BALL_LIGHT + i], part[BALL_COVER + i]
            part[NEAR + i], part[BEYOND + i] = ZERO, part[NEAR + i]
        lay(part, count, paint.colours[BALL])
        layers(part, count, view, ball, paint, see_table(part, count, view))


@kernel
def cover_rows(coverage, rays, shutter, moment):
    """Write which share of each pixel the ball covers if nothing is in front of it."""
    for row in range(coverage.shape[0]):
        look(moment, shutter, row)
        first, last = near_ball(rays, (0, row), coverage.shape[1], moment.box)
        for column in range(first, last):
            coverage[row, column] = sample_ball(rays, row, column, moment)[0]


@kernel
def look(moment, shutter, row):
    """Write what the row sees: its pose, and the ball at every instant of its exposure."""
    when, count = shutter.first + row * shutter.each, moment.balls.shape[0]
    box = moment.box
    box[0], box[1], box[2], box[3] = FAR, -FAR, FAR, -FAR
    for s in range(count):
        pose_at(moment.pose, shutter.track, when + shutter.window * ((s + 0.5) / count - 0.5))
        see_ball(moment, s)
    pose_at(moment.pose, shutter.track, when)
    for k in range(3):
        moment.axes[EYE, k] = moment.pose[POSITION + k]
        moment.light[k] = 0.0
        for axis in range(3):
            moment.axes[RIGHT + axis, k] = moment.pose[ROTATION + 3 * k + axis]
    for k in range(3):
        for axis in range(3):
            moment.light[axis] += moment.pose[ROTATION + 3 * k + axis] * LIGHT_DIRECTION[k]


@kernel
def pose_at(pose, track, when):
    """Write the track between its rows; before the first and after the last they hold."""
    last = track.shape[0] - 1
    when = min(max(when, 0.0), float(last))
    before = min(int(when), max(last - 1, 0))
    share, after = when - before, min(before + 1, last)
    for k in range(TRACK_COLUMNS):
        pose[k] = track[before, k]
        if share > 0.0:
            pose[k] += share * (track[after, k] - track[before, k])


@kernel
def see_ball(moment, s):
    """Write ball s of the moment as this pose sees it, and widen the box around all of them.

    The outline of a sphere at (X, Y, Z) lies within a = (X Z +- r sqrt(X^2 + Z^2 - r^2)) /
    (Z^2 - r^2), and likewise in b.
    """
    pose, box = moment.pose, moment.box
    x, y, z = 0.0, 0.0, 0.0
    for k in range(3):
        offset = pose[BALL_POSITION + k] - pose[POSITION + k]
        x += pose[ROTATION + 3 * k] * offset
        y += pose[ROTATION + 3 * k + 1] * offset
        z += pose[ROTATION + 3 * k + 2] * offset
    moment.balls[s, 0], moment.balls[s, 1], moment.balls[s, 2] = x, y, z
    r = BALL_RADIUS
    if z < -r:
        return
    left, right, top, bottom = -1e9, 1e9, -1e9, 1e9
    if z > 1.001 * r:
        scale = 1.0 / (z * z - r * r)
        half = r * math.sqrt(x * x + z * z - r * r) * scale
        left, right = x * z * scale - half, x * z * scale + half
        half = r * math.sqrt(y * y + z * z - r * r) * scale
        top, bottom = y * z * scale - half, y * z * scale + half
    box[0], box[1] = min(box[0], F(left)), max(box[1], F(right))
    box[2], box[3] = min(box[2], F(top)), max(box[3], F(bottom))


@kernel
def cast(tile, n, across, down, pitch, view):
    """Start a tile: its rays in the world, where they meet the walls, no bounds."""
    right_x, right_y, right_z = view[RIGHT, 0], view[RIGHT, 1], view[RIGHT, 2]
    down_x, down_y, down_z = view[DOWN, 0], view[DOWN, 1], view[DOWN, 2]
    forward_x, forward_y, forward_z = view[FORWARD, 0], view[FORWARD, 1], view[FORWARD, 2]
    front, back = FRONT - view[EYE, 0], BACK - view[EYE, 0]
    left, right, height = SIDE - view[EYE, 1], -SIDE - view[EYE, 1], view[EYE, 2]
    for i in range(n):
        a, b = across[i], down[i]
        x = forward_x + a * right_x + b * down_x
        y = forward_y + a * right_y + b * down_y
        z = forward_z + a * right_z + b * down_z
        ix, iy = inverse(x), inverse(y)
        tile[X + i], tile[Y + i], tile[Z + i] = x, y, z
        tile[IX + i], tile[IY + i], tile[IZ + i] = ix, iy, inverse(z)
        tx = (front if ix > ZERO else back) * ix
        ty = (left if iy > ZERO else right) * iy
        t = min(tx, ty)
        tile[PITCH + i], tile[WALL_T + i], tile[SOFT + i] = pitch[i], t, t * pitch[i]
        tile[WALL_Z + i] = height + t * z
        tile[BLUE + i], tile[GREEN + i], tile[RED + i] = ZERO, ZERO, ZERO
        tile[NEAR + i], tile[BEYOND + i] = ZERO, FAR


@kernel
def expose(pixels, tile, n):
    """Round a tile to what the picture holds."""
    for i in range(n):
        pixels[3 * i] = np.uint8(min(max(tile[BLUE + i], ZERO), WHITEST) + HALF)
        pixels[3 * i + 1] = np.uint8(min(max(tile[GREEN + i], ZERO), WHITEST) + HALF)
        pixels[3 * i + 2] = np.uint8(min(max(tile[RED + i], ZERO), WHITEST) + HALF)


@kernel
def ball_columns(tile, rays, place, n, moment):
    """Write the ball's light and coverage, and bound the layers behind it.

    Return the first and one past the last of n pixels that may show the ball.
    """
    first, last = near_ball(rays, place, n, moment.box)
    for i in range(first, last):
        cover, depth, light = sample_ball(rays, place[1], place[0] + i, moment)
        tile[BALL_LIGHT + i], tile[BALL_COVER + i], tile[NEAR + i] = light, cover, depth
    return first, last


@kernel
def near_ball(rays, place, n, box):
    """Return the first and one past the last of n pixels that may show a ball within the box."""
    start, row = place
    across, down = rays[0, row, start:], rays[1, row, start:]
    pitch, shown = rays[2, row, start:], False
    left, right, top, bottom = box[0], box[1], box[2], box[3]
    for i in range(n):
        margin = TWO * pitch[i]
        beside = (across[i] > left - margin) & (across[i] < right + margin)
        shown |= beside & (down[i] > top - margin) & (down[i] < bottom + margin)
    first, last = n, 0
    if shown:
        for i in range(n):
            a, b, margin = across[i], down[i], TWO * pitch[i]
            if (
                a > left - margin
                and a < right + margin
                and b > top - margin
                and b < bottom + margin
            ):
                first, last = min(first, i), i + 1
    return first, last


@kernel
def sample_ball(rays, row, column, moment):
    """Return which share of pixel and exposure the ball covers, its depth and its brightness."""
    a, b = np.float64(rays[0, row, column]), np.float64(rays[1, row, column])
    pixel, count = (a, b, *slopes(rays, row, column)), moment.balls.shape[0]
    if count == 1:
        cover, depth, light = sample_instant(pixel, moment.balls[0], moment.light, SUB, (0.5, 0.5))
        return F(cover), F(depth), F(light)
    cover, depth, light = 0.0, 0.0, 0.0
    for s in range(count):
        offset = ((s + 0.5) / count, (s * 3 % count + 0.5) / count)  # the mean is the middle
        share, far, bright = sample_instant(
            pixel, moment.balls[s], moment.light, SUB_MOVING, offset
        )
        cover, depth, light = cover + share, depth + share * far, light + share * bright
    if cover == 0.0:
        return ZERO, ZERO, ZERO
    return F(cover / count), F(depth / cover), F(light / cover)


@kernel
def sample_instant(pixel, ball, toward_light, sub, offset):
    """Return the share of a pixel that the ball covers, its depth there, and its brightness.

    A ray meets the sphere where (d.c)^2 >= |d|^2 (|c|^2 - r^2). Pixels whose every point is inside
    or outside need one ray; the others get sub x sub, placed by the local slopes of the ray table.
    """
    a, b, ax, bx, ay, by = pixel
    along = a * ball[0] + b * ball[1] + ball[2]
    squared = a * a + b * b + 1.0
    beyond = ball[0] ** 2 + ball[1] ** 2 + ball[2] ** 2 - BALL_RADIUS**2
    if along <= 0.0 or beyond <= 0.0:
        return 0.0, 0.0, 0.0
    off_axis = math.sqrt(max(beyond + BALL_RADIUS**2 - along * along / squared, 0.0))
    reach = 0.5 * (abs(ax) + abs(bx) + abs(ay) + abs(by)) * along / squared
    if off_axis - reach > BALL_RADIUS:
        return 0.0, 0.0, 0.0
    if off_axis + reach < BALL_RADIUS:
        depth = (along - math.sqrt(along * along - squared * beyond)) / squared
        return 1.0, depth, ball_light(a, b, depth, ball, toward_light)
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
