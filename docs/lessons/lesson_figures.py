"""How the figures of all lessons look, and where they are kept."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

IMAGES = Path(__file__).resolve().parents[1] / "images" / "lessons"
BLUE, ORANGE, GREEN, PINK, GREY = "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#8a8a8a"
STYLE: dict[str, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "legend.frameon": False,
}


def drawn(draw: Callable[[Figure], None], folder: Path, style: dict[str, Any] = STYLE) -> str:
    """Write what `draw` draws to a PNG of its name in `folder`; return the file's name and size."""
    folder.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(style):  # pyright: ignore[reportArgumentType]
        figure = Figure(figsize=(7.2, 3.2), layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        path = folder / f"{draw.__name__}.png"
        figure.savefig(path, dpi=100, pil_kwargs={"optimize": True})
    return f"{path.name}: {path.stat().st_size / 1000:.0f} kB"
