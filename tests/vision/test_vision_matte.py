from dataclasses import replace

import cv2
import numpy as np
import pytest
from vision_drawing import GREY, ORANGE, WHITE, disc_coverage, plain

from rotorpong.conventions import InputError
from rotorpong.vision.matte import (
    ORANGE_BALL,
    WHITE_BALL,
    BallDisc,
    Guess,
    area_and_edge,
    measure_ball,
    region_around,
    rolling_shape,
    streamed,
    without_rolling,
)

SHAPE = (61, 65)
ORANGE_DRAWN = replace(ORANGE_BALL, levels_bgr=ORANGE)
WHITE_DRAWN = replace(WHITE_BALL, levels_bgr=WHITE)


def encoded(light, gamma):
    return np.clip(np.rint(255.0 * (np.clip(light, 0, 255) / 255.0) ** (1 / gamma)), 0, 255)


def picture(cover, *, colour=ORANGE, background=GREY, noise=0.0, gamma=1.0, seed=0, shade=1.0):
    """Return a ball of this coverage before a background, mixed in linear light."""
    ball, behind = (255.0 * (np.array(c, float) / 255.0) ** gamma for c in (colour, background))
    light = cover[..., None] * ball * np.asarray(shade)[..., None] + (1 - cover[..., None]) * behind
    light = light + np.random.default_rng(seed).normal(0.0, 1.0, light.shape) * noise
    return encoded(light, gamma).astype(np.uint8)


def blurred(cover, sigma):
    """Return the coverage after a lens' blur, by its Fourier transform."""
    fy, fx = np.fft.fftfreq(cover.shape[0])[:, None], np.fft.fftfreq(cover.shape[1])[None]
    lens = np.exp(-2.0 * (np.pi * sigma) ** 2 * (fx**2 + fy**2))
    return np.clip(np.fft.ifft2(np.fft.fft2(cover) * lens).real, 0.0, 1.0)


def moving_coverage(shape, center, diameter, streak, instants=48):
    times = (np.arange(instants) + 0.5) / instants - 0.5
    places = np.array(center) + times[:, None] * np.array(streak)
    return np.mean([disc_coverage(shape, place, diameter) for place in places], axis=0)


def near(center, diameter, rng, **options):
    x, y = np.array(center) + rng.uniform(-0.7, 0.7, 2)
    return Guess(float(x), float(y), diameter * rng.uniform(0.9, 1.08), **options)


def errors(found, center, diameter):
    return np.array(
        [found.x_px - center[0], found.y_px - center[1], found.radius_px - diameter / 2]
    )


@pytest.mark.parametrize("gamma", [1.0, 2.2])
@pytest.mark.parametrize("diameter", [9.0, 17.3, 43.2])
def test_a_clean_ball_is_found_to_two_hundredths_of_a_pixel(diameter, gamma):
    rng = np.random.default_rng(1)
    for _ in range(8):
        center = np.array([32.0, 30.0]) + rng.uniform(-0.5, 0.5, 2)
        shot = picture(blurred(disc_coverage(SHAPE, center, diameter), 0.6), gamma=gamma)
        guess = near(center, diameter, rng)
        for found in area_and_edge(shot, guess, ORANGE_DRAWN, gamma=gamma):
            assert np.abs(errors(found, center, diameter)).max() < 0.02


@pytest.mark.parametrize(("colour", "ball"), [(ORANGE, ORANGE_DRAWN), (WHITE, WHITE_DRAWN)])
def test_errors_of_noisy_balls_are_as_large_as_their_covariances_say(colour, ball):
    """NEES of 200 balls: mean of a chi-square of 3 is 3 +- 0.17; allowed 1.2 to 4 (cautious)."""
    rng, scores, misses = np.random.default_rng(2), [], []
    for seed in range(200):
        center, diameter = (
            np.array([32.0, 30.0]) + rng.uniform(-0.5, 0.5, 2),
            rng.uniform(9.0, 30.0),
        )
        cover = blurred(disc_coverage(SHAPE, center, diameter), 0.6)
        shot = picture(cover, colour=colour, noise=4.0, seed=seed, background=(150, 88, 34))
        found = measure_ball(shot, near(center, diameter, rng), ball)
        error = errors(found, center, diameter)
        scores.append(error @ np.linalg.solve(found.covariance, error))
        misses.append(abs(found.radius_px - diameter / 2))
    assert 1.2 < np.mean(scores) < 4.0
    assert np.mean(np.array(scores) > 11.34) < 0.05  # 1 % of a chi-square lie beyond
    assert np.median(misses) < 0.02


def test_errors_of_large_balls_are_as_large_as_their_covariances_say_though_not_all_pixels_count():
    """NEES of 60 balls of which every third to eighth pixel of the edge is read: 3 +- 0.32."""
    rng, scores, shape = np.random.default_rng(10), [], (141, 139)
    for seed in range(60):
        center, diameter = (
            np.array([69.0, 70.0]) + rng.uniform(-0.5, 0.5, 2),
            rng.uniform(60.0, 100.0),
        )
        cover = blurred(disc_coverage(shape, center, diameter), 0.6)
        shot = picture(cover, noise=12.0, seed=seed, background=(150, 88, 34))
        found = measure_ball(shot, near(center, diameter, rng), ORANGE_DRAWN)
        error = errors(found, center, diameter)
        scores.append(error @ np.linalg.solve(found.covariance, error))
    assert 1.2 < np.mean(scores) < 4.3


def test_whatever_its_shading_an_orange_ball_has_its_size():
    down, across = np.indices(SHAPE)
    shade = np.clip(0.7 + 0.02 * (across - 32) + 0.015 * (down - 30), 0.2, 1.0)
    cover = blurred(disc_coverage(SHAPE, (32.3, 30.2), 20.0), 0.6)
    found = measure_ball(picture(cover, shade=shade), Guess(32.0, 30.0, 19.0), ORANGE_DRAWN)
    assert np.abs(errors(found, (32.3, 30.2), 20.0)).max() < 0.03


def test_an_edge_behind_the_ball_moves_it_by_less_than_it_says():
    rng, scores = np.random.default_rng(3), []
    for _ in range(60):
        center, diameter = np.array([32.0, 30.0]) + rng.uniform(-0.5, 0.5, 2), 17.3
        cover = blurred(disc_coverage(SHAPE, center, diameter), 0.6)
        behind = np.broadcast_to(np.array(GREY, float), (*SHAPE, 3)).copy()
        behind[: int(rng.integers(20, 40))] = (200, 210, 205)
        behind[:, : int(rng.integers(15, 45))] *= 0.7
        light = cover[..., None] * np.array(ORANGE) + (1 - cover[..., None]) * behind
        shot = encoded(light + rng.normal(0.0, 3.0, light.shape), 1.0).astype(np.uint8)
        found = measure_ball(shot, near(center, diameter, rng), ORANGE_DRAWN)
        error = errors(found, center, diameter)
        assert np.abs(error).max() < 0.25
        scores.append(error @ np.linalg.solve(found.covariance, error))
    assert np.median(scores) < 5.0  # 2.37 for a chi-square of 3


@pytest.mark.parametrize("streak", [(6.0, 0.0), (9.0, 7.0), (-3.0, 16.0)])
def test_blur_neither_grows_nor_moves_the_ball_and_is_measured_up_to_its_sign(streak):
    center, diameter = (32.3, 30.1), 16.0
    cover = blurred(moving_coverage(SHAPE, center, diameter, streak), 0.6)
    shot = picture(cover, noise=2.0)
    known = replace(ORANGE_DRAWN, tolerance=0.005)
    area, edge = area_and_edge(shot, Guess(32.0, 30.5, 19.0), known)
    assert np.abs(errors(edge, center, diameter)).max() < 0.1
    assert np.abs(errors(area, center, diameter)).max() < 0.25
    assert edge.blurred
    off = min(np.hypot(*np.subtract(edge.streak_px, sign * np.array(streak))) for sign in (-1, 1))
    assert off < 0.8


def test_a_known_streak_leads_to_the_same_ball():
    cover = blurred(moving_coverage(SHAPE, (32.3, 30.1), 16.0, (9.0, 7.0)), 0.6)
    shot, guess = picture(cover, noise=2.0), Guess(32.0, 30.5, 16.0)
    blind = measure_ball(shot, guess, ORANGE_DRAWN)
    told = measure_ball(shot, replace(guess, streak_px=(8.0, 8.0)), ORANGE_DRAWN)
    assert np.abs(errors(told, (blind.x_px, blind.y_px), 2 * blind.radius_px)).max() < 0.02


def test_a_sharp_ball_has_no_streak():
    cover = blurred(disc_coverage(SHAPE, (32.3, 30.2), 20.0), 0.6)
    found = measure_ball(picture(cover, noise=2.0), Guess(32.0, 30.0, 19.0), ORANGE_DRAWN)
    assert not found.blurred


@pytest.mark.parametrize("ball", [ORANGE_DRAWN, streamed(ORANGE_DRAWN)], ids=["plain", "streamed"])
def test_half_the_colour_resolution_leaves_a_shaded_ball_its_size_to_two_hundredths(ball):
    rng, misses, size = np.random.default_rng(11), [], (64, 60)
    down, across = np.indices(size[::-1])
    for seed in range(40):
        center = np.array([32.0, 30.0]) + rng.uniform(-1.0, 1.0, 2)
        lit = 0.75 + 0.02 * (across - center[0]) + 0.015 * (center[1] - down)
        cover = blurred(disc_coverage(size[::-1], center, 18.0), 0.6)
        sent = cv2.cvtColor(picture(cover, shade=lit, noise=2.0, seed=seed), cv2.COLOR_BGR2YCrCb)
        colours = cv2.resize(sent[..., 1:], (32, 30), interpolation=cv2.INTER_AREA)
        sent[..., 1:] = cv2.resize(colours, size, interpolation=cv2.INTER_LINEAR)
        shot = cv2.cvtColor(sent, cv2.COLOR_YCrCb2BGR)
        misses.append(measure_ball(shot, near(center, 18.0, rng), ball).radius_px - 9.0)
    assert np.sqrt(np.mean(np.square(misses))) < 0.02


def test_a_stream_makes_no_brightness_less_known():
    assert streamed(WHITE_BALL) == WHITE_BALL
    assert streamed(ORANGE_BALL) == replace(ORANGE_BALL, shading=0.1)


def test_two_measurements_disagree_where_something_of_the_balls_colour_touches_it():
    center, diameter = (32.3, 30.2), 20.0
    cover = disc_coverage(SHAPE, center, diameter)
    lump = np.maximum(cover, disc_coverage(SHAPE, (43.0, 30.0), 7.0))
    guess = Guess(32.0, 30.0, 19.0)
    alone = measure_ball(picture(blurred(cover, 0.6), noise=2.0), guess, ORANGE_DRAWN)
    touched = measure_ball(picture(blurred(lump, 0.6), noise=2.0), guess, ORANGE_DRAWN)
    assert alone.disagreement < 2.0
    assert np.abs(errors(touched, center, diameter)).max() < 0.3
    assert touched.disagreement > 1.5 * alone.disagreement


@pytest.mark.parametrize("hidden", [0.15, 0.3])
def test_what_the_border_leaves_of_a_ball_is_measured_with_an_honest_covariance(hidden):
    rng, scores = np.random.default_rng(5), []
    for seed in range(40):
        diameter = 24.0
        center = np.array([diameter * (0.5 - hidden), 30.0]) + rng.uniform(-0.5, 0.5, 2)
        shot = picture(blurred(disc_coverage(SHAPE, center, diameter), 0.5), noise=3.0, seed=seed)
        shot[:, 0] = shot[:, 1]  # the blur came around from the other side
        found = measure_ball(shot, near(center, diameter, rng), ORANGE_DRAWN)
        assert found.disagreement is None
        error = errors(found, center, diameter)
        scores.append(error @ np.linalg.solve(found.covariance, error))
    assert np.median(scores) < 6.0
    assert np.mean(scores) < 12.0


def test_the_offset_of_the_region_is_added_and_nothing_else_changes():
    cover = blurred(disc_coverage(SHAPE, (32.3, 30.2), 20.0), 0.6)
    shot = picture(cover, noise=3.0)
    here = measure_ball(shot, Guess(32.0, 30.0, 19.0), ORANGE_DRAWN)
    there = measure_ball(shot, Guess(432.0, 130.0, 19.0), ORANGE_DRAWN, offset=(400, 100))
    assert (there.x_px - 400, there.y_px - 100) == pytest.approx((here.x_px, here.y_px))
    assert there.radius_px == pytest.approx(here.radius_px)
    np.testing.assert_allclose(there.covariance, here.covariance, rtol=1e-6)


def test_an_ellipse_of_known_shape_is_measured_as_its_circle():
    stretch = np.array([[1.1, 0.04], [0.04, 0.0]])
    stretch[1, 1] = (1 + stretch[0, 1] ** 2) / stretch[0, 0]  # determinant 1
    fine = 8
    down, across = (np.indices((SHAPE[0] * fine, SHAPE[1] * fine)) + 0.5) / fine - 0.5
    places = np.stack([across - 32.3, down - 30.2], axis=-1) @ np.linalg.inv(stretch).T
    inside = np.hypot(places[..., 0], places[..., 1]) < 9.0
    cover = blurred(inside.reshape(SHAPE[0], fine, SHAPE[1], fine).mean(axis=(1, 3)), 0.6)
    found = measure_ball(picture(cover), Guess(32.0, 30.0, 17.0, shape=stretch), ORANGE_DRAWN)
    assert np.abs(errors(found, (32.3, 30.2), 18.0)).max() < 0.02


@pytest.mark.parametrize(
    "shot",
    [
        plain(SHAPE),
        plain(SHAPE, ORANGE),
        np.random.default_rng(6).integers(0, 255, (*SHAPE, 3)).astype(np.uint8),
        picture(disc_coverage(SHAPE, (32, 30), 20.0), colour=(200, 60, 20)),
        np.zeros((2, 2, 3), np.uint8),
        np.zeros((0, 5, 3), np.uint8),
    ],
    ids=["grey", "orange", "noise", "a blue ball", "too small", "empty"],
)
def test_where_there_is_no_ball_there_is_none(shot):
    assert measure_ball(shot, Guess(32.0, 30.0, 20.0), ORANGE_DRAWN) is None


@pytest.mark.parametrize("place", [(-40.0, 30.0), (32.0, 500.0)])
def test_a_guess_outside_the_region_finds_nothing(place):
    assert measure_ball(plain(SHAPE), Guess(*place, 20.0), ORANGE_DRAWN) is None


@pytest.mark.parametrize("guess", [Guess(np.nan, 1.0, 5.0), Guess(1.0, 1.0, 0.0)])
def test_guesses_that_are_none_are_refused(guess):
    with pytest.raises(InputError):
        measure_ball(plain(SHAPE), guess)


@pytest.mark.parametrize(
    "colour", [replace(ORANGE_BALL, levels_bgr=(0, 0, 0)), replace(ORANGE_BALL, tolerance=0.0)]
)
def test_black_balls_and_colours_without_tolerance_are_refused(colour):
    with pytest.raises(InputError, match="ball"):
        measure_ball(plain(SHAPE), Guess(32.0, 30.0, 20.0), colour)


def test_whatever_the_picture_a_ball_is_finite_or_none():
    rng, sides = np.random.default_rng(9), np.arange(50)
    for _ in range(400):
        height, width = rng.choice(sides, 2)
        shot = np.full((height, width, 3), rng.integers(0, 256, 3), np.uint8)
        shot[: height // 2] = rng.integers(0, 256, 3)
        down, across = np.indices((height, width))
        x, y, radius = *rng.uniform(0.0, 50.0, 2), rng.uniform(0.0, 20.0)
        shot[np.hypot(across - x, down - y) < radius] = ORANGE
        guess = Guess(x + rng.normal(0, 2), y + rng.normal(0, 2), 0.1 + 2.2 * radius)
        found = measure_ball(shot, guess, gamma=float(rng.choice([1.0, 2.2])))
        if found is not None:
            assert np.isfinite([found.x_px, found.y_px, found.radius_px]).all()
            assert np.linalg.eigvalsh(found.covariance).min() > 0.0


def test_the_region_around_a_guess_holds_ball_streak_and_ring_within_the_picture():
    assert region_around(Guess(100.0, 50.0, 20.0), 640, 360) == (76, 26, 125, 75)
    x0, _, x1, _ = region_around(Guess(100.0, 50.0, 20.0, streak_px=(10.0, 0.0)), 640, 360)
    assert (x0, x1) == (71, 130)
    x0, y0, x1, y1 = region_around(Guess(2.0, 359.0, 20.0), 640, 360)
    assert (x0, y1) == (0, 360)
    x0, y0, x1, y1 = region_around(Guess(2000.0, -300.0, 20.0), 640, 360)
    assert x0 == x1
    assert y0 == y1


def test_a_rolling_shutter_stretches_a_falling_ball_and_is_undone():
    """A circle whose rows are seen one after the other, each where the ball then is."""
    velocity, row_time, radius = np.array([700.0, 1300.0]), 42e-6, 9.0
    angle = np.linspace(0.0, 2 * np.pi, 2000, endpoint=False)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    rows = y / (1.0 - velocity[1] * row_time)
    outline = np.stack([x + velocity[0] * row_time * rows, rows], axis=-1)
    after = np.roll(outline, -1, axis=0)
    area = 0.5 * abs(np.sum(outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]))
    measured = BallDisc(0, 0, np.sqrt(area / np.pi), np.eye(3), (0.0, 0.0), None, (0, 0, 0))
    undone = without_rolling(measured, velocity[1], row_time)
    assert undone.radius_px == pytest.approx(radius, rel=1e-5)
    assert undone.covariance[2, 2] == pytest.approx(1 - velocity[1] * row_time)
    shape = rolling_shape(np.eye(2), velocity, row_time)
    radii = np.linalg.norm(np.linalg.solve(shape, outline.T), axis=0)
    np.testing.assert_allclose(radii, measured.radius_px, rtol=1e-5)


def test_a_ball_as_fast_as_the_shutter_is_refused():
    disc = BallDisc(0, 0, 9.0, np.eye(3), (0.0, 0.0), None, (0, 0, 0))
    with pytest.raises(InputError, match="rolling"):
        without_rolling(disc, 25_000.0, 42e-6)
