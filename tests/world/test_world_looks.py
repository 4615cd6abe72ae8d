"""Scenes drawn at random differ, repeat with their seed, and keep ball and court apart."""

import colorsys
from dataclasses import fields, replace

import numpy as np
import pytest

from rotorpong.world.looks import BALL_COLOURS, BALL_TINTS, draw_looks, plain_looks
from rotorpong.world.render import Scene


def drawn(seed, **given):
    return draw_looks(np.random.default_rng(seed), **given)


def hue_saturation(colour):
    blue, green, red = (part / 255.0 for part in colour)
    hue, saturation, _ = colorsys.rgb_to_hsv(red, green, blue)
    return hue * 360.0, saturation


def test_the_same_seed_gives_the_same_looks_and_another_seed_others():
    assert drawn(1) == drawn(1)
    assert drawn(1) != drawn(2)


def test_every_colour_is_one_of_a_picture():
    for seed in range(200):
        scene = drawn(seed)
        for field in fields(Scene):
            value = getattr(scene, field.name)
            if isinstance(value, tuple):
                assert all(0.0 <= part <= 255.0 for part in value), field.name


@pytest.mark.parametrize("colour", BALL_COLOURS)
def test_the_ball_is_of_the_colour_asked_for(colour):
    for seed in range(100):
        hue, saturation = hue_saturation(drawn(seed, ball=colour).ball)
        assert (saturation > 0.7 and 19.0 < hue < 35.0) == (colour == "orange")


def test_half_of_the_balls_are_white_within_four_sigma():
    white = sum(hue_saturation(drawn(seed).ball)[1] < 0.1 for seed in range(400))
    assert abs(white - 200) < 4 * np.sqrt(400 / 4)


def test_the_colour_of_the_ball_changes_nothing_else():
    orange, white = (drawn(5, ball=colour) for colour in BALL_COLOURS)
    same = [f.name for f in fields(Scene) if getattr(orange, f.name) == getattr(white, f.name)]
    assert {f.name for f in fields(Scene)} - set(same) == {"ball"}


def test_the_plain_scene_differs_in_the_ball_only_and_its_balls_are_within_their_tints():
    assert plain_looks("orange") == Scene()
    assert replace(plain_looks("white"), ball=Scene().ball) == Scene()
    for colour in BALL_COLOURS:
        blue, green, red = (part / 255.0 for part in plain_looks(colour).ball)
        hue, saturation, value = colorsys.rgb_to_hsv(red, green, blue)
        for part, (low, high) in zip(
            (360.0 * hue, saturation, value), BALL_TINTS[colour], strict=True
        ):
            assert low - 0.02 <= part <= high + 0.02
