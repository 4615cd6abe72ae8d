"""The shapes of the solids, compiled: gaps between the ball and each of them.

A gap is the distance from the ball's surface to a solid, negative inside.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import flown
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
START, END, PROBE, OTHER, LAUNCHED, PLACE, ACROSS, SPEED, POINT, ROTATION = range(10)
WORK_ROWS = ROTATION + 3  # in one array: each array that a kernel is handed costs a count
FLAT = 0.999  # of a normal: off a flat side, not an edge
HALF_POST = 0.5 * POST_WIDTH
POST_SIDE = NET_HALF_LENGTH - 1e-6  # its inner face is touched at the very length of the net
HALF_TABLE = 0.5 * TABLE_THICKNESS
HALF_NET = 0.5 * NET_HEIGHT
TAPE_HEIGHT = NET_HEIGHT - NET_TAPE_HEIGHT


@kernel
def make_work():
    """Return fresh scratch: rows of states, points and a rotation, named above."""
    return np.zeros((WORK_ROWS, 9))


@kernel
def scene_of(p):
    """Return the record of which `solids.parameters` gave the numbers."""
    return Solids(
        Air(p[0], p[1], p[2], p[3]),
        Surface(p[4], p[5]),
        Surface(p[6], p[7]),
        Surface(p[8], p[9]),
        Surface(p[10], p[11]),
        Surface(p[12], p[13]),
        Racket(Surface(p[14], p[15]), p[16], p[17], p[18], p[19], p[20]),
        Hull(Surface(p[21], p[22]), p[23], p[24]),
        p[25],
    )


@kernel
def copy_row(work, given, to):
    """Copy a row of scratch (an array assignment would compile for seconds)."""
    for k in range(9):
        work[to, k] = work[given, k]


@kernel
def step_row(work, given, dt, air, to):
    """Advance the state in one row of scratch by dt into another."""
    x, y, z, vx, vy, vz, wx, wy, wz = flown(
        work[given, 0], work[given, 1], work[given, 2], work[given, 3], work[given, 4],
        work[given, 5], work[given, 6], work[given, 7], work[given, 8], dt, air,
    )  # fmt: skip
    work[to, 0], work[to, 1], work[to, 2] = x, y, z
    work[to, 3], work[to, 4], work[to, 5] = vx, vy, vz
    work[to, 6], work[to, 7], work[to, 8] = wx, wy, wz


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
def pose_between(track, i, fraction, work):
    """Write the pose between ticks i and i + 1 of a track of (position, quaternion)."""
    j = min(i + 1, track.shape[0] - 1)
    dot = 0.0
    for k in range(3):
        work[PLACE, k] = track[i, k] + fraction * (track[j, k] - track[i, k])
    for k in range(3, 7):
        dot += track[i, k] * track[j, k]
    to = math.copysign(fraction, dot)  # q and -q are the same attitude
    w = (1.0 - fraction) * track[i, 3] + to * track[j, 3]
    x = (1.0 - fraction) * track[i, 4] + to * track[j, 4]
    y = (1.0 - fraction) * track[i, 5] + to * track[j, 5]
    z = (1.0 - fraction) * track[i, 6] + to * track[j, 6]
    n = 2.0 / (w * w + x * x + y * y + z * z)
    work[ROTATION, 0] = 1.0 - n * (y * y + z * z)
    work[ROTATION, 1] = n * (x * y - w * z)
    work[ROTATION, 2] = n * (x * z + w * y)
    work[ROTATION + 1, 0] = n * (x * y + w * z)
    work[ROTATION + 1, 1] = 1.0 - n * (x * x + z * z)
    work[ROTATION + 1, 2] = n * (y * z - w * x)
    work[ROTATION + 2, 0] = n * (x * z - w * y)
    work[ROTATION + 2, 1] = n * (y * z + w * x)
    work[ROTATION + 2, 2] = 1.0 - n * (x * x + y * y)


@kernel
def body_point(x, y, z, work):
    """Return a world point in the axes of the body at the pose in `work`."""
    dx, dy, dz = x - work[PLACE, 0], y - work[PLACE, 1], z - work[PLACE, 2]
    return (
        work[ROTATION, 0] * dx + work[ROTATION + 1, 0] * dy + work[ROTATION + 2, 0] * dz,
        work[ROTATION, 1] * dx + work[ROTATION + 1, 1] * dy + work[ROTATION + 2, 1] * dz,
        work[ROTATION, 2] * dx + work[ROTATION + 1, 2] * dy + work[ROTATION + 2, 2] * dz,
    )


@kernel
def blade_gap(bx, by, bz, racket):
    """Return the gap to the blade of a ball at a body-frame point."""
    x, y, z = bx - racket.x, by - racket.y, bz - racket.z
    off = ellipse_gap(y, z, racket.half_width, racket.half_height)[2]
    return math.sqrt(x * x + off * off) - BALL_RADIUS


@kernel
def least_blade_gap(bx, by, bz, racket):
    """Return the gap to the disc about the blade: less than that to the blade, and quicker."""
    x, y, z = bx - racket.x, by - racket.y, bz - racket.z
    off = max(math.sqrt(y * y + z * z) - max(racket.half_width, racket.half_height), 0.0)
    return math.sqrt(x * x + off * off) - BALL_RADIUS


@kernel
def hull_gap(bx, by, bz, hull):
    """Return the gap to the hull of a ball at a body-frame point."""
    radial = math.sqrt(bx * bx + by * by) - hull.radius
    axial = abs(bz) - hull.half_height
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
def gap(solid, row, track, i, fraction, scene, work):
    """Return the gap between the ball in a row of `work` and one solid at tick i + fraction."""
    if solid < BLADE:
        return court_gap(solid, work[row, 0], work[row, 1], work[row, 2])
    pose_between(track, i, fraction, work)
    x, y, z = body_point(work[row, 0], work[row, 1], work[row, 2], work)
    if solid == BLADE:
        return blade_gap(x, y, z, scene.racket)
    return hull_gap(x, y, z, scene.hull)


@kernel
def part_of(solid, forward, up, work):
    """Return which of its solid's parts is touched, at POINT and with normal ACROSS of `work`.

    Args:
        solid: the solid.
        forward: the normal along the body's x.
        up: the normal along the body's z.
        work: scratch.
    """
    if solid == TABLE:
        return 0 if work[ACROSS, 2] > FLAT else (2 if work[ACROSS, 2] < -FLAT else 1)
    if solid == NET:
        return 2 if abs(work[POINT, 1]) > POST_SIDE else int(work[POINT, 2] > TAPE_HEIGHT)
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
