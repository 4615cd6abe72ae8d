"""The sensor, compiled: what lens and chip make of the light that the ray caster finds.

    l = PSF * light            3 x 3, separable, weights (w, 1 - 2 w, w)
    s = l + sqrt(read^2 + shot l) n,   n ~ N(0, 1)
    picture = response(s)      a table

Rows are painted into a ring of three, so that each row of the picture is finished as soon as the
one below it is known. The normal numbers are a fixed sequence; where a row of one colour begins in
it is drawn from the frame's own key.
"""

from typing import NamedTuple

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.world._pixel_kernels import BLUE, GREEN, HALF, ONE, RED, TILE, TWO, ZERO, F
from rotorpong.world._render_kernels import look, paint_tile

FINENESS, LEVELS = F(16), 4096  # entries of the response per level of light, in all
BRIGHTEST = F(LEVELS - 1)
NORMALS = 2**16
LAST_NORMAL = np.int64(NORMALS - 1)


class Sensor(NamedTuple):
    """What lens and chip do to a frame."""

    aside: F  # weight of each neighbour
    shot: F  # variance per level of light
    read: F  # variance
    starts: np.ndarray  # (height, 3) int64: where each row of each colour begins in the normals
    normals: np.ndarray  # (NORMALS + TILE,) float32, the first again behind the last
    response: np.ndarray  # (LEVELS,) uint8


class Lines(NamedTuple):
    """Rows of light on their way to the picture."""

    light: np.ndarray  # (3, n + 2) float32: the row at hand, a pixel more on both sides
    ring: np.ndarray  # (9, n) float32: three rows in three colours, blurred along the row
    level: np.ndarray  # (3, TILE) int32: places in the response


@kernel
def expose_rows(picture, rays, corner, shutter, moment, paint, work, sensor, lines):
    """Expose a box of the picture, rows of bytes, from pixel (column, row) = corner on."""
    height, n = rays.shape[1], picture.shape[1] // 3
    end, last = corner[1] + picture.shape[0], height - 1
    for row in range(max(corner[1] - 1, 0), min(end + 1, height)):
        look(moment, shutter, row)
        gather(lines, rays, corner[0], row, n, moment, paint, work)
        smooth(lines, row % 3, sensor.aside)
        if row > corner[1]:
            develop(picture[row - 1 - corner[1]], row - 1, corner[0], sensor, lines, last)
        if row == last and end == height:
            develop(picture[row - corner[1]], row, corner[0], sensor, lines, last)


@kernel
def gather(lines, rays, column, row, n, moment, paint, work):
    """Write a row of light, n pixels from `column` on and one more on both sides."""
    width, light = rays.shape[2], lines.light
    first, last = max(column - 1, 0), min(column + n + 1, width)
    for start in range(first, last, TILE):
        count = min(last - start, TILE)
        paint_tile(work, count, rays, (start, row), moment, paint)
        copy(light[0, start - column + 1 :], work[0][BLUE:], count)
        copy(light[1, start - column + 1 :], work[0][GREEN:], count)
        copy(light[2, start - column + 1 :], work[0][RED:], count)
    for k in range(3):
        if column == 0:
            light[k, 0] = light[k, 1]
        if column + n == width:
            light[k, n + 1] = light[k, n]


@kernel
def copy(out, values, n):
    """Copy n numbers, none below 0."""
    for i in range(n):
        out[i] = max(values[i], ZERO)


@kernel
def smooth(lines, place, aside):
    """Blur the row at hand along itself, into a place of the ring."""
    middle = ONE - TWO * aside
    for k in range(3):
        light, out = lines.light[k], lines.ring[3 * place + k]
        for i in range(out.shape[0]):
            out[i] = middle * light[i + 1] + aside * (light[i] + light[i + 2])


@kernel
def develop(pixels, row, column, sensor, lines, last):
    """Finish a row: blur across rows, noise, response."""
    ring, normals, n = lines.ring, sensor.normals, lines.ring.shape[1]
    above, here, below = max(row - 1, 0) % 3, row % 3, min(row + 1, last) % 3
    aside, middle = sensor.aside, ONE - TWO * sensor.aside
    for start in range(0, n, TILE):
        count = min(n - start, TILE)
        for k in range(3):
            noise = normals[(sensor.starts[row, k] + column + start) & LAST_NORMAL :]
            up, at, down = ring[3 * above + k], ring[3 * here + k], ring[3 * below + k]
            up, at, down, out = up[start:], at[start:], down[start:], lines.level[k]
            for i in range(count):
                light = middle * at[i] + aside * (up[i] + down[i])
                light += np.sqrt(sensor.read + sensor.shot * light) * noise[i]
                out[i] = np.int32(min(max(light * FINENESS + HALF, ZERO), BRIGHTEST))
        respond(pixels[3 * start :], lines.level, sensor.response, count)


@kernel
def respond(pixels, level, response, n):
    """Look the levels of n pixels up in the response."""
    for i in range(n):
        pixels[3 * i] = response[np.uint32(level[0, i])]
        pixels[3 * i + 1] = response[np.uint32(level[1, i])]
        pixels[3 * i + 2] = response[np.uint32(level[2, i])]
