"""How a disc in a picture stands out from what surrounds it, compiled.

All is measured in one channel, the tint (`candidates.tint_of`). For a circle of radius r around
(x, y), with samples at the nearest pixels:

    core     pixels within 0.75 r: mean, standard deviation, mean blue, green, red
    ring     pixels from 1.15 r + 0.7 to 1.5 r + 2: mean of each of its eight sectors
    sides    at 32 angles, one sample inside and one outside the outline: whether the outer one is
             below the middle of core and ring, whether the inner one is above as well
    edges    at 24 angles, the steepest fall over two pixels between 0.75 r and 1.25 r, and where

Pixels beyond the picture are left out; what share of the outline is in it is told.
"""

import math

import numpy as np

from rotorpong.kernels import kernel

CORE, RING_FROM, RING_TO = 0.75, 1.15, 1.5  # radii
SECTORS, SIDES, EDGES = 8, 32, 24
ACROSS = 10.0  # samples of a large radius
(
    CORE_MEAN,
    CORE_SD,
    RING_MEAN,
    RING_WORST,
    BLUE,
    GREEN,
    RED,
    OUTSIDE_BELOW,
    BOTH_SIDES,
    SEEN,
    EDGE_QUARTER,
    EDGE_OFFSET,
) = range(12)
MEASURES = 12


@kernel
def write_tint(tint, picture, lowest, width):
    """Write the chroma of pixels whose hue is from `lowest` to `lowest + width`, 0 elsewhere.

    Args:
        tint: (height, width) uint8, to be written.
        picture: (height, width, 3) uint8: blue, green, red.
        lowest: hue, 0..180, of OpenCV.
        width: of the range; it goes on over 180 = 0.
    """
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            b, g, r = picture[row, column]
            blue, green, red = np.float32(b), np.float32(g), np.float32(r)
            value = max(max(blue, green), red)
            chroma = value - min(min(blue, green), red)
            hue = hue_of(blue, green, red, value, chroma)
            away = hue - lowest
            away += 180.0 if away < 0.0 else 0.0
            tint[row, column] = np.uint8(chroma) if away <= width else np.uint8(0)


@kernel
def hue_of(blue, green, red, value, chroma):
    """Return a hue from 0 to 180; 0 without chroma."""
    if chroma == 0.0:
        return 0.0
    if red == value:
        hue = 30.0 * (green - blue) / chroma
        return hue + 180.0 if hue < 0.0 else hue
    if green == value:
        return 60.0 + 30.0 * (blue - red) / chroma
    return 120.0 + 30.0 * (red - green) / chroma


@kernel
def describe(measures, tint, picture, circles):
    """Write the measures of circles.

    Args:
        measures: (n, MEASURES) float64, to be written.
        tint: (height, width) uint8.
        picture: (height, width, 3) uint8: blue, green, red.
        circles: (n, 3) float64: centre in the picture, radius, px.
    """
    for i in range(circles.shape[0]):
        x, y, radius = circles[i]
        measure_areas(measures[i], tint, picture, x, y, radius)
        measure_sides(measures[i], tint, x, y, radius)
        measure_edges(measures[i], tint, x, y, radius)


@kernel
def measure_areas(measures, tint, picture, x, y, radius):
    """Write what core and ring are like."""
    height, width = tint.shape
    core, near, far = CORE * radius, RING_FROM * radius + 0.7, RING_TO * radius + 2.0
    reach, step = int(far) + 1, max(1, int(radius / ACROSS))
    middle_x, middle_y = round(x), round(y)
    sums, counts = np.zeros(SECTORS), np.zeros(SECTORS)
    inside = np.zeros(5)  # tint, its square, blue, green, red
    count = 0
    for row in range(middle_y - reach, middle_y + reach + 1, step):
        for column in range(middle_x - reach, middle_x + reach + 1, step):
            if row < 0 or column < 0 or row >= height or column >= width:
                continue
            right, down = column - x, row - y
            away = math.sqrt(right * right + down * down)
            value = float(tint[row, column])
            if away <= max(core, 0.8):
                count += 1
                inside[0] += value
                inside[1] += value * value
                for k in range(3):
                    inside[2 + k] += picture[row, column, k]
            elif near <= away <= far:
                sector = int(right > 0) + 2 * int(down > 0) + 4 * int(abs(right) > abs(down))
                sums[sector] += value
                counts[sector] += 1.0
    mean = inside[0] / max(count, 1)
    measures[CORE_MEAN] = mean
    measures[CORE_SD] = math.sqrt(max(inside[1] / max(count, 1) - mean * mean, 0.0))
    for k in range(3):
        measures[BLUE + k] = inside[2 + k] / max(count, 1)
    write_ring(measures, sums, counts)


@kernel
def write_ring(measures, sums, counts):
    """Write mean and largest of the sectors that are in the picture."""
    worst, total, seen = -1.0, 0.0, 0
    for k in range(SECTORS):
        if counts[k] > 0.0:
            mean = sums[k] / counts[k]
            total += mean
            seen += 1
            worst = max(worst, mean)
    ring = total / seen if seen else measures[CORE_MEAN]  # no surroundings, no contrast
    measures[RING_MEAN] = ring
    measures[RING_WORST] = worst if seen else ring


@kernel
def measure_sides(measures, tint, x, y, radius):
    """Write on how many sides the outline parts core from ring."""
    middle = 0.5 * (measures[CORE_MEAN] + measures[RING_MEAN])
    apart = max(1.0, 0.15 * radius)
    seen, below, parted = 0, 0, 0
    for k in range(SIDES):
        angle = 2.0 * math.pi * k / SIDES
        inner = sample(tint, x, y, radius - apart, angle)
        outer = sample(tint, x, y, radius + apart + 0.5, angle)
        if inner >= 0 and outer >= 0:
            seen += 1
            below += outer < middle
            parted += outer < middle <= inner
    measures[SEEN] = seen / SIDES
    measures[OUTSIDE_BELOW] = below / max(seen, 1)
    measures[BOTH_SIDES] = parted / max(seen, 1)


@kernel
def measure_edges(measures, tint, x, y, radius):
    """Write how steep the tint falls around the outline, and how near the circle it does."""
    falls, places = np.empty(EDGES), np.empty(EDGES)
    near, far = 0.75 * radius - 0.5, 1.25 * radius + 0.5
    steps = max(3, int(far - near) + 1)
    seen = 0
    for k in range(EDGES):
        angle = 2.0 * math.pi * k / EDGES
        steepest, place, whole = -1e9, 0.0, True
        for j in range(steps):
            away = near + (far - near) * j / (steps - 1)
            inner = sample(tint, x, y, away - 1.0, angle)
            outer = sample(tint, x, y, away + 1.0, angle)
            whole &= inner >= 0 and outer >= 0
            if inner - outer > steepest:
                steepest, place = float(inner - outer), away
        if whole:
            falls[seen], places[seen] = steepest, place / radius - 1.0
            seen += 1
    measures[EDGE_QUARTER] = np.sort(falls[:seen])[seen // 4] if seen else 0.0
    measures[EDGE_OFFSET] = np.mean(np.abs(places[:seen])) if seen else 0.0


@kernel
def sample(tint, x, y, away, angle):
    """Return the tint of the pixel at a distance and an angle from a centre, -1 beyond."""
    column = round(x + away * math.cos(angle))
    row = round(y + away * math.sin(angle))
    if row < 0 or column < 0 or row >= tint.shape[0] or column >= tint.shape[1]:
        return -1
    return int(tint[row, column])
