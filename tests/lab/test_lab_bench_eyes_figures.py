"""Figures of `bench eyes` show the rows that it prints."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from rotorpong.lab.bench import eyes_figures, prediction_rows
from rotorpong.lab.bench.rows import Row

DEPTHS = [
    Row(f"depth by {method}, rms, {place}", 10.0 * i + j + 1.0, "cm")
    for i, method in enumerate(eyes_figures.METHODS)
    for j, place in enumerate(
        [
            *(f"{d:g} m, hall, gamma 2.2" for d in (1.0, 4.0)),
            *(f"2.5 m, {what}" for what in eyes_figures.DISTURBED.values()),
        ]
    )
]
BOUNDS = [Row(f"depth, Cramer-Rao bound, {d:g} m, grey", d, "cm") for d in eyes_figures.DEPTHS]
PLANES = [
    Row(f"{camera}, {vehicle}, {eyes}: {word} {axis} at 2.5 m, mean error", 7.0, "cm")
    for camera, vehicle in eyes_figures.PAIRS
    for eyes in ("paper", "tracker")
    for word, axis in eyes_figures.QUANTITIES
]


def test_depth_is_drawn_as_measured():
    values = {row.name: row.value for row in [*DEPTHS, *BOUNDS]}
    figure = Figure()
    eyes_figures.eyes_depth(figure, values)
    by_distance, disturbed = figure.axes
    edge = by_distance.lines[3]
    assert list(edge.get_ydata()) == [31.0, 34.0, 32.0]  # 1, 2.5, 4 m
    heights = [bar.get_height() for bar in disturbed.containers[0]]
    assert heights == [3.0, 4.0, 5.0, 6.0]


def test_all_figures_are_written_from_the_rows_of_predictions_that_are_really_printed(tmp_path):
    rows = [*DEPTHS, *BOUNDS, *PLANES, *prediction_rows.rows(quick=True)]
    paths = eyes_figures.draw_eyes(tmp_path / "new", rows)
    assert [path.name for path in paths] == [
        "eyes_depth.png",
        "eyes_plane.png",
        "eyes_prediction.png",
    ]
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size < 100_000


def test_a_row_that_is_missing_is_named():
    with pytest.raises(KeyError, match="depth by"):
        eyes_figures.eyes_depth(Figure(), {})


def test_the_all_knowing_know_the_table_and_see_no_worse():
    prior = prediction_rows._prior(0.0)
    told = prediction_rows._all_knowing(prior)
    assert told.restitution == (prior.restitution[0], 0.0)
    assert told.spin_sd < prior.spin_sd
    one = prediction_rows._predicted(3, 0.0)
    assert np.all(one.bound > 0.0)
