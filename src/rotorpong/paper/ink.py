"""How the figures of this folder look: one style, one colour for whoever appears in several."""

from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rotorpong.lab.report.ink import STYLE

COLOURS = {  # Okabe and Ito's, told apart by colour-blind readers
    "vision": "#D55E00",
    "truth": "#0072B2",
    "tracker": "#009E73",
    "paper": "#555555",
    "other": "#CC79A7",
    "light": "#E69F00",
    "sky": "#56B4E9",
}


@contextmanager
def drawing(width: float, height: float) -> Iterator[Figure]:
    """Give an empty figure of so many inches; what is drawn meanwhile has the common style."""
    with mpl.rc_context(STYLE):  # pyright: ignore[reportArgumentType]
        figure = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
