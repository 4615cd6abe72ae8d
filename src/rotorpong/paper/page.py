"""The page of a reproduction, made of results.json alone: as Markdown, and as HTML.

A number is shown with the digits of its column, with its standard deviation or 95 % interval beside
it where there is one; results.json has it whole.
"""

import base64
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt

from rotorpong.lab import report
from rotorpong.paper.findings import Column

STYLESHEET = Path(report.__file__).with_name("page.css")
Results = Mapping[str, Mapping[str, Any]]
"""What results.json holds: items by name."""

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


def markdown_page(results: Results) -> str:
    """Return the page of what results.json holds."""
    rough = [ROUGH] if any(one["setting"]["quick"] for one in results.values()) else []
    return "\n".join([HEAD, *rough, *("\n".join(_section(one)) for one in results.values())])


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


def cell(values: Mapping[str, Any], column: Column) -> str:
    """Return a value of a line as it is shown, its deviation or interval beside it."""
    value = values.get(column.key)
    if value is None:
        return UNKNOWN
    shown = _rounded(value, column.digits)
    if (sd := values.get(f"{column.key}_sd")) is not None:
        shown += f" ± {sd:.{column.digits}f}"
    if (bounds := values.get(f"{column.key}_interval")) is not None:
        low, high = bounds
        shown += f" ({low:.{column.digits}f} to {high:.{column.digits}f})"
    return shown


def _section(found: Mapping[str, Any]) -> Iterator[str]:
    title = found["title"]
    yield f"## {title}\n"
    if found["columns"]:
        yield from _table(found)
    for name in found["figures"]:
        yield f"![{title}: {Path(name).stem.replace('_', ' ')}]({name})\n"
    if found["remarks"]:
        yield f"{found['remarks']}\n"
    played = (f"{key.replace('_', ' ')} {_said(v)}" for key, v in found["setting"].items())
    yield f"Setting: {'; '.join(played)}.\n"
    yield f"Command: `{found['command']}`\n"


def _table(found: Mapping[str, Any]) -> Iterator[str]:
    columns = [Column(**column) for column in found["columns"]]
    yield " | ".join(["|", *(column.head for column in columns), ""]).strip()
    yield "|".join(["", "---", *("---:" for _ in columns), ""])
    for whose in ("paper", "ours"):
        for label, values in found[whose].items():
            name = f"**{whose}**: {label}" if label else f"**{whose}**"
            yield " | ".join([f"| {name}", *(cell(values, c) for c in columns), ""]).strip()
    yield ""


def _rounded(value: float, digits: int) -> str:
    """Return a number with so many digits after the point, a power of ten where that is 0."""
    return f"{value:.0e}" if 0.0 < abs(value) < 0.5 * 10.0**-digits else f"{value:.{digits}f}"


def _said(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_said(inner)}" for key, inner in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_said(inner) for inner in value)
    return str(value)
