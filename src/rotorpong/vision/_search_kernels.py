"""Where a picture may hold a colour, compiled: one pass that leaves out what surely is another.

OpenCV's value is the largest of blue, green and red, its saturation 255 (largest - least) / largest
rounded, its hue, where red is the largest, 30 (green - blue) / (largest - least) rounded. A pixel
passes if it can be within limits on these whatever the rounding: limits are widened by one.
"""

import numpy as np

from rotorpong.kernels import kernel

F = np.float32
ONE, THIRTY, FULL = F(1), F(30), F(255)
REDDISH = 28.0  # largest hue of which it is sure that red is the largest


@kernel
def find_reach(reach, picture, lower, upper):
    """Write the box (x0, y0, x1, y1) around all pixels that may be within limits, x1 = 0 if none.

    Args:
        reach: (4,) int64, to be written.
        picture: (height, 3 width) uint8: blue, green, red.
        lower: (3,) float32: least hue, saturation and value.
        upper: (3,) float32: most.
    """
    height, width = picture.shape[0], picture.shape[1] // 3
    left, top, right, bottom = width, height, 0, 0
    for row in range(height):
        line, found = picture[row], False
        for i in range(width):
            found |= passes(line[3 * i], line[3 * i + 1], line[3 * i + 2], lower, upper)
        if found:
            top, bottom = min(top, row), row + 1
            first, last = 0, width
            while first < left and not passes_at(line, first, lower, upper):
                first += 1
            while last > right and not passes_at(line, last - 1, lower, upper):
                last -= 1
            left, right = min(left, first), max(right, last)
    reach[0], reach[1], reach[2], reach[3] = left, top, right, bottom


@kernel
def passes_at(line, column, lower, upper):
    """Tell whether the pixel in a column of a row may be within limits."""
    i = 3 * column
    return passes(line[i], line[i + 1], line[i + 2], lower, upper)


@kernel
def passes(blue, green, red, lower, upper):
    """Tell whether a pixel may be within limits on hue, saturation and value."""
    b, g, r = F(blue), F(green), F(red)
    value = max(max(b, g), r)
    chroma = value - min(min(b, g), r)
    saturation, hue = FULL * chroma, THIRTY * (g - b)
    within = (value >= lower[2]) & (value <= upper[2])
    within &= (saturation >= (lower[1] - ONE) * value) & (saturation <= (upper[1] + ONE) * value)
    red_is_most = (r >= value) & (hue >= -chroma) & (hue <= (upper[0] + ONE) * chroma)
    return within & ((upper[0] > REDDISH) | red_is_most)
