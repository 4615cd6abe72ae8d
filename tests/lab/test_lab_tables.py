"""Tables show what was found, also where nothing was."""

import io

import pytest
from rich.console import Console

from rotorpong.lab.evaluate import Result, summary
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.tables import (
    conversion_table,
    detection_table,
    findings_table,
    percent,
    stats_table,
    summary_table,
)

TIMES = ("flight_time_s", "time_after_plane_s", "last_sight_before_contact_s")
SHARES = (
    "share_reachable",
    "share_reachable_interval",
    "share_in_picture",
    "share_in_picture_at_plane",
    "hover_hit_rate_interval",
)


def shown(table):
    console = Console(width=200, record=True, file=io.StringIO())
    console.print(table)
    return console.export_text()


@pytest.mark.parametrize(
    ("share", "interval", "text"),
    [
        (None, None, "-"),
        (0.125, None, "12.5 %"),
        (0.0, (0.0, 0.03), "0.0 % (0.0-3.0)"),
        (1.0, (0.97, 1.0), "100.0 % (97.0-100.0)"),
    ],
)
def test_a_rate_in_words(share, interval, text):
    assert percent(share, interval) == text


def test_a_summary_counts_every_outcome():
    results = [
        Result(0, "hit", 0.0, 0.0, None, reachable=True),
        Result(1, "hull", 0.1, None, None, reachable=True),
        Result(2, "hull", 0.3, 0.05, None, reachable=True),
    ]
    text = shown(summary_table(summary(Spec(), results)))
    rows = {
        line.split("│")[1].strip(): line.split("│")[2].strip()
        for line in text.splitlines()
        if "│" in line
    }
    assert rows["hits"] == rows["hit"] == "1"
    assert rows["hull"] == "2"
    assert rows["hit rate (95 %)"].startswith("33.3 % (")
    assert rows["miss distance, median"] == "20.0 cm"


def test_a_summary_shows_what_is_unusual_of_the_player_and_nothing_else():
    settings = PlayerSettings(
        tune=True, plane_distance=2.0, selection="ucb", deviations=0.5, learn_from_misses=True
    )
    spec = Spec(eyes="truth", player_settings=settings, control="feed-forward")
    hit = Result(0, "hit", 0.0, 0.0, None, reachable=True)
    told = {
        cells[1].strip(): cells[2].strip()
        for line in shown(summary_table(summary(spec.check(), [hit]))).splitlines()
        if len(cells := line.split("│")) > 2
    }
    expected = {"tune": "yes", "plane distance, m": "2", "selection": "ucb", "deviations": "0.5"}
    expected |= {"learn from misses": "yes", "control": "feed-forward"}
    assert told.items() >= expected.items()
    usual = shown(summary_table(summary(Spec(eyes="truth"), [hit])))
    assert not any(what in usual for what in (*expected, "labels", "trigger", "exploration"))


def test_a_summary_without_misses_shows_a_dash():
    hit = Result(0, "hit", 0.0, 0.0, None, reachable=True)
    assert "-" in shown(summary_table(summary(Spec(), [hit])))
    assert "100.0 %" in shown(summary_table(summary(Spec(), [hit])))


def test_names_in_brackets_are_shown_as_they_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "[").mkdir()
    (tmp_path / "[" / "nonsense].csv").touch()
    own = Spec("[red]players[/red]/own.py:Own", serves="[/nonsense].csv")
    text = shown(summary_table(summary(own, [Result(0, "miss", 0.2, None, None, reachable=True)])))
    assert "[red]players[/red]/own.py:Own" in text
    assert "[/nonsense].csv" in text
    picture = {"path": "[/x].png", "frame": 0, "balls": []}
    assert "[/x].png" in shown(detection_table({"pictures": [picture]}))
    check = {"name": "python", "ok": False, "found": "[/y]"}
    assert "[/y]" in shown(findings_table({"checks": [check]}))
    quantiles = {"p05": None, "p50": 1.0, "p95": 2.0}
    stats = {
        **{"balls": 1, "serves": "[/z].csv", "camera": "[/c].json", "hover_hit_rate": None},
        **dict.fromkeys(TIMES, quantiles),
        **dict.fromkeys(SHARES),
        **{"vehicle": "[/v]", "never_at_plane": 3, "never_in_picture": 0},
    }
    text = shown(stats_table(stats))
    assert "reachable for [/v]" in text
    assert "never pass the blade" in text
    assert "never in the picture" not in text
    assert "[/z].csv" in text
    assert "[/c].json" in text
    assert "- / 1.00 / 2.00" in text
    flight = {
        **{"flight": "[/f].csv", "points": 30, "residual_rms_mm": 1.5, "drag_per_m": 0.15},
        **{"bounces": 1, "target_left_m": 0.1, "target_up_m": -0.2},
    }
    made = {"out": "[/o].csv", "serves": [flight], "files_passed_over": 2}
    text = shown(conversion_table({**made, "flights_passed_over": 1}))
    assert all(word in text for word in ("[/f].csv", "[/o].csv", "2 files", "1 flights", "-0.20"))


def test_detections_show_the_best_ball():
    ball = {
        "x_px": 1.0,
        "y_px": 2.0,
        "diameter_px": 3.0,
        "score": 0.5,
        "position_m": [0.0, 0.0, 2.5],
    }
    pictures = [{"path": "a.png", "frame": 0, "balls": [ball, ball]}]
    text = shown(detection_table({"pictures": pictures}))
    assert all(word in text for word in ("a.png", "1.0", "2.0", "3.0", "0.50", "2.50"))


def test_detections_that_are_linked_show_their_tracks_and_finer_numbers():
    place = {"x_px": 1.234, "y_px": 2.0, "diameter_px": 3.0, "score": 0.5}
    balls = [{**place, "position_m": None, "track": track} for track in (17, None)]
    pictures = [{"path": "a\udcff.mp4", "frame": k, "balls": [b]} for k, b in enumerate(balls)]
    text = shown(detection_table({"pictures": [*pictures, {**pictures[0], "balls": []}]}))
    assert all(word in text for word in ("track", "17", "1.23", "a\\udcff.mp4"))
