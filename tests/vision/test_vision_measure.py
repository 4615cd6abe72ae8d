import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vision_drawing import disc_coverage

from rotorpong.conventions import InputError
from rotorpong.vision.measure import OUTLINE_BIAS_PX, fit_circle, outer_arc

PLACES = st.floats(-500.0, 500.0)


def points_on_circle(center, radius, angles):
    return np.array(center) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def outline_of_disc(center, diameter):
    mask = (disc_coverage((80, 80), center, diameter) >= 0.5).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return contours[0][:, 0].astype(np.int32)


@given(PLACES, PLACES, st.floats(0.5, 200.0))
def test_the_fit_is_exact_on_points_of_a_circle(x, y, radius):
    circle = fit_circle(points_on_circle((x, y), radius, np.linspace(0, 6, 25)))
    np.testing.assert_allclose(
        [circle.x_px, circle.y_px, circle.diameter_px], [x, y, 2 * radius], atol=1e-4 * radius
    )


def test_a_quarter_of_a_circle_is_enough():
    circle = fit_circle(points_on_circle((3.0, 4.0), 10.0, np.linspace(0, np.pi / 2, 30)))
    np.testing.assert_allclose(
        [circle.x_px, circle.y_px, circle.diameter_px], [3, 4, 20], rtol=1e-3
    )


@given(PLACES, PLACES, st.floats(0.1, 10.0))
def test_moving_and_scaling_the_points_moves_and_scales_the_circle(dx, dy, factor):
    points = np.random.default_rng(1).normal(0.0, 1.0, (20, 2)) + points_on_circle(
        (0.0, 0.0), 10.0, np.linspace(0, 6, 20)
    )
    before, after = fit_circle(points), fit_circle(factor * points + (dx, dy))
    expected = [factor * before.x_px + dx, factor * before.y_px + dy, factor * before.diameter_px]
    np.testing.assert_allclose(
        [after.x_px, after.y_px, after.diameter_px], expected, rtol=1e-7, atol=1e-7
    )


@pytest.mark.parametrize("diameter", [9.0, 17.3, 43.2])
def test_outlines_of_drawn_discs_lack_the_stated_bias_and_agree_with_the_enclosing_circle(diameter):
    rng = np.random.default_rng(3)
    outlines = [outline_of_disc(40 + rng.uniform(-0.5, 0.5, 2), diameter) for _ in range(40)]
    fitted = np.mean([fit_circle(outline).diameter_px for outline in outlines])
    enclosing = np.mean([2 * cv2.minEnclosingCircle(outline)[1] for outline in outlines])
    assert fitted + OUTLINE_BIAS_PX == pytest.approx(diameter, abs=0.15)
    assert fitted < enclosing < fitted + 1.0


def test_the_centre_of_a_drawn_disc_is_found_to_a_tenth_of_a_pixel():
    rng = np.random.default_rng(4)
    centers = 40 + rng.uniform(-0.5, 0.5, (40, 2))
    circles = [fit_circle(outline_of_disc(center, 17.3)) for center in centers]
    errors = np.array([[c.x_px, c.y_px] for c in circles]) - centers
    assert np.sqrt(np.mean(errors**2)) < 0.1


def test_whole_pixels_give_the_steps_of_figure_4():
    angles = np.linspace(0, 6, 40)
    diameters = [
        fit_circle(points_on_circle((0.0, 0.0), radius, angles), whole_pixels=True).diameter_px
        for radius in np.linspace(0.01, 6.0, 50)
    ]
    assert set(diameters) == set(range(1, 13))
    assert np.all(np.diff(diameters) >= 0)


def test_a_single_pixel_and_a_line_are_circles_too():
    assert fit_circle(np.array([[5, 7]])).diameter_px == 0.0
    line = fit_circle(np.stack([np.arange(9), np.zeros(9, dtype=int)], axis=-1))
    assert (line.x_px, line.y_px) == pytest.approx((4.0, 0.0))


def test_a_bite_out_of_the_ball_leaves_its_circle():
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    whole = points_on_circle((40.0, 40.0), 20.0, angles)
    bitten = np.column_stack([whole[:, 0], np.minimum(whole[:, 1], 48.0)]).round().astype(np.int32)
    circle = fit_circle(outer_arc(bitten))
    assert (circle.x_px, circle.y_px) == pytest.approx((40.0, 40.0), abs=0.4)
    assert circle.diameter_px == pytest.approx(40.0, abs=0.8)


@pytest.mark.parametrize("outline", [np.zeros((0, 2)), np.array([[0.0, np.nan]])])
def test_no_point_or_a_point_that_is_not_finite_is_refused(outline):
    with pytest.raises(InputError, match="outline"):
        fit_circle(outline)
