"""Fig. 7a: how CrKR's error falls with the number of samples, for several lambda.

The paper took 170 successful hits and "measured how the estimation error varied with the number of
samples and as a function of the parameter lambda": a quick improvement, then a plateau, "due mainly
to the large errors in the ball velocity estimates". The curves are a figure that we cannot read;
its values of lambda, what error it shows, of which samples and in which unit are not told.

Here the samples are the demonstrations and after them own hits of a training run in the order in
which they were hit, learnt by the player's own regression: s in standard deviations of the
demonstrations, costs from rewards. Two errors, both in the plane of the blade, X and Y, as mean
distance:

    label    predicted position against the label of hits of another run, as the paper could have
    place    predicted position against where the ball really passes, of serves as they come, most
             of which were not hit; only a simulator can tell

Labels are `commanded` (where the motion was to end, exploration included) or `achieved` (where
navdata say the body was; the paper's text). They are of the same hits: a run that learns commanded
labels, played again for the others. Runs differ in all balls and exploration.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.learners import settings_of
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import knowledge_of
from rotorpong.paper import fig7b
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale, Training
from rotorpong.paper.hits import Hit, Serve, hits_again, serves_seen
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.play.paper import PaperPlayer, PaperSettings

TITLE = "Fig. 7a: error of the predicted hitting point against samples, by lambda"
OWN_HITS, FEW_OWN_HITS = (0, 10, 20, 40, 70, 100, 130, 160), (0, 3, 6)
RUNS, FEW_RUNS = 5, 2  # training runs, each tested on the hits of the next
SERVES, FEW_SERVES = 100, 10  # of each run's seed, for `place`
LAMBDAS = tuple(sorted({0.0005, 0.002, 0.02, 0.2, 2.0, PaperSettings().regularization}))  # m^2
LABELS = ("commanded", "achieved")
ERRORS = ("label", "place")
SECONDS_PER_HIT = {"truth": 0.01, "vision": 0.04}


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Work on each eyes' runs, which are those of Fig. 7b."""
    marks, serves = scale.of(OWN_HITS, FEW_OWN_HITS), scale.of(SERVES, FEW_SERVES)
    found = []
    for label in fig7b.EYES:
        runs = _runs(scale, label)
        hits = len(runs) * (runs[0].hits + serves)
        specs = tuple(run.spec for run in runs)
        seconds = SECONDS_PER_HIT[label] * hits
        found.append(Job(label, measured, (specs, marks, serves), runs, seconds=seconds))
    return tuple(found)


def measured(
    specs: Sequence[Spec], marks: Sequence[int], serves: int, *runs: Path
) -> dict[str, Any]:
    """Return errors, cm: by labels, lambda and kind of error, a row for each run, by mark."""
    known = [knowledge_of(run)[1] for run in runs]
    hits = [list(hits_again(*pair)) for pair in zip(specs, known, strict=True)]
    seen = [serves_seen(spec, serves) for spec in specs]
    lessons = lessons_of(known[0].demonstrations, specs[0])
    errors: dict[str, Any] = {
        labels: {f"{lam:g}": {kind: [] for kind in ERRORS} for lam in LAMBDAS} for labels in LABELS
    }
    for labels in LABELS:
        for lam in LAMBDAS:
            settings = replace(settings_of(specs[0]), regularization=lam)
            for k, own in enumerate(hits):
                asked = (hits[(k + 1) % len(hits)], seen[k])
                found = _errors(PaperPlayer(lessons, settings), labels, own, marks, asked)
                for kind, row in zip(ERRORS, found.T.tolist(), strict=True):
                    errors[labels][f"{lam:g}"][kind].append(row)
    samples = [len(lessons) + np.mean([min(mark, len(own)) for own in hits]) for mark in marks]
    return {"samples": [float(mean) for mean in samples], "errors": errors}


def findings(scale: Scale, answers: Answers) -> Findings:
    """Average over runs."""
    lines = [
        Line(f"{eyes}, {labels}, lambda {lam}", _values(answer["samples"], errors))
        for labels in LABELS
        for eyes, answer in answers.items()
        for lam, errors in answer["errors"][labels].items()
    ]
    return Findings(
        columns=tuple(
            Column(f"{kind}_{when}_cm", f"{kind}, {said}, cm", 1)
            for kind in ERRORS
            for when, said in (("first", "demonstrations only"), ("last", "all samples"))
        ),
        paper=(Line("quick improvement, then a plateau; no numbers in the text", {}),),
        ours=lines,
        setting={
            **{"player": "paper", "vehicle": "tum_gazebo", "camera": "gazebo", "serves": "human"},
            **{"length_scale": PaperSettings().length_scale, "lambda": list(LAMBDAS)},
            **{"runs": scale.of(RUNS, FEW_RUNS), "serves_per_run": scale.of(SERVES, FEW_SERVES)},
        },
        figures={"fig7a": _figure(lines)},
        remarks=_remarks(lines),
    )


def _runs(scale: Scale, label: str) -> tuple[Training, ...]:
    return fig7b.runs(scale, label)[: scale.of(RUNS, FEW_RUNS)]


def _errors(
    player: PaperPlayer,
    labels: str,
    own: Sequence[Hit],
    marks: Sequence[int],
    asked: tuple[Sequence[Hit], Sequence[Serve]],
) -> Float[ndarray, "marks 2"]:
    """Return both errors of a player after so many own hits, which it is taught, cm."""
    learnt, found = 0, []
    for mark in marks:
        for hit in own[learnt:mark]:
            player.remember(hit.attempt(labels), hit.trial.reward)
        learnt = mark
        found.append([_of_labels(player, labels, asked[0]), _of_places(player, asked[1])])
    return 100.0 * np.array(found)


def _of_labels(player: PaperPlayer, labels: str, hits: Sequence[Hit]) -> float:
    tried = [hit.attempt(labels) for hit in hits]
    told = np.array([one.hitting_point[:2] for one in tried])
    return _distance(told, [player.hitting_point(one.state) for one in tried])


def _of_places(player: PaperPlayer, serves: Sequence[Serve]) -> float:
    needed = np.array([serve.need for serve in serves])
    return _distance(needed, [player.hitting_point(serve.ball) for serve in serves])


def _distance(told: Float[ndarray, "n 2"], predicted: Sequence[Float[ndarray, "7"]]) -> float:
    return float(np.mean(np.linalg.norm(np.array(predicted)[:, :2] - told, axis=1)))


def _values(samples: Sequence[float], errors: dict[str, list[list[float]]]) -> dict[str, Any]:
    """Return means and standard deviations over runs: curves, and their ends as columns."""
    values: dict[str, Any] = {"samples": list(samples)}
    for kind in ERRORS:
        runs = np.array(errors[kind])
        for what, curve in (("", runs.mean(axis=0)), ("_sd", runs.std(axis=0, ddof=1))):
            values[f"{kind}_curve_cm{what}"] = curve.tolist()
            values[f"{kind}_first_cm{what}"] = float(curve[0])
            values[f"{kind}_last_cm{what}"] = float(curve[-1])
    return values


def _remarks(lines: Sequence[Line]) -> str:
    best = {
        (eyes, labels): min(
            (
                (line.label.split()[-1], line.values)
                for line in lines
                if line.label.startswith(f"{eyes}, {labels},")
            ),
            key=lambda pair: pair[1]["place_last_cm"],
        )
        for labels in LABELS
        for eyes in fig7b.EYES
    }
    return "\n\n".join([
        "Numbers are mean distances in the blade's plane ± standard deviations over runs. `label` "
        "is measured against hits of another run, whose commanded labels hold their exploration, so"
        " it cannot fall to zero; `place` against where serves as they come really pass.",
        "\n".join(f"- {_said(*whose, *told)}" for whose, told in best.items()),
        f"The player's own lambda is {PaperSettings().regularization:g}. "
        + _vision_or_truth({whose: values for whose, (_, values) in best.items()}),
        "What is unknown: the paper's values of lambda, its units and what its error was measured "
        "against.",
    ])  # fmt: skip


def _said(eyes: str, labels: str, lam: str, values: Mapping[str, Any]) -> str:
    curve, samples = values["place_curve_cm"], values["samples"]
    middle = len(curve) // 2
    return (
        f"{eyes.capitalize()}, {labels}: the best lambda at the end is {lam}, and places are "
        f"predicted to {curve[0]:.1f} cm with {samples[0]:.0f} samples, {curve[middle]:.1f} cm "
        f"with {samples[middle]:.0f} and {curve[-1]:.1f} cm with {samples[-1]:.0f}."
    )


def _vision_or_truth(best: Mapping[tuple[str, str], Mapping[str, Any]]) -> str:
    """Say what true states are worth, for labels as commanded."""
    vision, truth = (best[eyes, "commanded"]["place_last_cm"] for eyes in ("vision", "truth"))
    if truth >= vision:
        return "True states of the ball predict no better, so vision is not what the plateau is of."
    return (
        f"With true states of the ball the error at the end is {vision - truth:.1f} cm smaller: so "
        f"much of the plateau is vision's, as the paper says, and {truth:.1f} cm are not."
    )


def _figure(lines: Sequence[Line]) -> Figure:
    """Draw both errors for both labels."""
    rows = {"label": "error against labels, cm", "place": "error against places, cm"}
    with drawing(7.2, 6.0) as figure:
        grid = figure.subplots(2, 2, sharex=True, sharey="row")
        for across, (kind, said) in zip(grid, rows.items(), strict=True):
            across[0].set_ylabel(said)
            for axes, labels in zip(across, LABELS, strict=True):
                _curves(axes, kind, [line for line in lines if f", {labels}," in line.label])
        for axes, labels in zip(grid[0], LABELS, strict=True):
            axes.set_title(f"labels {labels}")
        for axes in grid[1]:
            axes.set_xlabel("samples, demonstrations included")
        handles, names = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, names, frameon=False, ncols=2, loc="outside lower center")
    return figure


def _curves(axes: Axes, kind: str, lines: Sequence[Line]) -> None:
    strokes = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 4)))
    for line in lines:
        eyes, _, lam = line.label.split(", ")
        at = [f"lambda {one:g}" for one in LAMBDAS].index(lam)
        values = line.values
        axes.plot(
            values["samples"],
            values[f"{kind}_curve_cm"],
            color=COLOURS[eyes],
            linestyle=strokes[at],
            label=f"{eyes}, {lam.replace('lambda', 'λ =')}",
        )
    axes.set_ylim(bottom=0.0)
