"""The numbers of a reproduction for a terminal, made of results.json alone."""

from collections.abc import Mapping
from typing import Any

from rich.console import Group
from rich.markup import escape
from rich.table import Table

from rotorpong.paper.findings import Column
from rotorpong.paper.page import Results, cell


def results_tables(results: Results) -> Group:
    """Return a table for each item that has numbers, the paper's lines first."""
    return Group(*(_table(found) for found in results.values() if found["columns"]))


def _table(found: Mapping[str, Any]) -> Table:
    columns = [Column(**column) for column in found["columns"]]
    table = Table(title=escape(found["title"]), title_justify="left")
    table.add_column("")
    for column in columns:
        table.add_column(escape(column.head), justify="right")
    for whose in ("paper", "ours"):
        for label, values in found[whose].items():
            name = f"{whose}: {label}" if label else whose
            table.add_row(escape(name), *(cell(values, column) for column in columns))
        table.add_section()
    return table
