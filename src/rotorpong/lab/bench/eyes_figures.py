"""Figures of `rotorpong bench eyes --out DIR`, drawn from its rows.

Depth errors of one ball in one picture, by distance and by what disturbs it; errors of position and
velocity where the ball passes 2.5 m; the error of the predicted place by how wrong the attitude is.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rotorpong.lab.bench.eyes_rows import DEPTHS, METHODS
from rotorpong.lab.bench.prediction_rows import AHEAD, TILTS_DEG
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.tracking_rows import PAIRS
from rotorpong.lab.report.ink import STYLE

COLOURS = ("#8a8a8a", "#e69f00", "#009e73", "#0072b2")  # Okabe and Ito's, one per method
DISTURBED = {
    "grey wall": "grey, gamma 2.2",
    "hall": "hall, gamma 2.2",
    "grey wall,\n3 m/s across": "grey, 3 m/s, 1/60 s",
    "hall,\n3 m/s across": "hall, 3 m/s, 1/60 s",
}
QUANTITIES = tuple((word, axis) for word in ("position", "velocity") for axis in "XYZ")

Values = Mapping[str, float]  # by the name of a row


def draw_eyes(folder: Path, rows: Iterable[Row]) -> tuple[Path, ...]:
    """Write one PNG each into `folder`; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    values, paths = {row.name: row.value for row in rows}, []
    for draw in (eyes_depth, eyes_plane, eyes_prediction):
        with mpl.rc_context(STYLE):  # pyright: ignore[reportArgumentType]
            figure = Figure(figsize=(7.2, 3.4), layout="constrained")
            FigureCanvasAgg(figure)
            draw(figure, values)
            paths.append(folder / f"{draw.__name__}.png")
            figure.savefig(paths[-1], dpi=110)
    return tuple(paths)


def eyes_depth(figure: Figure, values: Values) -> None:
    """Depth error by distance before the hall, and at 2.5 m by what disturbs it."""
    by_distance, disturbed = figure.subplots(1, 2, width_ratios=[1, 1.25])
    for method, colour in zip(METHODS, COLOURS, strict=True):
        errors = [values[f"depth by {method}, rms, {d:g} m, hall, gamma 2.2"] for d in DEPTHS]
        by_distance.loglog(DEPTHS, errors, "o-", color=colour, label=method)
    bound = [values[f"depth, Cramer-Rao bound, {d:g} m, grey"] for d in DEPTHS]
    by_distance.loglog(DEPTHS, bound, color="black", linestyle="--", label="bound, grey wall")
    by_distance.set_xticks(DEPTHS, [f"{d:g}" for d in DEPTHS])
    by_distance.minorticks_off()
    by_distance.set(xlabel="distance, m (hall)", ylabel="depth error, rms, cm", ylim=(None, 3e3))
    by_distance.legend(fontsize=8, frameon=False)
    groups = [
        [values[f"depth by {method}, rms, 2.5 m, {what}"] for what in DISTURBED.values()]
        for method in METHODS
    ]
    _bars(disturbed, groups, tuple(DISTURBED), METHODS)
    disturbed.set(ylabel="depth error at 2.5 m, rms, cm")


def eyes_plane(figure: Figure, values: Values) -> None:
    """Errors at the plane: the paper's eyes beside the tracker's, both cameras."""
    panels = figure.subplots(1, len(PAIRS), sharey=True)
    for axes, (camera, vehicle) in zip(panels, PAIRS, strict=True):
        groups = [
            [
                values[f"{camera}, {vehicle}, {eyes}: {word} {axis} at 2.5 m, mean error"]
                for word, axis in QUANTITIES
            ]
            for eyes in ("paper", "tracker")
        ]
        labels = tuple(f"{axis}" if word == "position" else f"v{axis}" for word, axis in QUANTITIES)
        _bars(axes, groups, labels, ("paper", "tracker"), (COLOURS[0], COLOURS[3]))
        axes.set_title(f"{camera}, {vehicle}", fontsize=9)
    panels[0].set_ylabel("mean error at 2.5 m, cm or cm/s")
    panels[0].legend(fontsize=8, frameon=False)


def eyes_prediction(figure: Figure, values: Values) -> None:
    """Error of the predicted place by attitude error, and its bound."""
    axes = figure.subplots()
    places = np.arange(len(TILTS_DEG))
    for ahead, colour in zip(AHEAD, (COLOURS[3], COLOURS[1]), strict=True):
        for what, style in (("rms", "o-"), ("rms, Cramer-Rao bound", "--")):
            errors = [
                values[f"prediction {ahead:g} s ahead, attitude error {d:g} degrees: {what}"]
                for d in TILTS_DEG
            ]
            label = f"{ahead:g} s ahead, {what}"
            axes.plot(places, errors, style, color=colour, label=label)
    axes.set_xticks(places, [f"{d:g}" for d in TILTS_DEG])
    axes.set(xlabel="constant attitude error, degrees", ylabel="cm", ylim=(0.0, None))
    axes.legend(fontsize=8, frameon=False, ncols=2)


def _bars(
    axes: Axes,
    groups: Sequence[Sequence[float]],
    labels: Sequence[str],
    names: Sequence[str],
    colours: Sequence[str] = COLOURS,
) -> None:
    """Draw bars side by side on a logarithmic axis."""
    places, width = np.arange(len(labels)), 0.8 / len(groups)
    for i, (errors, name, colour) in enumerate(zip(groups, names, colours, strict=True)):
        axes.bar(places + (i + 0.5) * width - 0.4, errors, width, color=colour, label=name)
    axes.set_yscale("log")
    axes.set_xticks(places, labels, fontsize=8)
    axes.tick_params(axis="x", length=0)
