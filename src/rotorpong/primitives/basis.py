"""The phase, the basis functions over it, and how the transformed system answers to each.

    dz/dx = -alpha_z z, z(0) = 1                                            Eq. (3a), tau = duration
    psi_k(z) = exp(-h_k (z - c_k)^2) / sum_j exp(-h_j (z - c_j)^2)
    e'' + alpha_s e' + alpha_s beta_s e = psi_k(z) z, e(0) = e'(0) = 0      Eq. (4), e = s - g

x = t / duration runs from 0 to 1. beta_s = alpha_s / 4 damps critically: the answer to basis k is

    Phi_k(x) = int_0^x (x - y) exp(-a (x - y)) psi_k(z(y)) z(y) dy, a = alpha_s / 2.

It depends on neither goal, start nor duration: it is integrated once per number of bases and kept
as a piecewise quintic, exact to 1e-10.
"""

import functools
import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.primitives.quintic import quintic_coefficients

STIFFNESS = 25.0  # alpha_s, per duration; the value of the peers, the paper names none
DAMPING = STIFFNESS / 4  # beta_s: critical
PHASE_DECAY = -math.log(0.01)  # alpha_z: the phase ends at 0.01
OVERLAP = 0.3  # height of a basis function at its neighbour's centre
PIECES_PER_BASIS = 16  # of the response table: Phi and Phi' to 1e-10
MINIMUM_PIECES = 320
GAUSS_NODES = 8


def phase(x: Float[ndarray, "n"]) -> Float[ndarray, "n"]:
    """Return z at the fractions `x` of the duration."""
    return np.exp(-PHASE_DECAY * x)


def activations(z: Float[ndarray, "n"], basis: int) -> Float[ndarray, "n basis"]:
    """Return the bells exp(-h_k (z - c_k)^2), centres equally spaced in time."""
    centres = phase(np.linspace(0.0, 1.0, basis))
    gaps = -np.diff(centres)
    widths = -math.log(OVERLAP) / np.append(gaps, gaps[-1]) ** 2
    return np.exp(-widths * (z[:, None] - centres) ** 2)


def forcing_features(z: Float[ndarray, "n"], basis: int) -> Float[ndarray, "n basis"]:
    """Return psi_k(z) z, so that u = features @ weights."""
    bells = activations(z, basis)
    return bells / bells.sum(axis=1, keepdims=True) * z[:, None]


def responses(
    x: Float[ndarray, "n"], basis: int
) -> tuple[Float[ndarray, "n basis"], Float[ndarray, "n basis"]]:
    """Integrate Phi and Phi' (with respect to x) at increasing `x` from 0, Gauss-Legendre."""
    nodes, shares = np.polynomial.legendre.leggauss(GAUSS_NODES)
    steps = np.diff(x)[:, None]
    y = x[:-1, None] + steps * (nodes + 1) / 2
    a = STIFFNESS / 2
    loads = (np.exp(a * y) * shares * steps / 2)[..., None]
    loads = loads * forcing_features(phase(y.ravel()), basis).reshape(*y.shape, basis)
    zeroth = _running_sum(loads.sum(axis=1))
    first = _running_sum((loads * y[..., None]).sum(axis=1))
    decay = np.exp(-a * x)[:, None]
    position = decay * (x[:, None] * zeroth - first)
    return position, decay * zeroth - a * position


@functools.lru_cache(maxsize=16)
def response_table(basis: int) -> Float[ndarray, "6 pieces basis"]:
    """Return the quintic coefficients of Phi on each of many equal pieces of [0, 1]; read-only.

    They are polynomials in the fraction of the piece.
    """
    pieces = max(PIECES_PER_BASIS * basis, MINIMUM_PIECES)
    x = np.linspace(0.0, 1.0, pieces + 1)
    position, slope = responses(x, basis)
    force = forcing_features(phase(x), basis)
    curvature = force - STIFFNESS * slope - STIFFNESS * DAMPING * position
    states = np.stack([position, slope / pieces, curvature / pieces**2])
    table = quintic_coefficients(states[:, :-1], states[:, 1:])
    table.setflags(write=False)
    return table


def _running_sum(steps: Float[ndarray, "n basis"]) -> Float[ndarray, "m basis"]:
    return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])
