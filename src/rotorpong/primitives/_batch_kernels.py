"""Many primitives towards many goals at the same fractions of their durations, see `batch.py`."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.kernels import kernel

LANES = 8  # maxima kept side by side, so that the search becomes vector instructions


@kernel
def fill_motions(
    targets: Float[ndarray, "m 6 d"],
    scales: Float[ndarray, "m"],
    fractions: Float[ndarray, "n"],
    answers: Float[ndarray, "k d n"],
    motions: Float[ndarray, "k m d n"],
) -> None:
    """Write target + scale * answer for every primitive k, goal m, coordinate d and fraction n.

    Args:
        targets: coefficients of a polynomial of fifth order in the fraction.
        scales: of the answers, one per goal.
        fractions: of the duration.
        answers: what each primitive adds, at the fractions.
        motions: where it goes.
    """
    coordinates, count = answers.shape[1], len(fractions)
    target = np.empty(count)
    for m in range(len(scales)):
        scale = scales[m]
        for j in range(coordinates):
            b0, b1, b2 = targets[m, 0, j], targets[m, 1, j], targets[m, 2, j]
            b3, b4, b5 = targets[m, 3, j], targets[m, 4, j], targets[m, 5, j]
            for i in range(count):
                q = fractions[i]
                target[i] = b0 + q * (b1 + q * (b2 + q * (b3 + q * (b4 + q * b5))))
            for k in range(len(answers)):
                answer, motion = answers[k, j], motions[k, m, j]
                for i in range(count):
                    motion[i] = target[i] + scale * answer[i]


@kernel
def find_peaks(
    targets: Float[ndarray, "m 6 d"],
    scales: Float[ndarray, "m"],
    fractions: Float[ndarray, "n"],
    answers: Float[ndarray, "k d n"],
    peaks: Float[ndarray, "k m"],
) -> None:
    """Write the largest norm of target + scale * answer over all fractions; nothing else is kept.

    The arguments are those of `fill_motions`.
    """
    coordinates, count = answers.shape[1], len(fractions)
    target = np.empty((coordinates, count))
    squares = np.zeros((count + LANES - 1) // LANES * LANES)
    largest = np.empty(LANES)
    for m in range(len(scales)):
        scale = scales[m]
        for j in range(coordinates):
            b0, b1, b2 = targets[m, 0, j], targets[m, 1, j], targets[m, 2, j]
            b3, b4, b5 = targets[m, 3, j], targets[m, 4, j], targets[m, 5, j]
            row = target[j]
            for i in range(count):
                q = fractions[i]
                row[i] = b0 + q * (b1 + q * (b2 + q * (b3 + q * (b4 + q * b5))))
        for k in range(len(answers)):
            squares[:] = 0.0
            for j in range(coordinates):
                row, answer = target[j], answers[k, j]
                for i in range(count):
                    v = row[i] + scale * answer[i]
                    squares[i] += v * v
            largest[:] = 0.0
            for first in range(0, len(squares), LANES):
                for lane in range(LANES):
                    square = squares[first + lane]
                    largest[lane] = square if square > largest[lane] else largest[lane]
            peaks[k, m] = np.sqrt(largest.max())
