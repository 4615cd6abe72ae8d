"""What serves are like, against the ranges they are drawn from."""

import json

import pytest

from rotorpong import __version__
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.serve_files import SERVE_COLUMNS
from rotorpong.lab.serve_stats import serve_stats
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import wilson_interval


@pytest.fixture(scope="module")
def human():
    told = []
    found = serve_stats(Spec("hover"), 16, lambda *done: told.append(done))
    assert told[-1] == (16, 16)
    return found


def test_the_answer_is_json_with_ordered_quantiles(human):
    assert json.loads(json.dumps(human, allow_nan=False)) == {
        **human,
        "hover_hit_rate_interval": list(human["hover_hit_rate_interval"]),
        "share_reachable_interval": list(human["share_reachable_interval"]),
    }
    assert (human["vehicle"], human["version"]) == ("tum_gazebo", __version__)
    for key in ("flight_time_s", "time_after_plane_s", "last_sight_before_contact_s"):
        assert list(human[key]) == ["p05", "p50", "p95"]
        assert human[key]["p05"] <= human[key]["p50"] <= human[key]["p95"]


def test_a_human_serve_flies_about_a_second_most_of_it_in_view(human):
    assert human["flight_time_s"]["p05"] > 0.45  # 3.5 m at 8 m/s
    assert human["flight_time_s"]["p95"] < 1.3  # 4.5 m at 6 m/s, slowed by drag and bounce
    assert human["flight_time_s"]["p50"] == pytest.approx(0.8, abs=0.3)
    assert human["time_after_plane_s"]["p50"] < human["flight_time_s"]["p50"]
    assert 0.5 < human["share_in_picture"] <= 1.0
    assert 0.5 < human["share_in_picture_at_plane"] <= 1.0


def test_hover_hits_what_evaluate_says_it_hits(human):
    hits = sum(result.outcome == "hit" for result in evaluate(Spec("hover"), 16))
    assert human["hover_hit_rate"] == hits / 16
    assert human["hover_hit_rate_interval"] == wilson_interval(hits, 16)
    assert human["share_reachable"] == 1.0
    assert human["share_reachable_interval"] == wilson_interval(16, 16)
    assert human["never_at_plane"] == human["never_in_picture"] == 0


def test_balls_that_never_arrive_or_are_never_seen_are_counted(tmp_path):
    """One as usual, one that falls to the floor far ahead, one that falls past above the view."""
    rows = ["2,0,0.3,-7,0,2,0,0,0,0.15,0.94,0.23", "5,0,0.3,-0.1,0,0,0,0,0,0.15,0.94,0.23"]
    rows.append("-1.5,0,3,-0.5,0,0,0,0,0,0.15,0.94,0.23")
    (tmp_path / "three.csv").write_text("\n".join([",".join(SERVE_COLUMNS), *rows]) + "\n")
    found = serve_stats(Spec("hover", serves=str(tmp_path / "three.csv")), 3)
    assert (found["never_at_plane"], found["never_in_picture"]) == (1, 1)
    assert set(found["contents"]) == {"serves"}


def test_constant_serves_vary_less_than_human_ones(human):
    constant = serve_stats(Spec("hover", serves="constant"), 8)
    assert constant["serves"] == "constant"

    def spread(found):
        return found["flight_time_s"]["p95"] - found["flight_time_s"]["p05"]

    assert spread(constant) < spread(human)


def test_a_narrower_camera_sees_less(human):
    narrow = serve_stats(Spec("hover", camera="ardrone2_720p"), 16)
    assert narrow["camera"] == "ardrone2_720p"
    assert narrow["share_in_picture"] < human["share_in_picture"]
    assert narrow["flight_time_s"] == human["flight_time_s"]
