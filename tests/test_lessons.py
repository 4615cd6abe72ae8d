"""Lessons say what the code says: their blocks of code run, and print what they print."""

import doctest
import importlib.util
import re
from pathlib import Path

import pytest

from rotorpong.physics.ball import TABLE_SURFACE, Air

LESSONS = sorted((Path(__file__).resolve().parents[1] / "docs" / "lessons").glob("*.md"))
EACH = pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)


def test_there_are_lessons():
    assert LESSONS


@EACH
def test_the_code_of_a_lesson_prints_what_the_page_says(lesson):
    done = doctest.testfile(str(lesson), module_relative=False)
    assert done.attempted > 10
    assert done.failed == 0


@EACH
def test_every_figure_of_a_lesson_is_there_and_small(lesson):
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", lesson.read_text())
    assert 4 <= len(shown) <= 6
    for name in shown:
        figure = lesson.parent / name
        assert figure.read_bytes().startswith(b"\x89PNG")
        assert figure.stat().st_size < 100_000


@EACH
def test_a_lesson_has_code_that_draws_its_figures(lesson):
    code = lesson.with_suffix(".py").read_text()
    for name in re.findall(r"images/lessons/(\w+)\.png", lesson.read_text()):
        assert f"def {name}(" in code


NUMBER = r"(-?[0-9.]+)"
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
def printed(tmp_path_factory):
    """What the script of the lesson prints, by the product's own constants."""
    path = LESSONS[0].with_name("camera_and_court.py")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.IMAGES = tmp_path_factory.mktemp("figures")
    said = []
    module.print = said.append
    module.main()
    return "\n".join(said)


@pytest.mark.parametrize(("line", "words"), SAME, ids=[words for _, words in SAME])
def test_the_page_says_the_numbers_that_the_script_prints(printed, line, words):
    numbers = map(float, re.search(line, printed).groups())
    assert words.format(*numbers) in (LESSONS[0].with_name("camera_and_court.md")).read_text()


def test_what_the_page_says_of_spin_is_what_the_script_prints(printed):
    page = LESSONS[0].with_name("camera_and_court.md").read_text()
    heights = dict(re.findall(rf"(drag.*): after 0.5 s .* z {NUMBER} m", printed))
    lost = float(heights["drag"]) - float(heights["drag and topspin, 100 rad/s"])
    assert f"takes another {100 * lost:.0f} cm of\nheight" in page
    wrong = re.search(rf"speed error {NUMBER} cm/s", printed)[1]
    assert f"\n{float(wrong) / 100:.2f} m/s\n" in page


def test_the_page_names_the_constants_of_the_product():
    page = LESSONS[0].with_name("camera_and_court.md").read_text()
    air, (restitution, friction) = Air(), TABLE_SURFACE
    assert (
        f"with k = {air.drag} per metre, m = {air.magnus}, s = {air.saturation} and "
        f"c = {air.spin_decay} per second"
    ) in page
    assert f"{friction} (1 + {restitution}) 2 = " in page
    assert not re.search(r"Air\([^)]|Surface\(0", page)  # the blocks take no constants of their own
