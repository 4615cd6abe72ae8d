"""The report: two serves really played, results made up around them."""

import base64
import json
import math
import re
from collections import Counter
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest

from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import OUTCOMES
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demo import _described
from rotorpong.lab.evaluate import Knowledge, make_player
from rotorpong.lab.footage import most_telling, play_again
from rotorpong.lab.report import film_strip, report_page
from rotorpong.lab.report.film import circle_in_picture
from rotorpong.lab.report.view import EYE, TARGET, UP, seen
from rotorpong.lab.report.words import KINDS
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import wilson_interval
from rotorpong.lab.trial import Stage, play_trial
from rotorpong.physics.camera import GAZEBO
from rotorpong.play.hover import Hover
from rotorpong.vision.locate import ball_position

VOID = {"meta", "img", "br", "link", "input"}
Z = 1.959963984540054


@pytest.fixture(scope="module")
def stage():
    spec = Spec()
    return Stage(spec, spec.setting(), serve_source("human", 0), "evaluate")


@pytest.fixture(scope="module")
def player():
    return make_player(Spec(), Knowledge(shipped_demonstrations()[:2]))


@pytest.fixture(scope="module")
def hit(stage):
    index = next(i for i in range(50) if play_trial(stage, i, Hover()).outcome == "hit")
    return play_again(stage, index, Hover())


@pytest.fixture(scope="module")
def miss(stage, player):
    index = next(i for i in range(50) if play_trial(stage, i, player).outcome != "hit")
    return play_again(stage, index, player)


def standing(name, outcomes):
    hits, balls = outcomes.count("hit"), len(outcomes)
    return {
        "name": name,
        "player": name,
        "label": f"{name} <label>",
        "knows": "something & more",
        "eyes": "paper",
        "balls": balls,
        "hits": hits,
        "hit_rate": hits / balls,
        "hit_rate_interval": wilson_interval(hits, balls),
        "miss_distance_median_m": 0.123,
        "outcomes": outcomes,
    }


def results(take, frames):
    kinds = ["miss", "hull", "near_hit", "unseen", "fault"]
    training = (["miss", "hit", "hull"] * 30)[:83]
    return {
        "rotorpong": "0.0.0",
        "command": "rotorpong demo --seed 7",
        "seed": 7,
        "setting": {"vehicle": "a vehicle", "eyes": "paper"},
        "demonstrations": {"pilot": "scripted", "kept": 10, "balls": 37},
        "training": {
            "balls": 83,
            "hits": training.count("hit"),
            "hit_rate": training.count("hit") / 83,
            "outcomes": training,
        },
        "players": [
            standing("hover", ["hit"] * 3 + kinds * 9),
            standing("before", ["hit"] * 8 + kinds * 8),
            standing("after", ["hit"] * 23 + kinds * 5),
        ],
        "comparison": {"won": 17, "lost": 2, "p_value": 0.00073},
        "shown": _described(take, frames),
    }


@pytest.fixture(scope="module")
def report(hit, miss):
    frames = film_strip(hit)
    found = results(hit, frames)
    return found, report_page(found, hit, frames, (miss,))


class Reader(HTMLParser):
    """Collects elements, and complains about tags that do not match."""

    def __init__(self, page):
        super().__init__()
        self.open, self.elements, self.numbers, self.text = [], [], [], ""
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, name, attributes):
        self.elements.append((name, dict(attributes), tuple(self.open)))
        if name == "data":
            self.numbers.append(float(dict(attributes)["value"]))
        if name not in VOID:
            self.open.append(name)

    def handle_startendtag(self, name, attributes):
        self.elements.append((name, dict(attributes), tuple(self.open)))

    def handle_endtag(self, name):
        if self.open.pop() != name:
            raise ValueError(f"</{name}> closes another element")

    def handle_data(self, data):
        self.text += data if "style" not in self.open else ""

    def named(self, name):
        return [attributes for kind, attributes, _ in self.elements if kind == name]


def numbers_in(value):
    if isinstance(value, dict):
        return {n for part in value.values() for n in numbers_in(part)}
    if isinstance(value, list | tuple):
        return {n for part in value for n in numbers_in(part)}
    return {float(value)} if isinstance(value, int | float) else set()


def test_the_page_is_well_formed_and_its_identities_are_unique(report):
    reader = Reader(report[1])
    identities = [a["id"] for _, a, _ in reader.elements if "id" in a]
    assert len(identities) == len(set(identities))
    assert reader.named("html")[0]["lang"] == "en"
    assert len(reader.named("h1")) == 1


def test_the_page_asks_nothing_of_any_network(report):
    reader = Reader(report[1])
    assert not any(reader.named(name) for name in ("script", "link", "iframe", "object", "base"))
    for _, attributes, _ in reader.elements:
        for name in ("src", "href", "srcset", "data", "poster"):
            assert re.match(r"#|data:image/jpeg;base64,", attributes.get(name, "#"))
    assert not re.search(r"https?://|@import|url\((?!#)", report[1])


def test_references_inside_figures_lead_somewhere_on_the_page(report):
    reader = Reader(report[1])
    identities = {a["id"] for _, a, _ in reader.elements if "id" in a}
    wanted = set(re.findall(r'(?:href="|url\()#([\w-]+)', report[1]))
    assert wanted <= identities


def test_every_figure_is_there_with_words_for_who_cannot_see_it(report):
    reader = Reader(report[1])
    names = [figure.get("id") for figure in reader.named("figure")]
    assert set(names) >= {
        "rates", "learning-curve", "film-strip", "paths-in-space", "paths-from-the-side",
        "outcomes", "passes",
    }  # fmt: skip
    assert len(reader.named("figcaption")) == len(names)
    assert all(image["alt"] for image in reader.named("img"))
    drawings = [a for kind, a, above in reader.elements if kind == "svg" and "svg" not in above]
    assert len(drawings) == 4
    assert all(drawing["role"] == "img" and drawing["aria-label"] for drawing in drawings)


def test_every_colour_of_a_figure_is_one_that_the_stylesheet_defines(report):
    defined = set(re.findall(r"(--[\w-]+):", report[1]))
    assert set(re.findall(r"var\((--[\w-]+)\)", report[1])) <= defined
    assert not re.search(r"#[0-9a-f]{2}a5[0-9a-f]{2}", report[1])


def test_every_number_outside_the_training_table_is_one_of_the_results(report):
    found, page = report
    start, end = page.index('<section id="learning">'), page.index('<section id="film">')
    reader = Reader(page[:start] + page[end:])
    counted = {float(n) for p in found["players"] for n in Counter(p["outcomes"]).values()}
    allowed = numbers_in(found) | counted | {0.0}
    assert set(reader.numbers) <= allowed
    for player in found["players"]:
        assert numbers_in({**player, "outcomes": []}) <= set(reader.numbers)


def test_the_blocks_of_the_training_table_add_up(report):
    found, page = report
    start, end = page.index('<section id="learning">'), page.index('<section id="film">')
    hits = Reader(page[start:end]).numbers[::4]
    assert sum(hits) == found["training"]["hits"]


def test_the_bars_are_the_roots_of_wilsons_equation_on_one_scale(report):
    found, page = report
    styles = re.findall(r'class="(?:bar|dot)" style="left:([\d.]+)%(?:;width:([\d.]+)%)?"', page)
    lefts = np.array([float(left) for left, _ in styles]).reshape(3, 2)
    widths = np.array([float(width) for _, width in styles[::2]])
    rates = np.array([player["hit_rate"] for player in found["players"]])
    scale = rates / lefts[:, 1]
    assert np.ptp(scale) < 1e-3 * scale[0]  # two decimals of a percent
    for rate, (low, _), width, player in zip(rates, lefts, widths, found["players"], strict=True):
        share = Z * Z / player["balls"]
        roots = np.sort(np.roots([1 + share, -(2 * rate + share), rate * rate]))
        assert np.array([low, low + width]) * scale[0] == pytest.approx(roots, abs=2e-4)


def test_names_from_the_results_are_escaped(report):
    assert "hover <label>" in Reader(report[1]).text
    assert "hover <label>" not in report[1]


def test_the_verdict_follows_the_numbers(hit, miss):
    frames = film_strip(hit)
    found = results(hit, frames)
    said = {}
    for won, lost, chance in ((17, 2, 0.001), (9, 2, 0.03), (5, 4, 0.9), (1, 9, 0.02)):
        pair = {"won": won, "lost": lost, "p_value": chance}
        page = report_page({**found, "comparison": pair}, hit, frames, (miss,))
        said[won] = re.search(r'class="verdict">([^:]*):', page)[1]
    assert said[17] == "Learning helped"
    assert said[9] == "Learning probably helped"
    assert "chance" in said[5]
    assert "worse" in said[1]


def test_a_run_without_any_hit_shows_a_miss_and_says_so(miss):
    frames = film_strip(miss)
    found = results(miss, frames)
    reader = Reader(report_page(found, miss, frames, ()))
    assert "nearest miss" in reader.text
    assert "It is missed by" in reader.text


def test_the_page_explains_every_outcome_there_is():
    assert set(KINDS) == set(OUTCOMES)


def test_the_film_strip_runs_forward_through_the_flight_and_holds_the_trigger(miss):
    frames = film_strip(miss, 8)
    times = [frame.time for frame in frames]
    assert len(frames) == 8
    assert times == sorted(set(times))
    assert [frame.time for frame in frames if frame.is_trigger] == [miss.trigger.time]
    jpeg = np.frombuffer(base64.b64decode(frames[0].jpeg.partition(",")[2]), np.uint8)
    assert cv2.imdecode(jpeg, cv2.IMREAD_COLOR).shape == (frames[0].height, frames[0].width, 3)


def test_the_circle_drawn_is_the_circle_that_the_estimate_came_from():
    rng = np.random.default_rng(1)
    for pixel, diameter in zip(rng.uniform((0, 0), (639, 359), (20, 2)), range(3, 23), strict=True):
        position = ball_position(GAZEBO, pixel, np.array(float(diameter)))
        center, radius = circle_in_picture(GAZEBO, position)
        assert center == pytest.approx(pixel, abs=1e-6)
        assert 2 * radius == pytest.approx(diameter)


def test_a_serve_played_again_is_the_same_serve(stage, player, miss):
    first = play_trial(stage, miss.played.index, player)
    assert np.array_equal(first.truth.ball_path, miss.played.truth.ball_path)
    assert np.array_equal(first.truth.blade_path, miss.played.truth.blade_path)
    assert miss.trigger is not None
    assert miss.trigger.position[2] < 2.5
    assert any(sight.estimate is not None for sight in miss.sights)


def test_the_true_ball_of_a_take_is_where_the_paths_say(miss):
    for sight in miss.sights[:5]:
        tick = round(1000 * sight.observation.frame_time)
        apart = miss.played.truth.ball_path[tick] - miss.played.truth.body_path[tick]
        level = CAMERA_FROM_BODY_AXES @ (apart - np.array(GAZEBO.position_m))
        assert sight.ball == pytest.approx(level, abs=0.15)  # attitude wobbles by 2 degrees


def test_the_most_telling_serve_is_one_of_those_offered(stage, player):
    assert most_telling(stage, [3], player) == 3
    assert most_telling(stage, [3, 5], player) in {3, 5}


def test_the_onlooker_sees_what_opencv_projects():
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, UP) / math.hypot(*np.cross(forward, UP))
    camera_from_world = np.stack([right, np.cross(forward, right), forward])
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (12, 3))
    turn, _ = cv2.Rodrigues(camera_from_world)
    flat, _ = cv2.projectPoints(points, turn, -camera_from_world @ EYE, np.eye(3), None)
    assert seen(points) * [1, -1] == pytest.approx(flat[:, 0], abs=1e-9)
    assert seen(TARGET) == pytest.approx([0, 0], abs=1e-12)


def test_straight_lines_stay_straight_before_the_onlooker():
    line = np.linspace((-1.0, 0.5, 0.0), (1.0, -0.5, 0.4), 7)
    a, b, *rest = seen(line)
    assert all(abs(np.linalg.det([b - a, point - a])) < 1e-12 for point in rest)


def test_results_survive_json(report):
    found, _ = report
    assert numbers_in(json.loads(json.dumps(found))) == numbers_in(found)
