"""Pictures for the tests of vision, drawn by supersampling: no code of the package."""

import cv2
import numpy as np

SAMPLES = 8  # per pixel and axis
ORANGE = (20, 115, 245)  # blue, green, red
WHITE = (245, 245, 245)
GREY = (110, 100, 90)


def disc_coverage(shape, center, diameter):
    """Return the share of each pixel that a disc covers; pixel centres are whole numbers."""
    height, width = shape
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    x = (np.arange(width)[:, None] + steps).ravel() - center[0]
    y = (np.arange(height)[:, None] + steps).ravel() - center[1]
    inside = x[None, :] ** 2 + y[:, None] ** 2 <= (diameter / 2) ** 2
    return inside.reshape(height, SAMPLES, width, SAMPLES).mean(axis=(1, 3))


def plain(shape=(120, 160), colour=GREY):
    return np.full((*shape, 3), colour, dtype=np.uint8)


def with_ball(picture, center, diameter, colour=ORANGE):
    """Return the picture with an evenly coloured ball, exactly covered pixel by pixel."""
    reach = int(diameter / 2) + 3
    left, top = max(int(center[0]) - reach, 0), max(int(center[1]) - reach, 0)
    box = (slice(top, int(center[1]) + reach + 1), slice(left, int(center[0]) + reach + 1))
    drawn = picture.copy()
    patch = picture[box].astype(float)
    share = disc_coverage(patch.shape[:2], (center[0] - left, center[1] - top), diameter)[..., None]
    drawn[box] = np.round(share * np.array(colour) + (1 - share) * patch).astype(np.uint8)
    return drawn


def court(rng, shape=(360, 640)):
    """Return a blue table with white lines and a net on planks, an opponent of skin and cloth."""
    height, width = shape
    picture = plain(shape, (185, 190, 195))
    picture[height // 2 :] = (120, 152, 188)  # wood
    picture[height // 2 :: 9] = (108, 136, 166)  # between planks
    table = np.array([[0.1, 0.95], [0.9, 0.95], [0.65, 0.58], [0.35, 0.58]]) * (width, height)
    cv2.fillPoly(picture, [table.astype(np.int32)], (140, 75, 25))
    cv2.polylines(picture, [table.astype(np.int32)], True, (240, 240, 240), 2)  # noqa: FBT003
    cv2.rectangle(
        picture,
        (int(0.45 * width), int(0.2 * height)),
        (int(0.55 * width), int(0.57 * height)),
        (60, 30, 30),
        -1,
    )
    cv2.circle(picture, (width // 2, int(0.14 * height)), height // 16, (125, 155, 205), -1)  # head
    noisy = picture + rng.normal(0.0, 3.0, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)
