import math

import numpy as np
import pytest
from scipy.special import ndtr

from rotorpong.vision._trace_kernels import (
    ALPHA,
    FIELDS,
    INVERSE,
    LANES,
    S0,
    SUMS,
    VALUE,
    X,
    Y,
    add_up,
    normal,
    trace,
)

STILL = np.array([0.2, -0.3, 8.0, 0.5, 0.06, -0.04])
MOVING = np.array([0.2, -0.3, 8.0, 0.5, 2.1, -1.4])


def still_edge(points, edge):
    """Return Eq. (3) and (4) of `matte` in float64."""
    x, y, r, a, b, c = edge
    offset = points - (x, y)
    rho, phi = np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0])
    turned = b * np.cos(2 * phi) + c * np.sin(2 * phi)
    return ndtr((r - (a - turned) / (2 * r) - rho) / np.sqrt(a + turned))


def moving_edge(points, edge, nodes):
    """Return the mean of a round edge over the exposure in float64."""
    times = (2 * np.arange(nodes) + 1) / nodes - 1
    places = edge[:2] + times[:, None] * edge[4:]
    instants = [still_edge(points, [*place, edge[2], edge[3], 0, 0]) for place in places]
    return np.mean(instants, axis=0)


def edge_of(points, edge, nodes):
    return moving_edge(points, edge, nodes) if nodes else still_edge(points, edge)


def band_of(points, alpha=0.0, inverse=1.0):
    """Return lines of a band with these pixels; the last one is filled up."""
    count = len(points)
    flat = np.zeros((4, -(-count // LANES) * LANES), np.float32)
    flat[:2, :count], flat[2, :count], flat[3, :count] = points.T, alpha, inverse
    band = np.zeros((flat.shape[1] // LANES, FIELDS * LANES), np.float32)
    for field, first in enumerate((X, Y, ALPHA, INVERSE)):
        band[:, first : first + LANES] = flat[field].reshape(-1, LANES)
    return band


def field(band, first, count):
    return band[:, first : first + LANES].ravel()[:count].astype(float)


def test_the_normal_distribution_is_good_to_5e_7_within_four_and_a_half_sd():
    for z in np.linspace(-4.49, 4.49, 301).astype(np.float32):
        value, density = normal(z)
        assert abs(value - 0.5 * math.erfc(-float(z) / math.sqrt(2.0))) < 5e-7
        expected = math.exp(-0.5 * float(z) ** 2) / math.sqrt(2 * math.pi)
        assert abs(density - expected) < 5e-7


def test_beyond_four_and_a_half_sd_it_is_0_or_1_and_flat():
    for z in (4.5, 7.0, 60.0, 1e6):
        assert normal(np.float32(-z)) == (0.0, 0.0)
        assert normal(np.float32(z)) == (1.0, 0.0)


@pytest.mark.parametrize(("edge", "nodes"), [(STILL, 0), (MOVING, 12)])
def test_alpha_is_that_of_the_equations(edge, nodes):
    points = np.random.default_rng(7).uniform(-11.0, 11.0, (75, 2))
    band = band_of(points)
    trace(band, edge, nodes)
    expected = edge_of(points, edge, nodes)
    np.testing.assert_allclose(field(band, VALUE, 75), expected, atol=5e-6)


@pytest.mark.parametrize(("edge", "nodes"), [(STILL * [1, 1, 1, 1, 0, 0], 0), (MOVING, 12)])
def test_slopes_of_the_edge_are_those_of_differences(edge, nodes):
    """To 1e-4: from 4.5 sd on they are 0."""
    points = np.random.default_rng(8).uniform(-11.0, 11.0, (75, 2))
    band = band_of(points)
    trace(band, edge, nodes)
    for k in range(6):
        step = 1e-4 * (np.arange(6) == k)
        ahead, behind = (edge_of(points, edge + sign * step, nodes) for sign in (1, -1))
        slopes = (ahead - behind) / 2e-4
        np.testing.assert_allclose(field(band, S0 + k * LANES, 75), slopes, atol=1e-4)


def test_a_ball_that_hardly_moves_has_the_edge_of_one_at_rest():
    points = np.random.default_rng(9).uniform(-11.0, 11.0, (40, 2))
    still, moving = band_of(points), band_of(points)
    trace(still, np.array([*STILL[:4], 0.0, 0.0]), 0)
    trace(moving, np.array([*STILL[:4], 1e-3, 1e-3]), 8)
    for first in (VALUE, *(S0 + k * LANES for k in range(3))):
        np.testing.assert_allclose(field(moving, first, 40), field(still, first, 40), atol=1e-5)


def test_normal_equations_are_those_of_their_pixels_and_fillers_count_nothing():
    rng, clip = np.random.default_rng(10), 0.1
    points = rng.uniform(-11.0, 11.0, (75, 2))
    alpha = still_edge(points, STILL) + rng.normal(0.0, 0.05, 75)
    inverse = rng.uniform(100.0, 900.0, 75)
    band = band_of(points, alpha, inverse)
    trace(band, STILL, 0)
    matrix, pulls = np.zeros((6, 6)), np.zeros(6)
    squares, weights = add_up(band, clip, np.empty(SUMS * LANES, np.float32), matrix, pulls)
    slopes = np.array([field(band, S0 + k * LANES, 75) for k in range(6)])
    residual = alpha - field(band, VALUE, 75)
    share = (1.0 + clip * inverse * residual**2) ** -2
    expected = np.tril((slopes * share * inverse) @ slopes.T)
    np.testing.assert_allclose(matrix, expected, atol=1e-5 * np.abs(expected).max())
    np.testing.assert_allclose(pulls, slopes @ (share * inverse * residual), rtol=1e-3, atol=1e-2)
    assert squares == pytest.approx(np.sum(share * inverse * residual**2), rel=1e-4)
    assert weights == pytest.approx(share.sum(), rel=1e-5)
