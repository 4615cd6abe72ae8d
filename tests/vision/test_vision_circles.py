import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from rotorpong.vision.circles import FITS
from rotorpong.vision.measure import fit_circle

UNBIASED = ("pratt", "taubin", "geometric")


def arc(share, *, noise=0.0, seed=0, points=120, center=(31.3, -7.9), radius=9.4):
    """Return points of a share of a circle, with white noise, px."""
    rng = np.random.default_rng(seed)
    angles = 2 * math.pi * share * np.linspace(0.0, 1.0, points, endpoint=share < 1.0)
    there = np.array(center) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return there + noise * rng.standard_normal(there.shape)


@pytest.mark.parametrize("fit", FITS)
@pytest.mark.parametrize("share", [0.99, 0.5, 0.25])
def test_each_fit_is_exact_on_points_of_a_circle(fit, share):
    found = fit_circle(arc(share), fit=fit)
    assert found.diameter_px == pytest.approx(18.8, abs=1e-3)
    assert (found.x_px, found.y_px) == pytest.approx((31.3, -7.9), abs=1e-3)


def test_on_full_noisy_outlines_all_agree_to_a_fiftieth_of_a_pixel():
    for seed in range(50):
        found = [fit_circle(arc(0.99, noise=0.3, seed=seed), fit=fit) for fit in FITS]
        diameters = [circle.diameter_px for circle in found]
        assert max(diameters) - min(diameters) < 0.05
        assert np.ptp([circle.x_px for circle in found]) < 0.02


def test_of_a_short_arc_only_kasa_makes_the_circle_too_small():
    """A sixth of the outline, 200 times; k-sigma of each mean is 4."""
    found = {fit: [] for fit in FITS}
    for seed in range(200):
        points = arc(1.0 / 6.0, noise=0.05, seed=seed)
        for fit in FITS:
            found[fit].append(fit_circle(points, fit=fit).diameter_px)
    mean = {fit: np.mean(values) for fit, values in found.items()}
    error = {fit: np.std(values) / math.sqrt(200) for fit, values in found.items()}
    assert mean["kasa"] < 18.8 - 4.0 * error["kasa"]
    for fit in UNBIASED:
        assert abs(mean[fit] - 18.8) < 0.5 * (18.8 - mean["kasa"])


def test_the_geometric_circle_is_the_least_squares_one():
    points = arc(0.4, noise=0.3, seed=3)
    found = fit_circle(points, fit="geometric")

    def residuals(circle):
        return np.hypot(points[:, 0] - circle[0], points[:, 1] - circle[1]) - circle[2]

    wanted = least_squares(residuals, [31.0, -8.0, 9.0], xtol=1e-15, ftol=1e-15).x
    assert [found.x_px, found.y_px, found.diameter_px / 2] == pytest.approx(wanted, abs=1e-5)


@pytest.mark.parametrize("fit", FITS)
def test_moving_and_scaling_the_points_moves_and_scales_the_circle(fit):
    points = arc(0.6, noise=0.4, seed=1)
    here, there = fit_circle(points, fit=fit), fit_circle(3.0 * points + [5.0, -2.0], fit=fit)
    assert there.x_px == pytest.approx(3.0 * here.x_px + 5.0, abs=1e-6)
    assert there.diameter_px == pytest.approx(3.0 * here.diameter_px, rel=1e-6)


@pytest.mark.parametrize("fit", FITS)
def test_a_point_two_points_and_a_line_give_finite_circles(fit):
    for points in ([[3.0, 4.0]], [[0.0, 0.0], [2.0, 0.0]], [[float(k), 2.0 * k] for k in range(9)]):
        found = fit_circle(np.array(points), fit=fit)
        assert np.isfinite([found.x_px, found.y_px, found.diameter_px]).all()
