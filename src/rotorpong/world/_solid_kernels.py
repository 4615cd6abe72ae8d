"""The shapes of the solids, compiled: gaps between the ball and each of them.

A gap is the distance from the ball's surface to a solid, negative inside.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics.ball import Air, Surface
from rotorpong.world.court import (
    FLOOR_HEIGHT,
    NET_HALF_LENGTH,
    NET_HALF_THICKNESS,
    NET_HEIGHT,
    NET_TAPE_HEIGHT,
    POST_WIDTH,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    TABLE_THICKNESS,
)
from rotorpong.world.racket import Hull, Racket
from rotorpong.world.solids import Solids

TABLE, NET, FLOOR, BLADE, HULL = range(5)
SOLIDS = 5
FLAT = 0.999  # of a normal: off a flat side, not an edge
HALF_POST = 0.5 * POST_WIDTH
HALF_TABLE = 0.5 * TABLE_THICKNESS
HALF_NET = 0.5 * NET_HEIGHT
TAPE_HEIGHT = NET_HEIGHT - NET_TAPE_HEIGHT


class Work(NamedTuple):
    """Scratch arrays of the kernels, made once per flight."""

    start: np.ndarray
    end: np.ndarray
    probe: np.ndarray
    other: np.ndarray
    launched: np.ndarray
    rotation: np.ndarray
    position: np.ndarray
    body: np.ndarray
    normal: np.ndarray
    velocity: np.ndarray


@kernel
def make_work():
    """Return fresh scratch arrays."""
    return Work(
        np.zeros(9), np.zeros(9), np.zeros(9), np.zeros(9), np.zeros(9),
        np.zeros((3, 3)), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3),
    )  # fmt: skip


@kernel
def scene_of(p):
    """Return the record of which `solids.parameters` gave the numbers."""
    return Solids(
        Air(p[0], p[1], p[2]),
        Surface(p[3], p[4]),
        Surface(p[5], p[6]),
        Surface(p[7], p[8]),
        Surface(p[9], p[10]),
        Surface(p[11], p[12]),
        Racket(Surface(p[13], p[14]), p[15], p[16], p[17], p[18], p[19]),
        Hull(Surface(p[20], p[21]), p[22], p[23]),
        p[24],
    )


@kernel
def copy_state(state, out):
    """Copy nine floats (an array assignment would compile for seconds)."""
    for k in range(9):
        out[k] = state[k]


@kernel
def box_gap(x, y, z, half_x, half_y, half_z):
    """Return the distance from a point to a box about the origin, negative inside."""
    qx, qy, qz = abs(x) - half_x, abs(y) - half_y, abs(z) - half_z
    ox, oy, oz = max(qx, 0.0), max(qy, 0.0), max(qz, 0.0)
    return math.sqrt(ox * ox + oy * oy + oz * oz) + min(max(qx, max(qy, qz)), 0.0)


@kernel
def ellipse_gap(y, z, a, b):
    """Return the nearest point of a filled ellipse and the distance to it."""
    if (y / a) ** 2 + (z / b) ** 2 <= 1.0:
        return y, z, 0.0
    t = max(a * abs(y) - a * a, b * abs(z) - b * b)
    for _ in range(50):
        p, q = a * y / (t + a * a), b * z / (t + b * b)
        excess = p * p + q * q - 1.0
        if excess < 1e-14:
            break
        t += excess / (2.0 * (p * p / (t + a * a) + q * q / (t + b * b)))
    ny, nz = a * a * y / (t + a * a), b * b * z / (t + b * b)
    return ny, nz, math.sqrt((y - ny) ** 2 + (z - nz) ** 2)


@kernel
def pose_between(track, i, fraction, rotation, position):
    """Write the pose between ticks i and i + 1 of a track of (position, quaternion)."""
    a, b = track[i], track[min(i + 1, track.shape[0] - 1)]
    for k in range(3):
        position[k] = a[k] + fraction * (b[k] - a[k])
    dot = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6]
    to = math.copysign(fraction, dot)  # q and -q are the same attitude
    w = (1.0 - fraction) * a[3] + to * b[3]
    x = (1.0 - fraction) * a[4] + to * b[4]
    y = (1.0 - fraction) * a[5] + to * b[5]
    z = (1.0 - fraction) * a[6] + to * b[6]
    n = 2.0 / (w * w + x * x + y * y + z * z)
    rotation[0, 0] = 1.0 - n * (y * y + z * z)
    rotation[0, 1] = n * (x * y - w * z)
    rotation[0, 2] = n * (x * z + w * y)
    rotation[1, 0] = n * (x * y + w * z)
    rotation[1, 1] = 1.0 - n * (x * x + z * z)
    rotation[1, 2] = n * (y * z - w * x)
    rotation[2, 0] = n * (x * z - w * y)
    rotation[2, 1] = n * (y * z + w * x)
    rotation[2, 2] = 1.0 - n * (x * x + y * y)


@kernel
def body_point(px, py, pz, rotation, position, out):
    """Write a world point in body axes."""
    dx, dy, dz = px - position[0], py - position[1], pz - position[2]
    for k in range(3):
        out[k] = rotation[0, k] * dx + rotation[1, k] * dy + rotation[2, k] * dz


@kernel
def blade_gap(body, racket):
    """Return the gap to the blade of a ball at a body-frame point."""
    x, y, z = body[0] - racket.x, body[1] - racket.y, body[2] - racket.z
    off = ellipse_gap(y, z, racket.half_width, racket.half_height)[2]
    return math.sqrt(x * x + off * off) - BALL_RADIUS


@kernel
def least_blade_gap(body, racket):
    """Return a gap that the one to the blade is not below; quicker than the gap itself."""
    x, y, z = body[0] - racket.x, body[1] - racket.y, body[2] - racket.z
    size = max(racket.half_width, racket.half_height)
    return math.sqrt(x * x + y * y + z * z) - size - BALL_RADIUS


@kernel
def hull_gap(body, hull):
    """Return the gap to the hull of a ball at a body-frame point."""
    radial = math.sqrt(body[0] * body[0] + body[1] * body[1]) - hull.radius
    axial = abs(body[2]) - hull.half_height
    ox, oz = max(radial, 0.0), max(axial, 0.0)
    return math.sqrt(ox * ox + oz * oz) + min(max(radial, axial), 0.0) - BALL_RADIUS


@kernel
def court_gap(solid, x, y, z):
    """Return the gap to table, net (with its posts) or floor."""
    if solid == TABLE:
        top = box_gap(x, y, z + HALF_TABLE, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH, HALF_TABLE)
        return top - BALL_RADIUS
    if solid == NET:
        net = box_gap(x, y, z - HALF_NET, NET_HALF_THICKNESS, NET_HALF_LENGTH, HALF_NET)
        aside = abs(y) - NET_HALF_LENGTH - HALF_POST
        post = box_gap(x, aside, z - HALF_NET, HALF_POST, HALF_POST, HALF_NET)
        return min(net, post) - BALL_RADIUS
    return z - FLOOR_HEIGHT - BALL_RADIUS


@kernel
def gap(solid, state, track, i, fraction, scene, work):
    """Return the gap between a ball state and one solid at tick i + fraction."""
    if solid < BLADE:
        return court_gap(solid, state[0], state[1], state[2])
    pose_between(track, i, fraction, work.rotation, work.position)
    body_point(state[0], state[1], state[2], work.rotation, work.position, work.body)
    if solid == BLADE:
        return blade_gap(work.body, scene.racket)
    return hull_gap(work.body, scene.hull)


@kernel
def part_of(solid, point, normal, forward, up):
    """Return which of its solid's parts is touched at a world point.

    Args:
        solid: the solid.
        point: of its surface, that the ball touches.
        normal: there.
        forward: the normal along the body's x.
        up: the normal along the body's z.
    """
    if solid == TABLE:
        return 0 if normal[2] > FLAT else (2 if normal[2] < -FLAT else 1)
    if solid == NET:
        return 2 if abs(point[1]) > NET_HALF_LENGTH else int(point[2] > TAPE_HEIGHT)
    if solid == FLOOR:
        return 0
    if solid == BLADE:
        return 0 if forward > FLAT else (2 if forward < -FLAT else 1)
    return 1 if up > FLAT else (2 if up < -FLAT else 0)


@kernel
def surface_of(solid, part, scene):
    """Return restitution and friction of a part of a solid."""
    if solid == TABLE:
        return scene.table
    if solid == NET:
        return scene.post if part == 2 else (scene.tape if part == 1 else scene.net)
    if solid == FLOOR:
        return scene.floor
    if solid == BLADE:
        return scene.racket.surface
    return scene.hull.surface
