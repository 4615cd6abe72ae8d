"""A figure of where each vehicle can bring its blade, by the time left.

Filled: where the blade's centre came in flights of random commands that change at every third
frame, seen from behind the drone. Outline: the outer bound by
which a serve is called unreachable, which holds the whole blade and its margin.
"""

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Polygon, Rectangle
from numpy import ndarray
from scipy.spatial import ConvexHull

from rotorpong.geometry import rotation_from_quaternion
from rotorpong.lab.reachable import blade_centre, blade_corners
from rotorpong.lab.spec import VEHICLES
from rotorpong.physics.reach import corner_commands, plate_bound, repeated
from rotorpong.physics.vehicle import Vehicle, VehicleState
from rotorpong.world.racket import HOME_BLADE, HOME_BODY, Racket

DRAWN = ("tum_gazebo", "ardrone2")
TIMES = (0.2, 0.4, 0.6, 0.8)  # s since the decision
FLIGHTS = 250
CHANGE = 100  # ticks
TARGETS = (0.4, 0.2)  # m, half the window of `human` serves
COLOURS = colormaps["viridis"](np.linspace(0.85, 0.1, len(TIMES)))


def reach_figure() -> Figure:
    """Draw the reach of both vehicles."""
    figure = Figure(figsize=(9.0, 2.9), layout="constrained")
    axes = figure.subplots(1, len(DRAWN), sharex=True, sharey=True)
    for ax, name in zip(axes, DRAWN, strict=True):
        _draw(ax, VEHICLES[name])
        ax.set_title(name)
        ax.set_xlabel("left of home, m")
    axes[0].set_ylabel("above home, m")
    axes[0].legend(loc="lower center", fontsize=7, ncols=5, columnspacing=0.8, framealpha=1.0)
    return figure


def places(vehicle: Vehicle, state: VehicleState, ticks: int) -> Float[ndarray, "flights n 3"]:
    """Return paths of the blade's centre in flights of random commands, world frame."""
    rng = np.random.default_rng(0)
    corners = corner_commands(vehicle)
    limits = vehicle.limits
    batch, parts = repeated(state, FLIGHTS), []
    for leg in range(-(-ticks // CHANGE)):
        drawn = limits * rng.choice([-1.0, 0.0, 1.0], size=(FLIGHTS, 4))
        drawn[: len(corners)] = np.clip(corners, -limits, limits)
        batch, track = vehicle.advance(batch, drawn, ticks=CHANGE, new_command=True)
        first = min(leg, 1)
        turned = rotation_from_quaternion(track.quaternion[:, first:])
        parts.append(track.position[:, first:] + turned @ np.array(blade_centre(Racket())))
    return np.concatenate(parts, axis=1)[:, : ticks + 1]


def _draw(ax: Axes, vehicle: Vehicle) -> None:
    state = vehicle.start(np.array(HOME_BODY), np.random.default_rng(0))
    ticks = [round(1e3 * time) for time in TIMES]
    bound = plate_bound(vehicle, state, ticks[-1], blade_corners(Racket()))
    flown = places(vehicle, state, ticks[-1])
    home = np.array(HOME_BLADE)
    for order, (tick, time) in enumerate(zip(ticks, TIMES, strict=True)):
        colour, layer = COLOURS[order], 10.0 - order
        points = flown[:, tick, 1:] - home[1:]
        outline = points[ConvexHull(points).vertices]
        ax.add_patch(Polygon(outline, facecolor=colour, label=f"{time:.1f} s", zorder=layer))
        low, high = bound.low[tick, 1:] - home[1:], bound.high[tick, 1:] - home[1:]
        box = Rectangle(tuple(low), *(high - low), fill=False, edgecolor=colour, zorder=layer)
        ax.add_patch(box)
    ax.add_patch(_blade())
    window = Rectangle((-TARGETS[0], -TARGETS[1]), 2 * TARGETS[0], 2 * TARGETS[1], fill=False)
    window.set(linestyle="--", edgecolor="black", zorder=20.0, label="targets of human serves")
    ax.add_patch(window)
    ax.set_xlim(1.7, -1.7)
    ax.set_ylim(-0.9, 0.7)
    ax.set_aspect("equal")
    ax.grid(visible=True, color="0.9")
    ax.set_axisbelow(True)


def _blade() -> Ellipse:
    racket = Racket()
    size = (2 * racket.half_width, 2 * racket.half_height)
    return Ellipse((0.0, 0.0), *size, facecolor="white", edgecolor="black", zorder=21.0)
