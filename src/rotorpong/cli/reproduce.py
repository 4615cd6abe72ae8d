"""The command that reproduces the paper: reproduce."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tyro.conf import FlagCreatePairsOff, Positional

from rotorpong.cli.common import Common, compile_kernels, progress_bar, say, show, within_cores


@dataclass(frozen=True, kw_only=True)
class Reproduce(Common):
    """Make the paper's tables and figures anew, each number beside the paper's."""

    what: Positional[tuple[str, ...]]
    """fig1, table1, fig3, fig4, table2, fig5, fig6, fig7a, fig7b, real (section V on the robot),
    ladder (what each step beyond the paper buys), sensitivity (to what the paper leaves open); or
    all."""
    out: Path
    """Folder for results.json, page.md, page.html and figures. What was worked out is kept there:
    the same command goes on where it was interrupted."""
    quick: FlagCreatePairsOff[bool] = False
    """Few balls, rough numbers: everything within a minute and a half."""
    workers: int = 0
    """Processes; 0: one for each core. The results do not depend on it."""

    def run(self) -> dict[str, Any]:
        """Reproduce."""
        from rotorpong.lab.spec import require_count
        from rotorpong.lab.workers import cores
        from rotorpong.paper import reproduce
        from rotorpong.paper.findings import Scale
        from rotorpong.paper.reproduce import chosen_items
        from rotorpong.paper.tables import ResultsTables

        chosen_items(self.what)
        require_count("workers", self.workers, 0)
        compile_kernels("tracker")
        with progress_bar() as advance:
            results = reproduce(
                self.what,
                self.out,
                scale=Scale(self.seed, self.quick),
                workers=within_cores(self.workers or cores()),
                progress=advance,
            )
        if not self.json:
            show(ResultsTables(results))
            say(f"numbers and figures: {self.out / 'page.html'}")
        return results
