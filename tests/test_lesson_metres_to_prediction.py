"""The lesson on prediction: its page says what its script prints, and what the product holds."""

import importlib.util
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from lesson_pages import FOLDER

from rotorpong.conventions import GRAVITY
from rotorpong.physics.ball import TABLE_SURFACE
from rotorpong.vision.flight_filter import HUMAN_PRIOR, TUM_ATTITUDE, Belief, crossing, ground
from rotorpong.world.racket import Racket

SCRIPT = FOLDER / "metres_to_prediction.py"
PAGE = " ".join(SCRIPT.with_suffix(".md").read_text().split())  # wherever its lines are broken
N = r"(-?[0-9.]+)"
SAME = (  # a line that the script prints, and what the page makes of its numbers
    (f"two frames at 2.5 m: {N} m/s", " {0:.2f} m/s ``` Here are the speeds"),
    (f"vx after 6 sights, {N} m away", "| 6 sights, {0:.2f} m away | 13 sights"),
    (f"vx after 13 sights, {N} m away", "| 13 sights, {0:.2f} m away |"),
    (f"a point 2.5 m away: {N} mm deep, {N} mm", " {0:.1f} mm along the line of sight, {1:.2f} mm"),
    (f"depth after 5 sights, the disc.*: {N} cm", "by a line through its depths, has {0:.2f} cm, "),
    (f"depth after 8 sights, the disc.*: {N} cm", " cm, {0:.2f} cm and "),
    (f"depth after 13 sights, the disc.*: {N} cm", " cm and {0:.2f} cm. The fall is no help"),
    (f"depth after 5 sights, the fall.*: {N} cm", " 5 sights: fall alone {0:.1f} cm, "),
    (f"depth after 8 sights, the fall.*: {N} cm", " 8 sights: fall alone {0:.1f} cm, "),
    (f"depth after 13 sights, the fall.*: {N} cm", " 13 sights: fall alone {0:.1f} cm, "),
    (f"depth after 5 sights, both.*: {N} cm", " cm, fall and disc {0:.2f} cm 8 sights"),
    (f"depth after 8 sights, both.*: {N} cm", " cm, fall and disc {0:.2f} cm 13 sights"),
    (f"depth after 13 sights, both.*: {N} cm", " cm, fall and disc {0:.2f} cm ```"),
    (f"NIS of 8 sights: {N} to {N}", " {0:.2f} < 3.15 < {1:.2f} "),
    (f"in its band, 1° of tilt, untold: {N} %", "NIS is in the band in {0:.0f} % of serves"),
    (f"walk untold, filter: NIS {N}", "that of the filter without slack is {0:.0f}.)"),
    (f"crossing: sideways sd {N} mm, of the cloud {N}", " sd {0:.1f} mm left, 13.2 mm up, "),
    (f"crossing: sideways sd {N} mm, of the cloud {N}", " sd {1:.1f} mm left, 12.9 mm up ```"),
    (f"crossing: height sd {N} mm, of the cloud {N}", " mm left, {0:.1f} mm up, 21.3 ms"),
    (f"crossing: height sd {N} mm, of the cloud {N}", " mm left, {1:.1f} mm up ```"),
    (f"within the ellipse of 2 sd: {N} %", "{0:.0f} % of the balls pass within the ellipse"),
)
SPEEDS = (
    ("finite differences", ".0f"),
    ("Kalman filter of metres", ".0f"),
    ("flight filter", ".1f"),
)
MISSES = (
    ("finite differences", "finite differences, flown on by the same laws"),
    ("flight filter", "flight filter"),
    ("flight filter: what it claims", "what the flight filter claims"),
)
CAUSES = (
    ("sights", "what the sights left open"),
    ("restitution", "restitution, sd 0.02"),
    ("friction", "friction, sd 0.05"),
    ("table", "height of the table, sd 1 cm"),
)
TOLD = (
    ("told the truth", "told the truth"),
    ("half the noise", "told half the noise"),
    ("tilt untold", "tilt of 1° about x and y, untold"),
    ("tilt told", "told: filter"),
    ("tilt told, renewed", "told: filter that is renewed twice"),
    ("tilt told, window", "told: window"),
    ("tilt told, level read", "told, and the level read once, sd 0.2°"),
)
WALKED = (
    ("walk untold, window", "nothing | window"),
    ("walk untold, filter", "nothing | filter"),
    ("walk untold, slack filter", "nothing, but slack of 0.3 m/s² per root hertz | filter"),
    ("walk told as white, window", "its size, as if white | window"),
    ("walk told, filter", "all | filter"),
    ("walk told, window", "all | window"),
)


@pytest.fixture(scope="module")
def lesson():
    spec = importlib.util.spec_from_file_location(SCRIPT.stem, SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """What the script prints, in a process of its own: without checks of shapes it takes half."""
    images = tmp_path_factory.mktemp("figures")
    run = (
        "import sys, pathlib, metres_to_prediction as lesson\n"
        "lesson.IMAGES = pathlib.Path(sys.argv[1])\n"
        "lesson.main()\n"
    )
    places = os.pathsep.join(
        [str(SCRIPT.parent), *(str(Path(place).resolve()) for place in sys.path)]
    )
    done = subprocess.run(
        [sys.executable, "-c", run, str(images)],
        env={**os.environ, "PYTHONPATH": places},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len(list(images.glob("*.png"))) == 6
    return done.stdout


def found(pattern, printed):
    return [float(number) for number in re.search(pattern, printed, re.MULTILINE).groups()]


def means(name, printed):
    """Return NIS, NEES, x, z (cm), vx and vz (cm/s) of a case."""
    numbers = rf"NIS ([0-9.]+|nan), NEES {N}, x {N} cm, z {N} cm, vx {N} cm/s, vz {N} cm/s"
    return found(f"^{name}: {numbers}", printed)


def two_digits(number):
    return f"{number:.1f}" if number < 100.0 else f"{float(f'{number:.1e}'):.0f}"


@pytest.mark.parametrize(("line", "words"), SAME, ids=[words for _, words in SAME])
def test_the_page_says_the_numbers_that_the_script_prints(printed, line, words):
    assert words.format(*found(line, printed)) in PAGE


@pytest.mark.parametrize(("name", "digits"), SPEEDS)
def test_the_table_of_speeds_is_the_scripts(printed, name, digits):
    far = found(rf"vx after 6 sights, .* away, {name}: {N} cm/s", printed)[0]
    near = found(rf"vx after 13 sights, .* away, {name}: {N} cm/s", printed)[0]
    assert re.search(rf"\| {name}( \(section 4\))? \| {far:.0f} \| {near:{digits}} \|", PAGE)


@pytest.mark.parametrize(("name", "row"), TOLD)
def test_the_table_of_consistency_is_the_scripts(printed, name, row):
    nis, nees, _, z, _, vz = means(name, printed)
    end = f"{two_digits(nees)} | {z:.2f} | {vz:.1f} |"
    if math.isnan(nis):  # a window predicts no sight
        assert f"| {row} | | {end}" in PAGE
    else:
        assert f"| {row} | {nis:.1f} | {end}" in PAGE


@pytest.mark.parametrize(("name", "row"), WALKED)
def test_the_table_of_the_walk_is_the_scripts(printed, name, row):
    _, nees, _, _, vx, vz = means(name, printed)
    assert f"| {row} | {vx:.1f} | {vz:.1f} | {two_digits(nees)} |" in PAGE


@pytest.mark.parametrize(("name", "row"), CAUSES)
def test_the_table_of_the_bounce_is_the_scripts(printed, name, row):
    height, time = found(rf"at the plane, {name}: {N} mm, {N} ms", printed)
    assert f"| {row} | {height:.1f} | {time:.1f} |" in PAGE


@pytest.mark.parametrize(("name", "row"), MISSES)
def test_the_table_of_misses_is_the_scripts(printed, name, row):
    early, late = (
        found(rf"miss after {n} sights, {name}: median {N} cm", printed)[0] for n in (8, 13)
    )
    assert f"| {row} | {early:.1f} | {late:.1f} |" in PAGE


def test_what_the_page_concludes_from_its_numbers_holds(printed):
    sideways, cloud = found(rf"crossing: sideways sd {N} mm, of the cloud {N}", printed)
    assert cloud / sideways == pytest.approx(7 / 6, abs=0.03)
    loses = (
        means("walk untold, window", printed)[4] / means("walk untold, slack filter", printed)[4]
    )
    assert loses == pytest.approx(3.0, abs=0.3)
    window, bound = found(rf"height after 13 sights, window: {N} cm, bound {N} cm", printed)
    assert window == pytest.approx(bound, rel=0.10)  # 2 sd of an rms over 200 serves
    assert found(rf"height after 13 sights, filter: {N} cm", printed)[0] > 1.15 * bound
    early = found(rf"miss after 8 sights, finite differences: median {N} cm", printed)[0]
    assert early > 100 * Racket().half_height


def test_the_page_names_the_constants_of_the_product(lesson):
    (e, e_sd), (mu, mu_sd) = HUMAN_PRIOR.restitution, HUMAN_PRIOR.friction
    assert (e, mu) == TABLE_SURFACE
    assert f"restitution, sd {e_sd}" in PAGE
    assert f"friction, sd {mu_sd}" in PAGE
    assert f"height of the table, sd {100 * HUMAN_PRIOR.table[1]:.0f} cm" in PAGE
    assert f"by {math.degrees(TUM_ATTITUDE.walk):.2f}° per root second" in PAGE
    assert f"A blade of {200 * Racket().half_width:.0f} cm forgives" in PAGE
    assert f"Statistics are over {lesson.SERVES} serves" in PAGE
    assert f"slack of {lesson.SLACK} m/s²" in PAGE
    lean = GRAVITY * math.sin(lesson.TILT)
    assert (
        f"That is {lean:.2f} m/s² along the line of sight, or {50 * lean * 0.4**2:.1f} cm" in PAGE
    )


def test_the_bend_of_a_parabola_is_found_as_well_as_the_page_says():
    """The closed form is that of many directions; 200 are within 2 % of it."""
    count, span, sd = 200, 0.4, 3e-4
    times = span * (np.arange(count) + 0.5) / count
    design = np.stack([np.ones(count), times, 0.5 * times**2], axis=1)
    variance = sd**2 * np.linalg.inv(design.T @ design)[2, 2]
    assert variance == pytest.approx(720.0 * sd**2 / (count * span**4), rel=0.02)


def test_the_lessons_flight_to_the_blade_is_the_filters(lesson):
    start = ground(lesson.KNOWN, 0.0)
    mean = start.mean.copy()
    mean[:6] = np.concatenate([lesson.THROWN.position, lesson.THROWN.velocity])
    there = crossing(Belief(0.0, mean, start.covariance), *lesson.BLADE, lesson.KNOWN)
    time, place = lesson.at_blade(lesson.THROWN, TABLE_SURFACE, 0.0)
    assert there.position == pytest.approx(place, abs=1e-5)
    assert there.time == pytest.approx(time, abs=1e-5)


def test_the_bound_of_the_lesson_is_what_slopes_of_its_sights_say(lesson):
    """By differences of the exact sights alone; the prior, wide as it is, moves it by a percent."""

    def flown(start):
        return lesson.flown(lesson.Ball(start[:3], start[3:6], start[6:]))

    def seen(start):
        return lesson.look(flown(start)[:, :3], np.zeros((lesson.FRAMES, 3))).ravel()

    def end(start):
        return flown(start)[-1]

    thrown, spin = lesson.THROWN, np.zeros(3)
    start = np.concatenate([thrown.position, thrown.velocity, spin])
    nudges = np.diag([1e-5] * 3 + [1e-4] * 3 + [1e-2] * 3)
    slopes = np.array([(seen(start + n) - seen(start - n)) / (2 * n.sum()) for n in nudges])
    carry = np.array([(end(start + n) - end(start - n)) / (2 * n.sum()) for n in nudges])
    prior = np.diag(np.array([4.0] * 3 + [3.0, 1.5, 3.0] + [lesson.SPIN_SD] * 3) ** -2)
    information = (slopes / np.tile(lesson.SDS**2, lesson.FRAMES)) @ slopes.T + prior
    bound = carry.T @ np.linalg.inv(information) @ carry
    expected = np.sqrt(np.diag(lesson.bound(lesson.FRAMES)))
    assert np.sqrt(np.diag(bound)) == pytest.approx(expected, rel=0.02)
