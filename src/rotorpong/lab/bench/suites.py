"""What `rotorpong bench` measures: suites of sections, each a module imported in its turn.

A section's module returns rows. Rows that need a peer, or data that not everybody has, belong to
sections that are asked for.
"""

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from rotorpong.conventions import InputError
from rotorpong.files import prepare_folder
from rotorpong.lab.bench.rows import Row

REACH_BALLS = 100  # of each kind on each vehicle; reach_rows.rows(balls=...) takes more

Suite = Literal["world", "eyes", "primitives", "learning", "control", "players"]
BELONGS: Mapping[str, tuple[Suite, ...]] = {  # what can be ordered of some suites only
    "peers": ("world", "primitives", "learning"),
    **dict.fromkeys(("flights", "events"), ("world",)),
    "out": ("world", "eyes", "players"),
    "player": ("players",),
    **dict.fromkeys(("images", "ball_class", "colour"), ("eyes",)),
}

Advance = Callable[[str, int, int], None]  # what, done, of how many


@dataclass(frozen=True, slots=True)
class Order:
    """What is asked for."""

    suite: Suite = "world"
    quick: bool = False  # few repetitions, and nothing that takes minutes
    peers: bool = False
    flights: Path | None = None  # measured flights, a folder
    events: Path | None = None  # measured events, a file or a folder
    out: Path | None = None  # folder for figures
    images: Path | None = None  # labelled pictures, a folder
    ball_class: int | None = None  # in their labels
    colour: str | None = None  # to look for in them, as `detect` takes it
    player: str | None = None  # a user's own, as FILE.py:CLASS

    def check(self) -> "Order":
        """Return the order if all that it names can be read and written, before all measuring.

        Raises:
            InputError: something belongs to another suite, data are missing or damaged, a peer
                cannot be had, or figures cannot be written.
        """
        self._check_suite()
        if self.flights is not None and not self.flights.is_dir():
            raise InputError(f"--flights {self.flights}: expected a folder of measured flights")
        if self.events is not None and not self.events.exists():
            raise InputError(f"--events {self.events}: no such file or folder of measured events")
        if self.flights is not None:
            _module("real_flights").require(self.flights)
        if self.events is not None:
            _module("real_events").require(self.events)
        self._check_images()
        if self.player is not None:
            _module("player_rows").require(self.player)
        if self.peers:
            _module("peers").require(suite=self.suite)
        if self.out is not None:
            prepare_folder(self.out)
        return self

    def _check_suite(self) -> None:
        for name, suites in BELONGS.items():
            if getattr(self, name) not in (None, False) and self.suite not in suites:
                raise InputError(
                    f"{_flag(name)} with bench {self.suite}: belongs to bench {' or '.join(suites)}"
                )

    def _check_images(self) -> None:
        if self.images is not None:
            _module("image_rows").require(self.images, self.ball_class, self.colour)
        for name in ("ball_class", "colour"):
            if getattr(self, name) is not None and self.images is None:
                raise InputError(f"{_flag(name)}: expected --images beside it")


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


@dataclass(frozen=True, slots=True)
class Section:
    """Rows that are measured together."""

    title: str
    rows: Callable[[Order, Advance], tuple[Row, ...]]
    asked: Callable[[Order], bool] = lambda order: True


def _module(name: str) -> Any:
    """Return a module of this folder; imported only now, for what it imports is heavy."""
    return importlib.import_module(f"rotorpong.lab.bench.{name}")


def _named(tell: Advance, what: str) -> Callable[[int, int], None]:
    return lambda done, total: tell(f"bench: {what}", done, total)


WORLD = (
    Section("ball", lambda order, tell: _module("ball_rows").rows(quick=order.quick)),
    Section("vehicle", lambda order, tell: _module("vehicle_rows").rows(quick=order.quick)),
    Section("world", lambda order, tell: _module("world_speed").rows(quick=order.quick)),
    Section(
        "render", lambda order, tell: _module("render_rows").rows(), lambda order: not order.quick
    ),
    Section(
        "reach",
        lambda order, tell: _module("reach_rows").rows(balls=REACH_BALLS),
        lambda order: not order.quick,
    ),
    Section(
        "batch", lambda order, tell: _module("batch_rows").rows(), lambda order: not order.quick
    ),
    Section(
        "flights",
        lambda order, tell: _module("real_flights").rows(order.flights, _named(tell, "flights")),
        lambda order: order.flights is not None,
    ),
    Section(
        "events",
        lambda order, tell: _module("real_events").rows(order.events, _named(tell, "events")),
        lambda order: order.events is not None,
    ),
    Section(
        "peers",
        lambda order, tell: _module("peers").rows(quick=order.quick),
        lambda order: order.peers,
    ),
)
EYES = (
    Section(
        "measuring", lambda order, tell: _module("eyes_rows").measurement_rows(quick=order.quick)
    ),
    Section("tracking", lambda order, tell: _module("tracking_rows").rows(quick=order.quick)),
    Section("predicting", lambda order, tell: _module("prediction_rows").rows(quick=order.quick)),
    Section(
        "images",
        lambda order, tell: _module("image_rows").rows(
            order.images, _named(tell, "images"), ball_class=order.ball_class, colour=order.colour
        ),
        lambda order: order.images is not None,
    ),
)
PRIMITIVES = (
    Section("primitives", lambda order, tell: _module("primitives_rows").rows(quick=order.quick)),
    Section(
        "peers",
        lambda order, tell: _module("peers").rows(quick=order.quick, suite="primitives"),
        lambda order: order.peers,
    ),
)
LEARNING = (
    Section("learning", lambda order, tell: _module("learning_rows").rows(quick=order.quick)),
    Section("selecting", lambda order, tell: _module("selection_rows").rows(quick=order.quick)),
    Section(
        "peers",
        lambda order, tell: _module("peers").rows(quick=order.quick, suite="learning"),
        lambda order: order.peers,
    ),
)
CONTROL = (Section("control", lambda order, tell: _module("control_rows").rows(quick=order.quick)),)
PLAYERS = (
    Section(
        "players",
        lambda order, tell: _module("player_rows").rows(
            _named(tell, "players"), own=order.player, out=order.out, quick=order.quick
        ),
    ),
)
SUITES: Mapping[Suite, tuple[Section, ...]] = {
    "world": WORLD,
    "eyes": EYES,
    "primitives": PRIMITIVES,
    "learning": LEARNING,
    "control": CONTROL,
    "players": PLAYERS,
}


def measure(order: Order, advance: Advance) -> tuple[Row, ...]:
    """Return the rows of all sections that are asked for, in order.

    Args:
        order: what is asked for.
        advance: called with a section's title and how many of how many sections are done.
    """
    chosen = [section for section in SUITES[order.suite] if section.asked(order)]
    rows: list[Row] = []
    for done, section in enumerate(chosen):
        advance(f"bench: {section.title}", done, len(chosen))
        rows.extend(section.rows(order, advance))
        advance(f"bench: {section.title}", len(chosen), len(chosen))
    if order.out is not None and order.suite in {"world", "eyes"}:
        advance("bench: figures", 0, 1)
        if order.suite == "world":
            _module("growth").draw_growth(order.out, quick=order.quick)
        else:
            _module("eyes_figures").draw_eyes(order.out, rows)
        advance("bench: figures", 1, 1)
    return tuple(rows)
