"""Fig. 6: the ball comes nearer than 2.5 m, and a motion begins; plane and distance compared.

The text says that the ball crosses the "2.5m plane", the caption that "the ball-robot distance"
drops below 2.5 m. Here are both, from the code's own constants: to the plane Z = 2.5 m before the
camera, and to the sphere d = 2.5 m around it, Eq. (2c). A ball beside the optical axis is in the
sphere later than behind the plane. Hovering drones watch serves with both, once with exact ball
states and once with the paper's eyes, whose depth errors are larger than the difference.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy import ndarray

from rotorpong.conventions import CAMERA_FROM_BODY_AXES, TABLE_HALF_LENGTH
from rotorpong.drone import HOVER
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale
from rotorpong.paper.ink import COLOURS, drawing
from rotorpong.paper.tally import arrival
from rotorpong.play.paper import PaperSettings
from rotorpong.world.contact import TICK
from rotorpong.world.racket import HOME_BLADE, HOME_BODY, Racket

TITLE = "Fig. 6: the 2.5 m at which a motion begins"
SERVES, FEW = 200, 10
DRAWN = 12  # ball paths of the figure
STEP = 20  # ticks between points of them
TRIGGERS = ("plane", "distance")
EYES = {"exact states": "truth", "paper's eyes": "paper"}


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Watch the same serves with either eyes."""
    serves = scale.of(SERVES, FEW)
    return tuple(
        Job(
            label,
            watched,
            (Spec("hover", eyes=eyes, seed=scale.seed), serves),
            seconds=0.05 * serves,
        )
        for label, eyes in EYES.items()
    )


def watched(spec: Spec, serves: int) -> dict[str, Any]:
    """Return when and where each trigger fires, by trigger; None where it does not.

    Per serve: seconds left until the ball is at the blade's plane, true depth Z and distance d (m),
    and X, Y there. With the paths of the first serves in the camera frame, m.
    """
    stage = stage_of(spec)
    found: dict[str, Any] = {trigger: [] for trigger in TRIGGERS}
    paths = []
    for index in range(serves):
        drone = new_drone(stage, index)
        eyes = spec.make_eyes(drone)
        fired: dict[str, Any] = dict.fromkeys(TRIGGERS)
        while (observation := drone.observe()) is not None:
            drone.command(HOVER)
            estimate = eyes.see(observation)
            for trigger in TRIGGERS:
                settings = PaperSettings(trigger=trigger)
                if estimate is not None and fired[trigger] is None and settings.triggers(estimate):
                    place, _ = drone.ball_in_camera(estimate.time)
                    fired[trigger] = (estimate.time, place.tolist())
        path = drone.truth().ball_path
        there = TICK * arrival(path)
        for trigger, at in fired.items():
            found[trigger].append(None if at is None else [there - at[0], *at[1]])
        if index < DRAWN:
            paths.append(_in_camera(path[::STEP], spec).tolist())
    return {**found, "paths": paths}


def findings(scale: Scale, answers: Answers) -> Findings:
    """Compare the triggers."""
    return Findings(
        columns=(
            Column("serves", "serves", 0),
            Column("triggered_percent", "triggered, %", 1),
            Column("depth_m", "true Z then, m", 3),
            Column("distance_m", "true d then, m", 3),
            Column("time_left_s", "time left, s", 3),
        ),
        paper=(Line("", {"serves": None, "distance_m": PaperSettings().plane_distance}),),
        ours=[
            Line(f"{trigger}, {label}", _numbers(answer[trigger]))
            for label, answer in answers.items()
            for trigger in TRIGGERS
        ],
        setting={"serves": "human", "vehicle": "tum_gazebo", "camera": "gazebo", "player": "hover"},
        figures={"fig6": _figure(answers)},
        remarks="Numbers are means ± standard deviations over serves; time is left until the ball "
        "passes the blade's plane. A trigger fires at the first frame in which the estimate is "
        "nearer than 2.5 m, so with exact states on average half a frame late. The two differ by "
        "less than the paper's eyes err: their whole-pixel diameter decides when either fires.",
    )


def _numbers(rows: Sequence[Any]) -> dict[str, Any]:
    """Return means and standard deviations over serves."""
    fired = np.array([row for row in rows if row is not None]).reshape(-1, 4)
    values: dict[str, Any] = {
        "serves": len(rows),
        "triggered_percent": 100.0 * len(fired) / len(rows),
    }
    columns = {
        "depth_m": fired[:, 3],
        "distance_m": np.linalg.norm(fired[:, 1:], axis=1),
        "time_left_s": fired[:, 0],
    }
    for key, column in columns.items():
        known = len(column) > 1
        values[key] = float(column.mean()) if known else None
        values[f"{key}_sd"] = float(column.std(ddof=1)) if known else None
    return values


def _in_camera(points: Float[ndarray, "n 3"], spec: Spec) -> Float[ndarray, "n 3"]:
    """Return points of the world in the camera frame of the drone at home."""
    return (
        points - HOME_BODY - np.array(spec.camera_profile().position_m)
    ) @ CAMERA_FROM_BODY_AXES.T


def _figure(answers: Answers) -> Figure:
    """Draw what is before the camera from the side and from above."""
    paths = [np.array(path) for path in answers["exact states"]["paths"]]
    fired = {t: [row for row in answers["exact states"][t][:DRAWN] if row] for t in TRIGGERS}
    with drawing(7.2, 4.3) as figure:
        side, top = figure.subplots(2, 1, sharex=True)
        _view(side, 1, paths, fired)
        _view(top, 0, paths, fired)
        side.set(ylabel="Y (down), m", ylim=(0.45, -0.75))
        top.set(ylabel="X (right), m", xlabel="Z (depth), m", ylim=(-0.6, 0.6))
        top.set(xlim=(-0.45, 4.4))
        side.legend(frameon=False, loc="upper left", ncols=2)
    return figure


def _view(axes: Axes, across: int, paths: Sequence[Any], fired: dict[str, Any]) -> None:
    """Draw one view; `across` is the axis (0: X, 1: Y) drawn upwards."""
    distance = PaperSettings().plane_distance
    for path in paths:
        axes.plot(path[:, 2], path[:, across], color=COLOURS["light"], linewidth=0.8, alpha=0.7)
    axes.axvline(distance, color=COLOURS["truth"], label="plane Z = 2.5 m")
    angles = np.linspace(-0.5, 0.5, 101)
    sphere = distance * np.array([np.cos(angles), np.sin(angles)])
    axes.plot(*sphere, "--", color=COLOURS["vision"], label="distance d = 2.5 m")
    for trigger, mark, colour in zip(TRIGGERS, "ox", ("truth", "vision"), strict=True):
        places = np.array([row[1:] for row in fired[trigger]]).reshape(-1, 3)
        axes.plot(places[:, 2], places[:, across], mark, color=COLOURS[colour], markersize=5)
    _drone(axes, across)


def _drone(axes: Axes, across: int) -> None:
    """Draw camera, blade and the table's near edge."""
    spec, racket = Spec(), Racket()
    blade = _in_camera(np.array([HOME_BLADE]), spec)[0]
    half = (racket.half_width, racket.half_height)[across]
    axes.add_patch(
        Ellipse((blade[2], blade[across]), 0.03, 2.0 * half, color=COLOURS["paper"], zorder=3)
    )
    axes.plot(0.0, 0.0, "s", color="black", markersize=5)
    axes.annotate("camera", (0.0, 0.0), (4, -12), textcoords="offset points", fontsize=8)
    edge = _in_camera(np.array([[-TABLE_HALF_LENGTH, 0.0, 0.0], [0.0, 0.0, 0.0]]), spec)
    if across == 1:
        axes.plot([edge[0, 2], 4.4], edge[:, 1], color=COLOURS["paper"], linewidth=2)
    axes.set_aspect("equal")
