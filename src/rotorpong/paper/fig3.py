"""Fig. 3: the circles that the paper's eyes put around a bouncing ball, frame by frame.

The paper shows a sequence of onboard pictures and no number. Here are the frames about a bounce,
and how well the circles of many serves fit: a ball in the camera frame has an exact picture (an
ellipse bent by the lens; its centroid, and the radius of the circle with its area), and every
frame in which all of it is inside the picture counts. Through a rolling shutter the ball is taken
where it was when its own row was exposed. The chain is the paper's, as `PaperEyes` has it: colour,
largest plausible outline, Kasa's circle; rounded to whole pixels for Eq. (1) as in Fig. 4.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Ring
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, Picture
from rotorpong.drone import HOVER
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.paper.findings import Answers, Column, Findings, Job, Line, Scale
from rotorpong.paper.ink import drawing
from rotorpong.paper.snapshot import as_rgb, as_text
from rotorpong.paper.trajectory import true_state
from rotorpong.physics.camera import row_time
from rotorpong.vision.colour import ORANGE
from rotorpong.vision.detect import find_blobs
from rotorpong.vision.measure import Circle, fit_circle
from rotorpong.vision.paper_eyes import PLAUSIBLE_SCORE
from rotorpong.vision.sphere import disc_of_sphere
from rotorpong.world.simulated_drone import SimulatedDrone

TITLE = "Fig. 3: detections of a bouncing ball"
SERVES, FEW = 20, 2
VIEWS = {
    "gazebo": Spec("hover"),
    "ardrone2_720p": Spec("hover", vehicle="ardrone2", camera="ardrone2_720p"),
}
SECONDS = {"gazebo": 0.1, "ardrone2_720p": 0.35}  # about, for a serve
SERVE = 0  # of the strip
FRAMES, COLUMNS = 6, 3
WINDOW = (280, 168)  # px, of the pictures of the strip
FAR, MIDDLE = (2.0, 3.0), 2.5  # m, at which the radius' error is told apart
LOUPE = 1.7  # ball radii to either side
RING = "#FF00FF"  # magenta, which no ball has


class Shown(NamedTuple):
    """One frame that has all of the ball, and what was found in it."""

    time: float  # s
    disc: Float[ndarray, "3"]  # centroid x, y and area radius, px, exact
    circle: Circle | None  # diameter not rounded
    picture: Picture


def jobs(scale: Scale) -> tuple[Job, ...]:
    """Look at serves through either camera, and keep the frames about one bounce."""
    serves = scale.of(SERVES, FEW)
    specs = {view: replace(spec, seed=scale.seed) for view, spec in VIEWS.items()}
    looks = (
        Job(view, detections, (spec, serves), seconds=SECONDS[view] * serves)
        for view, spec in specs.items()
    )
    return (*looks, Job("strip", strip, (specs["gazebo"], SERVE)))


def detections(spec: Spec, serves: int) -> list[list[float]]:
    """Return a row for each frame: the exact disc (px), then the circle, if there is one.

    Centroid x, y and radius; centre x, y and diameter.
    """
    rows = []
    for index in range(serves):
        for shown in frames_of(new_drone(stage_of(spec), index)):
            found = shown.circle
            circle = [] if found is None else [found.x_px, found.y_px, found.diameter_px]
            rows.append([*shown.disc.tolist(), *circle])
    return rows


def strip(spec: Spec, serve: int) -> dict[str, Any]:
    """Return the frames about the bounce of a serve, cut to one window, with their circles."""
    drone = new_drone(stage_of(spec), serve)
    shown = frames_of(drone)
    bounce = next(c.time for c in drone.truth().contacts if c.solid == "table")
    after = sum(one.time < bounce for one in shown)
    first = min(max(after - FRAMES // 2, 0), max(len(shown) - FRAMES, 0))
    chosen = shown[first : first + FRAMES]
    left, top = _window(chosen)
    return {
        "bounce_s": bounce,
        "frames": [
            {
                "time_s": one.time,
                "picture": as_text(
                    one.picture[top : top + WINDOW[1], left : left + WINDOW[0]].copy()
                ),
                "circle": None if one.circle is None else _moved(one.circle, left, top),
            }
            for one in chosen
        ],
    }


def frames_of(drone: SimulatedDrone) -> list[Shown]:
    """Return the frames of a serve at a hovering drone that have all of the ball."""
    frames = []
    while (seen := drone.observe()) is not None:
        drone.command(HOVER)
        disc = exact_disc(drone, seen.frame_time)
        if _is_inside(disc, (seen.frame.width, seen.frame.height)):
            picture = seen.frame.picture
            frames.append(Shown(seen.frame_time, disc, circle_in(picture), picture))
    return frames


def circle_in(picture: Picture) -> Circle | None:
    """Return the largest plausible ball whose centre is in the picture, as the paper's eyes do."""
    height, width = picture.shape[:2]
    plausible = [b for b in find_blobs(picture, (ORANGE,)) if b.score >= PLAUSIBLE_SCORE]
    circles = [fit_circle(blob.contour) for blob in plausible]
    inside = [c for c in circles if 0 <= c.x_px <= width - 1 and 0 <= c.y_px <= height - 1]
    return max(inside, key=lambda circle: circle.diameter_px, default=None)


def exact_disc(drone: SimulatedDrone, frame_time: float) -> Float[ndarray, "3"]:
    """Return the ball's exact picture: centroid x, y and area radius, px; nan if there is none."""
    camera, time = drone.camera, frame_time
    disc = disc_of_sphere(camera, true_state(drone, time)[:3])
    if camera.readout_s > 0.0 and np.isfinite(disc).all():
        row = np.array(np.clip(disc[1], 0.0, camera.height_px - 1.0))
        time = float(row_time(camera, frame_time, row))
        disc = disc_of_sphere(camera, true_state(drone, time)[:3])
    return disc


def findings(scale: Scale, answers: Answers) -> Findings:
    """Tell how well circles fit, and show some."""
    lines = [Line(view, numbers(answers[view], *_far_radii(view))) for view in VIEWS]
    return Findings(
        columns=(
            Column("frames", "frames with the ball", 0),
            Column("detected_percent", "detected, %", 1),
            Column("elsewhere", "found elsewhere", 0),
            Column("radius_px", "radius, px", 2),
            Column("center_error_px", "error of centre, px", 3),
            Column("radius_error_px", "error of radius, px", 3),
            Column("whole_radius_error_px", "same, diameter in whole pixels", 3),
            Column("far_radius_error_px", "same, float, at 2 to 3 m", 3),
        ),
        paper=(),
        ours=lines,
        setting={
            "serves": f"human, {scale.of(SERVES, FEW)}",
            "cameras": {view: f"on {spec.vehicle_name}" for view, spec in VIEWS.items()},
            "player": "hover",
            "figure": f"camera gazebo, serve {SERVE}",
        },
        figures={"fig3": _figure(answers["strip"])},
        remarks="A circle counts as detected if its centre is within the ball's exact picture, as "
        "elsewhere if not. Error of the centre: mean distance; of the radius: mean, with its sign, "
        "± standard deviation. An outline runs through the centres of the outermost pixels inside "
        "the ball, so its circle is too small"
        f"{_cost(lines)}. Through ardrone2_720p near balls are blurred besides, as they cross the "
        "picture during the exposure. The corners of the figure show the ball enlarged.",
    )


def numbers(
    rows: Sequence[Sequence[float]], least: float = 0.0, most: float = np.inf
) -> dict[str, Any]:
    """Return how many balls were found, and how far their circles are off.

    Args:
        rows: of `detections`.
        least: radius in px of a ball that is said to be far,
        most: and the largest.
    """
    found = np.array([row for row in rows if len(row) > 3], dtype=float).reshape(-1, 6)
    away = np.linalg.norm(found[:, 3:5] - found[:, :2], axis=1)
    on = found[away <= found[:, 2]]
    values: dict[str, Any] = {
        "frames": len(rows),
        "detected_percent": 100.0 * len(on) / len(rows) if rows else None,
        "elsewhere": len(found) - len(on),
    }
    if len(on) < 2:
        return values
    radius, whole = 0.5 * on[:, 5], 0.5 * np.maximum(np.rint(on[:, 5]), 1.0)
    far = (on[:, 2] > least) & (on[:, 2] < most)
    columns = {
        "radius_error_px": radius - on[:, 2],
        "whole_radius_error_px": whole - on[:, 2],
        "far_radius_error_px": (radius - on[:, 2])[far],
    }
    values |= {"radius_px": float(on[:, 2].mean())}
    values |= {"center_error_px": float(away[away <= found[:, 2]].mean())}
    for key, column in columns.items():
        if len(column) > 1:
            values[key], values[f"{key}_sd"] = float(column.mean()), float(column.std(ddof=1))
    return values


def _far_radii(view: str) -> tuple[float, float]:
    """Return the radii of balls at 3 and at 2 m, px."""
    near, far = FAR
    return _radius(view, far), _radius(view, near)


def _radius(view: str, distance: float) -> float:
    return VIEWS[view].camera_profile().focal_length_px[0] * BALL_RADIUS / distance


def _cost(lines: Sequence[Line]) -> str:
    """Say what the radius' error at 2 to 3 m is worth in depth at 2.5 m, by Eq. (1)."""
    worth = []
    for line in lines:
        error = line.values.get("far_radius_error_px")
        if error is not None:
            radius, place = _radius(line.label, MIDDLE), 100.0 * MIDDLE
            worth.append(f"{-place * error / (radius + error):.0f} cm ({line.label})")
    return f": at 2.5 m this puts the ball {' and '.join(worth)} too far" if worth else ""


def _is_inside(disc: Float[ndarray, "3"], size: tuple[int, int]) -> bool:
    x, y, r = disc
    return bool(r <= x <= size[0] - 1 - r and r <= y <= size[1] - 1 - r)


def _window(shown: Sequence[Shown]) -> tuple[int, int]:
    """Return the upper left corner of a window about the balls of some frames."""
    height, width = shown[0].picture.shape[:2]
    discs = np.array([one.disc for one in shown])
    middle = 0.5 * (discs[:, :2].min(axis=0) + discs[:, :2].max(axis=0))
    left, top = np.rint(middle - 0.5 * np.array(WINDOW)).astype(int).tolist()
    return min(max(left, 0), width - WINDOW[0]), min(max(top, 0), height - WINDOW[1])


def _moved(circle: Circle, left: int, top: int) -> list[float]:
    return [circle.x_px - left, circle.y_px - top, circle.diameter_px]


def _figure(answer: dict[str, Any]) -> Figure:
    with drawing(7.2, 3.5) as figure:
        panels = figure.subplots(-(-FRAMES // COLUMNS), COLUMNS).ravel()
        for axes in panels:
            axes.set_axis_off()
        for axes, frame in zip(panels, answer["frames"], strict=False):
            picture = as_rgb(frame["picture"])
            axes.imshow(picture, interpolation="nearest")
            late = 1000.0 * (frame["time_s"] - answer["bounce_s"])
            axes.set_title(f"{abs(late):.0f} ms {'after' if late >= 0 else 'before'} the bounce")
            axes.title.set_fontsize(9)
            if frame["circle"] is not None:
                _draw(axes, picture, frame["circle"])
    return figure


def _draw(axes: Axes, picture: Picture, circle: Sequence[float]) -> None:
    """Draw a circle, and the ball enlarged in the corner that is farther from it."""
    x, y, diameter = circle
    reach = LOUPE * diameter / 2.0
    axes.add_patch(Ring((x, y), diameter / 2.0, fill=False, edgecolor=RING, linewidth=1.0))
    right = x < picture.shape[1] / 2
    loupe = axes.inset_axes(
        (0.66 if right else 0.01, 0.01, 0.33, 0.55),
    )
    loupe.imshow(picture, interpolation="nearest")
    loupe.add_patch(Ring((x, y), diameter / 2.0, fill=False, edgecolor=RING, linewidth=1.4))
    loupe.set(xlim=(x - reach, x + reach), ylim=(y + reach, y - reach), xticks=[], yticks=[])
    for spine in loupe.spines.values():
        spine.set(visible=True, color="white", linewidth=1.2)
