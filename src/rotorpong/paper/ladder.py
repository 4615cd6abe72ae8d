"""What each step beyond the paper buys: from a drone that hovers to one that knows everything.

Every rung keeps what the former gained and changes one thing. Each trains on its own hits and then
plays the same balls, those of `rotorpong evaluate`. Rungs aside are no part of the climb:
another way to a better CrKR, and the last rung with true states of the ball in place of eyes.

    as written        labels are where navdata say the drone was; the kernel 3 standard deviations
                      of the demonstrations wide, lambda 0.1 m^2: the paper's own are lost
    commanded labels  where the drone was told to be, its exploration included
    wide CrKR         12 and 0.002 m^2: the kernel reaches over all serves, and a label is as
                      uncertain as the blade is large (docs/players.md)
    float diameter    of the ball in the picture, not rounded to whole pixels
    tracker           a filter of flights in place of two frames' difference
    feed-forward      the drone's lag is made up for
    closed loop       navdata bring the drone back to its course
    oracle            knows the world, and searches
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotorpong.lab.eye_settings import EyeSettings
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import LEARNERS, Spec
from rotorpong.lab.statistics import skill
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale, Training
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.paper.same_balls import UNLIKELY, chance, gained, outcomes, shares

TITLE = "The ladder: what each step beyond the paper buys"
HITS, FEW_HITS = 170, 2
BALLS, FEW_BALLS = 500, 10
SECONDS_PER_BALL = 0.04
HOVER, WRITTEN, COMMANDED = "hover", "paper as written", "commanded labels"
WIDE, TUNED, FLOAT = "wide CrKR", "CrKR by marginal likelihood", "float diameter"
TRACKER, AHEAD, CLOSED = "tracker eyes", "feed-forward", "closed loop"
TRUE, ORACLE = "true states", "oracle"


@dataclass(frozen=True, slots=True)
class Rung:
    """One step."""

    label: str
    spec: Spec
    former: str | None  # that it is compared with
    aside: bool = False  # no part of the climb


def rungs(seed: int) -> tuple[Rung, ...]:
    """Return the ladder, from below."""
    written = Spec(
        player_settings=PlayerSettings(labels="achieved", length_scale=3.0, regularization=0.1),
        seed=seed,
    )
    commanded = _with(written, labels="commanded")
    wide = _with(commanded, length_scale=12.0, regularization=0.002)
    precise = replace(wide, eye_settings=EyeSettings(diameter="float"))
    tracking = replace(wide, eyes="tracker")
    ahead = replace(tracking, control="feed-forward")
    closed = replace(tracking, control="closed-loop")
    return (
        Rung(HOVER, Spec("hover", seed=seed), None),
        Rung(WRITTEN, written, HOVER),
        Rung(COMMANDED, commanded, WRITTEN),
        Rung(TUNED, _with(commanded, tune=True), COMMANDED, aside=True),
        Rung(WIDE, wide, COMMANDED),
        Rung(FLOAT, precise, WIDE),
        Rung(TRACKER, tracking, FLOAT),
        Rung(AHEAD, ahead, TRACKER),
        Rung(CLOSED, closed, AHEAD),
        Rung(TRUE, replace(closed, eyes="truth"), CLOSED, aside=True),
        Rung(ORACLE, Spec("oracle", eyes="truth", seed=seed), CLOSED),
    )


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Train who learns, and let everybody play the same balls."""
    return tuple(_job(rung, scale) for rung in rungs(scale.seed))


def findings(scale: Scale, answers: Answers) -> Findings:
    """Compare each rung with the former."""
    steps = rungs(scale.seed)
    values = {rung.label: shares(answers[rung.label]) for rung in steps}
    ends = [values[label]["hit_percent"] / 100.0 for label in (HOVER, ORACLE)]
    for rung in steps:
        found = values[rung.label]
        found["skill"] = skill(found["hit_percent"] / 100.0, *ends)
        if rung.former is not None:
            found |= gained(answers[rung.label], answers[rung.former])
            found["former"] = rung.former
    return Findings(
        columns=(
            Column("hit_percent", "hits, %", 1),
            Column("near_hit_percent", "near-hits, %", 1),
            Column("skill", "skill", 2),
            Column("points", "gain, points", 1),
            Column("won", "balls won", 0),
            Column("lost", "balls lost", 0),
            Column("p_value", "McNemar's p", 4),
            Column("training_balls", "training balls", 0),
        ),
        paper=(Line("after 170 hits, simulated", {"hit_percent": 30.0}),),
        ours=[Line(rung.label, values[rung.label]) for rung in steps],
        setting=_setting(scale, steps),
        figures={"ladder": _figure(steps, values)},
        remarks=_remarks(steps, values),
    )


def _with(spec: Spec, **settings: Any) -> Spec:
    return replace(spec, player_settings=replace(spec.player_settings, **settings))


def _job(rung: Rung, scale: Scale) -> Job:
    balls, spec = scale.of(BALLS, FEW_BALLS), rung.spec
    learns = spec.player in LEARNERS
    return Job(
        rung.label,
        outcomes,
        (spec, balls),
        (Training(spec, scale.of(HITS, FEW_HITS)),) if learns else (),
        seconds=balls * (SECONDS_PER_BALL if spec.eyes != "truth" and learns else 0.01),
    )


def _setting(scale: Scale, steps: Sequence[Rung]) -> dict[str, Any]:
    spec = steps[0].spec
    return {
        "vehicle": spec.vehicle_name,
        "camera": spec.camera_name,
        "serves": spec.serves_name,
        "balls": scale.of(BALLS, FEW_BALLS),
        "own_hits": scale.of(HITS, FEW_HITS),
        "aside": [rung.label for rung in steps if rung.aside],
    }


Values = Mapping[str, dict[str, Any]]


def _remarks(steps: Sequence[Rung], values: Values) -> str:
    """Say what each step buys, and what all of them together do."""
    bought = [_step(rung, values[rung.label]) for rung in steps if rung.former is not None]
    lowest, highest = values[WRITTEN], values[CLOSED]
    return "\n\n".join([
        "Won and lost are balls that only this rung, or only the former, hit; skill is 0 for who "
        "hovers and 1 for the oracle. Rungs were trained once each: McNemar's p tells these "
        "players apart, and another training would come out otherwise by a point or two. Rungs "
        "aside are compared with the rung that they would replace or follow.",
        "What the steps buy: " + "; ".join(bought) + ".",
        f"From the paper's text to the last rung that sees with its own camera the hit rate is "
        f"{lowest['hit_percent']:.1f} and {highest['hit_percent']:.1f} %, on a scale from "
        f"{values[HOVER]['hit_percent']:.1f} % (who hovers) to {values[ORACLE]['hit_percent']:.1f}"
        f" % (the oracle): skill {_skill(lowest)} and {_skill(highest)}. {_left(values)}",
    ])  # fmt: skip


def _step(rung: Rung, found: dict[str, Any]) -> str:
    sure = found["p_value"] < UNLIKELY
    points = f"{found['points']:+.1f} points, {chance(found['p_value'])}"
    if not sure:
        points += ", which chance would do as well"
    other = f" against {found['former']}" if rung.aside else ""
    return f"{rung.label}{other} {points}"


def _skill(found: dict[str, Any]) -> str:
    return "unknown" if found["skill"] is None else f"{found['skill']:.2f}"


def _left(values: Values) -> str:
    """Say what better eyes than the last would still buy."""
    true, last = values[TRUE], values[CLOSED]
    more = "" if true["p_value"] < UNLIKELY else ", too little to be told from nothing"
    return (
        f"With true states of the ball it is {true['hit_percent'] - last['hit_percent']:+.1f} "
        f"points{more}; the other {100.0 - true['hit_percent']:.1f} points up to all balls are "
        "those of a player that decides once, 2.5 m before the ball, and learns from its own hits."
    )


def _figure(steps: Sequence[Rung], values: Values) -> Figure:
    """Draw hit rates with intervals, the first rung at the bottom."""
    with drawing(7.2, 4.6) as figure:
        axes = figure.subplots()
        for height, rung in enumerate(steps):
            _bar(axes, height, rung, values[rung.label])
        axes.axvline(30.0, color=COLOURS["paper"], linestyle=":", linewidth=1.2)
        axes.annotate("the paper's 30 %", (30.0, len(steps) - 0.35), (4, 0), fontsize=8,
                      textcoords="offset points", color=COLOURS["paper"])  # fmt: skip
        axes.set_yticks(range(len(steps)), [_name(rung) for rung in steps])
        axes.set(xlim=(0.0, 112.0), ylim=(-0.6, len(steps) + 0.1), xlabel="hits, % (95 % interval)")
        axes.set_xticks(range(0, 101, 20))
        axes.grid(visible=False, axis="y")
    return figure


def _name(rung: Rung) -> str:
    return f"({rung.label})" if rung.aside else rung.label


def _bar(axes: Axes, height: int, rung: Rung, found: dict[str, Any]) -> None:
    """Draw one rung, what it gained beside it."""
    percent, ends = found["hit_percent"], np.array(found["hit_percent_interval"])
    learns = rung.spec.player in LEARNERS
    kind = rung.spec.eyes if learns else "other"
    colour = {"paper": "vision", "tracker": "tracker", "truth": "truth", "other": "paper"}[kind]
    axes.barh(height, percent, 0.66, color=COLOURS[colour], alpha=0.45 if rung.aside else 1.0)
    error = np.abs(ends - percent)[:, None]
    axes.errorbar(percent, height, xerr=error, color="black", capsize=2.5, linewidth=1.0)
    gain = "" if rung.former is None else f"{found['points']:+.1f}"
    axes.annotate(gain, (ends[1], height), (5, 0), textcoords="offset points", fontsize=8.5,
                  va="center")  # fmt: skip
