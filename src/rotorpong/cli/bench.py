"""The command that measures: bench."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from tyro.conf import FlagCreatePairsOff, Positional

from rotorpong.cli.common import Common, compile_kernels, progress_bar, say, show


@dataclass(frozen=True, kw_only=True)
class Bench(Common):
    """Measure speed and exactness, each figure beside its target and its peer."""

    seed: int = 0
    """Taken by every command; what is measured here has seeds of its own."""
    what: Positional[Literal["world", "eyes", "primitives", "learning", "control", "players"]]
    """world: the simulator. eyes: how well a ball is measured, followed and predicted. primitives:
    how fast and how exactly motions are fitted and rolled out. learning: how well, how exactly and
    how fast is learnt where to hit, and with which primitive. control: how exactly motions are
    flown. players: who hits how many of the same balls, and how that grows with learning (five
    minutes)."""

    peers: FlagCreatePairsOff[bool] = False
    """Measure peers as well: needs a checkout and the extra bench."""
    flights: Path | None = None
    """Folder of measured flights: adds what the ball's model leaves of them."""
    events: Path | None = None
    """File or folder of measured bounces: adds what the laws of contact leave of them."""
    images: Path | None = None
    """Folder of labelled pictures, or of such folders: adds how well detect finds their balls."""
    ball_class: int | None = None
    """Of a ball in labels of several classes."""
    colour: str | None = None
    """To look for in the pictures, as detect takes it; by default orange, and orange,white."""
    out: Path | None = None
    """Folder for figures: of growth with balls, trials, pixels and workers; of the eyes' errors; of
    learning curves."""
    player: str | None = None
    """Your own as FILE.py:CLASS, to play against ours."""
    quick: FlagCreatePairsOff[bool] = False
    """Few repetitions, rough numbers, and nothing that takes minutes (render, reach, batch)."""

    def run(self) -> dict[str, Any]:
        """Measure."""
        from rotorpong.lab.bench.suites import Order, measure
        from rotorpong.lab.bench.tables import rows_table
        from rotorpong.lab.bench.timing import is_single_thread

        order = Order(
            self.what,
            self.quick,
            self.peers,
            self.flights,
            self.events,
            self.out,
            self.images,
            self.ball_class,
            self.colour,
            self.player,
        ).check()
        if not is_single_thread():
            say("numeric libraries run as many threads as they like: OMP_NUM_THREADS etc. unset")
        if self.what != "primitives":  # which has few kernels, and warms up
            compile_kernels()
        with progress_bar() as advance:
            rows = measure(order, advance)
        if not self.json:
            show(rows_table(rows))
            if self.out is not None:
                say(f"figures: {self.out}")
        return {"rows": [row.as_json() for row in rows]}
