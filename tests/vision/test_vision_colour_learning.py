"""Colours learnt from pixels: what they take, what they leave out, and where they end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotorpong.conventions import InputError
from rotorpong.vision.colour_files import colour_text, read_colour
from rotorpong.vision.colour_learning import learn_colour


def pixels(center, spread=(3, 15, 20), count=300, seed=0):
    """Pixels around a colour in HSV; hues wrap."""
    drawn = np.random.default_rng(seed).normal(center, spread, (count, 3))
    drawn[:, 0] %= 180
    return np.clip(np.round(drawn), 0, (179, 255, 255)).astype(np.uint8)


FLOOR = pixels((15, 60, 150), count=2000, seed=9)


@settings(max_examples=25, deadline=None)
@given(hue=st.integers(30, 160), saturation=st.integers(140, 220), value=st.integers(90, 220))
def test_a_colour_takes_its_balls_and_leaves_the_floor(tmp_path_factory, hue, saturation, value):
    balls = [pixels((hue, saturation, value), seed=i) for i in range(3)]
    learnt = learn_colour(balls, FLOOR, "own")
    assert learnt.recall > 0.9
    assert learnt.surroundings_taken < 0.01 * learnt.surroundings
    assert not learnt.hue_cut
    assert abs(learnt.colour.typical[0] - hue) <= 2
    path = tmp_path_factory.mktemp("colour") / "own.json"
    path.write_text(colour_text(learnt.colour))
    assert read_colour(path) == learnt.colour


def test_every_ball_counts_the_same_however_large():
    small, large = pixels((60, 180, 180), count=40), pixels((70, 180, 180), count=4000)
    typical = learn_colour([small, large], FLOOR, "own").colour.typical
    assert typical[0] == pytest.approx(65, abs=2)
    assert learn_colour([large, small], FLOOR, "own").colour.typical == typical


def test_nearly_every_ball_keeps_the_core_with_half_its_pixels():
    balls = [pixels((60, 180, v), seed=v) for v in (100, 150, 200)]
    colour = learn_colour(balls, FLOOR, "own").colour
    for ball in balls:
        assert np.all(ball >= colour.core, axis=1).mean() > 0.4


def test_white_balls_take_all_hues_and_no_saturated_pixel():
    learnt = learn_colour([pixels((90, 12, 235), (50, 8, 10))], FLOOR, "snow")
    assert learnt.colour.lower[0] == 0
    assert learnt.colour.upper[0] == 180
    assert learnt.colour.upper[1] < 120
    assert learnt.colour.lower[2] > 150


def test_red_that_is_mostly_on_one_side_ends_at_the_border():
    learnt = learn_colour([pixels((175, 200, 200))], FLOOR, "red")
    assert learnt.hue_cut
    assert learnt.colour.upper[0] == 180
    assert learnt.recall > 0.8


def test_red_around_zero_is_refused():
    with pytest.raises(InputError, match="go over red's 0 = 180"):
        learn_colour([pixels((0, 200, 200))], FLOOR, "red")


def test_balls_like_their_surroundings_are_refused():
    with pytest.raises(InputError, match="no colour tells these balls"):
        learn_colour([pixels((15, 60, 150))], FLOOR, "wood")


def test_black_balls_on_black_are_refused():
    black = np.zeros((100, 3), np.uint8)
    with pytest.raises(InputError, match="no colour tells these balls"):
        learn_colour([black], black, "night")


def test_limits_close_where_the_surroundings_are_near():
    near = pixels((71, 180, 180), (2, 15, 20), count=2000, seed=5)
    balls = [pixels((60, 180, 180), (2, 15, 20))]
    wide = learn_colour(balls, FLOOR, "own").colour.upper[0]
    learnt = learn_colour(balls, near, "own")
    assert learnt.colour.upper[0] < wide
    assert learnt.surroundings_taken < 0.05 * len(near)
