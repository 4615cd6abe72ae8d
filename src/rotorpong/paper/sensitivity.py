"""How much hangs on what the paper leaves open: one setting changed at a time.

The paper's player with the paper's eyes, everything as it is by default, trains on its own hits and
plays; then again with one setting changed. Changed are the window in which serves pass the drone,
the camera's rate (the AR.Drone's is 30 frames/s, tum_simulator's camera ran at 60), what a hit
teaches, how far training explores, and what sets a motion going: the plane or the distance, and how
far away. Where eyes decide when that is, the same is done with true states of the ball. Every
setting is trained and played once with each seed; settings of one seed meet the same balls, but for
the serve windows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import skill
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale, Training
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.paper.same_balls import UNLIKELY, chance, gained, outcomes, pooled, shares
from rotorpong.paper.trajectory import FAST
from rotorpong.world.serves import HUMAN, ServeKind

TITLE = "Sensitivity: what hangs on settings that the paper leaves open"
HITS, FEW_HITS = 80, 1
BALLS, FEW_BALLS = 150, 6  # with each seed
SEEDS, FEW_SEEDS = 2, 1
SECONDS_PER_BALL = {"paper": 0.04, "truth": 0.012}
USUAL = "default"
EYES = {"vision": "paper", "truth": "truth"}


@dataclass(frozen=True, slots=True)
class Change:
    """One setting that is changed."""

    label: str
    spec: Spec
    truth: bool = False  # also played with true states
    serves: bool = False  # the balls are others


def changes() -> tuple[Change, ...]:
    """Return the default, and what is changed of it."""
    usual = Spec()
    return (
        Change(USUAL, usual, truth=True),
        Change("serve window x 0.5", replace(usual, serves=window(0.5)), serves=True),
        Change("serve window x 1.5", replace(usual, serves=window(1.5)), serves=True),
        Change("60 frames/s", replace(usual, camera=FAST), truth=True),
        Change("labels achieved", _with(labels="achieved")),
        Change("exploration 5 cm", _with(exploration_sd=0.05)),
        Change("exploration 20 cm", _with(exploration_sd=0.20)),
        Change("trigger by distance", _with(trigger="distance"), truth=True),
        Change("plane at 2.0 m", _with(plane_distance=2.0), truth=True),
        Change("plane at 3.0 m", _with(plane_distance=3.0), truth=True),
    )


def window(factor: float) -> ServeKind:
    """Return human serves whose targets on the blade's plane spread by this factor."""
    left, up = ((factor * low, factor * high) for low, high in (HUMAN.target_left, HUMAN.target_up))
    return replace(HUMAN, name=f"human, window x {factor:g}", target_left=left, target_up=up)


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Train and play every setting, and hover before every kind of serve."""
    seeds = range(scale.of(SEEDS, FEW_SEEDS))
    return tuple(
        job
        for seed in seeds
        for change in changes()
        for job in (
            *(_job(change, label, seed, scale) for label in _eyes(change)),
            *([_hovering(change, seed, scale)] if _has_floor(change) else []),
        )
    )


def findings(scale: Scale, answers: Answers) -> Findings:
    """Compare each setting with the default."""
    runs = {
        (change.label, label): _pooled(answers, change.label, label, scale)
        for change in changes()
        for label in _eyes(change)
    }
    hover = {c.label: _pooled(answers, c.label, "hover", scale) for c in changes() if _has_floor(c)}
    lines = {
        (change.label, label): _values(change, label, runs, hover)
        for change in changes()
        for label in _eyes(change)
    }
    return Findings(
        columns=(
            Column("hit_percent", "hits, %", 1),
            Column("points", "against default, points", 1),
            Column("won", "balls won", 0),
            Column("lost", "balls lost", 0),
            Column("p_value", "McNemar's p", 3),
            Column("near_hit_percent", "near-hits, %", 1),
            Column("hover_percent", "who hovers, %", 1),
            Column("skill", "skill", 2),
            Column("training_balls", "training balls", 0),
        ),
        paper=(),
        ours=[Line(f"{label}: {name}", values) for (name, label), values in lines.items()],
        setting=_setting(scale),
        figures={"sensitivity": _figure(lines)},
        remarks=_remarks(lines),
    )


def _with(**settings: Any) -> Spec:
    return Spec(player_settings=PlayerSettings(**settings))


def _eyes(change: Change) -> tuple[str, ...]:
    return tuple(EYES) if change.truth else ("vision",)


def _has_floor(change: Change) -> bool:
    """Whether it says how many balls a drone hits that hovers: once for each kind of serve."""
    return change.serves or change.label == USUAL


def _key(name: str, label: str, seed: int) -> str:
    return f"{name}, {label}, {seed}"


def _job(change: Change, label: str, seed: int, scale: Scale) -> Job:
    spec = replace(change.spec, eyes=EYES[label], seed=scale.seed + seed)
    balls = scale.of(BALLS, FEW_BALLS)
    return Job(
        _key(change.label, label, seed),
        outcomes,
        (spec, balls),
        (Training(spec, scale.of(HITS, FEW_HITS)),),
        seconds=SECONDS_PER_BALL[spec.eyes] * balls,
    )


def _hovering(change: Change, seed: int, scale: Scale) -> Job:
    spec = Spec("hover", serves=change.spec.serves, seed=scale.seed + seed)
    key = _key(change.label, "hover", seed)
    return Job(key, outcomes, (spec, scale.of(BALLS, FEW_BALLS)), seconds=1.0)


def _pooled(answers: Answers, name: str, label: str, scale: Scale) -> dict[str, Any]:
    seeds = range(scale.of(SEEDS, FEW_SEEDS))
    return pooled([answers[_key(name, label, seed)] for seed in seeds])


Runs = Mapping[tuple[str, str], dict[str, Any]]


def _values(
    change: Change, label: str, runs: Runs, hover: Mapping[str, dict[str, Any]]
) -> dict[str, Any]:
    """Return one line: shares, skill, and the difference from the default."""
    run, usual = runs[change.label, label], runs[USUAL, label]
    floor = shares(hover[change.label if change.serves else USUAL])["hit_percent"]
    values = shares(run)
    values["hover_percent"] = floor
    ends = (floor / 100.0, values["reachable_percent"] / 100.0)
    values["skill"] = skill(values["hit_percent"] / 100.0, *ends)
    if change.serves:
        values["points"] = values["hit_percent"] - shares(usual)["hit_percent"]
    elif change.label != USUAL:
        values |= gained(run, usual)
    return values


def _setting(scale: Scale) -> dict[str, Any]:
    usual = Spec()
    return {
        "default": {
            "vehicle": usual.vehicle_name,
            "camera": usual.camera_name,
            "serves": usual.serves_name,
            "player": usual.player_settings.as_json(usual.player),
        },
        "own_hits": scale.of(HITS, FEW_HITS),
        "balls_per_seed": scale.of(BALLS, FEW_BALLS),
        "seeds": scale.of(SEEDS, FEW_SEEDS),
    }


def _remarks(lines: Runs) -> str:
    """Say which settings matter."""
    apart = {where: v for where, v in lines.items() if v.get("p_value", 1.0) < UNLIKELY}
    alike = [name for name, v in lines.items() if v.get("p_value", 0.0) >= UNLIKELY]
    said = [
        "Hits of all seeds together, with Wilson's interval; skill is 0 for who hovers before the "
        "same serves and 1 for all reachable balls. McNemar's p is of the same balls, so serve "
        "windows have none; one in twenty settings without any effect has p < 0.05.",
        _windows(lines),
    ]
    if apart:
        each = (
            f"{name} with {label} ({v['points']:+.1f} points, {chance(v['p_value'])})"
            for (name, label), v in apart.items()
        )
        said.append(f"Told apart from the default: {'; '.join(each)}.")
    if alike:
        each = (f"{name} with {label}" for name, label in alike)
        said.append(f"Not told apart by so few balls: {'; '.join(each)}.")
    return "\n\n".join(said)


def _windows(lines: Runs) -> str:
    """Say what the serve window does to the hit rate and to skill."""
    each = [
        f"{name} {lines[name, 'vision']['hit_percent']:.1f} % (who hovers "
        f"{lines[name, 'vision']['hover_percent']:.1f} %)"
        for name in ("serve window x 0.5", USUAL, "serve window x 1.5")
    ]
    return (
        "How widely balls are thrown decides more than any player does, and the paper does not "
        f"tell it: {', '.join(each)}."
        if _window_span(lines) > _widest_other(lines)
        else f"Serve windows: {', '.join(each)}."
    )


def _window_span(lines: Runs) -> float:
    found = [lines[f"serve window x {factor}", "vision"]["points"] for factor in ("0.5", "1.5")]
    return abs(found[0] - found[1])


def _widest_other(lines: Runs) -> float:
    """Return the largest difference that a setting of player or camera makes, points."""
    return max(abs(v["points"]) for v in lines.values() if "p_value" in v)


def _figure(lines: Runs) -> Figure:
    """Draw hit rates as dots with intervals, the default's as a band."""
    names = tuple(dict.fromkeys(name for name, _ in lines))
    with drawing(7.2, 4.6) as figure:
        axes = figure.subplots()
        for label in EYES:
            usual = lines[USUAL, label]
            axes.axvspan(*usual["hit_percent_interval"], color=COLOURS[label], alpha=0.10, lw=0)
            axes.axvline(usual["hit_percent"], color=COLOURS[label], linewidth=0.9, linestyle="--")
            _dots(axes, names, label, lines)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set_xlim(left=0.0)
        axes.set_xlabel("hits, % (95 % interval; bands: of the default)")
        figure.legend(frameon=False, ncols=3, loc="outside upper center")
    return figure


def _dots(axes: Axes, names: Sequence[str], label: str, lines: Runs) -> None:
    """Draw what one pair of eyes came to, and below vision's who hovers."""
    aside = {"vision": 0.13, "truth": -0.13}[label]
    shown = {names.index(name): v for (name, eyes), v in lines.items() if eyes == label}
    percents = np.array([v["hit_percent"] for v in shown.values()])
    ends = np.array([v["hit_percent_interval"] for v in shown.values()]).T
    heights = np.array(list(shown)) + aside
    axes.errorbar(
        percents, heights, xerr=np.abs(ends - percents), fmt="o", capsize=2.5, markersize=5,
        color=COLOURS[label],
        label={"vision": "the paper's eyes", "truth": "true states"}[label],
    )  # fmt: skip
    if label == "vision":
        hovering = [v["hover_percent"] for v in shown.values()]
        axes.plot(hovering, heights, "|", color="black", markersize=9, label="who hovers")
