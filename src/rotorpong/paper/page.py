"""The page of a reproduction: the same text as Markdown, for the documentation, and as HTML.

A number is shown with the digits of its column, with its standard deviation or 95 % interval beside
it where there is one; results.json has it whole.
"""

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt

from rotorpong.lab import report
from rotorpong.paper.findings import Column, Findings, Line

STYLESHEET = Path(report.__file__).with_name("page.css")
HEAD = """# The paper, reproduced

Silva, Melo and Veloso, *Towards Table Tennis with a Quadrotor Autonomous Learning Robot and Onboard
Vision* (IROS 2015): every table and figure beside ours, in the same units. This page is written by
`rotorpong reproduce all --out DIR`, nothing in it by hand; each number is in `results.json`, whole,
with its setting. A value after ± is a standard deviation, one in brackets a 95 % interval.
"""
ROUGH = """
**These are the rough numbers of `--quick`: they show that everything runs, and tell nothing more.**
"""
UNKNOWN = "-"


@dataclass(frozen=True, slots=True)
class Part:
    """One item on the page."""

    name: str
    title: str
    findings: Findings
    command: str


def markdown_page(parts: Sequence[Part], *, quick: bool = False, images: str = "") -> str:
    """Return the page.

    Args:
        parts: its items, in order.
        quick: say that these are rough numbers.
        images: what goes before the names of figures.
    """
    sections = ("\n".join(_section(part, images)) for part in parts)
    return "\n".join([HEAD, *([ROUGH] if quick else []), *sections])


def html_page(page: str, pictures: Mapping[str, bytes]) -> str:
    """Return a page of `markdown_page` as one HTML file that asks nothing of any network."""
    body = MarkdownIt("commonmark").enable("table").render(page)
    for name, png in pictures.items():
        inside = f"data:image/png;base64,{base64.b64encode(png).decode()}"
        body = body.replace(f'src="{name}.png"', f'src="{inside}"')
    title = escape(HEAD.splitlines()[0].lstrip("# "))
    body = body.replace("<table>", '<div class="scroll"><table>')
    body = body.replace("</table>", "</table></div>")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{STYLESHEET.read_text()}</style></head>"
        f"<body><main>{body}</main></body></html>\n"
    )


def _section(part: Part, images: str) -> Iterator[str]:
    found = part.findings
    yield f"## {part.title}\n"
    if found.columns:
        yield from _table(found)
    for name in found.figures:
        yield f"![{part.title}: {name.replace('_', ' ')}]({images}{name}.png)\n"
    if found.remarks:
        yield f"{found.remarks.strip()}\n"
    if found.setting:
        played = "; ".join(
            f"{key.replace('_', ' ')} {_said(v)}" for key, v in found.setting.items()
        )
        yield f"Setting: {played}.\n"
    yield f"Command: `{part.command}`\n"


def _table(found: Findings) -> Iterator[str]:
    yield " | ".join(["|", *(column.head for column in found.columns), ""]).strip()
    yield "|".join(["", "---", *("---:" for _ in found.columns), ""])
    for whose, lines in (("paper", found.paper), ("ours", found.ours)):
        for line in lines:
            label = f"**{whose}**: {line.label}" if line.label else f"**{whose}**"
            yield " | ".join([f"| {label}", *(_cell(line, c) for c in found.columns), ""]).strip()
    yield ""


def _cell(line: Line, column: Column) -> str:
    value = line.values.get(column.key)
    if value is None:
        return UNKNOWN
    shown = _rounded(value, column.digits)
    if (sd := line.values.get(f"{column.key}_sd")) is not None:
        shown += f" ± {sd:.{column.digits}f}"
    if (bounds := line.values.get(f"{column.key}_interval")) is not None:
        low, high = bounds
        shown += f" ({low:.{column.digits}f} to {high:.{column.digits}f})"
    return shown


def _rounded(value: float, digits: int) -> str:
    """Return a number with so many digits after the point, a power of ten where that is 0."""
    return f"{value:.0e}" if 0.0 < abs(value) < 0.5 * 10.0**-digits else f"{value:.{digits}f}"


def _said(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_said(inner)}" for key, inner in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_said(inner) for inner in value)
    return str(value)
