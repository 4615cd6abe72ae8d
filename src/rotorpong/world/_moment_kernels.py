"""What a row sees at its time, compiled: its pose, and where the ball is meanwhile.

Between two rows of the track everything moves evenly, the axes too, so in the camera frame the ball
is at c(u) = ((1 - u) R_0 + u R_1)^T ((1 - u) d_0 + u d_1): a parabola. It stays in the triangle of

    R_0^T d_0,    (R_0^T d_1 + R_1^T d_0) / 2,    R_1^T d_1

and its outline in the box around the outlines of three balls there. Most rows are far from these
boxes and need not know where the ball is.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.world._pixel_kernels import EYE, FAR, RIGHT, F

LIGHT_DIRECTION = (-0.60, 0.25, 0.76)  # to the light, world frame, unit length
POSITION, ROTATION, BALL_POSITION, TRACK_COLUMNS = 0, 3, 12, 15  # columns of a track
NEAREST = 1.001 * BALL_RADIUS  # a ball that reaches behind the camera may be anywhere


class Shutter(NamedTuple):
    """When each row of the picture is exposed, in rows of the track: a global or a rolling one."""

    track: np.ndarray  # (n, TRACK_COLUMNS) float64: camera's place and axes, ball; even in time
    boxes: np.ndarray  # (max(n - 1, 1), 4) float32: around the ball between rows, to be written
    first: float  # middle of the exposure of row 0
    each: float  # from a row to the next
    window: float  # exposure


class Moment(NamedTuple):
    """What a row sees at its time; written anew for every row."""

    pose: np.ndarray  # (TRACK_COLUMNS,) float64: a row of the track, in the middle of the exposure
    axes: np.ndarray  # (4, 3) float32: eye, and axes right, down, forward, in the world
    balls: np.ndarray  # (n, 3) float64: the ball in the camera frame, evenly over the exposure
    light: np.ndarray  # (3,) float64: direction to the light in the camera frame
    box: np.ndarray  # (4,) float32: left, right, top, bottom directions around all balls


@kernel
def look(moment, shutter, row):
    """Write the pose of a row."""
    pose, axes = moment.pose, moment.axes
    pose_at(pose, shutter.track, shutter.first + row * shutter.each)
    for k in range(3):
        axes[EYE, k] = pose[POSITION + k]
        for axis in range(3):
            axes[RIGHT + axis, k] = pose[ROTATION + 3 * k + axis]


@kernel
def look_for_ball(moment, shutter, row):
    """Write the light, where the ball is at every instant of a row's exposure, and a box around.

    The pose is that of the row again afterwards.
    """
    when, count = shutter.first + row * shutter.each, moment.balls.shape[0]
    pose, balls = moment.pose, moment.balls
    clear(moment.box)
    for s in range(count):
        pose_at(pose, shutter.track, when + shutter.window * ((s + 0.5) / count - 0.5))
        x, y, z = ball_from(pose, pose)
        balls[s, 0], balls[s, 1], balls[s, 2] = x, y, z
        widen(moment.box, x, y, z)
    pose_at(pose, shutter.track, when)
    for axis in range(3):
        light = 0.0
        for k in range(3):
            light += pose[ROTATION + 3 * k + axis] * LIGHT_DIRECTION[k]
        moment.light[axis] = light


@kernel
def pose_at(pose, track, when):
    """Write the track between its rows; before the first and after the last they hold."""
    last = track.shape[0] - 1
    when = min(max(when, 0.0), float(last))
    before = min(int(when), max(last - 1, 0))
    share, after = when - before, min(before + 1, last)
    for k in range(TRACK_COLUMNS):
        pose[k] = track[before, k] + share * (track[after, k] - track[before, k])


@kernel
def ball_from(eye, pose):
    """Return the ball of `pose`, as far from the camera as there, in the axes of `eye`."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(3):
        offset = pose[BALL_POSITION + k] - pose[POSITION + k]
        x += eye[ROTATION + 3 * k] * offset
        y += eye[ROTATION + 3 * k + 1] * offset
        z += eye[ROTATION + 3 * k + 2] * offset
    return x, y, z


@kernel
def clear(box):
    """Make a box one around nothing."""
    box[0], box[1], box[2], box[3] = FAR, -FAR, FAR, -FAR


@kernel
def widen(box, x, y, z):
    """Widen a box of directions by the outline of a ball.

    The outline of a sphere at (X, Y, Z) lies within a = (X Z +- r sqrt(X^2 + Z^2 - r^2)) /
    (Z^2 - r^2), and likewise in b.
    """
    r = BALL_RADIUS
    if z < -r:
        return
    left, right, top, bottom = -1e9, 1e9, -1e9, 1e9
    if z > NEAREST:
        scale = 1.0 / (z * z - r * r)
        half = r * math.sqrt(x * x + z * z - r * r) * scale
        left, right = x * z * scale - half, x * z * scale + half
        half = r * math.sqrt(y * y + z * z - r * r) * scale
        top, bottom = y * z * scale - half, y * z * scale + half
    box[0], box[1] = min(box[0], F(left)), max(box[1], F(right))
    box[2], box[3] = min(box[2], F(top)), max(box[3], F(bottom))


@kernel
def bound_balls(shutter):
    """Write the boxes in which the ball stays between each two rows of the track."""
    track, boxes = shutter.track, shutter.boxes
    for i in range(boxes.shape[0]):
        before, after = track[i], track[min(i + 1, track.shape[0] - 1)]
        x0, y0, z0 = ball_from(before, before)
        x1, y1, z1 = ball_from(before, after)
        x2, y2, z2 = ball_from(after, before)
        x3, y3, z3 = ball_from(after, after)
        middle = 0.5 * (z1 + z2)
        nearest = min(min(z0, middle), z3)
        clear(boxes[i])
        if nearest > NEAREST:
            widen(boxes[i], x0, y0, z0)
            widen(boxes[i], 0.5 * (x1 + x2), 0.5 * (y1 + y2), middle)
            widen(boxes[i], x3, y3, z3)
        elif max(max(z0, middle), z3) >= -BALL_RADIUS:
            widen(boxes[i], 0.0, 0.0, 0.0)


@kernel
def bound_row(box, shutter, row):
    """Write a box in which the ball stays while a row is exposed."""
    boxes, last = shutter.boxes, shutter.boxes.shape[0] - 1
    when, half = shutter.first + row * shutter.each, 0.5 * shutter.window
    clear(box)
    for i in range(interval(when - half, last), interval(when + half, last) + 1):
        box[0], box[1] = min(box[0], boxes[i, 0]), max(box[1], boxes[i, 1])
        box[2], box[3] = min(box[2], boxes[i, 2]), max(box[3], boxes[i, 3])


@kernel
def interval(when, last):
    """Return between which rows of the track a time lies."""
    return int(min(max(when, 0.0), float(last)))
