"""The fastest instant of a motion, exactly.

On each of the equal pieces of [0, 1] target and answer are polynomials in the fraction r of the
piece, so a squared speed or acceleration is one, too: p(r) = sum_i a_i r^i, i = 0..n. Its
coefficients in Bernstein's basis,

    b_j = sum_{i <= j} C(j, i) / C(n, i) a_i,

bound it: p(r) <= max_j b_j on the piece. Pieces whose bound lies below what some piece has at an
end cannot hold the peak; in those left it lies at an end or where p' = 0.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

CLOSE = 1e-13  # relative: bounds no higher than this above a value found are not searched
REAL = 1e-6  # largest imaginary part of a root that is taken for real; it only adds a candidate


@dataclass(frozen=True, slots=True)
class Extremum:
    """Where a motion's speed or acceleration is largest."""

    value: float
    fraction: float  # of the duration


def pieces_of(
    target: Float[ndarray, "6 d"], answer: Float[ndarray, "6 pieces d"]
) -> Float[ndarray, "6 pieces d"]:
    """Return the coefficients of target + answer in the fraction of each piece."""
    return np.einsum("imp,md->ipd", _shifts(answer.shape[1]), target) + answer


def derived(
    polynomials: Float[ndarray, "n pieces d"], order: int, duration: float
) -> Float[ndarray, "m pieces d"]:
    """Return the coefficients of a derivative in time, in the fraction of each piece."""
    rate = polynomials.shape[1] / duration
    for _ in range(order):
        polynomials = polynomials[1:] * (rate * np.arange(1.0, len(polynomials)))[:, None, None]
    return polynomials


def largest_norm(polynomials: Float[ndarray, "n pieces d"]) -> Extremum:
    """Return the largest norm over all coordinates, and where it is."""
    products = np.einsum("ipd,jpd->ijp", polynomials, polynomials)
    squares = _antidiagonals(len(polynomials)) @ products.reshape(-1, polynomials.shape[1])
    peak = _largest(squares)
    return Extremum(math.sqrt(max(peak.value, 0.0)), peak.fraction)


def _largest(polynomials: Float[ndarray, "n pieces"]) -> Extremum:
    """Return the largest value of one polynomial per piece."""
    pieces = polynomials.shape[1]
    ends = np.stack([polynomials[0], polynomials.sum(axis=0)])
    end, piece = np.unravel_index(np.argmax(ends), ends.shape)
    best = Extremum(float(ends[end, piece]), float(piece + end) / pieces)
    bounds = (_bernstein(len(polynomials) - 1) @ polynomials).max(axis=0)
    for p in np.flatnonzero(bounds > best.value * (1.0 + CLOSE)):
        value, r = _largest_inside(polynomials[:, p])
        if value > best.value:
            best = Extremum(value, float(p + r) / pieces)
    return best


def _largest_inside(polynomial: Float[ndarray, "n"]) -> tuple[float, float]:
    roots = np.polynomial.Polynomial(polynomial).deriv().roots()
    flat = roots.real[(np.abs(roots.imag) < REAL) & (roots.real > 0.0) & (roots.real < 1.0)]
    places = np.append(flat, 0.0)
    values = np.polynomial.polynomial.polyval(places, polynomial)
    best = int(np.argmax(values))
    return float(values[best]), float(places[best])


@functools.lru_cache(maxsize=16)
def _shifts(pieces: int) -> Float[ndarray, "6 6 pieces"]:
    """Return the matrix of each piece, from coefficients in x to those in the piece's fraction."""
    x = np.arange(pieces) / pieces
    matrix = np.zeros((6, 6, pieces))
    for i in range(6):
        for m in range(i, 6):
            matrix[i, m] = math.comb(m, i) * x ** (m - i) / float(pieces) ** i
    return matrix


@functools.lru_cache(maxsize=16)
def _antidiagonals(count: int) -> Float[ndarray, "n m"]:
    """Return the matrix from all products of coefficients to the coefficients of the product."""
    matrix = np.zeros((2 * count - 1, count, count))
    for i in range(count):
        for j in range(count):
            matrix[i + j, i, j] = 1.0
    return matrix.reshape(2 * count - 1, -1)


@functools.lru_cache(maxsize=16)
def _bernstein(degree: int) -> Float[ndarray, "n n"]:
    """Return the matrix from coefficients of powers to those of Bernstein's basis."""
    powers = range(degree + 1)
    ratios = [[math.comb(j, i) / math.comb(degree, i) for i in powers] for j in powers]
    return np.array(ratios)
