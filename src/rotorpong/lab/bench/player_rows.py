"""Who hits how many of the same balls, and how that grows with what was learnt: `bench players`.

Every player meets the same human serves with the paper's eyes (the oracle with true states: it is
the bound). Those that learn train on their own hits first, each with the same training balls, and
are measured with the first 0, 40 and 170 of these hits. Rates are in per cent, with Wilson's 95 %
interval. Five minutes with two cores; with --quick one minute, and far too few balls to tell
players apart.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rotorpong.conventions import InputError
from rotorpong.experience import Trial, shipped_demonstrations
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.evaluate import Knowledge, evaluate
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.report.ink import STYLE
from rotorpong.lab.spec import LEARNERS, Spec
from rotorpong.lab.statistics import wilson_interval
from rotorpong.lab.train import knowledge_of, train
from rotorpong.lab.workers import cores, in_workers

PAPERS = "paper, labels commanded"
GOAL = 30.0  # % that the paper's player is to hit after the last of the hits
FIGURE = "learning_curves.png"
APART, QUIET = 1.5, "#888888"  # own hits; colour of those that do not learn
ACHIEVED = PlayerSettings(labels="achieved")
WIDE = PlayerSettings(length_scale=12.0, regularization=0.002)
"""The kernel reaches over all serves that come, and a label is as noisy as the blade is large."""
TUNED = PlayerSettings(tune=True)
AHEAD = "feed-forward"


@dataclass(frozen=True, slots=True)
class Size:
    """How much is played."""

    balls: int = 200  # of each measurement
    own_hits: tuple[int, ...] = (0, 40, 170)  # when learners are measured


WHOLE, QUICK = Size(), Size(20, (0, 3))


@dataclass(frozen=True, slots=True)
class Entrant:
    """Who plays, and what that is called."""

    name: str
    spec: Spec


@dataclass(frozen=True, slots=True)
class Standing:
    """Hits of so many balls, after so many own hits were learnt from."""

    own_hits: int
    hits: int
    balls: int

    @property
    def percent(self) -> tuple[float, tuple[float, float]]:
        """The hit rate and its interval."""
        low, high = wilson_interval(self.hits, self.balls) or (0.0, 1.0)
        return 100.0 * self.hits / self.balls, (100.0 * low, 100.0 * high)


Curve = tuple[Standing, ...]


def entrants(own: str | None = None, *, seed: int = 0) -> tuple[Entrant, ...]:
    """Return everybody, and a user's own player."""
    ours = (
        Entrant("hover", Spec("hover")),
        Entrant("nearest demonstration", Spec("nearest")),
        Entrant("single primitive", Spec("single")),
        Entrant("paper, labels achieved", Spec("paper", player_settings=ACHIEVED)),
        Entrant(PAPERS, Spec("paper")),
        Entrant("paper, length scale 12, lambda 0.002", Spec("paper", player_settings=WIDE)),
        Entrant("paper, feed-forward", Spec("paper", control=AHEAD)),
        Entrant(
            "paper, length scale 12, lambda 0.002, feed-forward",
            Spec("paper", player_settings=WIDE, control=AHEAD),
        ),
        Entrant("paper, tuned CrKR", Spec("paper", player_settings=TUNED)),
        Entrant("bandit on the hitting point", Spec("bandit")),
        Entrant("oracle, true states", Spec("oracle", eyes="truth")),
    )
    everybody = ours if own is None else (*ours, Entrant(own, Spec(own)))
    return tuple(replace(one, spec=replace(one.spec, seed=seed)) for one in everybody)


def require(own: str) -> None:
    """Raise InputError unless `own` names a user's own player."""
    spec = Spec(own)
    if not spec.is_own_player:
        raise InputError(f"--player {own}: plays anyway or is none; expected FILE.py:CLASS")
    spec.check()


def rows(
    progress: Callable[[int, int], None],
    *,
    own: str | None = None,
    out: Path | None = None,
    quick: bool = False,
) -> tuple[Row, ...]:
    """Measure everybody; draw the learning curves into the folder `out`."""
    everybody, size = entrants(own), QUICK if quick else WHOLE
    curves: list[Curve] = []
    for curve in _curves(everybody, size, 1 if quick else cores()):
        curves.append(curve)
        progress(len(curves), len(everybody))
    named = {one.name: curve for one, curve in zip(everybody, curves, strict=True)}
    if out is not None:
        learning_curves(named).savefig(out / FIGURE, dpi=110)
    return tuple(_row(name, standing) for name, curve in named.items() for standing in curve)


def curve_of(entrant: Entrant, size: Size) -> Curve:
    """Let an entrant learn, if it does, and measure it on the way."""
    start = Knowledge(shipped_demonstrations())
    if entrant.spec.player not in LEARNERS:
        return (_standing(entrant, start, 0, size.balls),)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "experience.sqlite"
        won = train(entrant.spec, max(size.own_hits), path).hits
        known = knowledge_of(path)[1]
    marks = sorted({min(mark, won) for mark in size.own_hits})
    return tuple(
        _standing(entrant, replace(known, trials=until(known.trials, mark)), mark, size.balls)
        for mark in marks
    )


def until(trials: Sequence[Trial], hits: int) -> tuple[Trial, ...]:
    """Return the trials up to and with that many hits."""
    before = accumulate((trial.outcome == "hit" for trial in trials), initial=0)
    return tuple(trial for trial, won in zip(trials, before, strict=False) if won < hits)


def learning_curves(curves: dict[str, Curve]) -> Figure:
    """Draw hit rates over own hits; those that do not learn are told below, and drawn if they fit.

    Points of several players are drawn a little apart, so that their intervals can be seen.
    """
    learnt = {name: curve for name, curve in curves.items() if len(curve) > 1}
    levels = {name: curve[0].percent[0] for name, curve in curves.items() if len(curve) == 1}
    with mpl.rc_context(STYLE):  # pyright: ignore[reportArgumentType]
        figure = Figure(figsize=(7.2, 5.2), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        for k, (name, curve) in enumerate(learnt.items()):
            _draw(axes, name, curve, aside=APART * (k - 0.5 * (len(learnt) - 1)))
        _, top = axes.get_ylim()
        for name, level in levels.items():
            shade = QUIET if level < top else "none"
            axes.axhline(
                min(level, top), color=shade, linestyle="--", label=f"{name}: {level:.1f} %"
            )
        axes.set(xlabel="own hits learnt from", ylabel="hit rate, % (Wilson's 95 % interval)")
        axes.set_ylim(0.0, top)
        figure.legend(frameon=False, loc="outside lower center", ncols=2)
        return figure


def _draw(axes: Axes, name: str, curve: Curve, *, aside: float) -> None:
    rates = [standing.percent for standing in curve]
    bars = [[rate - low, high - rate] for rate, (low, high) in rates]
    at, heights = [standing.own_hits + aside for standing in curve], [rate for rate, _ in rates]
    axes.errorbar(at, heights, list(zip(*bars, strict=True)), label=name, capsize=2, fmt="o-", ms=4)


def _curves(everybody: Sequence[Entrant], size: Size, workers: int) -> Iterator[Curve]:
    tasks = [(one, size) for one in everybody]
    if workers == 1:
        return map(_measured, tasks)
    return in_workers(_measured, tasks, workers=workers)


def _measured(task: tuple[Entrant, Size]) -> Curve:
    return curve_of(*task)


def _standing(entrant: Entrant, known: Knowledge, own_hits: int, balls: int) -> Standing:
    results = evaluate(entrant.spec, balls, knowledge=known)
    return Standing(own_hits, sum(one.outcome == "hit" for one in results), balls)


def _row(name: str, standing: Standing) -> Row:
    rate, interval = standing.percent
    learnt = f", {standing.own_hits} own hits" if standing.own_hits else ""
    aimed = name == PAPERS and standing.own_hits == max(WHOLE.own_hits)
    target, unit = GOAL if aimed else None, f"% of {standing.balls} balls"
    return Row(f"hit rate: {name}{learnt}", rate, unit, target, interval=interval)
