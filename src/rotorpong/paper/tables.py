"""The numbers of a reproduction for a terminal, made of results.json alone."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table

from rotorpong.paper.findings import Column
from rotorpong.paper.page import UNKNOWN, Results, cell

WIDEST = 10_000  # columns of a terminal that there is not


@dataclass(frozen=True, slots=True)
class ResultsTables:
    """A table for each item that has numbers; a list of its lines where the table is too wide."""

    results: Results

    def __rich_console__(
        self, console: Console, options: ConsoleOptions
    ) -> Iterator[RenderableType]:
        """Yield what rich prints."""
        for found in filter(lambda one: one["columns"], self.results.values()):
            table = _table(found)
            whole = Measurement.get(console, options.update(width=WIDEST), table).maximum
            fits = whole <= options.max_width
            yield from (table,) if fits else _list(found)


def _table(found: Mapping[str, Any]) -> Table:
    columns = _columns(found)
    table = Table(title=escape(found["title"]), title_justify="left")
    table.add_column("")
    for column in columns:
        table.add_column(escape(column.head), justify="right")
    for whose, lines in _lines(found):
        for name, values in lines:
            table.add_row(escape(name), *(cell(values, column) for column in columns))
        if whose == "paper":
            table.add_section()
    return table


def _list(found: Mapping[str, Any]) -> Iterator[RenderableType]:
    yield f"[italic]{escape(found['title'])}[/italic]"
    for _, lines in _lines(found):
        for name, values in lines:
            cells = [(column.head, cell(values, column)) for column in _columns(found)]
            said = (f"{head}: {shown}" for head, shown in cells if shown != UNKNOWN)
            yield f"[bold]{escape(name)}[/bold]"
            yield Padding(escape("; ".join(said)), (0, 0, 0, 4))


def _columns(found: Mapping[str, Any]) -> list[Column]:
    return [Column(**column) for column in found["columns"]]


def _lines(found: Mapping[str, Any]) -> Iterator[tuple[str, list[tuple[str, Mapping[str, Any]]]]]:
    """Yield whose lines they are, and each with its name, the paper's first."""
    for whose in ("paper", "ours"):
        lines = found[whose].items()
        yield whose, [(f"{whose}: {name}" if name else whose, values) for name, values in lines]
