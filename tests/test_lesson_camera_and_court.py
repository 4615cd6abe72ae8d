"""The first lesson quotes what its script prints and names the product's constants."""

import re

import pytest
from lesson_pages import NUMBER, in_words, page, printed, says

from rotorpong.physics.ball import TABLE_SURFACE, Air

LESSON = "camera_and_court"
SAME = (  # a line that the lesson's script prints, and what the page makes of its numbers
    (f"X {NUMBER} m, Y {NUMBER} m, Z {NUMBER} m", "[{0:.1f}, {1:.2f}, {2:.2f}]"),
    (f"x {NUMBER} px, y {NUMBER} px, diameter {NUMBER} px", "[{0:.1f}, {1:.1f}]"),
    (f"x {NUMBER} px, y {NUMBER} px, diameter {NUMBER} px", "\n{2:.2f} px\n"),
    (rf"by Eq. \(1\): d = {NUMBER} m", "\n{0:.3f} m\n"),
    (f"distortion at 10 degrees: {NUMBER} px", "\n10 degrees from the axis: {0:.0f} px\n"),
    (f"distortion at 20 degrees: {NUMBER} px", "\n20 degrees from the axis: {0:.0f} px\n"),
    (f"distortion at 30 degrees: {NUMBER} px", "\n30 degrees from the axis: {0:.0f} px\n"),
    (f"yaw 30 degrees/s: a post leans by {NUMBER} px", "ball's picture by {0:.1f} px between"),
    (f"smear at 1 m, 2 m/s across, 10 ms: {NUMBER} px", "\n{0:.1f} px\n"),
    (f"a parabola: after 0.5 s x {NUMBER} m", "\n{0:.2f} m, -"),
    (f"drag: after 0.5 s x {NUMBER} m", " m, {0:.2f} m\n"),
    (f"drag at 7 m/s: {NUMBER} m", "\n{0:.2f} m/s^2\n"),
    (f"Magnus at 7 m/s, 100 rad/s: {NUMBER} m", "\n{0:.2f} m/s^2\n"),
    (rf"bounces to \[{NUMBER}, 0.0, {NUMBER}\]", "\n([{0:.2f}, 0.0, {1:.2f}], "),
    (rf"and \[0.0, {NUMBER}, 0.0\] rad/s", ", [0.0, {0:.1f}, 0.0])\n"),
    (f"impulse {NUMBER} of", "= {0:.2f} m/s, and grip would need"),
    (f"impulse {NUMBER} of", "slips, loses {0:.2f} m/s and"),
    (f"gazebo: 0.1 px at 2.5 m is {NUMBER} cm of depth", "\nf 374.7 px: depth {0:.1f} cm, sid"),
    (f"ardrone2_720p: 0.1 px at 2.5 m is {NUMBER} cm", "\nf 1124.0 px: depth {0:.1f} cm, sid"),
)


@pytest.fixture(scope="module")
def said():
    return printed(LESSON)


@pytest.mark.parametrize(("line", "words"), SAME, ids=[words for _, words in SAME])
def test_the_page_says_the_numbers_that_the_script_prints(said, line, words):
    assert says(LESSON, in_words(said, line, words))


def test_what_the_page_says_of_spin_is_what_the_script_prints(said):
    heights = dict(re.findall(rf"(drag.*): after 0.5 s .* z {NUMBER} m", said))
    lost = float(heights["drag"]) - float(heights["drag and topspin, 100 rad/s"])
    assert f"takes another {100 * lost:.0f} cm of\nheight" in page(LESSON)
    wrong = re.search(rf"speed error {NUMBER} cm/s", said)[1]
    assert f"\n{float(wrong) / 100:.2f} m/s\n" in page(LESSON)


def test_the_page_names_the_constants_of_the_product():
    text = page(LESSON)
    air, (restitution, friction) = Air(), TABLE_SURFACE
    assert (
        f"with k = {air.drag} per metre, m = {air.magnus}, s = {air.saturation} and "
        f"c = {air.spin_decay} per second"
    ) in text
    assert f"{friction} (1 + {restitution}) 2 = " in text
    assert not re.search(r"Air\([^)]|Surface\(0", text)  # the blocks take no constants of their own
