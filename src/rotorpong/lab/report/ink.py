"""Colours by role, and matplotlib figures as SVG that takes those colours from the page.

A figure is drawn in placeholder colours, one for each role; in the SVG they become CSS variables,
so the page decides about light, dark and print. The palette is that of Okabe and Ito, told apart
by colour-blind readers.
"""

import io
import re
from contextlib import AbstractContextManager
from html import escape
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

ROLES = ("ink", "quiet", "line", "paper", "table", "ball", "blade", "hover", "before", "after")
_PLACEHOLDERS = {role: f"#{i + 1:02x}a5{0x5A - i:02x}" for i, role in enumerate(ROLES)}

STYLE = {
    "svg.fonttype": "none",
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "axes.axisbelow": True,
}


def ink(role: str) -> str:
    """Return the colour in which to draw `role`."""
    return _PLACEHOLDERS[role]


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of so many inches."""
    with mpl.rc_context(_style()):
        drawn = Figure(figsize=(width, height))
        FigureCanvasSVG(drawn)
        return drawn


def drawing() -> AbstractContextManager[None]:
    """Return the context in which figures of the page are drawn."""
    return mpl.rc_context(_style())


def svg(drawn: Figure, name: str, alt: str) -> str:
    """Return a figure as an SVG element for a page.

    Args:
        drawn: the figure.
        name: its identity on the page, so that references inside do not meet another's.
        alt: what it shows, for who cannot see it.
    """
    text = io.StringIO()
    with mpl.rc_context({**_style(), "svg.hashsalt": name}):
        drawn.savefig(text, format="svg", transparent=True, metadata={"Date": None})
    body = text.getvalue()
    body = body[body.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    body = re.sub(r"<g id=\"[^\"]*\"", "<g", body)
    body = re.sub(r"font-family: [^;\"]*|'DejaVu Sans'[^;\"]*", _system_font, body)
    body = body.replace("xlink:href", "href")
    for role, colour in _PLACEHOLDERS.items():
        body = body.replace(colour, f"var(--{role})")
    box = re.search(r'viewBox="([^"]*)"', body)
    assert box is not None, "matplotlib gives every figure a viewBox"
    head = f'<svg viewBox="{box[1]}" role="img" aria-label="{escape(alt)}">'
    return head + body[body.index(">") + 1 :].strip()


def _style() -> dict[Any, Any]:
    quiet = dict.fromkeys(("axes.edgecolor", "xtick.color", "ytick.color"), ink("quiet"))
    dark = dict.fromkeys(("text.color", "axes.labelcolor"), ink("ink"))
    return {**STYLE, **quiet, **dark, "grid.color": ink("line"), "patch.linewidth": 0.8}


def _system_font(match: re.Match[str]) -> str:
    return "font-family: inherit" if match[0].startswith("font-family") else "system-ui, sans-serif"
