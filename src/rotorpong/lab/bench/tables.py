"""Rows of a benchmark as a table for a terminal."""

from collections.abc import Sequence

from rich.markup import escape
from rich.table import Table

from rotorpong.lab.bench.rows import Row

COLUMNS = ("measured", "value", "unit", "target", "met", "times the peer", "peer")
LEFT = ("measured", "unit", "peer")


def rows_table(rows: Sequence[Row]) -> Table:
    """Show each figure beside its target and its peer."""
    table = Table(title="bench: CPU time of one core unless said", title_justify="left")
    for column in COLUMNS:
        table.add_column(column, justify="left" if column in LEFT else "right")
    for row in rows:
        table.add_row(*_cells(row))
    return table


def number(value: float) -> str:
    """Return a number as people read it: four digits that count."""
    if value and not 1e-3 <= abs(value) < 1e7:
        return f"{value:.1e}"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"


def _cells(row: Row) -> list[str]:
    sign = {"more": "≥", "less": "≤"}[row.better]
    target = "" if row.target is None else f"{sign} {number(row.target)}"
    met = {None: "", True: "yes", False: "[red]no[/red]"}[row.met]
    ratio = "" if row.ratio is None else number(row.ratio)
    value = number(row.value)
    if row.interval is not None:
        value += " ({:.3g} - {:.3g})".format(*row.interval)
    return [escape(row.name), value, row.unit, target, met, ratio, row.peer or ""]
