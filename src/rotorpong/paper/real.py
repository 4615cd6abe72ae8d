"""Section V on the robot: what is learnt in the simulator's setting, ported without a change.

First test: "each of 4 motor primitives against balls fired by a human user", 20 balls each "with an
approximately constant direction and velocity". Before learning each "averaged a hitting rate of
approximately 20%", "after the first successful hits" 32.5 %. Second test: the 10 DMPs together, the
human "slightly changing in each throw the direction and initial velocity": about 10 % before, about
20 % after 80 successful hits. "No adjustments were made to the parameters used in simulation."

Here the robot is a model of the AR.Drone 2.0 with its own camera. `ardrone2_raw` takes the velocity
commands as fractions of the factory's limits, which is what a port without changes meets;
`ardrone2` flies them by a velocity loop of ours. Demonstrations, settings and learning are those
of the simulator.

Unknown: which 4 primitives (here the first 4 demonstrations), how many hits "the first" are (here
3), how many balls the second test had (here 200), and how far a person's throws scatter
(here the kinds `constant`: another throw for each primitive and repetition, 2 degrees and 0.2 m/s
about it; and `human`, the simulator's own serves). Each ball is played before and after.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotorpong.lab.evaluate import Knowledge, make_player, remember
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import wilson_interval
from rotorpong.lab.train import knowledge_of
from rotorpong.lab.trial import stage_of
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale, Training
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.paper.tally import HEADS, KINDS, percent, spread, tally
from rotorpong.play.hover import Hover
from rotorpong.world.serves import HUMAN

TITLE = "Section V on the robot: one primitive, then ten"
VEHICLES = {"as ported": "ardrone2_raw", "with a velocity loop": "ardrone2"}
CAMERA = "ardrone2_720p"
PRIMITIVES, FEW_PRIMITIVES = 4, 1
TIMES, FEW_TIMES = 4, 1  # the first test is repeated, with other throws
FIRST_HITS, FEW_FIRST_HITS = 3, 1
BALLS_EACH, FEW_BALLS_EACH = 20, 5
HITS, FEW_HITS = 80, 1
RUNS, FEW_RUNS = 1, 1  # of the second test
BALLS, FEW_BALLS = 200, 5
ONE, TEN = "1 primitive", "10 primitives"
PAPER = {ONE: (20.0, 32.5), TEN: (10.0, 20.0)}
SECONDS_PER_BALL = 0.1
STAGES = ("hover", "before", "after")
LEARNT = {ONE: "the first hits", TEN: f"{HITS} hits"}


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Train and play both tests on both vehicles; the serves are the same."""
    return tuple(
        Job(
            _key(vehicle, test, k),
            compared,
            (run.spec, _balls(scale, test)),
            (run,),
            seconds=2 * SECONDS_PER_BALL * _balls(scale, test),
        )
        for vehicle in VEHICLES
        for test in PAPER
        for k, run in enumerate(_runs(scale, vehicle, test))
    )


def compared(spec: Spec, balls: int, run: Path) -> dict[str, Any]:
    """Return how the same balls are played by who hovers, before learning and after."""
    known = knowledge_of(run)[1]
    stage, player = stage_of(spec), make_player(spec, Knowledge(known.demonstrations))
    hovering, before = tally(stage, Hover(), balls), tally(stage, player, balls)
    remember(player, known.trials)
    return {
        "hover": hovering,
        "before": before,
        "after": tally(stage, player, balls),
        "own_hits": sum(trial.outcome == "hit" for trial in known.trials),
        "training_balls": len(known.trials),
    }


def findings(scale: Scale, answers: Answers) -> Findings:
    """Pool primitives, repetitions and runs."""
    ours = {
        (vehicle, test): _told(scale, test, [answers[key] for key in keys])
        for vehicle in VEHICLES
        for test in PAPER
        for keys in [[_key(vehicle, test, k) for k, _ in enumerate(_runs(scale, vehicle, test))]]
    }
    return Findings(
        columns=(
            Column("own_hits", "own hits learnt from", 1),
            *(Column(key, HEADS[key], 1) for key in KINDS.values()),
            Column("moved_cm", "blade moved, cm", 1),
            Column("balls", "balls", 0),
        ),
        paper=tuple(_papers()),
        ours=[
            Line(f"{vehicle}, {test}, {stage}", values)
            for (vehicle, test), stages in ours.items()
            for stage, values in stages.items()
        ],
        setting=_setting(scale),
        figures={"real": _figure(ours)},
        remarks=_remarks(ours),
    )


def _runs(scale: Scale, vehicle: str, test: str) -> tuple[Training, ...]:
    """Return the training runs of one test: each primitive and repetition has throws of its own."""
    port = Spec(vehicle=VEHICLES[vehicle], camera=CAMERA)
    if test == TEN:
        hits = scale.of(HITS, FEW_HITS)
        seeds = [scale.seed + k for k in range(scale.of(RUNS, FEW_RUNS))]
        return tuple(Training(replace(port, seed=seed), hits) for seed in seeds)
    primitives, times = scale.of(PRIMITIVES, FEW_PRIMITIVES), scale.of(TIMES, FEW_TIMES)
    alone = replace(port, player="single", serves="constant")
    return tuple(
        Training(
            replace(alone, seed=scale.seed + k, player_settings=_only(k % primitives)),
            scale.of(FIRST_HITS, FEW_FIRST_HITS),
        )
        for k in range(primitives * times)
    )


def _only(primitive: int) -> PlayerSettings:
    return PlayerSettings(primitive=primitive)


def _balls(scale: Scale, test: str) -> int:
    return scale.of(BALLS, FEW_BALLS) if test == TEN else scale.of(BALLS_EACH, FEW_BALLS_EACH)


def _key(vehicle: str, test: str, k: int) -> str:
    return f"{vehicle}, {test}, {k}"


def _papers() -> Iterator[Line]:
    for test, rates in PAPER.items():
        hits = {"before": 0, "after": HITS if test == TEN else None}
        balls = PRIMITIVES * BALLS_EACH if test == ONE else None
        for (stage, learnt), rate in zip(hits.items(), rates, strict=True):
            values = {"own_hits": learnt, "hit_percent": rate, "balls": balls}
            yield Line(f"{test}, {stage}", values)


def _told(scale: Scale, test: str, played: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return what became of the balls, by stage."""
    size = scale.of(PRIMITIVES, FEW_PRIMITIVES) if test == ONE else len(played)
    found = {stage: _rates([one[stage] for one in played], size) for stage in STAGES}
    learnt = float(np.mean([one["own_hits"] for one in played]))
    for stage, values in found.items():
        values["own_hits"] = learnt if stage == "after" else 0.0
    found["after"] |= {
        "training_balls": float(np.mean([one["training_balls"] for one in played])),
        "trainings": len(played),
        "trainings_without_hit": sum(not one["own_hits"] for one in played),
    }
    return found


def _rates(tallies: Sequence[dict[str, Any]], size: int) -> dict[str, Any]:
    """Return shares of all balls; with their spread where so many tallies make one repetition."""
    balls, hits = (sum(one[what] for one in tallies) for what in ("balls", "hits"))
    low, high = wilson_interval(hits, balls) or (0.0, 1.0)
    times = [percent(tallies[k : k + size]) for k in range(0, len(tallies), size)]
    return {
        "balls": balls,
        **{key: percent(tallies, what) for what, key in KINDS.items()},
        "moved_cm": 100.0 * math.sqrt(sum(one["moved_m2"] for one in tallies) / balls),
        "hit_percent_interval": [100.0 * low, 100.0 * high],
        "hit_percent_sd": spread(times)["sd"],
        "hit_percent_by_repetition": times,
    }


def _setting(scale: Scale) -> dict[str, Any]:
    return {
        "vehicles": VEHICLES,
        "camera": CAMERA,
        "eyes": "paper",
        ONE: {
            "player": "single",
            "serves": "constant",
            "primitives": scale.of(PRIMITIVES, FEW_PRIMITIVES),
            "repetitions": scale.of(TIMES, FEW_TIMES),
            "hits": scale.of(FIRST_HITS, FEW_FIRST_HITS),
        },
        TEN: {
            "player": "paper",
            "serves": "human",
            "runs": scale.of(RUNS, FEW_RUNS),
            "hits": scale.of(HITS, FEW_HITS),
        },
    }


Told = dict[tuple[str, str], dict[str, dict[str, Any]]]


def _remarks(ours: Told) -> str:
    wide, high = HUMAN.target_left[1], HUMAN.target_up[1]
    return "\n\n".join([
        "In brackets Wilson's 95 % interval over all balls; after ± the standard deviation over "
        "repetitions of the first test, which throws of its own make wider than chance.",
        "\n".join(
            f"- {_change(vehicle, test, stages)}" for (vehicle, test), stages in ours.items()
        ),
        _floor(ours),
        "The robot here is a model and the person a distribution of throws, aimed up to "
        f"{100 * wide:.0f} cm beside the blade and {100 * high:.0f} cm above or below it: which "
        "primitives, how many first hits, how alike throws were and how near the drone they came "
        "is not told in the paper.",
    ])  # fmt: skip


def _change(vehicle: str, test: str, stages: dict[str, dict[str, Any]]) -> str:
    after = stages["after"]
    gain = after["hit_percent"] - stages["before"]["hit_percent"]
    lows, highs = zip(*(stages[s]["hit_percent_interval"] for s in STAGES[1:]), strict=True)
    apart = "" if max(lows) > min(highs) else ", within what chance does"
    nothing = after["trainings_without_hit"]
    return (
        f"{vehicle.capitalize()}, {test}: {stages['before']['hit_percent']:.1f} % before and "
        f"{after['hit_percent']:.1f} % after {after['own_hits']:.1f} own hits, "
        f"{after['training_balls']:.0f} balls a training: {gain:+.1f} points where the paper has "
        f"{PAPER[test][1] - PAPER[test][0]:+.1f}{apart}."
        + (
            f" {nothing} of {after['trainings']} trainings hit nothing to learn from."
            if nothing
            else ""
        )
    )


def _floor(ours: Told) -> str:
    """Say how much of it a drone hits that does not move, and how far these move."""
    ported, looped = VEHICLES
    hover = [f"{ours[ported, test]['hover']['hit_percent']:.1f} %" for test in PAPER]
    gone = {v: [ours[v, TEN][stage]["moved_cm"] for stage in STAGES] for v in VEHICLES}
    said = {v: f"{now:.1f} cm (hovering {still:.1f})" for v, (still, _, now) in gone.items()}
    hull = ours[ported, TEN]["after"]["hull_percent"]
    return (
        f"A ported drone that only hovers is hit on the blade by {' and '.join(hover)} of the two "
        f"tests' balls. After learning, the second test's blade has moved by {said[ported]} as "
        f"ported and {said[looped]} with a velocity loop when the ball comes, rms in its plane: "
        "what is commanded open loop acts late, and has little time. "
        f"{hull:.0f} % of the balls touch the ported drone's hull first, which is no hit."
    )


def _figure(ours: Told) -> Figure:
    """Draw what hovering, knowing demonstrations and having learnt hit, beside the paper's."""
    with drawing(7.2, 3.8) as figure:
        for axes, test in zip(figure.subplots(1, 2, sharey=True), PAPER, strict=True):
            _bars(axes, {v: stages for (v, its), stages in ours.items() if its == test}, test)
        figure.axes[0].set_ylabel("hits, % of balls")
        handles, names = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, names, frameon=False, ncols=4, loc="outside upper center")
    return figure


def _bars(axes: Axes, by_vehicle: dict[str, dict[str, dict[str, Any]]], test: str) -> None:
    colours = {"hover": "#cccccc", "before": COLOURS["sky"], "after": COLOURS["truth"]}
    width = 0.26
    for k, stage in enumerate(STAGES):
        told = [stages[stage] for stages in by_vehicle.values()]
        at = np.arange(len(told)) + width * (k - 1)
        heights = [one["hit_percent"] for one in told]
        bars = np.abs(np.array([one["hit_percent_interval"] for one in told]).T - heights)
        axes.bar(at, heights, width, color=colours[stage], label=stage)
        axes.errorbar(at, heights, bars, fmt="none", ecolor="black", elinewidth=0.8, capsize=2)
    for k, rate in enumerate(PAPER[test], start=1):
        ends = [(x + width * (k - 1.5), x + width * (k - 0.5)) for x in range(len(by_vehicle))]
        for left, right in ends:
            name = "paper" if k == 1 and left < 0.5 else None
            axes.plot([left, right], [rate, rate], color=COLOURS["light"], lw=2.5, label=name)
    axes.set_xticks(range(len(by_vehicle)), list(by_vehicle))
    axes.set_title(f"{test}, {LEARNT[test]}")
