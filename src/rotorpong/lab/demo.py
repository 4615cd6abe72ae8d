"""`rotorpong demo`: a drone learns to hit, from the first demonstration to the report.

    scripted pilot -> demonstrations -> paper's player -> own hits -> paper's player, trained
                                            |                              |
    hover ------------------------ the same balls --------------------- report

While it trains, the untrained play in other processes.
"""

import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from threading import Event
from typing import Any

from rich.table import Table

from rotorpong import __version__
from rotorpong.conventions import RotorpongError
from rotorpong.drone import Player
from rotorpong.experience import Demonstration
from rotorpong.experience.shipped import write_demonstrations
from rotorpong.lab.comparison import paired
from rotorpong.lab.demo_files import (
    DEMONSTRATIONS,
    EXPERIENCE,
    FILES,
    REPORT,
    RESULTS,
    finished_together,
)
from rotorpong.lab.demonstrate import PILOT, record_demonstrations
from rotorpong.lab.evaluate import Knowledge, Result, evaluate, make_player, summary
from rotorpong.lab.footage import Take, most_telling, play_again
from rotorpong.lab.report import FilmFrame, film_strip, report_page
from rotorpong.lab.spec import Spec, require_count
from rotorpong.lab.statistics import rate
from rotorpong.lab.tables import percent
from rotorpong.lab.train import knowledge_of, train
from rotorpong.lab.trial import Stage, stage_of
from rotorpong.lab.workers import cores

MOST_WORKERS = 4
CANDIDATES = 12  # hits among which the one to be shown is chosen
MISSES = ("near_hit", "miss", "hull", "unseen", "fault")

Advance = Callable[[str, int, int], None]
"""(what, done, of how many), called as work goes on."""


@dataclass(frozen=True, slots=True)
class DemoSize:
    """How much is played."""

    demonstrations: int = 10
    hits: int = 60
    balls: int = 120  # of each evaluation


WHOLE = DemoSize()


@dataclass(frozen=True, slots=True)
class DemoResult:
    """What a demo found, and where it was written."""

    out: Path
    found: dict[str, Any]  # the content of results.json

    def as_json(self) -> dict[str, Any]:
        """Return what `demo --json` prints: results.json without single balls, and the files."""
        players = [_without(player, "outcomes") for player in self.found["players"]]
        training = _without(self.found["training"], "outcomes")
        files = {name.split(".")[0]: str(self.out / name) for name in FILES}
        return {**self.found, "training": training, "players": players, "files": files}


def run_demo(
    out: Path,
    *,
    seed: int = 0,
    ball: str = "orange",
    workers: int | None = None,
    progress: Advance | None = None,
    size: DemoSize = WHOLE,
) -> DemoResult:
    """Record, learn, evaluate, and write the report.

    Args:
        out: folder for report.html, results.json, experience.sqlite and demonstrations.json.
        seed: of everything.
        ball: its colour.
        workers: processes of an evaluation; by default one for each core, four at most.
        progress: called with (what, done, of how many).
        size: how much is played.

    Raises:
        InputError: `out` is a file, cannot be written, or holds another's file of these names; or
            an unknown ball.
    """
    spec = Spec(seed=seed, ball=ball).check()
    workers = min(cores(), MOST_WORKERS) if workers is None else workers
    require_count("workers", workers)
    with finished_together(out) as draft:
        found = _Demo(draft, spec, workers, progress or _silent, size).run()
    return DemoResult(out, found)


def demo_table(result: DemoResult) -> Table:
    """Show who hit how many of the same balls."""
    table = Table(title="the same balls for everyone", title_justify="left")
    table.add_column("player")
    table.add_column("eyes")
    for column in ("hits", "balls", "hit rate", "95 % interval"):
        table.add_column(column, justify="right")
    for row in result.found["players"]:
        low, high = row["hit_rate_interval"]
        interval = f"{100 * low:.1f} - {100 * high:.1f} %"
        counts = (str(row["hits"]), str(row["balls"]))
        who = row["player"] if row["player"] == row["label"] else f"{row['player']}, {row['label']}"
        table.add_row(who, row["eyes"] or "-", *counts, percent(row["hit_rate"]), interval)
    return table


@dataclass(frozen=True, slots=True)
class _Demo:
    """One demo under way."""

    draft: Path
    spec: Spec
    workers: int
    progress: Advance
    size: DemoSize
    stop: Event = field(default_factory=Event)

    def run(self) -> dict[str, Any]:
        spec = self.spec
        shown = record_demonstrations(
            spec.seed, self.size.demonstrations, self._tell("demonstrations")
        )
        write_demonstrations(self.draft / DEMONSTRATIONS, shown)
        with ThreadPoolExecutor(1) as aside:
            first = aside.submit(self._untrained, spec, Knowledge(shown))
            try:
                if self.workers == 1:
                    first.result()
                known = self._train(spec, shown)
                hover, before = first.result()
            except BaseException:
                self.stop.set()
                raise
        after = self._evaluate(spec, known, "after training")
        found = _found(spec, known, {"hover": hover, "before": before, "after": after})
        self._report(spec, known, found, after)
        return found

    def _untrained(
        self, spec: Spec, start: Knowledge
    ) -> tuple[tuple[Result, ...], tuple[Result, ...]]:
        hover = self._evaluate(replace(spec, player="hover"), start, "hover")
        return hover, self._evaluate(spec, start, "before training")

    def _train(self, spec: Spec, shown: Sequence[Demonstration]) -> Knowledge:
        path, tell = self.draft / EXPERIENCE, self._tell("own hits")
        train(spec, self.size.hits, path, demonstrations=shown, progress=tell)
        return knowledge_of(path)[1]

    def _evaluate(self, spec: Spec, knowledge: Knowledge, what: str) -> tuple[Result, ...]:
        tell = self._tell(what)
        return evaluate(
            spec, self.size.balls, knowledge=knowledge, workers=self.workers, progress=tell
        )

    def _report(
        self, spec: Spec, known: Knowledge, found: dict[str, Any], after: Sequence[Result]
    ) -> None:
        tell = self._tell("report")
        tell(0, 3)
        stage = stage_of(spec)
        player = make_player(spec, known)
        shown = _to_show(stage, player, after)
        examples = _examples(stage, player, after)
        tell(1, 3)
        frames = film_strip(shown)
        found["shown"] = _described(shown, frames)
        text = json.dumps(found, indent=1, allow_nan=False) + "\n"
        (self.draft / RESULTS).write_text(text, "utf-8")
        tell(2, 3)
        page = report_page(found, shown, frames, examples)
        (self.draft / REPORT).write_text(page, "utf-8")
        tell(3, 3)

    def _tell(self, what: str) -> Callable[[int, int], None]:
        def tell(done: int, total: int) -> None:
            if self.stop.is_set():
                raise RotorpongError("the demo was stopped")
            self.progress(what, done, total)

        return tell


def _found(spec: Spec, known: Knowledge, results: dict[str, Sequence[Result]]) -> dict[str, Any]:
    shown = known.demonstrations
    outcomes = [trial.outcome for trial in known.trials]
    hits = outcomes.count("hit")
    training = {"balls": len(outcomes), "hits": hits, "hit_rate": rate(hits, len(outcomes))}
    return {
        "rotorpong": __version__,
        "command": f"rotorpong demo --seed {spec.seed}" + _unusual_ball(spec),
        "seed": spec.seed,
        "setting": {
            "vehicle": spec.vehicle_name,
            "camera": spec.camera_name,
            "serves": spec.serves_name,
            "racket": spec.racket,
            "eyes": spec.eyes,
            "ball": spec.ball,
        },
        "demonstrations": _shown_json(shown),
        "training": {**training, "outcomes": outcomes},
        "players": [
            _standing(who, replace(spec, player=who.player), results[who.name])
            for who in _players(len(shown), hits)
        ],
        "comparison": _comparison(results["before"], results["after"]),
    }


def _unusual_ball(spec: Spec) -> str:
    return "" if spec.ball == "orange" else f" --ball {spec.ball}"


def _shown_json(shown: Sequence[Demonstration]) -> dict[str, Any]:
    """Return who demonstrated; the last ball that was kept was also the last to be thrown."""
    return {"pilot": PILOT, "kept": len(shown), "balls": shown[-1].trial + 1}


@dataclass(frozen=True, slots=True)
class _Who:
    """A player of the demo, in words."""

    name: str
    player: str
    label: str
    knows: str


def _players(demonstrations: int, hits: int) -> tuple[_Who, ...]:
    return (
        _Who("hover", "hover", "hover", "stays where it is"),
        _Who("before", "paper", "untrained", f"knows {demonstrations} demonstrations"),
        _Who("after", "paper", "trained", f"learnt from {hits} own hits, too"),
    )


def _standing(who: _Who, spec: Spec, results: Sequence[Result]) -> dict[str, Any]:
    whole = summary(spec, results)
    kept = ("balls", "hits", "hit_rate", "hit_rate_interval", "miss_distance_median_m")
    return {
        **asdict(who),
        "eyes": None if spec.player == "hover" else spec.eyes,
        **{key: whole[key] for key in kept},
        "outcomes": [result.outcome for result in results],
    }


def _comparison(before: Sequence[Result], after: Sequence[Result]) -> dict[str, Any]:
    """Return on how many of the same balls training changed hit or miss (McNemar's exact test)."""
    old, new = ([result.outcome == "hit" for result in results] for results in (before, after))
    return paired(new, old)


def _to_show(stage: Stage, player: Player, results: Sequence[Result]) -> Take:
    """Return the finest hit; where there is none, the nearest miss."""
    hits = [result.index for result in results if result.outcome == "hit"]
    nearest = min(results, key=_nearness).index
    index = most_telling(stage, hits[:CANDIDATES], player) if hits else nearest
    return play_again(stage, index, player)


def _examples(stage: Stage, player: Player, results: Sequence[Result]) -> tuple[Take, ...]:
    """Return of each kind of miss the one in the middle."""
    takes = []
    for kind in MISSES:
        some = [result for result in results if result.outcome == kind]
        if some:
            middle = sorted(some, key=_nearness)[len(some) // 2]
            takes.append(play_again(stage, middle.index, player, look=False))
    return tuple(takes)


def _nearness(result: Result) -> float:
    return math.inf if result.miss_distance is None else result.miss_distance


def _described(take: Take, frames: Sequence[FilmFrame]) -> dict[str, Any]:
    verdict, trigger = take.played.verdict, take.trigger
    return {
        "index": take.played.index,
        "outcome": verdict.outcome,
        "contact_offset": verdict.contact_offset,
        "contact_time_s": verdict.contact_time,
        "trigger_time_s": None if trigger is None else trigger.time,
        "trigger_depth_m": None if trigger is None else float(trigger.position[2]),
        "miss_distance_m": take.played.miss_distance,
        "frames": [frame.as_json() for frame in frames],
    }


def _without(record: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in record.items() if name != key}


def _silent(what: str, done: int, total: int) -> None:
    """Tell nobody."""
