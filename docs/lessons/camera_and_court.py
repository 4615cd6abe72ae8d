"""Figures and numbers of the lesson: `python docs/lessons/camera_and_court.py`.

Writes six PNGs to `docs/images/lessons/` and prints every number that the page quotes.
"""

import math
from dataclasses import replace

import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, drawn
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotorpong.conventions import (
    BALL_DIAMETER,
    BALL_RADIUS,
    CAMERA_FROM_BODY_AXES,
    GRAVITY,
)
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, bounce, fly
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO, Camera, project
from rotorpong.world.court import (
    NET_HALF_LENGTH,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rotorpong.world.render import Scene, render

EYE = np.array([-1.69, 0.0, 0.20])  # m, world: the camera of a drone at home
AXES = np.ascontiguousarray(CAMERA_FROM_BODY_AXES.T)  # world_from_camera, level
BALL = np.array([-0.2, 0.1, 0.45])
UP = np.array([0.0, 0.0, 1.0])
READOUT = 1.0 / 30.0  # s, in which a rolling shutter passes the picture: an assumption
EXPOSURE = 0.010  # s, for the blur: an assumption
SMALL_ERROR = 0.1  # px, of a diameter


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (pinhole, distortion, shutter_and_blur, flight, bouncing, depth):
        print(f"  {drawn(draw, IMAGES)}")


def in_camera(points: np.ndarray) -> np.ndarray:
    """Return world points in the camera's frame: X right, Y down, Z depth."""
    return (points - EYE) @ AXES


def pinhole(figure: Figure) -> None:
    """The court from above, and the same court in the picture."""
    plan, picture = figure.subplots(1, 2, width_ratios=[1, 1.15])
    outline = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    plan.plot(*(outline * [TABLE_HALF_LENGTH, TABLE_HALF_WIDTH]).T, color=BLUE)
    plan.plot([0, 0], [-NET_HALF_LENGTH, NET_HALF_LENGTH], color=GREY)
    for side in (-1, 1):
        far = EYE[:2] + 4.2 * np.array([1.0, side * 320 / GAZEBO.focal_length_px[0]])
        plan.plot(*np.stack([EYE[:2], far]).T, color=PINK, linewidth=0.8)
    plan.plot(*BALL[:2], "o", color=ORANGE)
    plan.plot(*EYE[:2], "s", color="black")
    plan.annotate("camera", EYE[:2], (-2.1, -0.35))
    plan.annotate("ball", BALL[:2], (-0.1, 0.2))
    plan.set(
        xlabel="x, m (to the opponent)", ylabel="y, m (left)", xlim=(-2.2, 2.2), ylim=(-1.7, 1.7)
    )
    _show(picture, render(GAZEBO, EYE, AXES, BALL, Scene()))
    place = in_camera(BALL)
    x, y = project(GAZEBO, place)
    diameter = GAZEBO.focal_length_px[0] * BALL_DIAMETER / float(np.linalg.norm(place))
    picture.plot(x, y, "o", color="magenta", markersize=14, fillstyle="none")
    picture.set_title("Eq. (2): where the ball appears", fontsize=9)
    print(f"ball in camera axes: X {place[0]:.3f} m, Y {place[1]:.3f} m, Z {place[2]:.3f} m")
    print(f"its picture: x {x:.1f} px, y {y:.1f} px, diameter {diameter:.2f} px")
    back = GAZEBO.focal_length_px[0] * BALL_DIAMETER / diameter
    print(f"and back by Eq. (1): d = {back:.3f} m")


def distortion(figure: Figure) -> None:
    """The AR.Drone's lens: how far it moves what it shows."""
    picture, graph = figure.subplots(1, 2, width_ratios=[1.15, 1])
    eye = EYE + np.array([-0.2, 0.0, 0.25])
    _show(picture, render(ARDRONE2_720P, eye, AXES, BALL, Scene()))
    straight = replace(ARDRONE2_720P, distortion=(0.0,) * 5)
    y = np.linspace(-NET_HALF_LENGTH, NET_HALF_LENGTH, 60)
    tape = np.stack([np.zeros(60), y, np.full(60, NET_HEIGHT)], axis=1)
    flat = project(straight, (tape - eye) @ AXES)
    picture.plot(*flat.T, color="magenta", linewidth=1.0)
    picture.set_title("the net as a pinhole would show it", fontsize=9, color="magenta")
    angle = np.radians(np.linspace(0.0, 32.0, 80))
    rays = np.stack([np.tan(angle), np.zeros(80), np.ones(80)], axis=1)
    shift = project(straight, rays)[:, 0] - project(ARDRONE2_720P, rays)[:, 0]
    graph.plot(np.degrees(angle), shift, color=BLUE)
    graph.set(xlabel="angle from the optical axis, degrees", ylabel="shift to the middle, px")
    for degrees in (10, 20, 30):
        moved = float(np.interp(degrees, np.degrees(angle), shift))
        print(f"distortion at {degrees} degrees: {moved:.1f} px")


def shutter_and_blur(figure: Figure) -> None:
    """What rows exposed one after the other, and an open shutter, do to a moving ball."""
    rolling, blur = figure.subplots(1, 2)
    focal, velocity = GAZEBO.focal_length_px[0], 7.0
    away = np.linspace(0.5, 3.0, 80)
    for turn, colour in ((30.0, GREEN), (60.0, ORANGE), (120.0, PINK)):
        rows = np.arange(GAZEBO.height_px)
        lean = focal * np.tan(np.radians(turn) * (rows / GAZEBO.height_px - 0.5) * READOUT)
        rolling.plot(lean, rows, color=colour, label=f"yaw {turn:.0f} degrees/s")
        print(f"rolling shutter, yaw {turn:.0f} degrees/s: a post leans by {np.ptp(lean):.1f} px")
    rolling.invert_yaxis()
    rolling.set(xlabel="shift of an upright post, px", ylabel="row of the picture")
    rolling.legend(fontsize=8)
    across = focal * 2.0 * EXPOSURE / away
    growth = focal * BALL_DIAMETER * (1 / (away - velocity * EXPOSURE / 2) - 1 / away)
    blur.plot(away, focal * BALL_DIAMETER / away, color=GREY, label="diameter of the ball")
    blur.plot(away, across, color=BLUE, label="2 m/s across: length of the smear")
    blur.plot(away, growth, color=ORANGE, label="7 m/s towards us: growth while open")
    blur.set(xlabel="distance, m", ylabel="px", ylim=(0, 32))
    blur.legend(fontsize=8)
    print(f"smear at 1 m, 2 m/s across, 10 ms: {focal * 2.0 * EXPOSURE:.1f} px")


def flight(figure: Figure) -> None:
    """The same throw in vacuum, in air, and with spin."""
    axes = figure.subplots()
    thrown = Ball(np.array([2.0, 0.0, 0.25]), np.array([-7.0, 0.0, 2.2]), np.zeros(3))
    vacuum, air = Air()._replace(drag=0.0, magnus=0.0), Air()
    throws = (
        ("vacuum: a parabola", thrown, vacuum, GREY),
        ("drag", thrown, air, BLUE),
        (
            "drag and topspin, 100 rad/s",
            replace(thrown, spin=np.array([0.0, -100.0, 0.0])),
            air,
            ORANGE,
        ),
        (
            "drag and backspin, 100 rad/s",
            replace(thrown, spin=np.array([0.0, 100.0, 0.0])),
            air,
            GREEN,
        ),
    )
    for label, ball, medium, colour in throws:
        path = np.stack([fly(ball, medium, t).position for t in np.linspace(0.0, 0.6, 61)])
        path = path[path[:, 2] > BALL_RADIUS]
        axes.plot(path[:, 0], path[:, 2], color=colour, label=label)
        end = fly(ball, medium, 0.5)
        place, speed = end.position, float(np.linalg.norm(end.velocity))
        print(f"{label}: after 0.5 s x {place[0]:.3f} m, z {place[2]:.3f} m, {speed:.2f} m/s")
    axes.plot([-TABLE_HALF_LENGTH, TABLE_HALF_LENGTH], [0, 0], color="black", linewidth=2)
    axes.plot([0, 0], [0, NET_HEIGHT], color="black", linewidth=2)
    axes.invert_xaxis()
    axes.set(xlabel="x, m: the ball flies to the right", ylabel="z, m")
    axes.legend(fontsize=8)
    terminal = math.sqrt(GRAVITY / air.drag)
    print(f"drag at 7 m/s: {air.drag * 49:.2f} m/s^2; it equals gravity at {terminal:.2f} m/s")
    ratio = BALL_RADIUS * 100.0 / 7.0
    lift = air.magnus * 700.0 / (1.0 + air.saturation * ratio)
    print(f"Magnus at 7 m/s, 100 rad/s: {lift:.2f} m/s^2")


def bouncing(figure: Figure) -> None:
    """Grip or slip: how much speed and spin a bounce exchanges."""
    speed, turn = figure.subplots(1, 2)
    spins, ratio = np.linspace(-400.0, 400.0, 161), TABLE_SURFACE.restitution
    for down, colour in ((1.0, GREEN), (2.0, BLUE), (4.0, ORANGE)):
        count = len(spins)
        before = Ball(
            np.zeros((count, 3)),
            np.tile([-5.0, 0.0, -down], (count, 1)),
            np.stack([np.zeros(count), spins, np.zeros(count)], axis=1),
        )
        after = bounce(before, UP, TABLE_SURFACE)
        speed.plot(spins, -after.velocity[:, 0], color=colour, label=f"falling at {down:.0f} m/s")
        turn.plot(spins, after.spin[:, 1], color=colour)
    speed.axhline(5.0, color=GREY, linewidth=0.8)
    turn.plot(spins, spins, color=GREY, linewidth=0.8)
    speed.set(xlabel="spin before, rad/s (topspin < 0)", ylabel="forward speed after, m/s")
    turn.set(xlabel="spin before, rad/s", ylabel="spin after, rad/s")
    speed.legend(fontsize=8)
    example = Ball(np.zeros(3), np.array([-5.0, 0.0, -2.0]), np.zeros(3))
    after = bounce(example, UP, TABLE_SURFACE)
    limit = TABLE_SURFACE.friction * (1 + ratio) * 2.0
    print(f"(-5, 0, -2) m/s without spin bounces to {np.round(after.velocity, 3).tolist()} m/s")
    print(
        f"and {np.round(after.spin, 1).tolist()} rad/s; impulse {limit:.2f} of 2/5 |u| = 2.00 m/s"
    )


def depth(figure: Figure) -> None:
    """Why depth is hard: one tenth of a pixel."""
    axes = figure.subplots()
    away = np.linspace(0.4, 4.0, 100)
    for camera, colour in ((GAZEBO, ORANGE), (ARDRONE2_720P, BLUE)):
        error = _depth_error(camera, away)
        axes.semilogy(away, 100 * error, color=colour, label=f"depth, {camera.name}")
        sideways = away / camera.focal_length_px[0] * SMALL_ERROR
        axes.semilogy(
            away, 100 * sideways, color=colour, linestyle="--", label=f"sideways, {camera.name}"
        )
        centimetres = 100 * float(_depth_error(camera, 2.5))
        print(f"{camera.name}: 0.1 px at 2.5 m is {centimetres:.1f} cm of depth")
        print(f"  and {1000 * 2.5 / camera.focal_length_px[0] * SMALL_ERROR:.2f} mm sideways")
    axes.set(xlabel="distance, m", ylabel="error from 0.1 px, cm")
    axes.legend(fontsize=8, ncols=2)
    flown = 7.0 / 30.0
    wrong = math.sqrt(2) * float(_depth_error(GAZEBO, 2.5)) * 30.0
    print(f"a ball of 7 m/s flies {flown:.3f} m between frames; speed error {100 * wrong:.0f} cm/s")


def _depth_error(camera: Camera, distance: np.ndarray | float) -> np.ndarray | float:
    """Return dZ = Z^2/(f D) dd."""
    return np.square(distance) / (camera.focal_length_px[0] * BALL_DIAMETER) * SMALL_ERROR


def _show(axes: Axes, picture: np.ndarray) -> None:
    """Show a picture of blue, green and red, thinned to at most 640 columns."""
    step = max(1, picture.shape[1] // 640)
    extent = (-0.5, picture.shape[1] - 0.5, picture.shape[0] - 0.5, -0.5)
    axes.imshow(picture[::step, ::step, ::-1], extent=extent)
    axes.set_xlim(extent[:2])
    axes.set_ylim(extent[2:])
    axes.grid(visible=False)
    axes.set(xlabel="x, px", ylabel="y, px")


if __name__ == "__main__":
    main()
