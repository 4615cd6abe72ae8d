"""Fig. 4: how far estimates are off along one trajectory, and where the steps in depth come from.

The paper plots the errors of all six quantities over time and reads from them that the steps in Z
"arise precisely from an increase in the number of pixels of the ball diameter in the image". Here
are the errors of the paper's eyes, with the diameter in whole pixels and not, and the tracker's, on
the same frames of one serve, and depth itself beside the diameter.

What a step is, is said without the diameter: between two frames the estimated Z changes by more
than half of what a pixel of the diameter is worth, Z / h. Counted are the steps with and without a
change of the whole-pixel diameter, over many serves, at 30 and at 60 frames/s (tum_simulator's
rate): between changes the estimate stands still but for the ray's angle, while the ball comes on.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from rotorpong.conventions import BALL_DIAMETER
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import stage_of
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.paper.trajectory import (
    FAST,
    FLOAT,
    HEADS,
    KEYS,
    TRACKER,
    WHOLE,
    Told,
    mean_errors,
    told,
    watched,
)
from rotorpong.physics.camera import GAZEBO

TITLE = "Fig. 4: errors along one trajectory"
SERVE = 0  # that is drawn
SERVES, FEW = 20, 2  # in which steps are counted
CAMERAS = {"30 frames/s": GAZEBO, "60 frames/s": FAST}
DRAWN = {WHOLE: "vision", FLOAT: "light", TRACKER: "tracker"}
HALF_A_PIXEL = 0.5


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Watch one serve with all eyes, and many with the paper's."""
    spec, serves = Spec("hover", seed=scale.seed), scale.of(SERVES, FEW)
    counts = (
        Job(rate, stepping, (replace(spec, camera=camera), serves), seconds=0.1 * serves)
        for rate, camera in CAMERAS.items()
    )
    return (Job("trajectory", trajectory, (spec, SERVE)), *counts)


def trajectory(spec: Spec, serve: int) -> dict[str, Any]:
    """Return what all eyes tell along one serve: rows of `watched`, by eyes."""
    return {label: rows.tolist() for label, rows in watched(stage_of(spec), serve).items()}


def stepping(spec: Spec, serves: int) -> dict[str, int]:
    """Return how many frames, changes of diameter and steps of depth the paper's eyes tell of."""
    stage = stage_of(spec)
    counts = np.zeros(4, int)
    for index in range(serves):
        one = told(watched(stage, index, (WHOLE,))[WHOLE])
        changed, stepped = changes(one), steps(one)
        both = (changed & stepped).sum()
        counts += [len(one.time), changed.sum(), stepped.sum(), both]
    return dict(zip(("frames", "changes", "steps", "steps_with_change"), counts.tolist(),
                    strict=True))  # fmt: skip


def diameters(one: Told) -> Int[ndarray, "n"]:
    """Return the whole-pixel diameters that estimates come from: Eq. (1) read backwards."""
    distances = np.linalg.norm(one.estimate[:, :3], axis=1)
    return np.rint(GAZEBO.focal_length_px[0] * BALL_DIAMETER / distances).astype(int)


def changes(one: Told) -> Bool[ndarray, "m"]:
    """Tell between which frames the diameter changes."""
    return np.diff(diameters(one)) != 0


def steps(one: Told) -> Bool[ndarray, "m"]:
    """Tell between which frames the estimated depth steps: by over half a pixel's worth."""
    depth = one.estimate[:, 2]
    worth = depth[:-1] / diameters(one)[:-1]
    return np.abs(np.diff(depth)) > HALF_A_PIXEL * worth


def findings(scale: Scale, answers: Answers) -> Findings:
    """Tell the errors of one trajectory and what its steps coincide with."""
    seen = {label: told(rows) for label, rows in answers["trajectory"].items()}
    counts = {rate: answers[rate] for rate in CAMERAS}
    serves = scale.of(SERVES, FEW)
    return Findings(
        columns=(
            *(Column(key, head) for key, head in zip(KEYS, HEADS, strict=True)),
            Column("frames", "frames", 0),
            Column("steps", "steps of Z", 0),
            Column("steps_with_change", "with a change of diameter", 0),
            Column("changes", "changes of diameter", 0),
        ),
        paper=(),
        ours=[
            *(Line(f"serve {SERVE}, {label}", _errors(label, one)) for label, one in seen.items()),
            *(Line(f"{serves} serves, {WHOLE}, {rate}", c) for rate, c in counts.items()),
        ],
        setting={
            "serves": "human",
            "vehicle": "tum_gazebo",
            "camera": "gazebo",
            "player": "hover",
            "figure": f"serve {SERVE}, 30 frames/s",
        },
        figures={"fig4": _figure(seen)},
        remarks=_remarks(counts),
    )


def _errors(label: str, one: Told) -> dict[str, Any]:
    """Return mean absolute errors along a trajectory, and its steps where the diameter has any."""
    errors = mean_errors(one).tolist() if len(one.time) else [None] * len(KEYS)
    values = {**dict(zip(KEYS, errors, strict=True)), "frames": len(one.time)}
    if label != WHOLE:
        return values
    changed, stepped = changes(one), steps(one)
    return values | {
        "steps": int(stepped.sum()),
        "steps_with_change": int((changed & stepped).sum()),
        "changes": int(changed.sum()),
    }


def _remarks(counts: Mapping[str, Mapping[str, int]]) -> str:
    """Say what the steps come from, as far as the counts do."""
    shares = "; ".join(
        f"at {rate} {c['steps_with_change']} of {c['steps']} steps, with {c['changes']} changes "
        f"between {c['frames']} frames"
        for rate, c in counts.items()
    )
    return (
        "Means of absolute values along the trajectory. A step is a change of the estimated Z by "
        "more than half of what a pixel of the diameter is worth. Steps that coincide with a "
        f"change of the diameter in whole pixels: {shares}. Far away a pixel is worth most and "
        "the diameter changes seldom; near by it changes in every frame. Dotted: the bounce, over "
        "which a finite difference knows neither velocity. Far away the circle is too small and "
        "the ball seems too far; off the axis, near by, Eq. (1) puts it too near. The paper's "
        "figure has no numbers."
    )


def _figure(seen: Mapping[str, Told]) -> Figure:
    """Draw six errors over time, then depth and diameter."""
    with drawing(7.2, 8.4) as figure:
        grid = figure.add_gridspec(4, 2, height_ratios=[1, 1, 1, 1.7])
        for k, head in enumerate(HEADS):
            axes = figure.add_subplot(grid[k % 3, k // 3])
            _error(axes, k, head, seen)
            if k % 3 == 2:
                axes.set_xlabel("time since release, s")
        _depth(figure.add_subplot(grid[3, :]), seen)
    return figure


def _error(axes: Axes, quantity: int, head: str, seen: Mapping[str, Told]) -> None:
    axes.axhline(0.0, color=COLOURS["paper"], linewidth=0.6)
    if (bounce := _bounce(seen[WHOLE])) is not None:
        axes.axvline(bounce, color=COLOURS["paper"], linewidth=0.8, linestyle=":")
    for label, one in seen.items():
        axes.plot(one.time, one.error[:, quantity], ".-", color=COLOURS[DRAWN[label]], label=label,
                  linewidth=1.1, markersize=3.5)  # fmt: skip
    axes.set_ylabel(f"error of {head}")
    if quantity == 0:
        axes.legend(frameon=False, fontsize=8)


def _bounce(whole: Told) -> float | None:
    """Return when the ball bounces: between the frames where it goes down (Y) and up."""
    fall = whole.truth[:, 4]
    turned = np.flatnonzero((fall[:-1] > 0.0) & (fall[1:] < 0.0))
    return float(whole.time[turned[0] : turned[0] + 2].mean()) if len(turned) else None


def _depth(axes: Axes, seen: Mapping[str, Told]) -> None:
    whole = seen[WHOLE]
    axes.plot(whole.time, whole.truth[:, 2], color=COLOURS["truth"], label="Z, truth")
    for label, one in seen.items():
        axes.plot(one.time, one.estimate[:, 2], ".-", color=COLOURS[DRAWN[label]],
                  label=f"Z, {label}", linewidth=1.1, markersize=4)  # fmt: skip
    axes.set(xlabel="time since release, s", ylabel="Z, m", ylim=(0.0, None))
    beside = axes.twinx()
    beside.step(whole.time, diameters(whole), where="mid", color=COLOURS["paper"], linewidth=1.0)
    beside.set_ylabel("diameter in whole pixels", color=COLOURS["paper"])
    beside.spines["right"].set_visible(True)
    beside.set_ylim(0.0, None)
    axes.plot([], [], color=COLOURS["paper"], linewidth=1.0, label="diameter, px")
    axes.legend(frameon=False, fontsize=8, loc="upper center")
