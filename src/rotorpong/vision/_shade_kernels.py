"""How bright one ball is, compiled: a Lambert ball under one lamp, fitted to its inside.

`ball` holds the direction of its colour and its sd, then ambient brightness and the lamp's x, y, z.
"""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.vision._linear_kernels import solve

FEWEST_FOR_SHADE = 10  # pixels
WELL_SHADED, SHADE_TURNS, RIDGE_OF_SHADE = 0.2, 4, 0.01  # of the paint: below, the lamp is fitted


@kernel
def shade(pixels, state, inverse, core, paint, ball):
    """Fit a Lambert ball's brightness to the core: B = A + max(0, l . normal).

    Least squares with a ridge on l, over and over with the lit side of the last fit. Only where
    shading counts; elsewhere, and for a ball that moves, B is the core's mean.
    """
    ball[5], ball[6], ball[7] = 0.0, 0.0, 0.0
    if paint.shading > WELL_SHADED or state[3] != 0.0 or state[4] != 0.0:
        return
    x, y, r = state[0], state[1], state[2]
    squares, rhs, n, deep = np.zeros((4, 4)), np.zeros(4), np.ones(4), r - core
    for turn in range(SHADE_TURNS):
        squares[:] = 0.0
        rhs[:] = 0.0
        for i in range(max(int(y - deep), 0), min(int(y + deep) + 2, pixels.shape[0])):
            for j in range(max(int(x - deep), 0), min(int(x + deep) + 2, pixels.shape[1])):
                dx, dy = j - x, i - y
                n[1] = (inverse[0, 0] * dx + inverse[0, 1] * dy) / r
                n[2] = (inverse[1, 0] * dx + inverse[1, 1] * dy) / r
                squared = n[1] * n[1] + n[2] * n[2]
                if squared * r * r >= deep * deep:
                    continue
                n[3] = math.sqrt(1.0 - squared)
                if turn > 0 and ball[5] * n[1] + ball[6] * n[2] + ball[7] * n[3] < 0.0:
                    n[1], n[2], n[3] = 0.0, 0.0, 0.0
                value = 0.0
                for k in range(3):
                    value += ball[k] * paint.light[pixels[i, j, k]]
                for a in range(4):
                    rhs[a] += n[a] * value
                    for b in range(a + 1):
                        squares[a, b] += n[a] * n[b]
        if squares[0, 0] < FEWEST_FOR_SHADE:
            return
        for a in range(1, 4):
            squares[a, a] += RIDGE_OF_SHADE
        solve(squares, rhs, 4)
        for a in range(4):
            ball[4 + a] = rhs[a]


@kernel
def brightness(ball, nx, ny):
    """Return the ball's brightness where its normal has these components; at the rim beyond it."""
    squared = nx * nx + ny * ny
    if squared >= 1.0:
        size = math.sqrt(squared)
        return ball[4] + max(0.0, (ball[5] * nx + ball[6] * ny) / size)
    return ball[4] + max(0.0, ball[5] * nx + ball[6] * ny + ball[7] * math.sqrt(1.0 - squared))
