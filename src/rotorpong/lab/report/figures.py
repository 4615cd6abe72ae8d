"""The figures of the report that need axes, drawn with matplotlib.

World frame, metres: x towards the opponent, y left, z up. Each function returns an SVG element; the
colours are those of the page.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Ellipse, Rectangle
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS
from rotorpong.lab.footage import Take
from rotorpong.lab.report.ink import drawing, figure, ink, svg
from rotorpong.lab.report.view import draw_court, draw_drone, draw_path, draw_shadow, seen
from rotorpong.lab.report.words import spoken
from rotorpong.lab.statistics import wilson_interval
from rotorpong.physics.camera import GAZEBO
from rotorpong.world.contact import TICK
from rotorpong.world.court import (
    NET_HALF_LENGTH,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    TABLE_THICKNESS,
)
from rotorpong.world.racket import HOME_BODY, HULL, Racket

WINDOW = 100  # training balls that a point of the learning curve stands for
PATH_STEP = 8  # ticks between drawn points
FLASH = 100  # ticks between marks along a path
PLANE_DISTANCE = 2.5  # m from the camera, where the paper's player is triggered
LARGEST_VIEW = 0.46  # m to every side of the blade
SHOWN_TICKS = 400  # of a ball's way past the blade


def learning_curve(found: dict[str, Any]) -> str:
    """Draw the hit rate in training, between the evaluations before and after."""
    alt = "Hit rate over the balls of the training, with the evaluations before and after."
    with drawing():
        drawn = figure(6.2, 3.7)
        axes = drawn.add_subplot()
        outcomes = found["training"]["outcomes"]
        end = max(len(outcomes), 1)
        hover, before, after = found["players"]
        _level(axes, hover, end)
        _rolling(axes, np.array([outcome == "hit" for outcome in outcomes]))
        _point(axes, before, -0.035 * end)
        _point(axes, after, 1.035 * end)
        axes.set(xlim=(-0.07 * end, 1.07 * end), xlabel="balls played in training")
        axes.set_ylim(bottom=0.0)
        axes.set_ylabel("hit rate")
        axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
        axes.grid(axis="y", linewidth=0.7)
        drawn.legend(frameon=False, fontsize=8.5, loc="upper center", ncols=4, columnspacing=1.2)
        drawn.tight_layout(rect=(0, 0, 1, 0.94))
        return svg(drawn, "learning", alt)


def paths_in_space(take: Take) -> str:
    """Draw court, drone, ball and blade in perspective."""
    alt = "The court in perspective, with the paths of the ball and of the blade that meets it."
    truth = take.played.truth
    with drawing():
        drawn = figure(7.6, 4.07)
        axes = drawn.add_axes((0, 0, 1, 1))
        draw_court(axes)
        draw_shadow(axes, truth.ball_path[::PATH_STEP])
        draw_drone(axes, truth.body_path[0], 0.35)
        draw_drone(axes, truth.body_path[-1], 1.0)
        draw_path(axes, truth.ball_path[::PATH_STEP], "ball", 1.9)
        draw_path(axes, truth.blade_path[::PATH_STEP], "blade", 2.6)
        axes.plot(*seen(truth.ball_path[::FLASH]).T, ".", color=ink("ball"), markersize=8)
        axes.plot(*seen(truth.ball_path[-1]), "*", color=ink("ink"), markersize=11)
        _label_space(axes, take)
        axes.set(aspect="equal", xlim=(-0.42, 0.42), ylim=(-0.25, 0.20))
        axes.set_axis_off()
        return svg(drawn, "space", alt)


def paths_from_the_side(take: Take) -> str:
    """Draw the same paths from the side and from above."""
    alt = "The paths of ball and blade from the side and from above, with the 2.5 metre plane."
    with drawing():
        drawn = figure(6.4, 4.15)
        side, top = drawn.subplots(2, 1, sharex=True, height_ratios=(1.05, 1.7))
        _court_from_the_side(side)
        _court_from_above(top)
        for place, alpha in ((0, 0.35), (-1, 1.0)):
            _drone_from_the_side(side, take.played.truth.body_path[place], alpha)
            _drone_from_above(top, take.played.truth.body_path[place], alpha)
        for axes, column in ((side, 2), (top, 1)):
            _draw_paths(axes, take, column)
            axes.set_aspect("equal")
            axes.grid(linewidth=0.5)
        side.set(ylabel="height (m)", ylim=(-0.25, 0.8), xlim=(-2.5, 2.7))
        top.set(ylabel="left (m)", xlabel="towards the opponent (m)", ylim=(-0.85, 0.85))
        lines = side.get_legend_handles_labels()
        place = {"loc": "upper center", "ncols": 4, "columnspacing": 1.2}
        drawn.legend(*lines, frameon=False, fontsize=8.5, **place)
        drawn.tight_layout(rect=(0, 0, 1, 0.95))
        return svg(drawn, "side", alt)


def passes(takes: Sequence[Take]) -> str:
    """Draw where the ball went by as the blade sees it, one panel for each serve."""
    alt = "Where the ball passed, seen from behind the blade: " + ", ".join(
        spoken(take.played.outcome) for take in takes
    )
    with drawing():
        drawn = figure(1.55 * len(takes) + 0.4, 2.2)
        views = drawn.subplots(1, len(takes), squeeze=False, sharey=True)[0]
        for axes, take in zip(views, takes, strict=True):
            _draw_pass(axes, take)
        views[0].set_ylabel("up (cm)")
        drawn.tight_layout()
        return svg(drawn, "passes", alt)


def _level(axes: Axes, hover: dict[str, Any], end: int) -> None:
    low, high = hover["hit_rate_interval"]
    axes.axhspan(low, high, color=ink("hover"), alpha=0.16, linewidth=0)
    axes.axhline(hover["hit_rate"], color=ink("hover"), linestyle=(0, (4, 3)), label="hover")


def _rolling(axes: Axes, won: ndarray) -> None:
    """Draw the rate of the last balls at each ball, with its interval."""
    window = min(WINDOW, max(len(won) // 3, 1))
    sums = np.convolve(won, np.ones(window), mode="valid")
    places = np.arange(len(sums)) + window
    bounds = [wilson_interval(int(hits), window) or (0.0, 1.0) for hits in sums]
    low, high = np.array(bounds).reshape(-1, 2).T
    axes.fill_between(places, low, high, color=ink("after"), alpha=0.16, linewidth=0)
    label = f"training, last {window} balls"
    axes.plot(places, sums / window, color=ink("after"), linewidth=1.7, label=label)
    marks = np.flatnonzero(won) + 1
    axes.plot(marks, np.full(len(marks), 0.006), "|", color=ink("after"), alpha=0.8, markersize=5)


def _point(axes: Axes, player: dict[str, Any], place: float) -> None:
    share, (low, high) = player["hit_rate"], player["hit_rate_interval"]
    role = player["name"]
    axes.errorbar(
        place,
        share,
        yerr=[[share - low], [high - share]],
        color=ink(role),
        marker="o" if role == "after" else "s",
        markersize=6,
        capsize=3,
        linestyle="none",
        label=f"evaluated {role}",
    )


def _label_space(axes: Axes, take: Take) -> None:
    truth = take.played.truth
    end = "hit" if take.played.outcome == "hit" else "end"
    below = truth.body_path[0] - [0.0, 0.0, 0.3]
    labels = ((truth.ball_path[0], 10, "thrown here"), (truth.ball_path[-1], 14, end))
    for place, higher, words in (*labels, (below, 0, "drone")):
        x, y = seen(place).tolist()
        axes.annotate(words, (x, y), (0, higher), textcoords="offset points", ha="center")


def _court_from_the_side(axes: Axes) -> None:
    x = TABLE_HALF_LENGTH
    axes.fill_between([-x, x], -TABLE_THICKNESS, 0.0, color=ink("table"), alpha=0.6, linewidth=0)
    axes.plot([0, 0], [0, NET_HEIGHT], color=ink("ink"), linewidth=1.6)


def _court_from_above(axes: Axes) -> None:
    x, y = TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
    axes.fill_between([-x, x], -y, y, color=ink("table"), alpha=0.2, linewidth=0)
    axes.plot([0, 0], [-NET_HALF_LENGTH, NET_HALF_LENGTH], color=ink("ink"), linewidth=1.2)
    axes.plot([-x, x], [0, 0], color=ink("quiet"), linewidth=0.6)


def _drone_from_the_side(axes: Axes, body: ndarray, alpha: float) -> None:
    racket, (x, _, z) = Racket(), body
    corner = (x - HULL.radius, z - HULL.half_height)
    size = (2 * HULL.radius, 2 * HULL.half_height)
    axes.add_patch(Rectangle(corner, *size, color=ink("quiet"), alpha=0.5 * alpha, linewidth=0))
    ends = z + racket.z + np.array([-racket.half_height, racket.half_height])
    axes.plot([x + racket.x] * 2, ends, color=ink("blade"), alpha=alpha, linewidth=2.2)


def _drone_from_above(axes: Axes, body: ndarray, alpha: float) -> None:
    racket, (x, y, _) = Racket(), body
    disc = Circle((x, y), HULL.radius, color=ink("quiet"), alpha=0.5 * alpha, linewidth=0)
    axes.add_patch(disc)
    ends = y + np.array([-racket.half_width, racket.half_width])
    axes.plot([x + racket.x] * 2, ends, color=ink("blade"), alpha=alpha, linewidth=2.2)


def _draw_paths(axes: Axes, take: Take, column: int) -> None:
    truth = take.played.truth
    ball, blade = truth.ball_path[:, [0, column]], truth.blade_path[:, [0, column]]
    label = "ball, a dot each 0.1 s"
    axes.plot(*ball[::PATH_STEP].T, color=ink("ball"), linewidth=1.8, label=label)
    axes.plot(*blade[::PATH_STEP].T, color=ink("blade"), linewidth=2.2, label="blade")
    axes.plot(*ball[::FLASH].T, ".", color=ink("ball"), markersize=6)
    plane = HOME_BODY[0] + GAZEBO.position_m[0] + PLANE_DISTANCE
    dashes = (0, (4, 3))
    axes.axvline(plane, color=ink("quiet"), linestyle=dashes, linewidth=1, label="2.5 m plane")
    if take.trigger is not None:
        place = ball[min(round(take.trigger.time / TICK), len(ball) - 1)]
        label = "ball at the trigger"
        axes.plot(*place, "o", mfc="none", mec=ink("ink"), markersize=9, label=label)
    axes.plot(*ball[-1], "*", color=ink("ink"), markersize=9)


def _draw_pass(axes: Axes, take: Take) -> None:
    truth = take.played.truth
    apart = 100 * (truth.ball_path - truth.blade_path)  # cm
    nearest = int(np.argmin(np.abs(apart[:, 0] - 100 * BALL_RADIUS)))
    way = apart[max(nearest - SHOWN_TICKS, 0) :: PATH_STEP, 1:]
    _draw_drone(axes)
    axes.plot(-way[:, 0], way[:, 1], color=ink("ball"), linewidth=1.2)
    place = (-apart[nearest, 1], apart[nearest, 2])
    axes.add_patch(Circle(place, 100 * BALL_RADIUS, color=ink("ball")))
    if take.played.outcome == "hull":
        axes.plot(-apart[-1, 1], apart[-1, 2], "*", color=ink("ink"), markersize=9)
    limit = 100 * LARGEST_VIEW
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xlabel="right (cm)")
    axes.set(xticks=(-40, 0, 40), yticks=(-40, 0, 40))
    axes.set_title(spoken(take.played.outcome), fontsize=9.5)
    axes.grid(linewidth=0.5)


def _draw_drone(axes: Axes) -> None:
    """Draw hull and blade from behind, in cm from the blade's centre."""
    racket, hull = Racket(), HULL
    corner = (-100 * hull.radius, -100 * (racket.z + hull.half_height))
    size = (200 * hull.radius, 200 * hull.half_height)
    axes.add_patch(Rectangle(corner, *size, color=ink("quiet"), alpha=0.25, linewidth=0))
    blade = (200 * racket.half_width, 200 * racket.half_height)
    axes.add_patch(Ellipse((0, 0), *blade, facecolor=ink("blade"), alpha=0.35))
    axes.add_patch(Ellipse((0, 0), *blade, fill=False, edgecolor=ink("blade")))
