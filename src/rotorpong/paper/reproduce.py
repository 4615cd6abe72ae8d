"""The paper's evaluation from end to end: work, numbers, figures, one page.

    DIR/results.json   every number beside the paper's, by item
    DIR/page.md        tables, figures and remarks; also a page of the documentation
    DIR/page.html      the same, in one file
    DIR/*.png          the figures
    DIR/work-*         what was worked out, so that it need not be again; may be deleted

With all items there comes a last part, `claims`: the paper's numbers beside those of all of them.
The same seed gives the same results.json, for any number of workers and however often the run was
killed on the way.
"""

import importlib
import json
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, cast

from matplotlib.figure import Figure

from rotorpong import __version__
from rotorpong.conventions import InputError
from rotorpong.files import prepare_folder, write_whole
from rotorpong.lab.choices import require_choice
from rotorpong.paper import claims
from rotorpong.paper.findings import Findings, Item, Line, Scale
from rotorpong.paper.page import Part, html_page, markdown_page
from rotorpong.paper.work import Progress, answers_of

ITEMS = (
    *("fig1", "table1", "fig3", "fig4", "fig6", "fig7a", "fig7b", "real"),
    *("ladder", "sensitivity"),
)
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
    parts = [
        Part(name, item.TITLE, item.findings(scale, answers[name]), command_of(name, scale))
        for name, item in items.items()
    ]
    results = {part.name: as_json(part, scale) for part in parts}
    if chosen == ITEMS:
        parts.append(Part("claims", claims.TITLE, claims.findings(results), command_of(ALL, scale)))
        results["claims"] = as_json(parts[-1], scale)
    _write(out, parts, results, scale)
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
    return f"rotorpong reproduce {name} --out DIR{seed}{scale.of('', ' --quick')}"


def as_json(part: Part, scale: Scale) -> dict[str, Any]:
    """Return an item as results.json holds it."""
    found = part.findings
    return {
        "title": part.title,
        "paper": _lines(found.paper),
        "ours": _lines(found.ours),
        "setting": {
            **found.setting,
            "seed": scale.seed,
            "quick": scale.quick,
            "version": __version__,
        },
        "command": part.command,
        "figures": sorted(f"{name}.png" for name in found.figures),
    }


def _lines(lines: Sequence[Line]) -> dict[str, dict[str, Any]]:
    return {line.label: dict(line.values) for line in lines}


def _write(out: Path, parts: Sequence[Part], results: dict[str, Any], scale: Scale) -> None:
    pictures = {name: png for part in parts for name, png in _pictures(part.findings).items()}
    for name, png in pictures.items():
        write_whole(out / f"{name}.png", png)
    text = json.dumps(results, allow_nan=False, indent=1)
    write_whole(out / "results.json", text.encode())
    page = markdown_page(parts, quick=scale.quick)
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
