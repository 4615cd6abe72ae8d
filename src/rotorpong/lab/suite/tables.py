"""A suite's result as a table for a terminal."""

from collections.abc import Sequence
from typing import Any

from rich.markup import escape
from rich.table import Table

from rotorpong.lab.tables import percent

COLUMNS = ("cell", "hit rate (95 %)", "of reachable", "near", "hover", "skill (95 %)")


def suite_table(result: dict[str, Any]) -> Table:
    """Show what `suite` found."""
    balls = result["cells"][0]["balls"]
    title = f"suite {result['suite']}: {result['player']} player, {result['eyes']} eyes"
    table = Table(title=f"{escape(title)}, {balls} balls a cell", title_justify="left")
    for column in COLUMNS:
        justify = "left" if column == "cell" else "right"
        table.add_column(column, justify=justify, no_wrap=column != "of reachable")
    for cell in result["cells"]:
        table.add_row(*_row(cell))
    table.add_section()
    table.add_row("score", "", "", "", "", of_scale(result["score"], result["score_interval"]))
    if not result["comparable"]:
        table.caption = "quick: compares with nothing, and no leaderboard takes it"
    return table


def of_scale(value: float | None, interval: Sequence[float] | None) -> str:
    """Return a skill or score with half its interval: `0.12 ± 0.04`."""
    if value is None or interval is None:
        return "-"
    return f"{value:.2f} ± {(interval[1] - interval[0]) / 2:.2f}"


def _row(cell: dict[str, Any]) -> list[str]:
    return [
        cell["name"],
        percent(cell["hit_rate"], cell["hit_rate_interval"]),
        percent(cell["hit_rate_of_reachable"]),
        str(cell["near_hits"]),
        percent(cell["hover_hits"] / cell["balls"]),
        of_scale(cell["skill"], cell["skill_interval"]),
    ]
