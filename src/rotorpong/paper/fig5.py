"""Fig. 5: one motor primitive, re-targeted in its end point and in its duration.

A primitive of Eqs. (3)-(5) is learnt from a demonstration and executed with another reference
state, then within another time. What the paper shows as curves is here checked in numbers as well:
the end point and its velocity are met, the shape that the forcing adds to the moving target is the
same whatever goal and duration (s = g + eta Phi theta), and the demonstration is reproduced.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.spec import Spec
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.primitives import Dmp, State, fit_dmp

TITLE = "Fig. 5: a motor primitive with other end points and durations"
ASIDE = (
    0.0,
    0.10,
    -0.10,
    0.20,
)  # m, of the end point from the demonstration's, along its main axis
STRETCHES = (1.0, 0.6, 1.6)  # of its own duration
SAMPLES = 61


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Learn the primitive and roll it out; the same at every scale."""
    return (Job(f"seed {scale.seed}", rolled_out),)


def rolled_out() -> dict[str, Any]:
    """Return the demonstration that goes farthest along one axis, and the motions, m, s."""
    paths = [lesson.path for lesson in lessons_of(shipped_demonstrations(), Spec(eyes="truth"))]
    ways = np.array([np.abs(path.positions[-1] - path.positions[0]) for path in paths])
    number, axis = np.unravel_index(ways.argmax(), ways.shape)
    path = paths[number]
    dmp = fit_dmp(path.times, path.positions, velocities=path.velocities)
    start = State(path.positions[0], path.velocities[0])
    goal, duration = State(path.positions[-1], path.velocities[-1]), float(np.ptp(path.times))
    shown = dmp.roll_out(start, goal, duration, path.times - path.times[0]).position
    others = [State(goal.position + aside * np.eye(3)[axis], goal.velocity) for aside in ASIDE]
    return {
        "number": int(number),
        "axis": int(axis),
        "times": (path.times - path.times[0]).tolist(),
        "demonstration": path.positions.tolist(),
        "reproduced": shown.tolist(),
        "goals": [_motion(dmp, start, other, duration) for other in others],
        "durations": [_motion(dmp, start, goal, stretch * duration) for stretch in STRETCHES],
    }


def findings(scale: Scale, answers: Answers) -> Findings:
    """Say how exactly goals are met and shapes are kept."""
    (answer,) = answers.values()
    axis = "XYZ"[answer["axis"]]
    reproduced = np.array(answer["reproduced"]) - np.array(answer["demonstration"])
    lines = [
        Line(
            "the demonstration, reproduced",
            {
                "duration_s": answer["times"][-1],
                "rms_cm": 100.0 * float(np.sqrt((reproduced**2).sum(axis=1).mean())),
                "end_cm": None,
                "shape_cm": None,
            },
        ),
        *(_line(f"end point {100 * aside:+.0f} cm in {axis}", motion, answer)
          for aside, motion in zip(ASIDE, answer["goals"], strict=True)),
        *(_line(f"{stretch:g} times the duration", motion, answer)
          for stretch, motion in zip(STRETCHES, answer["durations"], strict=True)),
    ]  # fmt: skip
    return Findings(
        columns=(
            Column("duration_s", "duration, s", 3),
            Column("rms_cm", "rms distance, cm", 3),
            Column("end_cm", "end point missed by, cm", 3),
            Column("shape_cm", "shape differs by, cm", 3),
        ),
        paper=(Line("a figure without numbers", {}),),
        ours=lines,
        setting={
            "demonstration": f"the shipped one number {answer['number']}",
            "basis functions": 20,
        },
        figures={"fig5": _figure(answer)},
        remarks="The closed form of Eqs. (4) and (5) meets every end point, and its velocity, to "
        "rounding. `shape` is the greatest difference of what the forcing adds to the moving "
        "target from what it adds in the demonstration.",
    )


def _motion(dmp: Dmp, start: State, goal: State, duration: float) -> dict[str, Any]:
    """Return a motion, and what its forcing adds to the moving target."""
    times = np.linspace(0.0, duration, SAMPLES)
    motion = dmp.roll_out(start, goal, duration, times)
    plain = Dmp(np.zeros_like(dmp.weights)).roll_out(start, goal, duration, times)
    return {
        "times": times.tolist(),
        "position": motion.position.tolist(),
        "velocity": motion.velocity.tolist(),
        "shape": (motion.position - plain.position).tolist(),
        "goal": goal.position.tolist(),
    }


def _line(label: str, motion: dict[str, Any], answer: dict[str, Any]) -> Line:
    end = np.array(motion["position"])[-1] - np.array(motion["goal"])
    apart = np.array(motion["shape"]) - np.array(answer["goals"][0]["shape"])
    return Line(
        label,
        {
            "duration_s": motion["times"][-1],
            "rms_cm": None,
            "end_cm": 100.0 * float(np.abs(end).max()),
            "shape_cm": 100.0 * float(np.abs(apart).max()),
        },
    )


def _figure(answer: dict[str, Any]) -> Figure:
    """Draw other end points above, other durations below; position left, velocity right."""
    axis = answer["axis"]
    inks = [COLOURS[name] for name in ("truth", "vision", "tracker", "other")]
    with drawing(7.2, 4.6) as figure:
        rows = figure.subplots(2, 2)
        for (left, right), motions in zip(
            rows, (answer["goals"], answer["durations"]), strict=True
        ):
            for motion, colour in zip(motions, inks, strict=False):
                for axes, what in ((left, "position"), (right, "velocity")):
                    values = 100.0 * np.array(motion[what])[:, axis]
                    axes.plot(motion["times"], values, color=colour)
                left.plot(motion["times"][-1], 100.0 * motion["goal"][axis], "o", color=colour)
            shown = 100.0 * np.array(answer["demonstration"])[:, axis]
            left.plot(answer["times"], shown, color="black", linestyle=":", label="demonstration")
            left.set(ylabel=f"{'XYZ'[axis]}, cm")
            right.set(ylabel=f"{'XYZ'[axis]}', cm/s")
        rows[0, 0].set_title("other end points")
        rows[1, 0].set_title("other durations")
        rows[0, 0].legend(frameon=False)
        for axes in rows[1]:
            axes.set(xlabel="s")
    return figure
