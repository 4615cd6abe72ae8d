"""Fig. 1d: the simulator's picture.

The paper shows its Gazebo world with drone, blade, table and ball. Here is ours at one instant of a
serve at a hovering drone: what the onboard camera sees, with the circle of the paper's eyes, and
what somebody beside the table sees, with the ball's way so far. Both come from our own ray caster;
the drone is drawn into the onlooker's picture. It holds no numbers; its setting is beside it.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotorpong.lab.footage import Take, play_again
from rotorpong.lab.report.cinema import Scenery, beside, onboard
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import stage_of
from rotorpong.paper.findings import Answers, Findings, Job, Scale
from rotorpong.paper.ink import drawing
from rotorpong.paper.snapshot import as_rgb, as_text
from rotorpong.play.hover import Hover
from rotorpong.world.contact import TICK
from rotorpong.world.racket import HOME_BLADE

TITLE = "Fig. 1d: the simulator"
SERVE = 0
BEFORE = 0.2  # s, before the ball is at the blade's plane
VIEWS = {"onboard": "the onboard camera", "beside": "an onlooker beside the table"}


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Take the picture."""
    return (Job("picture", picture, (Spec("hover", seed=scale.seed), SERVE)),)


def picture(spec: Spec, serve: int) -> dict[str, Any]:
    """Return both views of a serve 0.2 s before the ball arrives, and when and where that is."""
    stage = stage_of(spec)
    take = play_again(stage, serve, Hover())
    scenery = Scenery(stage, take)
    tick = max(_arrival(take) - round(BEFORE / TICK), 0)
    return {
        "onboard": as_text(onboard(scenery, tick * TICK)),
        "beside": as_text(beside(scenery, tick * TICK)),
        "time_s": tick * TICK,
        "ball_m": take.played.truth.ball_path[tick].tolist(),
        "outcome": take.played.outcome,
    }


def findings(scale: Scale, answers: Answers) -> Findings:
    """Show the picture."""
    seen, spec = answers["picture"], Spec("hover", seed=scale.seed)
    return Findings(
        columns=(),
        paper=(),
        ours=(),
        setting={
            "serve": f"{spec.serves} {SERVE}",
            "time": f"{seen['time_s']:.3f} s after release",
            "ball": "({:.2f}, {:.2f}, {:.2f}) m from the table's middle".format(*seen["ball_m"]),
            "vehicle": spec.vehicle_name,
            "camera": spec.camera_name,
            "racket": spec.racket,
            "player": "hover",
            "outcome": seen["outcome"],
        },
        figures={"fig1": _figure(seen)},
        remarks="Above the newest frame of the onboard camera, the circle where the paper's eyes "
        "have the ball; below the same instant from beside the table. The paper's picture is of "
        "Gazebo, with the model of the AR.Drone; court and ball are ours.",
    )


def _arrival(take: Take) -> int:
    """Return the tick at which the ball is at the blade's plane, or the serve is over."""
    path = take.played.truth.ball_path
    passed = np.flatnonzero(path[:, 0] < HOME_BLADE[0])
    return int(passed[0]) if len(passed) else len(path) - 1


def _figure(seen: dict[str, Any]) -> Figure:
    with drawing(6.4, 7.7) as figure:
        for axes, (view, title) in zip(figure.subplots(2, 1), VIEWS.items(), strict=True):
            _show(axes, seen[view], title)
    return figure


def _show(axes: Axes, text: str, title: str) -> None:
    axes.imshow(as_rgb(text), interpolation="lanczos")
    axes.set_title(title, fontsize=10)
    axes.set_axis_off()
