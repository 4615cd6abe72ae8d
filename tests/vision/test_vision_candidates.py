"""What may be a ball, what is measured of it, and how sure the model is."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vision_drawing import GREY, ORANGE, WHITE, plain, with_ball

from rotorpong.vision import _candidate_kernels as kernels
from rotorpong.vision.ball_model import HUED, PALE, BallModel, probability
from rotorpong.vision.candidates import FEATURES, find_candidates, tint_of
from rotorpong.vision.colour import COLOURS, Colour

BLUE = Colour("blue", (100, 120, 80), (100, 100, 50), (130, 255, 255), (115, 200, 200))
BLACK = Colour("black", (0, 0, 0), (0, 0, 0), (180, 255, 60), (90, 60, 25))


def feature(found, name):
    return found.features[:, FEATURES.index(name)]


@pytest.mark.parametrize("colour", [COLOURS["orange"], BLUE])
def test_the_tint_is_the_chroma_of_pixels_of_the_hue(colour):
    rng = np.random.default_rng(0)
    picture = rng.integers(0, 256, (60, 80, 3)).astype(np.uint8)
    hue = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)[..., 0].astype(int)
    chroma = picture.max(axis=2).astype(int) - picture.min(axis=2)
    tint = tint_of(picture, colour)
    away = (hue - colour.lower[0] + 90) % 180 - 90  # from the lower limit, around the circle
    width = colour.upper[0] - colour.lower[0]
    surely = (away >= 0) & (away <= width)
    np.testing.assert_array_equal(tint[surely], chroma[surely])
    assert not tint[(away < -4) | (away > width + 4)].any()


def test_the_tint_of_balls_without_a_hue_is_most_where_they_are_palest():
    shades = np.array([[(0, 0, 0), (128, 128, 128), (255, 255, 255), (200, 220, 255)]], np.uint8)
    shades = np.repeat(np.repeat(shades, 9, axis=0), 9, axis=1)
    assert tint_of(shades, COLOURS["white"])[4, 4::9].tolist() == [0, 128, 255, 145]
    assert tint_of(shades, BLACK)[4, 4::9].tolist() == [255, 127, 0, 0]


@pytest.mark.parametrize("radius", [4.0, 11.0, 37.0])
def test_a_sharp_disc_is_measured_as_it_was_drawn(radius):
    tint = np.full((120, 140), 30, np.uint8)
    rows, columns = np.mgrid[:120, :140]
    tint[np.hypot(columns - 70, rows - 60) <= radius] = 200
    picture = np.full((120, 140, 3), (10, 20, 30), np.uint8)
    measures = np.empty((1, kernels.MEASURES))
    kernels.describe(measures, tint, picture, np.array([[70.0, 60.0, radius]]))
    one = measures[0]
    assert one[kernels.CORE_MEAN] == 200
    assert one[kernels.CORE_SD] == pytest.approx(0.0, abs=1e-6)
    assert one[kernels.RING_MEAN] == one[kernels.RING_WORST] == 30
    assert one[kernels.BLUE : kernels.RED + 1].tolist() == [10, 20, 30]
    assert one[kernels.OUTSIDE_BELOW] == one[kernels.SEEN] == 1.0
    assert one[kernels.BOTH_SIDES] > 0.9
    assert one[kernels.EDGE_QUARTER] == 170
    assert one[kernels.EDGE_OFFSET] < 0.3


@settings(max_examples=30, deadline=None)
@given(st.floats(-8.0, 60.0), st.floats(-8.0, 60.0), st.floats(1.5, 30.0))
def test_measures_are_finite_wherever_a_circle_lies(x, y, radius):
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 256, (40, 50, 3)).astype(np.uint8)
    measures = np.full((1, kernels.MEASURES), np.nan)
    kernels.describe(measures, picture[..., 0].copy(), picture, np.array([[x, y, radius]]))
    assert np.isfinite(measures).all()
    for share in (kernels.OUTSIDE_BELOW, kernels.BOTH_SIDES, kernels.SEEN):
        assert 0.0 <= measures[0, share] <= 1.0
    assert measures[0, kernels.RING_WORST] >= measures[0, kernels.RING_MEAN]


def test_a_ball_is_a_candidate_and_a_patch_without_a_core_is_none():
    found = find_candidates(with_ball(plain(), (80.3, 60.4), 20.0), COLOURS["orange"])
    assert found.features.shape == (len(found.contours), len(FEATURES))
    assert np.isfinite(found.features).all()
    assert np.abs(found.circles[:, :2] - (80.3, 60.4)).max() < 0.7
    skin = with_ball(plain(), (80.3, 60.4), 20.0, (125, 155, 205))
    for picture in (skin, plain(), plain((1, 1)), plain(colour=WHITE)):
        empty = find_candidates(picture, COLOURS["orange"])
        assert empty.contours == []
        assert empty.features.shape == (0, len(FEATURES))


def test_features_tell_discs_from_squares_and_sharp_from_soft():
    disc = with_ball(plain(), (80.0, 60.0), 30.0)
    square = plain()
    square[45:75, 65:95] = ORANGE
    round_one, flat = (find_candidates(p, COLOURS["orange"]) for p in (disc, square))
    assert feature(round_one, "fill").min() > feature(flat, "fill").max()
    assert feature(flat, "fill").max() == pytest.approx(math.log(2 / math.pi), abs=0.1)
    assert feature(round_one, "corners").min() > feature(flat, "corners").max()
    soft = find_candidates(cv2.GaussianBlur(disc, (0, 0), 4.0), COLOURS["orange"])
    assert feature(soft, "sharpness").max() < feature(round_one, "sharpness").min()


def test_features_do_not_depend_on_where_the_ball_is():
    here = find_candidates(with_ball(plain((200, 300)), (140.0, 90.0), 20.0), COLOURS["orange"])
    there = find_candidates(with_ball(plain((200, 300)), (120.0, 110.0), 20.0), COLOURS["orange"])
    np.testing.assert_allclose(here.features, there.features, atol=1e-4)
    np.testing.assert_allclose(
        here.circles - there.circles, [[20.0, -20.0, 0.0]] * len(here.circles), atol=1e-4
    )


def test_the_model_is_a_logistic_function_of_named_features():
    features = np.zeros((3, len(FEATURES)))
    features[1, FEATURES.index("fill")] = 1.0
    features[2] = 1e6
    model = BallModel(-1.0, {"fill": 3.0})
    expected = [1 / (1 + math.exp(1.0)), 1 / (1 + math.exp(-2.0)), 1.0]
    np.testing.assert_allclose(probability(features, model), expected)
    for one in (HUED, PALE):
        assert set(one.weights) <= set(FEATURES)


def test_the_model_believes_in_balls_and_not_in_squares():
    for name, model, colour in (("orange", HUED, ORANGE), ("white", PALE, WHITE)):
        square = plain(colour=GREY)
        square[45:75, 65:95] = colour
        disc = with_ball(plain(), (80.0, 60.0), 30.0, colour)
        sure, unsure = (
            probability(find_candidates(p, COLOURS[name]).features, model).max()
            for p in (disc, square)
        )
        assert sure > 0.5 > unsure
