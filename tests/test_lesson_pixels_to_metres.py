"""The lesson from pixels to metres quotes what its script prints."""

import re

import pytest
from lesson_pages import NUMBER, in_words, page, printed, says

from rotorpong.vision.matte import ORANGE_BALL
from rotorpong.vision.measure import OUTLINE_BIAS_PX

LESSON = "pixels_to_metres"
AT_REST_AND_MOVING = f"{NUMBER} cm at rest, {NUMBER} cm at 22 px"
SAME = (  # a line that the lesson's script prints, and what the page makes of its numbers
    (f"true: {NUMBER} m, diameter {NUMBER} px", "\n{0:.3f} m, {1:.2f} px\n"),
    (f"true: {NUMBER} m, diameter {NUMBER} px", "The ball is {0:.3f} m away"),
    (f"true: {NUMBER} m, diameter {NUMBER} px", "It should be {1:.2f} px wide"),
    (f"fitted: diameter {NUMBER} px, d = {NUMBER} m", "\n{0:.2f} px, so {1:.2f} m\n"),
    (f"fitted: diameter {NUMBER} px, d = {NUMBER} m", "and the circle says {1:.2f} m"),
    (f"whole: diameter {NUMBER} px, d = {NUMBER} m", "\n{1:.2f} m\n"),
    (f"pratt: diameter {NUMBER} px", "\npratt: {0:.2f} px\n"),
    (f"geometric: diameter {NUMBER} px", "\ngeometric: {0:.2f} px\n"),
    (f"one pixel of diameter at 2.5 m: {NUMBER} cm", "\n{0:.0f} cm\n"),
    (f"float, 2.25 to 2.75 m: mean error {NUMBER} cm", "circle is {0:.0f} cm too far on average"),
    (f"bias, 2.25 to 2.75 m: mean error {NUMBER} cm", "and still {0:.0f} cm with"),
    (f"kasa: .* a sixth -{NUMBER} px", "Kasa's circle is {0:.2f} px too small"),
    (f"pratt: .* a sixth -{NUMBER} px", "and Pratt's {0:.2f} px."),
    (f"ideal, .*: -{NUMBER} px, sd", "outline lacks {0:.2f} px of radius at 2.5 m"),
    (f"gamma 1, .*: -{NUMBER} px, sd", "lens and noise {0:.2f} px"),
    (f"gamma 2.2, .*: -{NUMBER} px, sd {NUMBER}", "its gamma {0:.2f} px, and that with a spread"),
    (f"gamma 2.2, .*: -{NUMBER} px, sd {NUMBER}", "a spread of {1:.2f} px"),
    (f"one background: {NUMBER} px", "goes from {0:.2f} px to"),
    (f"24 sectors, scatter: {NUMBER} px of {NUMBER} px", " to {0:.2f} px, of {1:.2f} px"),
    (f"hall, one level: .* 90 % {NUMBER} cm", "it puts {0:.1f} cm or more from"),
    (f"at 2.5 m: circle {NUMBER} cm", "the circle spreads by {0:.2f} cm even"),
    (f"at 2.5 m: .*area {NUMBER} cm, edge {NUMBER}", "the area by {0:.2f} cm, the edge by {1:.2f}"),
    (f"at 2.5 m: .*bound {NUMBER} cm", "the bound is at {0:.2f} cm"),
    (f"the bound as its sd: {NUMBER} % beyond 3 sd", " {0:.0f} % of all balls beyond 3 sd"),
    (f"its own covariance: {NUMBER} % beyond 3 sd", "has {0:.0f} % there"),
    (f"at 20 degrees: {NUMBER} m by", "\n{0:.2f} m\n2.50 m\n"),
    (f"0.2 m at 20 degrees.*: {NUMBER} mm", "leaves {0:.1f} mm at 20 cm"),
    (f"circle: {AT_REST_AND_MOVING}", "errs by {0:.1f} cm at rest"),
    (f"circle: {AT_REST_AND_MOVING}", "and by {1:.1f} cm at 22 px"),
    (f"area: {AT_REST_AND_MOVING}", "the area by {0:.1f} cm and {1:.1f} cm"),
    (f"edge: {AT_REST_AND_MOVING}", "exposure, by {0:.1f} cm and {1:.1f} cm"),
    (f"measured at 22 px: {NUMBER} of {NUMBER} balls", "only {0:.0f} of {1:.0f} balls"),
    (
        f"balls, {NUMBER} when told",
        "Told the streak beforehand (`Guess.streak_px`), it measures {0:.0f}.",
    ),
    (f"{NUMBER} px/s, area x {NUMBER}", "\n{0:.0f} px/s: area x {1:.3f}, "),
    (f"too near by {NUMBER} cm", "seems {0:.1f} cm too near\n"),
)
ROWS = {  # of the page's table, by what the script calls them
    "one level": "one level",
    "sectors": "sectors",
    "one, scatter": "one level, scatter in S",
    "sectors, scatter": "sectors, scatter in S",
    "edge": "edge of the matte",
}


@pytest.fixture(scope="module")
def said():
    return printed(LESSON)


@pytest.mark.parametrize(("line", "words"), SAME, ids=[words for _, words in SAME])
def test_the_page_says_the_numbers_that_the_script_prints(said, line, words):
    assert says(LESSON, in_words(said, line, words))


@pytest.mark.parametrize(("name", "row"), ROWS.items())
def test_the_table_of_mattes_is_what_the_script_prints(said, name, row):
    line = f"{name}: median {NUMBER} cm, 90 % {NUMBER} cm"
    cells = [
        f"{number} cm"
        for place in ("grey", "hall")
        for number in re.search(f"{place}, {line}", said).groups()
    ]
    assert f"\n| {row} | {' | '.join(cells)} |\n" in page(LESSON)


def test_the_four_fits_lie_as_far_apart_and_lack_as_much_as_the_page_says(said):
    found = re.findall(rf"^(?:kasa|pratt|taubin|geometric): diameter {NUMBER} px", said, re.M)
    widths = [float(number) for number in found]
    whole = float(re.search(f"true: .* diameter {NUMBER} px", said)[1])
    apart = max(widths) - min(widths)
    assert says(LESSON, f"They differ by {apart:.2f} px, and")
    assert says(LESSON, f"Four fits, {apart:.2f} px apart, on an outline that lacks")
    assert says(LESSON, f"lacks {whole - widths[0]:.2f} px. Ask")


def test_the_page_names_the_constants_of_the_product():
    assert says(LESSON, f"the {OUTLINE_BIAS_PX} px added")
    shading = ORANGE_BALL.shading
    assert says(LESSON, f"({shading} B b)({shading} B b)^T")
    assert says(LESSON, f"shading = {shading}**2")
