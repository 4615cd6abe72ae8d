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
from rotorpong.world._moment_kernels import bound_balls
from rotorpong.world._pixel_kernels import BLUE, GREEN, HALF, ONE, RED, TILE, TWO, ZERO, F
from rotorpong.world._render_kernels import begin_row, expose, paint_tile

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
    normals: np.ndarray  # (more than NORMALS + n,) float32, the first again behind; 0: ideal
    response: np.ndarray  # (LEVELS,) uint8


class Lines(NamedTuple):
    """Rows of light on their way to the picture."""

    light: np.ndarray  # (3, n + 2) float32: the row at hand, a pixel more on both sides
    ring: np.ndarray  # (9, n) float32: three rows in three colours, blurred along the row
    level: np.ndarray  # (3, n) int32: places in the response


@kernel
def take_rows(picture, lens, corner, shutter, moment, scan, paint, work, sensor, lines):
    """Take a box of the picture, rows of bytes, from pixel (column, row) = corner on.

    An ideal sensor, of which there are no normal numbers, rounds what the ray caster finds. Any
    other needs a pixel and a row more on each side that the picture has.
    """
    height, width = lens.rays.shape[1], lens.rays.shape[2]
    n, end, sharp = (
        picture.shape[1] // 3,
        corner[1] + picture.shape[0],
        sensor.normals.shape[0] == 0,
    )
    more = 0 if sharp else 1
    columns = max(corner[0] - more, 0), min(corner[0] + n + more, width)
    bound_balls(shutter)
    for row in range(max(corner[1] - more, 0), min(end + more, height)):
        begin_row(scan, lens, row, columns, shutter, moment)
        for start in range(columns[0], columns[1], TILE):
            count, tile = min(columns[1] - start, TILE), work[0]
            paint_tile(work, count, lens, (start, row), moment, scan, paint)
            if sharp:
                expose(picture[row - corner[1], 3 * (start - corner[0]) :], tile, count)
            else:
                copy(lines.light[0, start - corner[0] + 1 :], tile[BLUE:], count)
                copy(lines.light[1, start - corner[0] + 1 :], tile[GREEN:], count)
                copy(lines.light[2, start - corner[0] + 1 :], tile[RED:], count)
        if not sharp:
            smooth(lines, row % 3, sensor.aside, corner[0] == 0, corner[0] + n == width)
            if row > corner[1]:
                develop(picture[row - 1 - corner[1]], row - 1, corner[0], sensor, lines, height - 1)
            if row == height - 1 and end == height:
                develop(picture[row - corner[1]], row, corner[0], sensor, lines, height - 1)


@kernel
def copy(out, values, n):
    """Copy n numbers, none below 0."""
    for i in range(n):
        out[i] = max(values[i], ZERO)


@kernel
def smooth(lines, place, aside, at_left, at_right):
    """Blur the row at hand along itself, into a place of the ring; at borders it goes on evenly."""
    middle, n = ONE - TWO * aside, lines.ring.shape[1]
    for k in range(3):
        light, out = lines.light[k], lines.ring[3 * place + k]
        if at_left:
            light[0] = light[1]
        if at_right:
            light[n + 1] = light[n]
        for i in range(out.shape[0]):
            out[i] = middle * light[i + 1] + aside * (light[i] + light[i + 2])


@kernel
def develop(pixels, row, column, sensor, lines, last):
    """Finish a row: blur across rows, noise, response."""
    ring, normals, n = lines.ring, sensor.normals, lines.ring.shape[1]
    above, here, below = max(row - 1, 0) % 3, row % 3, min(row + 1, last) % 3
    for k in range(3):
        noise = normals[(sensor.starts[row, k] + column) & LAST_NORMAL :]
        up, at, down = ring[3 * above + k], ring[3 * here + k], ring[3 * below + k]
        expose_line(lines.level[k], up, at, down, noise, n, sensor)
    respond(pixels, lines.level, sensor.response, n)


@kernel
def expose_line(level, up, at, down, noise, n, sensor):
    """Write the places in the response of n pixels in one colour: blur across rows, noise."""
    aside, read, shot = sensor.aside, sensor.read, sensor.shot
    middle = ONE - TWO * aside
    for i in range(n):
        light = middle * at[i] + aside * (up[i] + down[i])
        light += np.sqrt(read + shot * light) * noise[i]
        level[i] = np.int32(min(max(light * FINENESS + HALF, ZERO), BRIGHTEST))


@kernel
def respond(pixels, level, response, n):
    """Look the levels of n pixels up in the response."""
    for i in range(n):
        pixels[3 * i] = response[np.uint32(level[0, i])]
        pixels[3 * i + 1] = response[np.uint32(level[1, i])]
        pixels[3 * i + 2] = response[np.uint32(level[2, i])]
