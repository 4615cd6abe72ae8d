import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from vision_drawing import GREY, ORANGE, WHITE, court, plain, with_ball

from rotorpong.conventions import InputError
from rotorpong.vision._search_kernels import find_reach, passes
from rotorpong.vision.colour import COLOURS, Colour
from rotorpong.vision.detect import as_picture, detect, find_balls, find_blobs

PLAUSIBLE = 0.15
CREAM, SKIN = (200, 216, 217), (125, 155, 205)


def only_ball(picture, **options):
    balls = detect(picture, **options)
    assert len(balls) == 1
    return balls[0]


@pytest.mark.parametrize("diameter", [3.0, 4.0, 6.0, 12.0, 40.0, 91.0])
def test_a_drawn_ball_is_found_where_it_is(diameter):
    rng = np.random.default_rng(0)
    for center in np.array([80.0, 60.0]) + rng.uniform(-0.5, 0.5, (10, 2)):
        ball = only_ball(with_ball(plain(), center, diameter))
        assert (ball.x_px, ball.y_px) == pytest.approx(tuple(center), abs=0.5)
        assert ball.diameter_px == pytest.approx(diameter, abs=1.0)
        assert 0.0 < ball.score <= 1.0


@pytest.mark.parametrize(("shape", "least"), [((360, 640), 4.0), ((720, 1280), 5.0)])
def test_a_court_shows_the_ball_and_nothing_else(shape, least):
    rng = np.random.default_rng(1)
    empty = court(rng, shape)
    assert [ball for ball in detect(empty) if ball.score >= PLAUSIBLE] == []
    for diameter in np.linspace(least, 30.0, 12):
        center = rng.uniform((100, 60), (shape[1] - 100, shape[0] - 60))
        balls = [b for b in detect(with_ball(empty, center, diameter)) if b.score >= PLAUSIBLE]
        assert len(balls) == 1
        assert (balls[0].x_px, balls[0].y_px) == pytest.approx(tuple(center), abs=0.8)


def test_three_pixels_are_enough_over_every_part_of_the_court():
    rng = np.random.default_rng(2)
    empty = court(rng)
    for center in ((320.3, 80.2), (320.1, 300.4), (60.2, 250.3), (500.4, 40.1)):
        best = detect(with_ball(empty, center, 3.5))[0]
        assert (best.x_px, best.y_px) == pytest.approx(center, abs=1.0)


@pytest.mark.parametrize("shape", [(360, 640), (720, 1280)])
def test_blobs_are_those_of_a_search_through_the_whole_picture(shape):
    """Two spots of the colour in opposite corners make it search all; both touch the border."""
    rng = np.random.default_rng(6)
    for diameter in (5.0, 9.0, 30.0):
        picture = court(rng, shape)
        for _ in range(3):
            center = rng.uniform((100, 60), (shape[1] - 100, shape[0] - 60))
            picture = with_ball(picture, center, diameter)
        cornered = picture.copy()
        cornered[:2, :2] = cornered[-2:, -2:] = ORANGE
        blobs, others = find_blobs(picture), find_blobs(cornered)
        inner = [blob for blob in others if not blob.on_border]
        assert len(blobs) == len(inner) > 0
        for blob, other in zip(blobs, inner, strict=True):
            np.testing.assert_array_equal(blob.contour, other.contour)
            assert blob.score == other.score


LIMITS = [(colour.core, colour.upper) for colour in COLOURS.values()] + [
    ((0, 30, 40), (28, 200, 220)),
    ((0, 1, 1), (12, 255, 255)),
    ((100, 50, 20), (140, 150, 120)),
]


@pytest.mark.parametrize(("lower", "upper"), LIMITS)
def test_no_pixel_within_a_colours_limits_is_left_out_of_the_search(lower, upper):
    levels = np.concatenate([np.arange(0, 256, 7), [1, 2, 3, 89, 90, 91, 200, 253, 254, 255]])
    cube = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(1, -1, 3)
    cube = cube.astype(np.uint8)
    within = cv2.inRange(cv2.cvtColor(cube, cv2.COLOR_BGR2HSV), lower, upper)[0] > 0
    limits = np.array([lower, upper], np.float32)
    passed = np.array([passes(*pixel, *limits) for pixel in cube[0]])
    assert within.any()
    assert not np.any(within & ~passed)


def test_the_reach_is_the_least_box_around_what_passes():
    rng = np.random.default_rng(7)
    limits = np.array([COLOURS["orange"].core, COLOURS["orange"].upper], np.float32)
    for _ in range(20):
        picture = np.zeros((40, 50, 3), np.uint8)
        spots = rng.integers(0, (40, 50), (rng.integers(0, 5), 2))
        picture[spots[:, 0], spots[:, 1]] = ORANGE
        reach = np.empty(4, np.int64)
        find_reach(reach, picture.reshape(40, 150), *limits)
        if len(spots) == 0:
            assert reach[0] >= reach[2]
        else:
            expected = [*spots.min(axis=0)[::-1], *(spots.max(axis=0)[::-1] + 1)]
            np.testing.assert_array_equal(reach, expected)


@settings(max_examples=30, deadline=None)
@given(st.integers(-60, 60), st.integers(-40, 40))
def test_moving_the_picture_moves_the_ball(right, down):
    here = only_ball(with_ball(plain(), (80.3, 60.4), 14.0))
    there = only_ball(with_ball(plain(), (80.3 + right, 60.4 + down), 14.0))
    moved = (there.x_px - here.x_px, there.y_px - here.y_px)
    assert moved == pytest.approx((right, down), abs=1e-6)
    assert there.diameter_px == pytest.approx(here.diameter_px, abs=1e-6)


def test_twice_the_picture_is_twice_the_ball():
    small = only_ball(with_ball(plain(), (80.0, 60.0), 20.0))
    large = only_ball(with_ball(plain((240, 320)), (160.0, 120.0), 40.0))
    assert large.diameter_px == pytest.approx(2 * small.diameter_px, abs=0.6)
    assert large.score == pytest.approx(small.score, abs=0.1)


def test_the_search_at_half_the_size_finds_the_same_ball():
    picture = with_ball(plain((480, 640)), (300.3, 200.4), 15.0)
    framed = np.pad(picture, ((0, 240), (0, 640), (0, 0)), mode="edge")
    assert only_ball(picture) == only_ball(framed)


def test_best_first_and_a_streak_scores_less_than_a_disc():
    picture = with_ball(plain(), (120.0, 60.0), 20.0)
    for x in range(20, 50):
        picture = with_ball(picture, (float(x), 30.0), 20.0)
    scores = [ball.score for ball in detect(picture)]
    assert len(scores) == 2
    assert scores[0] > 1.5 * scores[1]


@pytest.mark.parametrize("colour", [(0, 0, 0), GREY, (255, 255, 255), (125, 155, 205), ORANGE])
def test_a_picture_of_one_colour_shows_no_ball(colour):
    assert [b for b in detect(plain(colour=colour)) if b.score >= PLAUSIBLE] == []


def test_white_balls_are_found_when_asked_for():
    picture = with_ball(with_ball(plain(), (40.0, 60.0), 16.0), (110.0, 60.0), 16.0, WHITE)
    assert [ball.colour for ball in detect(picture)] == ["orange"]
    assert {ball.colour: round(ball.x_px) for ball in detect(picture, ("orange", "white"))} == {
        "orange": 40,
        "white": 110,
    }
    mine = Colour("mine", (100, 120, 80), (100, 100, 50), (130, 255, 255), (115, 200, 200))
    blue = with_ball(plain(), (70.0, 60.0), 16.0, (200, 80, 30))
    assert only_ball(blue, colours=(mine,)).colour == "mine"


def shaded(picture, center, diameter, colour):
    """Return the picture with a ball lit from above, its lower half in its own shade."""
    drawn = picture.copy()
    for step in np.linspace(0.0, 1.0, 30):
        light = 0.8 + 0.2 * step
        shrunk = diameter * (1.0 - step)
        if shrunk > 1.0:
            place = (center[0], center[1] - 0.25 * (diameter - shrunk))
            drawn = with_ball(drawn, place, shrunk, tuple(light * c for c in colour))
    return drawn


@pytest.mark.parametrize("diameter", [16.0, 24.0, 40.0])
def test_a_white_ball_is_found_on_a_light_floor(diameter):
    rng = np.random.default_rng(8)
    floor = plain((240, 320), CREAM) + rng.normal(0.0, 2.0, (240, 320, 3))
    floor = np.clip(floor, 0, 255).astype(np.uint8)
    best = detect(shaded(floor, (160.3, 120.2), diameter, WHITE), ("white",))[0]
    assert (best.x_px, best.y_px) == pytest.approx((160.3, 120.2), abs=0.15 * diameter)
    assert best.diameter_px == pytest.approx(0.85 * diameter, rel=0.2)  # its shade is the floor's
    assert best.score > PLAUSIBLE


def test_a_ball_in_a_hand_is_found_without_the_hand():
    hand = with_ball(plain((240, 320)), (150.0, 130.0), 70.0, (90, 120, 190))
    best = detect(with_ball(hand, (165.0, 105.0), 30.0))[0]
    assert (best.x_px, best.y_px) == pytest.approx((165.0, 105.0), abs=0.7)
    assert best.diameter_px == pytest.approx(30.0, abs=1.5)
    assert best.score > PLAUSIBLE


def test_a_pale_and_blurred_ball_is_found():
    pale = cv2.GaussianBlur(with_ball(plain(), (80.0, 60.0), 14.0, (95, 150, 230)), (0, 0), 1.5)
    ball = detect(pale)[0]
    assert (ball.x_px, ball.y_px) == pytest.approx((80.0, 60.0), abs=0.5)
    assert ball.diameter_px == pytest.approx(14.0, abs=2.5)
    assert ball.score > PLAUSIBLE


def test_ten_balls_are_found_once_each():
    picture, centers = plain((240, 320)), []
    for i in range(10):
        centers.append((30.0 + 60.0 * (i % 5), 70.0 + 90.0 * (i // 5)))
        picture = with_ball(picture, centers[-1], 12.0 + 2.0 * i)
    found = sorted((ball.y_px > 120, ball.x_px, ball.y_px) for ball in detect(picture))
    assert [place[1:] for place in found] == [pytest.approx(c, abs=0.5) for c in centers]


def test_what_is_no_ball_is_no_confident_guess():
    room = court(np.random.default_rng(3))
    room = with_ball(room, (120.0, 90.0), 50.0, SKIN)  # a face
    cv2.rectangle(room, (400, 60), (480, 170), (40, 40, 200), -1)  # a shirt
    cv2.rectangle(room, (20, 200), (60, 350), (120, 152, 188), -1)  # wood
    cv2.rectangle(room, (540, 40), (550, 300), ORANGE, -1)  # a post
    assert [ball for ball in detect(room) if ball.score > 0.5] == []
    assert max(b.score for b in detect(with_ball(room, (250.0, 250.0), 20.0))) > 0.5


def test_the_quick_search_finds_the_same_balls():
    picture = with_ball(with_ball(plain(), (40.3, 60.4), 16.0), (110.2, 70.1), 24.0)
    quick, thorough = ({round(b.x_px): b for b in f(picture)} for f in (find_balls, detect))
    assert quick.keys() == thorough.keys() == {40, 110}
    for x, ball in quick.items():
        assert (ball.x_px, ball.y_px) == pytest.approx(
            (thorough[x].x_px, thorough[x].y_px), abs=0.2
        )
        assert ball.diameter_px == pytest.approx(thorough[x].diameter_px, abs=1.0)


def test_a_ball_cut_by_the_border_keeps_its_circle():
    ball = only_ball(with_ball(plain(), (8.0, 60.0), 40.0))
    assert (ball.x_px, ball.y_px) == pytest.approx((8.0, 60.0), abs=0.7)
    assert ball.diameter_px == pytest.approx(40.0, abs=1.2)


def test_sixteen_bits_and_alpha_change_nothing():
    picture = with_ball(plain(), (80.0, 60.0), 14.0)
    alpha = np.concatenate([picture, np.full((120, 160, 1), 7, np.uint8)], axis=-1)
    assert detect(picture.astype(np.uint16) * 257) == detect(alpha) == detect(picture)


@settings(max_examples=60, deadline=None)
@given(
    hnp.arrays(
        st.sampled_from([np.uint8, np.uint16]),
        st.one_of(
            hnp.array_shapes(min_dims=2, max_dims=2, max_side=9),
            hnp.array_shapes(min_dims=2, max_dims=2, max_side=9).map(lambda s: (*s, 3)),
            hnp.array_shapes(min_dims=2, max_dims=2, max_side=9).map(lambda s: (*s, 4)),
        ),
    )
)
def test_any_picture_from_one_pixel_up_is_looked_at(picture):
    for ball in detect(picture, ("orange", "white")):
        assert 0.0 < ball.score <= 1.0
        assert np.isfinite([ball.x_px, ball.y_px, ball.diameter_px]).all()


@pytest.mark.parametrize("shape", [(1, 400_000), (400_000, 1), (2, 200_001), (4321, 7681)])
def test_very_long_and_very_large_pictures_are_looked_at(shape):
    assert detect(np.zeros((*shape, 3), np.uint8)) == []


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((4, 4, 2), np.uint8),
        np.zeros((0, 4, 3), np.uint8),
        np.zeros((4, 4, 3), float),
        np.zeros((4, 4), bool),
        np.zeros((2, 4, 4, 3), np.uint8),
        np.zeros(5, np.uint8),
    ],
)
def test_arrays_that_are_no_pictures_are_refused(picture):
    with pytest.raises(InputError, match="expected at least one pixel"):
        as_picture(picture)


def test_an_unknown_colour_names_the_known_ones():
    with pytest.raises(InputError, match="'mauve'; available: orange, white"):
        detect(plain(), ("mauve",))
    with pytest.raises(InputError, match="'mauve'; available: orange, white"):
        find_balls(plain(), ("mauve",))
