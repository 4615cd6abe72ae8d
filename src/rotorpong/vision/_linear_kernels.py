"""Small linear equations, compiled: for the few unknowns of one ball."""

import math

import numpy as np

from rotorpong.kernels import kernel


@kernel
def solve(m, b, n):
    """Solve m x = b in place for the first n unknowns by Cholesky; return whether m is positive.

    m's lower triangle becomes the factor, b the solution.
    """
    for i in range(n):
        for j in range(i + 1):
            total = m[i, j]
            for k in range(j):
                total -= m[i, k] * m[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                m[i, i] = math.sqrt(total)
            else:
                m[i, j] = total / m[j, j]
    back_substitute(m, b, n)
    return True


@kernel
def back_substitute(factor, b, n):
    """Solve L L^T x = b in place."""
    for i in range(n):
        for k in range(i):
            b[i] -= factor[i, k] * b[k]
        b[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= factor[k, i] * b[k]
        b[i] /= factor[i, i]


@kernel
def inverted(m):
    """Return the inverse of a 2 x 2 matrix."""
    determinant = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    inverse = np.empty((2, 2))
    inverse[0, 0], inverse[0, 1] = m[1, 1] / determinant, -m[0, 1] / determinant
    inverse[1, 0], inverse[1, 1] = -m[1, 0] / determinant, m[0, 0] / determinant
    return inverse
