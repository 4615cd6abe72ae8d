"""Balls of single pictures in pixels and metres, by circle and by matte, against where they are."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from vision_drawing import ORANGE, WHITE, court, disc_coverage, plain, with_ball

from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO
from rotorpong.vision.circles import FITS
from rotorpong.vision.colour import COLOURS, Colour
from rotorpong.vision.detect import detect
from rotorpong.vision.located import StillEyes
from rotorpong.vision.matte import BALL_COLOURS
from rotorpong.vision.paint import paint_of
from rotorpong.vision.sphere import disc_of_sphere

GREEN = (60, 170, 50)
FINE = StillEyes(fine=True)


def lit_ball(center, diameter, colour=ORANGE, background=(110, 100, 90), gamma=2.2):
    """An evenly coloured ball whose pixels mix as light, sent with a gamma."""
    share = disc_coverage((120, 160), center, diameter)[..., None]
    ball, behind = (255.0 * (np.array(c) / 255.0) ** gamma for c in (colour, background))
    light = share * ball + (1.0 - share) * behind
    return np.round(255.0 * (light / 255.0) ** (1.0 / gamma)).astype(np.uint8)


@pytest.mark.parametrize("diameter", [8.0, 13.3, 24.0, 47.7])
@pytest.mark.parametrize("center", [(80.0, 60.0), (80.37, 59.81)])
def test_the_matte_finds_centre_and_diameter_to_hundredths_of_a_pixel(center, diameter):
    picture = lit_ball(center, diameter)
    (fine,), (coarse,) = FINE.look(picture), StillEyes().look(picture)
    assert np.hypot(fine.x_px - center[0], fine.y_px - center[1]) < 0.03
    assert fine.diameter_px == pytest.approx(diameter, abs=0.06)
    assert (fine.score, fine.colour) == (coarse.score, coarse.colour)


@pytest.mark.parametrize("camera", [GAZEBO, replace(ARDRONE2_720P, gamma=1.0)])
@pytest.mark.parametrize("size", [0.04, 0.12])
def test_the_place_is_that_of_the_sphere_that_has_this_disc(camera, size):
    rng = np.random.default_rng(3)
    for _ in range(4):
        place = rng.uniform([-0.3, -0.2, 1.2], [0.3, 0.2, 2.0]) * size / 0.04
        x, y, radius = disc_of_sphere(camera, place, radius=size / 2)
        picture = with_ball(plain((camera.height_px, camera.width_px)), (x, y), 2 * radius)
        (ball,) = StillEyes(camera, ball_diameter=size, fine=True).look(picture)
        error = ball.position_m - place
        assert np.linalg.norm(error) < 0.02 * np.linalg.norm(place)
        assert error @ np.linalg.solve(ball.covariance_m2, error) < 16.3


def test_the_covariance_grows_with_the_distance():
    depths = (0.6, 1.2, 2.4)
    sd = []
    for depth in depths:
        x, y, radius = disc_of_sphere(GAZEBO, np.array([0.05, 0.02, depth]))
        picture = with_ball(plain((360, 640)), (x, y), 2 * radius)
        (ball,) = StillEyes(GAZEBO, fine=True).look(picture)
        sd.append(np.sqrt(ball.covariance_m2[2, 2]))
    assert sd == sorted(sd)
    assert sd[2] / sd[0] > 4.0


def test_what_the_matte_cannot_measure_keeps_its_circle():
    picture = with_ball(plain(), (80.0, 60.0), 24.0)
    picture = with_ball(picture, (98.0, 60.0), 20.0)  # two balls that touch are no disc
    fine, coarse = FINE.look(picture), StillEyes().look(picture)
    assert len(fine) == len(coarse) >= 1
    assert [ball.score for ball in fine] == [ball.score for ball in coarse]


@pytest.mark.parametrize("fit", FITS)
def test_every_fit_finds_a_full_circle(fit):
    picture = with_ball(plain(), (80.3, 60.4), 20.0)
    (ball,) = StillEyes(fit=fit).look(picture)
    assert np.hypot(ball.x_px - 80.3, ball.y_px - 60.4) < 0.2
    assert ball.diameter_px == pytest.approx(20.0, abs=0.6)


def test_asking_for_what_is_the_default_changes_nothing():
    picture = with_ball(court(np.random.default_rng(0)), (300.0, 150.0), 18.0)
    detections = detect(picture)
    located = StillEyes(fit="kasa").look(picture)
    assert [(b.x_px, b.y_px, b.diameter_px, b.score) for b in located] == [
        (b.x_px, b.y_px, b.diameter_px, b.score) for b in detections
    ]


def test_fits_are_the_same_chain_with_another_circle():
    """Two circles of one full outline agree to hundredths; that of all thresholds to tenths."""
    picture = with_ball(court(np.random.default_rng(0)), (300.0, 150.0), 40.0)
    pratt, taubin, usual = (
        StillEyes(fit=fit).look(picture)[0] for fit in ("pratt", "taubin", "kasa")
    )
    for other, within in ((taubin, 0.05), (usual, 0.5)):
        assert (pratt.x_px, pratt.y_px) == pytest.approx((other.x_px, other.y_px), abs=within)
        assert pratt.diameter_px == pytest.approx(other.diameter_px, abs=within)


def test_whole_pixels_are_whole():
    for diameter in (9.3, 17.7, 31.4):
        (ball,) = StillEyes(whole_pixels=True).look(with_ball(plain(), (80.0, 60.0), diameter))
        assert ball.diameter_px == round(ball.diameter_px)
        assert ball.diameter_px == pytest.approx(diameter, abs=1.0)


def test_a_ball_where_the_lens_cannot_be_undone_has_no_place_and_the_others_have():
    narrow = replace(GAZEBO, name="bent", distortion=(-0.9, 0.0, 0.0, 0.0, 0.0))
    picture = with_ball(with_ball(plain((360, 640)), (320.0, 180.0), 20.0), (628.0, 12.0), 20.0)
    for fine in (False, True):
        found = StillEyes(narrow, fine=fine).look(picture)
        assert sorted(ball.position_m is None for ball in found) == [False, True]
        assert all((b.position_m is None) == (b.covariance_m2 is None) for b in found)


def test_a_learnt_colour_is_measured_as_finely_as_orange():
    hue, saturation, value = cv2.cvtColor(np.uint8([[GREEN]]), cv2.COLOR_BGR2HSV)[0, 0].tolist()
    low = (hue - 10, saturation - 60, value - 60)
    high = (hue + 10, 255, 255)
    green = Colour("green", low, low, high, (hue, saturation, value))
    (ball,) = StillEyes(colours=(green,), fine=True).look(lit_ball((80.4, 60.2), 24.0, GREEN))
    assert ball.colour == "green"
    assert (ball.x_px, ball.y_px) == pytest.approx((80.4, 60.2), abs=0.03)
    assert ball.diameter_px == pytest.approx(24.0, abs=0.06)


def test_a_white_ball_is_measured_before_a_dark_wall():
    eyes = StillEyes(colours=("white",), fine=True)
    (ball,) = eyes.look(lit_ball((80.4, 60.2), 24.0, WHITE, (70, 60, 50)))
    assert ball.diameter_px == pytest.approx(24.0, abs=0.2)


@pytest.mark.parametrize("name", COLOURS)
def test_known_colours_are_measured_as_the_matte_knows_them(name):
    assert paint_of(COLOURS[name]) is BALL_COLOURS[name]


def test_a_learnt_white_is_shaded_as_white_and_a_learnt_orange_as_orange():
    pale = replace(COLOURS["white"], name="mine", typical=(25, 20, 240))
    assert paint_of(pale).shading == BALL_COLOURS["white"].shading
    own = paint_of(replace(COLOURS["orange"], name="mine"))
    assert own.shading == BALL_COLOURS["orange"].shading
    blue, green, red = own.levels_bgr
    assert blue < green < red
