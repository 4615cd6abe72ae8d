"""How cost grows: with balls, trials, pixels and worker processes, one figure each.

Double logarithmic, with the straight line that cost per piece would follow if it stayed what it is
at the largest size. CPU time of one thread; for workers, which are other processes, the wall.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rotorpong.lab.bench.ball_rows import FLIGHT, some_balls
from rotorpong.lab.bench.timing import cpu_seconds, wall_seconds
from rotorpong.lab.bench.world_speed import stage_of
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.report.ink import STYLE
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import play_trial
from rotorpong.physics.ball import Air, fly
from rotorpong.physics.camera import GAZEBO, camera_from_body
from rotorpong.play.hover import Hover
from rotorpong.world.render import Scene, render

BLUE, GREY = "#0072b2", "#8a8a8a"  # Okabe and Ito's
EYE, BALL = (-1.69, 0.0, 0.20), (-0.2, 0.1, 0.45)  # m, world: a drone at home, a ball before it


@dataclass(frozen=True, slots=True)
class Growth:
    """What was measured at several sizes."""

    name: str  # of the file
    size: str
    cost: str
    sizes: tuple[int, ...]
    seconds: tuple[float, ...]


def draw_growth(folder: Path, *, quick: bool = False) -> tuple[Path, ...]:
    """Measure how cost grows and write one PNG each into `folder`; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for measure in (_balls, _trials, _pixels, _workers):
        growth = measure(quick=quick)
        path = folder / f"growth_{growth.name}.png"
        drawn(growth).savefig(path, dpi=110)
        paths.append(path)
    return tuple(paths)


def _measured(
    sizes: Sequence[int], work: Callable[[int], Callable[[], Any]], *, quick: bool
) -> tuple[float, ...]:
    return tuple(cpu_seconds(work(size), quick=quick) for size in sizes)


def _balls(*, quick: bool) -> Growth:
    sizes = (1, 10, 100, 1000) if quick else (1, 10, 100, 1000, 10_000, 100_000)

    def work(size: int) -> Callable[[], Any]:
        balls = some_balls(size)
        return lambda: fly(balls, Air(), FLIGHT)

    label = f"flights of {FLIGHT} s in one call"
    return Growth("balls", label, "CPU time, s", sizes, _measured(sizes, work, quick=quick))


def _trials(*, quick: bool) -> Growth:
    sizes = (1, 2, 4) if quick else (1, 3, 10, 30, 100)
    stage, player = stage_of(Spec("hover")), Hover()

    def work(size: int) -> Callable[[], Any]:
        return lambda: [play_trial(stage, index, player) for index in range(size)]

    label = "serves at a hovering drone, no pictures"
    return Growth("trials", label, "CPU time, s", sizes, _measured(sizes, work, quick=True))


def _pixels(*, quick: bool) -> Growth:
    widths = (160, 320, 640) if quick else (80, 160, 320, 640, 1280, 1920)
    rotation = np.ascontiguousarray(camera_from_body(GAZEBO).T)

    def work(pixels: int) -> Callable[[], Any]:
        width = round(math.sqrt(pixels * 16 / 9))
        focal = GAZEBO.focal_length_px[0] * width / GAZEBO.width_px
        size = {"width_px": width, "height_px": width * 9 // 16}
        center = (width / 2 + 0.5, width * 9 / 32 + 0.5)
        camera = replace(GAZEBO, **size, focal_length_px=(focal, focal), center_px=center)
        return lambda: render(camera, np.array(EYE), rotation, np.array(BALL), Scene())

    sizes = tuple(width * width * 9 // 16 for width in widths)
    label = "pixels of a rendered picture"
    return Growth("pixels", label, "CPU time, s", sizes, _measured(sizes, work, quick=quick))


def _workers(*, quick: bool) -> Growth:
    sizes, balls = (1, 2), 20 if quick else 2000
    seconds = tuple(
        wall_seconds(lambda count=count: evaluate(Spec("hover"), balls, workers=count), quick=True)
        for count in sizes
    )
    label = f"worker processes for {balls} serves, their start included"
    return Growth("workers", label, "wall time, s", sizes, seconds)


def drawn(growth: Growth) -> Figure:
    """Return the figure of what was measured."""
    sizes, seconds = np.array(growth.sizes, float), np.array(growth.seconds)
    with mpl.rc_context(STYLE):  # pyright: ignore[reportArgumentType]
        figure = Figure(figsize=(5.4, 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        straight = seconds[-1] * sizes / sizes[-1]
        if growth.name == "workers":
            straight = seconds[0] / sizes
        axes.loglog(
            sizes, straight, color=GREY, linewidth=1.0, linestyle="--", label="in proportion"
        )
        axes.loglog(sizes, seconds, color=BLUE, marker="o", label="measured")
        axes.set_xlabel(growth.size)
        axes.set_ylabel(growth.cost)
        axes.set_xticks(sizes, [f"{size:,}" for size in growth.sizes], minor=False)
        axes.minorticks_off()
        axes.grid(visible=True, color="#e4e4e4")
        axes.legend(frameon=False)
        return figure
