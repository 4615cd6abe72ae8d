"""Labelled pictures: how they are read, and what is counted as found."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotorpong.conventions import InputError
from rotorpong.lab.bench import image_rows
from rotorpong.lab.bench.image_rows import Matches
from rotorpong.lab.bench.suites import SUITES, Order
from rotorpong.lab.picture_sets import read_picture_sets
from rotorpong.vision.detect import Detection

SIZE = (160, 120)
BALLS = [(40.0, 50.0, 18.0), (110.0, 70.0, 24.0)]  # centre from the picture's edge, diameter


def quiet(done, total):
    pass


def write_picture(path, balls=BALLS, labels=None, shown=None):
    """Write a picture of orange balls and where they are, or what is said about it."""
    picture = np.full((SIZE[1], SIZE[0], 3), (110, 100, 90), np.uint8)
    for x, y, diameter in balls if shown is None else shown:
        rows, columns = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
        picture[np.hypot(columns - x, rows - y) <= diameter / 2] = (20, 115, 245)
    cv2.imwrite(str(path), picture)
    lines = [f"0 {x / 160} {y / 120} {d / 160} {d / 120}" for x, y, d in balls]
    path.with_suffix(".txt").write_text("\n".join(lines) if labels is None else labels)


def values(folder, **options):
    return {row.name: row.value for row in image_rows.rows(folder, quiet, **options)}


def test_balls_where_the_labels_say_are_all_found(tmp_path):
    for i in range(6):
        write_picture(tmp_path / f"{i}.png", [(x + i, y, d) for x, y, d in BALLS])
    found = values(tmp_path, colour="orange")
    name = f"images: {tmp_path.name}, orange: "
    assert found[name + "balls"] == 12
    for what in ("recall at precision 0.95", "held-out recall", "average precision"):
        assert found[name + what] == 1.0
    assert found[name + "overlap, median"] > 0.9
    assert found[name + "centre error, median"] < 0.2
    assert found[name + "diameter ratio, median"] == pytest.approx(1.0, abs=0.05)


def test_a_ball_that_is_not_labelled_costs_precision_and_one_not_shown_recall(tmp_path):
    write_picture(tmp_path / "0.png", BALLS[:1], shown=BALLS)
    write_picture(tmp_path / "1.png", BALLS, shown=BALLS[:1])
    found = values(tmp_path, colour="orange")
    name = f"images: {tmp_path.name}, orange: "
    assert found[name + "balls"] == 3
    assert found[name + "recall at precision 0.95"] < 1.0
    assert found[name + "average precision"] < 1.0


def test_every_folder_is_a_set_and_both_colours_are_looked_for(tmp_path):
    for name in ("near", "far"):
        (tmp_path / name).mkdir()
        write_picture(tmp_path / name / "a.jpg")
    (tmp_path / "empty").mkdir()
    names = values(tmp_path)
    for one in ("near", "far"):
        for colour in ("orange", "orange,white"):
            assert names[f"images: {one}, {colour}: pictures"] == 1


def test_the_balls_class_is_asked_for_only_where_there_are_several(tmp_path):
    write_picture(tmp_path / "a.png", labels="3 0.5 0.5 0.1 0.1")
    assert read_picture_sets(tmp_path)[0].balls == 1
    write_picture(tmp_path / "b.png", labels="1 0.5 0.5 0.1 0.1\n1 0.2 0.5 0.1 0.1")
    with pytest.raises(InputError, match=r"classes 1 \(2 boxes\), 3 \(1 boxes\); expected"):
        read_picture_sets(tmp_path)
    assert read_picture_sets(tmp_path, 1)[0].balls == 2
    with pytest.raises(InputError, match="ball class 2; its labels are of classes 1"):
        read_picture_sets(tmp_path, 2)


BAD = {
    "0 0.5 0.5 0.1": "line 1: 4 fields; expected 'class x y width height'",
    "\n0 0.5 0.5 0.1 up": "line 2: 'up'; expected a finite number",
    "0 0.5 nan 0.1 0.1": "'nan'; expected a finite number",
    "0.5 0.5 0.5 0.1 0.1": "class 0.5; expected a whole number",
    "-1 0.5 0.5 0.1 0.1": "class -1; expected a whole number",
    "0 50 50 10 10": "expected shares of the picture",
    "0 0.5 0.5 0 0.1": "expected shares of the picture",
    "": "no label holds a box",
}


@pytest.mark.parametrize("labels", BAD)
def test_labels_that_are_none_are_refused(tmp_path, labels):
    write_picture(tmp_path / "a.png", labels=labels)
    with pytest.raises(InputError, match=BAD[labels].replace("(", r"\(")):
        read_picture_sets(tmp_path)


def test_a_folder_without_pictures_labels_or_whole_files_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected a folder of pictures"):
        read_picture_sets(tmp_path / "gone")
    with pytest.raises(InputError, match="no picture in it"):
        read_picture_sets(tmp_path)
    write_picture(tmp_path / "a.png")
    (tmp_path / "b.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"b\.png: no labels b\.txt beside it"):
        read_picture_sets(tmp_path)
    (tmp_path / "b.txt").write_text("")
    with pytest.raises(InputError, match=r"b\.png: not a picture"):
        image_rows.rows(tmp_path, quiet)
    with pytest.raises(InputError, match="mauve"):
        image_rows.require(tmp_path, None, "mauve")


def test_an_order_for_pictures_is_checked_before_all_measuring(tmp_path):
    assert [section.title for section in SUITES["eyes"]][-1] == "images"
    with pytest.raises(InputError, match="expected a folder of pictures"):
        Order("eyes", images=tmp_path / "gone").check()
    with pytest.raises(InputError, match="--images with bench world: belongs to bench eyes"):
        Order("world", images=tmp_path).check()
    for options in ({"ball_class": 0}, {"colour": "white"}):
        with pytest.raises(InputError, match="expected --images beside it"):
            Order("eyes", **options).check()


def test_a_box_is_taken_once_and_by_the_best_score():
    boxes = np.array([[10.0, 10.0, 20.0, 20.0]])
    near, exact = Detection(15.5, 14.5, 10.0, 0.9, "orange"), Detection(14.5, 14.5, 10.0, 0.4, "x")
    found = image_rows.match([exact, near], boxes)
    assert found.score.tolist() == [0.9, 0.4]
    assert found.right.tolist() == [True, False]
    assert found.away_px[0] == pytest.approx(1.0)
    assert found.overlap[0] == pytest.approx(9 / 11)
    assert image_rows.match([exact], boxes).overlap[0] == pytest.approx(1.0)


def matches(scores, right, missed=0):
    order = np.argsort(-np.array(scores), kind="stable")
    nothing = np.full(len(scores), np.nan)
    score, hit = np.array(scores, float)[order], np.array(right, bool)[order]
    return Matches(score, hit, nothing, nothing, nothing, int(hit.sum()) + missed)


DETECTIONS = st.lists(st.tuples(st.integers(0, 9), st.booleans()), min_size=1, max_size=30)


@settings(max_examples=100, deadline=None)
@given(DETECTIONS, st.integers(0, 5))
def test_the_threshold_is_the_lowest_of_all_that_are_precise_enough(pairs, missed):
    found = matches([score / 10 for score, _ in pairs], [hit for _, hit in pairs], missed)
    precise = [
        score
        for score in set(found.score.tolist())
        if found.right[found.score >= score].mean() >= 0.95
    ]
    threshold = image_rows.threshold_at(found, 0.95)
    assert threshold == min(precise, default=np.inf)
    recall, precision = image_rows.at_threshold(found, threshold)
    assert precision >= 0.95
    assert recall == found.right[found.score >= threshold].sum() / max(found.balls, 1)
    assert 0.0 <= image_rows.average_precision(found) <= 1.0


def test_held_out_pictures_get_the_threshold_of_the_others():
    same = [matches([0.9, 0.3], [True, True]) for _ in range(10)]
    assert image_rows.held_out(same) == (1.0, 1.0)
    odd = [*same[:8], *(matches([0.9, 0.8], [False, False], missed=2) for _ in range(2))]
    recall, precision = image_rows.held_out(odd)  # what the others are sure of is wrong in these
    assert precision < image_rows.at_threshold(image_rows.pooled(same), 0.0)[1]
    assert recall <= 0.8
