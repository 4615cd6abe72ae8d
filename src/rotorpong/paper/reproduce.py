"""The paper's evaluation from end to end: work, numbers, figures, one page.

    DIR/results.json   every number beside the paper's, by item
    DIR/page.md        tables, figures and remarks; also a page of the documentation
    DIR/page.html      the same, in one file
    DIR/*.png          the figures
    DIR/work-*         what was worked out, so that it need not be again; may be deleted

With all items there comes a closing part, the paper's numbers beside those of all of them.

The same seed gives the same results.json, for any number of workers and however often the run was
killed on the way.
"""

import importlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from io import BytesIO
from pathlib import Path
from typing import Any, cast

from matplotlib.figure import Figure

from rotorpong import __version__
from rotorpong.conventions import InputError
from rotorpong.files import prepare_folder, write_whole
from rotorpong.lab.choices import require_choice
from rotorpong.paper import claims
from rotorpong.paper.findings import Findings, Item, Scale
from rotorpong.paper.page import html_page, markdown_page
from rotorpong.paper.work import Progress, answers_of

ITEMS = (
    *("fig1", "table1", "fig3", "fig4", "table2", "fig5", "fig6", "fig7a", "fig7b", "real"),
    *("ladder", "sensitivity"),
)
CLOSING = "claims"  # comes with all items together, of which it is made
ALL = "all"
DPI = 110


def reproduce(
    names: Sequence[str],
    out: Path,
    *,
    scale: Scale | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Work out items, write their numbers, figures and page into `out`, and return the numbers.

    Args:
        names: of `ITEMS`, or "all".
        out: folder; what it holds of an earlier run with the same sources is used again.
        scale: seed, and whether roughly.
        workers: processes.
        progress: told (what, done, of how many).

    Raises:
        InputError: unknown items, or the folder cannot be written.
    """
    scale = scale or Scale()
    chosen = chosen_items(names)
    prepare_folder(out)
    items = {name: item_of(name) for name in chosen}
    jobs = {name: tuple(item.jobs(scale)) for name, item in items.items()}
    answers = answers_of(jobs, out, workers=workers, progress=progress)
    found = {name: item.findings(scale, answers[name]) for name, item in items.items()}
    results = {name: as_json(name, one, scale) for name, one in found.items()}
    if chosen == ITEMS:
        found[CLOSING] = claims.findings(results)
        results[CLOSING] = as_json(CLOSING, found[CLOSING], scale)
    _write(out, results, found)
    return results


def chosen_items(names: Sequence[str]) -> tuple[str, ...]:
    """Return the items that are meant, in the paper's order.

    Raises:
        InputError: none, or an unknown one.
    """
    if not names:
        raise InputError(f"nothing to reproduce: expected {', '.join(ITEMS)}, or {ALL}")
    for name in names:
        require_choice("item", name, (*ITEMS, ALL))
    return ITEMS if ALL in names else tuple(name for name in ITEMS if name in names)


def item_of(name: str) -> Item:
    """Return the file that tells an item."""
    return cast("Item", importlib.import_module(f"rotorpong.paper.{name}"))


def command_of(name: str, scale: Scale) -> str:
    """Return the command that prints an item's numbers."""
    seed = f" --seed {scale.seed}" if scale.seed else ""
    what = ALL if name == CLOSING else name
    return f"rotorpong reproduce {what} --out DIR{seed}{scale.of('', ' --quick')}"


def as_json(name: str, found: Findings, scale: Scale) -> dict[str, Any]:
    """Return an item as results.json holds it."""
    played = {"seed": scale.seed, "quick": scale.quick, "version": __version__}
    return {
        "title": claims.TITLE if name == CLOSING else item_of(name).TITLE,
        "paper": {line.label: dict(line.values) for line in found.paper},
        "ours": {line.label: dict(line.values) for line in found.ours},
        "setting": {**found.setting, **played},
        "command": command_of(name, scale),
        "columns": [asdict(column) for column in found.columns],
        "figures": [f"{figure}.png" for figure in found.figures],
        "remarks": found.remarks.strip(),
    }


def _write(out: Path, results: dict[str, Any], found: dict[str, Findings]) -> None:
    pictures = {name: png for one in found.values() for name, png in _pictures(one).items()}
    for name, png in pictures.items():
        write_whole(out / f"{name}.png", png)
    text = json.dumps(results, allow_nan=False, indent=1)
    write_whole(out / "results.json", text.encode())
    page = markdown_page(results)
    write_whole(out / "page.md", page.encode())
    write_whole(out / "page.html", html_page(page, pictures).encode())


def _pictures(found: Findings) -> dict[str, bytes]:
    return {name: _png(figure) for name, figure in found.figures.items()}


def _png(figure: Figure | bytes) -> bytes:
    if isinstance(figure, bytes):
        return figure
    made = BytesIO()
    figure.savefig(made, format="png", dpi=DPI, metadata={"Software": None})
    return made.getvalue()
