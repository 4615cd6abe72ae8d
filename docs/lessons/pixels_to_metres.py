"""Figures and numbers of the lesson: `python docs/lessons/pixels_to_metres.py`.

Writes six PNGs to `docs/images/lessons/` and prints every number that the page quotes.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, drawn
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rotorpong.conventions import BALL_DIAMETER, BALL_RADIUS, CAMERA_FROM_BODY_AXES
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO, Camera, project, row_time
from rotorpong.vision.circles import FITS, CircleFit
from rotorpong.vision.detect import find_blobs
from rotorpong.vision.locate import ball_position
from rotorpong.vision.matte import (
    BallDisc,
    Guess,
    area_and_edge,
    rolling_shape,
    without_rolling,
)
from rotorpong.vision.measure import OUTLINE_BIAS_PX, Circle, fit_circle
from rotorpong.vision.sphere import disc_of_sphere, outline_shape, sphere_of_disc
from rotorpong.world.exposure import Motion, expose
from rotorpong.world.render import Scene, render

EYE = np.array([-1.69, 0.0, 0.20])  # m, world: the camera of a drone at home
AXES = np.ascontiguousarray(CAMERA_FROM_BODY_AXES.T)  # world_from_camera, level
BALL = np.array([0.78, 0.15, 0.42])  # m, world: 2.5 m away
BEFORE_AN_EDGE = np.array([-0.3, 0.3, 0.22])  # m, world: of the wall behind
SHARP = replace(ARDRONE2_720P, exposure_s=0.0, readout_s=0.0)
LINEAR = replace(SHARP, gamma=1.0)
WALL = (150.0, 140.0, 120.0)  # blue, green, red: an even grey
SURFACES = (
    *("table", "line", "net", "steel", "floor", "seam"),
    *("wall", "wainscot", "window", "ceiling", "lamp"),
)
EVEN = replace(
    Scene(opponent=False, ball_shadow=0.0, texture_contrast=0.0), **dict.fromkeys(SURFACES, WALL)
)
COUNT, ARCS = 60, 300  # balls and arcs per mean
ROOM_PX = 14  # around a ball, of a box
CORE_PX, GAP_PX, RING_PX = 2.2, 2.5, 3.0  # 2.5, 3 sd of the edge; as in `vision.matte`
SHADING = 0.35  # relative sd of the ball's brightness
INSTANT = 0.002  # s, between places of a motion


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (
        pixels_chain,
        pixels_outline,
        pixels_matte,
        pixels_bound,
        pixels_ellipse,
        pixels_motion,
    ):
        print(f"  {drawn(draw, IMAGES)}")


@dataclass(frozen=True)
class Shot:
    """A box of a picture, and the ball that is in it."""

    box: np.ndarray  # blue, green, red
    corner: np.ndarray  # column and row of its first pixel
    place: np.ndarray  # of the ball, camera frame, m
    disc: np.ndarray  # its true picture: x, y, area radius, px


def shoot(
    camera: Camera,
    place: np.ndarray,
    scene: Scene,
    key: int,
    velocity: np.ndarray | None = None,
) -> Shot:
    """Take a ball that is at `place` when its own row is exposed; camera frame, m, m/s."""
    speed = np.zeros(3) if velocity is None else velocity
    disc = disc_of_sphere(camera, place)
    smear = camera.focal_length_px[0] * np.linalg.norm(speed) * camera.exposure_s / place[2]
    half = int(disc[2] + 0.5 * smear) + ROOM_PX
    x, y = round(disc[0]), round(disc[1])
    times = INSTANT * (np.arange(25) - 12)
    since = times - float(row_time(camera, 0.0, np.array(disc[1])))
    balls = EYE + (place + since[:, None] * speed) @ AXES.T
    eyes, axes = np.tile(EYE, (25, 1)), np.tile(AXES, (25, 1, 1))
    motion = Motion(float(times[0]), INSTANT, eyes, axes, balls)
    region = (x - half, y - half, x + half + 1, y + half + 1)
    box = expose(camera, motion, 0.0, scene, key=(key,), region=region)
    return Shot(box, np.array([x - half, y - half]), place, disc)


def measured(
    camera: Camera,
    shot: Shot,
    *,
    rows_px_s: float = 0.0,
    streak_px: tuple[float, float] = (0.0, 0.0),
) -> tuple[BallDisc | None, BallDisc | None]:
    """Return the ball by area and by edge, from the guess that the outline gives."""
    blobs = find_blobs(shot.box)
    if not blobs:
        return None, None
    circle = fit_circle(blobs[0].contour)
    center = np.array([circle.x_px, circle.y_px]) + shot.corner
    shape = outline_shape(camera, center)
    if rows_px_s != 0.0:
        row = camera.readout_s / camera.height_px
        shape = rolling_shape(shape, np.array([0.0, rows_px_s]), row)
    x, y = center.tolist()
    guess = Guess(x, y, circle.diameter_px, streak_px, shape)
    offset = (int(shot.corner[0]), int(shot.corner[1]))
    return area_and_edge(shot.box, guess, offset=offset, gamma=camera.gamma)


def depth(camera: Camera, disc: BallDisc) -> tuple[float, float]:
    """Return Z of a measured disc and its standard deviation, m."""
    found = sphere_of_disc(
        camera, np.array([disc.x_px, disc.y_px, disc.radius_px]), disc.covariance
    )
    return float(found.position[2]), math.sqrt(found.covariance[2, 2])


def depth_by_circle(camera: Camera, shot: Shot) -> float:
    """Return Z by the outline's circle, its bias and the ellipse allowed for, m."""
    circle = fit_circle(find_blobs(shot.box)[0].contour)
    center = np.array([circle.x_px, circle.y_px]) + shot.corner
    diameter = np.array(circle.diameter_px + OUTLINE_BIAS_PX)
    return float(ball_position(camera, center, diameter, eq1=False)[2])


def somewhere(rng: np.random.Generator, away: float) -> np.ndarray:
    """Return a place of this depth, near the middle of the picture and above the net."""
    return away * np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.13, -0.05), 1.0])


def pixels_chain(figure: Figure) -> None:
    """The paper's chain on one frame, and the distances it makes of a ball that comes."""
    picture, graph = figure.subplots(1, 2, width_ratios=[1, 1.2])
    place = (BALL - EYE) @ AXES
    frame = render(GAZEBO, EYE, AXES, BALL, Scene())
    contour = find_blobs(frame)[0].contour
    circle, whole = fit_circle(contour), fit_circle(contour, whole_pixels=True)
    x, y, radius = disc_of_sphere(GAZEBO, place)
    _show(picture, frame[140:155, 290:305], (290, 140))
    _ring(picture, x, y, radius, color="magenta", label="the ball")
    _ring(picture, circle.x_px, circle.y_px, 0.5 * circle.diameter_px, color=BLUE, label="fitted")
    picture.plot(*contour.T, "o", color="white", markeredgecolor=BLUE, label="outline")
    picture.xaxis.set_major_locator(MaxNLocator(integer=True))
    picture.legend(fontsize=8, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    print(f"true: {np.linalg.norm(place):.3f} m, diameter {2 * radius:.2f} px")
    for name, found in (("fitted", circle), ("whole", whole)):
        print(f"{name}: diameter {found.diameter_px:.2f} px, d = {_eq1(found):.2f} m")
    for fit in FITS:
        print(f"{fit}: diameter {fit_circle(contour, fit=fit).diameter_px:.2f} px")
    step = 2.5**2 / (GAZEBO.focal_length_px[0] * BALL_DIAMETER)
    print(f"one pixel of diameter at 2.5 m: {100 * step:.0f} cm")
    _comes(graph)


def _comes(graph: Axes) -> None:
    away = np.arange(0.8, 4.0, 0.01)
    ray = (BALL - EYE) / np.linalg.norm(BALL - EYE)
    seen = np.array([_three_distances(distance * ray) for distance in away])
    graph.plot(away, away, color="magenta", linewidth=1, label="true")
    lines = (("whole", "in whole pixels", ORANGE), ("float", "as fitted", BLUE))
    for k, (key, name, colour) in enumerate((*lines, ("bias", "0.74 px added", GREEN))):
        graph.plot(away, seen[:, k], color=colour, linewidth=1.2, label=name)
        error = 100 * (seen[:, k] - away)[np.abs(away - 2.5) < 0.25]
        print(f"{key}, 2.25 to 2.75 m: mean error {error.mean():.0f} cm, sd {error.std():.0f} cm")
    graph.set(xlabel="true distance, m", ylabel="distance by Eq. (1), m", ylim=(0.5, 5.7))
    graph.legend(fontsize=8)


def _three_distances(from_eye: np.ndarray) -> tuple[float, float, float]:
    """Return the distances of a ball by Eq. (1): whole pixels, as fitted, bias added."""
    x, y = np.rint(project(GAZEBO, from_eye @ AXES)).astype(int).tolist()
    region = (x - 20, y - 20, x + 21, y + 21)
    box = render(GAZEBO, EYE, AXES, EYE + from_eye, Scene(), region=region)
    contour = find_blobs(box)[0].contour + np.array([x - 20, y - 20], np.int32)
    circle = fit_circle(contour)
    whole = fit_circle(contour, whole_pixels=True)
    return _eq1(whole), _eq1(circle), _eq1(circle, OUTLINE_BIAS_PX)


def _eq1(circle: Circle, add_px: float = 0.0) -> float:
    """Return the distance of Eq. (1), m."""
    center, diameter = np.array([circle.x_px, circle.y_px]), circle.diameter_px + add_px
    return float(np.linalg.norm(ball_position(GAZEBO, center, np.array(diameter))))


def pixels_outline(figure: Figure) -> None:
    """Which algebra: of little weight. What feeds it: of much."""
    algebra, food = figure.subplots(1, 2)
    shares = np.array([1 / 6, 0.2, 0.25, 1 / 3, 0.5, 0.75, 1.0])
    styles = (("o-", ORANGE, 5), ("o-", PINK, 9), ("o-", GREEN, 6), ("o-", BLUE, 3))
    for fit, (style, colour, size) in zip(FITS, styles, strict=True):
        found = [_arc_error(fit, share) for share in shares]
        algebra.plot(100 * shares, found, style, color=colour, markersize=size, label=fit)
        print(f"{fit}: full outline {found[-1]:.2f} px, a sixth {found[0]:.2f} px")
    algebra.set(xlabel="share of the outline, %", ylabel="median error of the radius, px")
    algebra.legend(fontsize=8)
    away = np.array([1.0, 1.75, 2.5, 4.0])
    cameras = (("ideal, f = 375 px", GAZEBO, GREEN), ("AR.Drone, gamma 1", LINEAR, BLUE))
    for name, camera, colour in (*cameras, ("AR.Drone, gamma 2.2", SHARP, ORANGE)):
        means, spreads = np.array([_outline_bias(camera, z) for z in away]).T
        shift = {GREEN: -0.05, BLUE: 0.0, ORANGE: 0.05}[colour]
        food.errorbar(away + shift, means, spreads, fmt="o-", capsize=2, color=colour, label=name)
        print(f"outline, {name}, at 2.5 m: {means[2]:.2f} px, sd {spreads[2]:.2f} px")
    food.axhline(0.0, color="black", linewidth=0.8)
    food.set(xlabel="distance, m", ylabel="error of the outline's radius, px", ylim=(-1.0, 0.4))
    food.legend(fontsize=8, loc="upper right")


def _arc_error(fit: CircleFit, share: float) -> float:
    """Return the median error of a radius of 9.4 px, of 60 points a turn that err by 0.1 px."""
    rng, radii = np.random.default_rng(0), []
    angles = 2 * np.pi * np.arange(round(60 * share)) / 60
    circle = 9.4 * np.column_stack([np.cos(angles), np.sin(angles)])
    for _ in range(ARCS):
        points = circle + 0.1 * rng.standard_normal(circle.shape)
        radii.append(0.5 * fit_circle(points, fit=fit).diameter_px)
    return float(np.median(radii)) - 9.4


def _outline_bias(camera: Camera, away: float) -> tuple[float, float]:
    """Return mean and sd of the outline's radius less the ball's, px."""
    rng, missing = np.random.default_rng(1), []
    for k in range(COUNT):
        shot = shoot(camera, somewhere(rng, away), Scene(), k)
        blobs = find_blobs(shot.box)
        if blobs:
            missing.append(0.5 * fit_circle(blobs[0].contour).diameter_px - shot.disc[2])
    return float(np.mean(missing)), float(np.std(missing))


def pixels_matte(figure: Figure) -> None:
    """One ball, and its share of each pixel by one background and by those of sectors."""
    axes = figure.subplots(1, 3)
    shot = shoot(SHARP, (BEFORE_AN_EDGE - EYE) @ AXES, Scene(), 1)
    x, y, radius = shot.disc - [*shot.corner, 0.0]
    _show(axes[0], shot.box, (0, 0))
    axes[0].set_title(f"true radius {radius:.2f} px", fontsize=9)
    for ring in (radius + GAP_PX, radius + GAP_PX + RING_PX):
        _ring(axes[0], x, y, ring, color="black", linestyle=":")
    names = ("one background", "24 sectors, scatter")
    found = matte(shot, 1, scatter=False), matte(shot, 24, scatter=True)
    for axis, name, (alpha, by_area) in zip(axes[1:], names, found, strict=True):
        axis.imshow(alpha, vmin=-0.5, vmax=1.5, cmap="PuOr_r")
        axis.grid(visible=False)
        axis.set(xlabel="x, px", facecolor="#dcdcdc")
        axis.set_title(f"{name}: {by_area:.2f} px", fontsize=9)
        print(f"{name}: {by_area:.2f} px of {radius:.2f} px")
    for axis in axes:
        half = radius + GAP_PX + RING_PX + 1.5
        axis.set(xlim=(x - half, x + half), ylim=(y + half, y - half))
    figure.colorbar(axes[2].images[0], ax=axes[1:], label="alpha, share of ball", shrink=0.7)
    for name, disc in zip(("area", "edge"), measured(SHARP, shot), strict=True):
        if disc is not None:
            sd = math.sqrt(disc.covariance[2, 2])
            print(f"measured by {name}: {disc.radius_px:.2f} px, sd {sd:.2f} px")
    _backgrounds()


def matte(shot: Shot, sectors: int, *, scatter: bool) -> tuple[np.ndarray, float]:
    """Return alpha = w.(c - g)/w.D up to the ring, w = S^-1 D, and the radius of its area.

    Plainer than `vision.matte`: it is told where the ring lies, and neither fits the shading nor
    pools the noise. `scatter` takes that of the background into S.
    """
    x, y, radius = shot.disc - [*shot.corner, 0.0]
    light = 255.0 * (shot.box / 255.0) ** SHARP.gamma
    rows, columns = np.indices(light.shape[:2])
    away = np.hypot(columns - x, rows - y)
    turn = np.arctan2(rows - y, columns - x) / (2 * np.pi) * sectors
    ball = light[away < radius - CORE_PX].mean(axis=0)
    ring = (away > radius + GAP_PX) & (away < radius + GAP_PX + RING_PX)
    alpha = np.zeros_like(away)
    for k in range(sectors):
        aside = np.abs((turn - k - 0.5 + sectors / 2) % sectors - sectors / 2)  # of its middle
        level = light[ring & (aside < 0.5)].mean(axis=0)
        near = light[ring & (aside < 1.0)] - level
        noise = np.eye(3) + SHADING**2 * np.outer(ball, ball)
        noise += near.T @ near / len(near) if scatter else 0.0
        weights = np.linalg.solve(noise, ball - level)
        mine = np.clip(1.0 - aside, 0.0, 1.0) if sectors > 1 else 1.0
        alpha += mine * ((light - level) @ weights) / (weights @ (ball - level))
    alpha[away < radius - CORE_PX] = 1.0
    inside = away < radius + GAP_PX
    area = float(np.clip(alpha[inside], -0.3, 1.3).sum())
    return np.where(inside, alpha, np.nan), math.sqrt(area / math.pi)


def _backgrounds() -> None:
    """Print depth errors of balls before the hall and the grey, by how the matte is made."""
    rules = ((1, False), (24, False), (1, True), (24, True))
    for place, scene in (("hall", Scene()), ("grey", EVEN)):
        rng, errors = np.random.default_rng(5), []
        for k in range(2 * COUNT):
            shot = shoot(SHARP, somewhere(rng, 2.5), scene, k)
            edge = measured(SHARP, shot)[1]
            radii = [matte(shot, n, scatter=scatter)[1] for n, scatter in rules]
            radii.append(np.nan if edge is None else edge.radius_px)
            errors.append(250.0 * np.abs(np.array(radii) / shot.disc[2] - 1.0))
        names = ("one level", "sectors", "one, scatter", "sectors, scatter", "edge")
        for name, cm in zip(names, np.array(errors).T, strict=True):
            half, most = np.nanpercentile(cm, [50, 90])
            print(f"{place}, {name}: median {half:.1f} cm, 90 % {most:.1f} cm")


def pixels_bound(figure: Figure) -> None:
    """Depth errors against the Cramer-Rao bound, and how sure a measurement should be."""
    graph, trust = figure.subplots(1, 2, width_ratios=[1.2, 1])
    away = np.array([1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0])
    errors = {z: _errors(LINEAR, EVEN, float(z)) for z in away}
    lines = (("outline's circle", "circle", ORANGE), ("area of the matte", "area", GREEN))
    for name, key, colour in (*lines, ("edge of the matte", "edge", BLUE)):
        spread = [100 * np.std(errors[z][key]) for z in away]
        graph.loglog(away, spread, "o", color=colour, markersize=4, label=name)
    fine = np.linspace(0.9, 5.5, 50)
    graph.loglog(fine, 100 * depth_bound(fine), color="black", linewidth=1, label="bound")
    graph.set(xlabel="depth, m", ylabel="sd of the depth, cm", xticks=[1, 2, 3, 4, 5])
    graph.set_xticks([], minor=True)
    graph.xaxis.set_major_formatter("{x:g}")
    graph.yaxis.set_major_formatter("{x:g}")
    graph.legend(fontsize=8)
    for z in (1.0, 2.5, 4.0):
        found = {key: 100 * np.std(values) for key, values in errors[z].items()}
        print(
            f"at {z} m: circle {found['circle']:.2f} cm, area {found['area']:.2f} cm, "
            f"edge {found['edge']:.2f} cm, bound {100 * depth_bound(z):.2f} cm"
        )
    _trust(trust)


def depth_bound(away: np.ndarray | float) -> np.ndarray | float:
    """Return the least sd of the depth before the even grey, m: Cramer and Rao's bound."""
    ball, wall = np.array(Scene().ball), np.array(WALL)
    noise = np.sqrt(LINEAR.read_noise**2 + LINEAR.shot_noise * 0.5 * (0.8 * ball + wall))
    own, apart = ball / noise, wall / noise
    contrast = float(np.linalg.norm(apart - (apart @ own) / (own @ own) * own))  # A / sigma
    aside = math.exp(-0.5 / LINEAR.blur_px**2)
    blur = math.sqrt(2.0 * aside / (1.0 + 2.0 * aside) + 1.0 / 12.0)
    radius = LINEAR.focal_length_px[0] * BALL_RADIUS / np.asarray(away)
    return away / radius * np.sqrt(blur / (math.sqrt(math.pi) * radius)) / contrast


def _errors(
    camera: Camera,
    scene: Scene,
    away: float,
    *,
    count: int = COUNT,
    speed: float = 0.0,
    told: bool = False,
) -> dict[str, np.ndarray]:
    """Return errors of the depth, m, by circle, area and edge, and the edge's own sd.

    The balls cross the picture at `speed`, m/s, in any direction; `told`, the streak is known.
    """
    rng, rows = np.random.default_rng(2), []
    for k in range(count):
        place, turn = somewhere(rng, away), rng.uniform(0.0, 2 * np.pi)
        velocity = speed * np.array([math.cos(turn), math.sin(turn), 0.0])
        shot = shoot(camera, place, scene, k, velocity)
        along, down = (velocity[:2] * camera.focal_length_px * camera.exposure_s / away).tolist()
        area, edge = measured(camera, shot, streak_px=(along, down) if told else (0.0, 0.0))
        if area is not None and edge is not None:
            by_edge, sd = depth(camera, edge)
            found = depth_by_circle(camera, shot), depth(camera, area)[0], by_edge
            rows.append((*(one - away for one in found), sd))
    return dict(zip(("circle", "area", "edge", "sd"), np.array(rows).T, strict=True))


def _trust(axes: Axes) -> None:
    hall = _errors(LINEAR, Scene(), 2.5, count=200)
    ratios = np.linspace(0.0, 8.0, 200)
    gauss = [math.erf(ratio / math.sqrt(2.0)) for ratio in ratios]
    axes.plot(ratios, gauss, color="black", linewidth=1, label="as a sd should be")
    for name, sd, colour in (
        ("its own covariance", hall["sd"], BLUE),
        ("the bound as its sd", float(depth_bound(2.5)), PINK),
    ):
        scores = np.abs(hall["edge"]) / sd
        axes.plot(ratios, [np.mean(scores < r) for r in ratios], color=colour, label=name)
        print(f"before the hall, {name}: {100 * np.mean(scores > 3.0):.0f} % beyond 3 sd")
    axes.set(xlabel="error of the edge's depth / sd", ylabel="share of balls below", ylim=(0, 1.02))
    axes.legend(fontsize=8, loc="lower right")


def pixels_ellipse(figure: Figure) -> None:
    """A sphere's picture off the axis, and what Eq. (1) makes of it."""
    picture, graph = figure.subplots(1, 2, width_ratios=[1.5, 1])
    for degrees, right in ((0.0, 0.0), (20.0, 1.25), (40.0, 2.8)):
        _outlines(picture, degrees, right)
    picture.plot([], [], color=BLUE, label="a sphere's outline")
    picture.plot([], [], "--", color=ORANGE, label="a circle of Eq. (1)")
    picture.set(aspect="equal", yticks=[], xticks=[], ylim=(-1.05, 1.25), xlim=(-0.6, 3.8))
    picture.spines[["left", "bottom"]].set_visible(False)
    picture.legend(fontsize=8, loc="upper center", ncols=2)
    angles = np.linspace(0.0, 35.0, 36)
    straight = _distances(angles, 2.5, eq1=True)
    corrected = _distances(angles, 2.5, eq1=False)
    exact = [_exact(angle, 2.5) for angle in angles]
    graph.plot(angles, straight, color=ORANGE, label="Eq. (1)")
    graph.plot(angles, exact, color=BLUE, linewidth=3.0, alpha=0.4, label="exact cone")
    graph.plot(angles, corrected, "--", color=GREEN, label="cos$^{1.5}$ divided out")
    graph.set(xlabel="angle from the axis, degrees", ylabel="distance, m", ylim=(1.75, 2.6))
    graph.legend(fontsize=8, loc="lower left")
    for degrees in (10, 20, 30):
        print(f"2.5 m at {degrees} degrees: {straight[degrees]:.2f} m by Eq. (1)")
    near = 1000 * abs(_distances(np.array([20.0]), 0.2, eq1=False)[0] - 0.2)
    print(f"0.2 m at 20 degrees, cos^1.5 divided out: {near:.1f} mm wrong")


def _outlines(axes: Axes, degrees: float, right: float) -> None:
    """Draw the outline of a sphere of R/d = 0.1 and Eq. (1)'s circle, in diameters f D/d."""
    angle, turn = math.radians(degrees), np.linspace(0.0, 2 * np.pi, 200)[:, None]
    ahead = np.array([math.sin(angle), 0.0, math.cos(angle)])
    side, up = np.array([math.cos(angle), 0.0, -math.sin(angle)]), np.array([0.0, 1.0, 0.0])
    tangent = math.sqrt(1 - 0.1**2) * ahead + 0.1 * (np.cos(turn) * side + np.sin(turn) * up)
    shape = (tangent[:, :2] / tangent[:, 2:] - ahead[:2] / ahead[2]) / 0.2
    axes.plot(shape[:, 0] + right, shape[:, 1], color=BLUE)
    axes.plot(right + 0.5 * np.cos(turn), 0.5 * np.sin(turn), "--", color=ORANGE)
    axes.plot(right, 0.0, "+", color=GREY)
    axes.text(right, -1.0, f"{degrees:.0f}°", ha="center")


def _discs(angles: np.ndarray, away: float) -> np.ndarray:
    angle = np.radians(angles)
    places = away * np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=-1)
    return disc_of_sphere(GAZEBO, places)


def _distances(angles: np.ndarray, away: float, *, eq1: bool) -> np.ndarray:
    discs = _discs(angles, away)
    found = ball_position(GAZEBO, discs[:, :2], 2.0 * discs[:, 2], eq1=eq1)
    return np.linalg.norm(found, axis=-1)


def _exact(degrees: float, away: float) -> float:
    disc = _discs(np.array(degrees), away)
    return float(np.linalg.norm(sphere_of_disc(GAZEBO, disc, np.eye(3)).position))


def pixels_motion(figure: Figure) -> None:
    """What an open shutter and rows one after the other do to the ball's size."""
    blur, rolling = figure.subplots(1, 2, width_ratios=[1.15, 1])
    open_shutter = replace(LINEAR, exposure_s=1.0 / 60.0)
    speeds = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0])
    streaks = speeds * LINEAR.focal_length_px[0] / 60.0 / 2.5
    errors = [_errors(open_shutter, EVEN, 2.5, speed=float(speed)) for speed in speeds]
    lines = (("outline's circle", "circle", ORANGE), ("area of the matte", "area", GREEN))
    for name, key, colour in (*lines, ("edge of the matte", "edge", BLUE)):
        medians = [100 * float(np.median(np.abs(error[key]))) for error in errors]
        blur.semilogy(streaks, medians, "o-", color=colour, label=name)
        print(f"{key}: {medians[0]:.1f} cm at rest, {medians[-1]:.1f} cm at {streaks[-1]:.0f} px")
    told = len(_errors(open_shutter, EVEN, 2.5, speed=3.0, told=True)["edge"])
    blind = len(errors[-1]["edge"])
    print(
        f"measured at {streaks[-1]:.0f} px: {blind} of {COUNT} balls, {told} when told the streak"
    )
    blur.set(
        xlabel="smear in the exposure, px", ylabel="error of the depth, median, cm", ylim=(0.1, 40)
    )
    blur.yaxis.set_major_formatter("{x:g}")
    blur.legend(fontsize=8, loc="center right")
    _rolls(rolling, replace(LINEAR, readout_s=0.030))


def _rolls(axes: Axes, camera: Camera) -> None:
    row = camera.readout_s / camera.height_px
    speeds = np.linspace(-4.0, 4.0, 9)
    pixels = speeds * camera.focal_length_px[1] / 2.5
    raw, undone = [], []
    for speed, rows_px_s in zip(speeds, pixels, strict=True):
        as_seen, right = [], []
        for k in range(10):
            place = somewhere(np.random.default_rng(k), 2.5)
            shot = shoot(camera, place, EVEN, k, np.array([0.0, speed, 0.0]))
            area, _ = measured(camera, shot, rows_px_s=rows_px_s)
            if area is None:
                continue
            as_seen.append((area.radius_px / shot.disc[2]) ** 2)
            right.append((without_rolling(area, rows_px_s, row).radius_px / shot.disc[2]) ** 2)
        raw.append(float(np.mean(as_seen)))
        undone.append(float(np.mean(right)))
    axes.plot(pixels, 1 / (1 - pixels * row), color="black", linewidth=1, label="1 / (1 - v t)")
    axes.plot(pixels, raw, "o", color=ORANGE, label="as measured")
    axes.plot(pixels, undone, "o", color=BLUE, label="undone")
    axes.set(xlabel="speed down the picture, px/s", ylabel="area / true area")
    axes.legend(fontsize=8)
    fall = 3.0 * camera.focal_length_px[1] / 2.5
    stretch = 1 / (1 - fall * row)
    print(f"3 m/s at 2.5 m: {fall:.0f} px/s, area x {stretch:.3f}")
    print(f"too near by {250 * (1 - 1 / math.sqrt(stretch)):.1f} cm")


def _show(axes: Axes, picture: np.ndarray, corner: tuple[int, int]) -> None:
    """Show part of a picture of blue, green and red, in pixels of the whole."""
    height, width = picture.shape[:2]
    x, y = corner
    axes.imshow(picture[..., ::-1], extent=(x - 0.5, x + width - 0.5, y + height - 0.5, y - 0.5))
    axes.grid(visible=False)
    axes.set(xlabel="x, px", ylabel="y, px")


def _ring(axes: Axes, x: float, y: float, radius: float, **style: Any) -> None:
    turn = np.linspace(0.0, 2 * np.pi, 100)
    axes.plot(x + radius * np.cos(turn), y + radius * np.sin(turn), **style)


if __name__ == "__main__":
    main()
