"""The ball among solids, compiled: gaps, exact contact times, bounces.

A gap is the distance from the ball's surface to a solid, negative inside. It changes no faster than
ball and solid move, so a step in which it can have been negative is never skipped. Contact times
solve gap = 0 on the step's own RK4 path, so restitution does not depend on where in a step the
contact falls.
"""

import math
from typing import NamedTuple

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import bounce, step
from rotorpong.world.court import (
    FLOOR_HEIGHT,
    NET_HALF_LENGTH,
    NET_HALF_THICKNESS,
    NET_HEIGHT,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    TABLE_THICKNESS,
)

TABLE, NET, FLOOR, BLADE, HULL = range(5)
SOLIDS = 5
CONTACT_COLUMNS = 14
REACH = 0.8  # m from the centre of mass: nothing of the drone is further out, ball included
DRONE_SPEED = 5.0  # m/s that no point of the drone exceeds
SLOWEST_CONTACT = 1e-3  # m/s towards the solid
PROBES = 8  # looks into a step that may hide a graze
ROOT_STEPS = 60
ROOT_TOLERANCE = 1e-12  # m
MOST_CONTACTS_PER_STEP = 16


class Work(NamedTuple):
    """Scratch arrays of the kernels, made once per flight."""

    start: np.ndarray
    before: np.ndarray
    probe: np.ndarray
    other: np.ndarray
    rotation: np.ndarray
    position: np.ndarray
    body: np.ndarray
    normal: np.ndarray
    velocity: np.ndarray
    row: np.ndarray


@kernel
def make_work():
    """Return fresh scratch arrays."""
    return Work(
        np.zeros(9), np.zeros(9), np.zeros(9), np.zeros(9),
        np.zeros((3, 3)), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3),
        np.zeros(CONTACT_COLUMNS),
    )  # fmt: skip


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
def hull_gap(body, hull):
    """Return the gap to the hull of a ball at a body-frame point."""
    radial = math.sqrt(body[0] * body[0] + body[1] * body[1]) - hull.radius
    axial = abs(body[2]) - hull.half_height
    ox, oz = max(radial, 0.0), max(axial, 0.0)
    return math.sqrt(ox * ox + oz * oz) + min(max(radial, axial), 0.0) - BALL_RADIUS


@kernel
def court_gap(solid, x, y, z):
    """Return the gap to table, net or floor."""
    if solid == TABLE:
        half = 0.5 * TABLE_THICKNESS
        top = box_gap(x, y, z + half, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH, half)
        return top - BALL_RADIUS
    if solid == NET:
        half = 0.5 * NET_HEIGHT
        return box_gap(x, y, z - half, NET_HALF_THICKNESS, NET_HALF_LENGTH, half) - BALL_RADIUS
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
def drone_is_far(state, track, i):
    """Tell whether the ball cannot touch anything of the drone in this step."""
    if track.shape[0] == 0:
        return True
    dx, dy, dz = state[0] - track[i, 0], state[1] - track[i, 1], state[2] - track[i, 2]
    return dx * dx + dy * dy + dz * dz > REACH * REACH


@kernel
def longest_way(start, end, duration):
    """Return more than ball and drone can have come closer in a step, m."""
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    return 1.5 * math.sqrt(dx * dx + dy * dy + dz * dz) + DRONE_SPEED * duration


@kernel
def court_is_far(state, travel):
    """Tell whether the ball cannot touch table, net or floor in this step."""
    reach = BALL_RADIUS + travel
    above_table = state[2] > reach
    beside_net = abs(state[0]) > NET_HALF_THICKNESS + reach or state[2] > NET_HEIGHT + reach
    return above_table and beside_net


@kernel
def first_negative(solid, start, dt, low, high, travel, track, i, base, scale, scene, work):
    """Return the first probed fraction of the step with a negative gap, -1 if there is none."""
    if high < 0.0:
        return 1.0
    if low + high > travel:
        return -1.0
    for k in range(1, PROBES):
        f = k / PROBES
        step(start, f * dt, scene.air, work.probe)
        if gap(solid, work.probe, track, i, base + scale * f, scene, work) < 0.0:
            return f
    return -1.0


@kernel
def contact_fraction(solid, start, dt, upper, track, i, base, scale, scene, work):
    """Return where in (0, upper] of the step the gap vanishes, by regula falsi with bisection."""
    a, b = 0.0, upper
    fa = max(gap(solid, start, track, i, base, scene, work), 0.0)
    step(start, b * dt, scene.air, work.probe)
    fb = gap(solid, work.probe, track, i, base + scale * b, scene, work)
    for k in range(ROOT_STEPS):
        c = b - fb * (b - a) / (fb - fa) if k % 3 < 2 and fa > fb else 0.5 * (a + b)
        step(start, c * dt, scene.air, work.probe)
        fc = gap(solid, work.probe, track, i, base + scale * c, scene, work)
        if abs(fc) < ROOT_TOLERANCE:
            return c
        if fc > 0.0:
            a, fa = c, fc
        else:
            b, fb = c, fc
    return a


@kernel
def surface_normal(solid, state, track, i, fraction, scene, work):
    """Write the outward normal of a solid at a touching ball, by central differences of the gap."""
    h = 1e-6
    for k in range(3):
        copy_state(state, work.other)
        work.other[k] = state[k] + h
        up = gap(solid, work.other, track, i, fraction, scene, work)
        work.other[k] = state[k] - h
        down = gap(solid, work.other, track, i, fraction, scene, work)
        work.normal[k] = up - down
    size = math.sqrt(work.normal[0] ** 2 + work.normal[1] ** 2 + work.normal[2] ** 2)
    for k in range(3):
        work.normal[k] /= size


@kernel
def surface_velocity(solid, state, track, i, tick, work):
    """Write the velocity of the drone's point that the ball touches; zero for the court."""
    for k in range(3):
        work.velocity[k] = 0.0
    if solid < BLADE or i + 1 >= track.shape[0]:
        return
    x = state[0] - BALL_RADIUS * work.normal[0]
    y = state[1] - BALL_RADIUS * work.normal[1]
    z = state[2] - BALL_RADIUS * work.normal[2]
    pose_between(track, i, 0.5, work.rotation, work.position)
    body_point(x, y, z, work.rotation, work.position, work.body)
    for side in range(2):
        pose_between(track, i, float(side), work.rotation, work.position)
        sign = 1.0 if side == 1 else -1.0
        for k in range(3):
            r = work.rotation[k]
            point = r[0] * work.body[0] + r[1] * work.body[1] + r[2] * work.body[2]
            work.velocity[k] += sign * (point + work.position[k]) / tick


@kernel
def surface_of(solid, scene):
    """Return restitution and friction of a solid."""
    if solid == TABLE:
        return scene.table
    if solid == NET:
        return scene.net
    if solid == FLOOR:
        return scene.floor
    if solid == BLADE:
        return scene.racket.surface
    return scene.hull.surface


@kernel
def nearest_contact(start, end, dt, track, i, base, scale, scene, work):
    """Return (solid, fraction) of the step's first contact; (-1, 1) if there is none."""
    travel = longest_way(start, end, dt)
    hit, first = -1, 1.0
    for solid in range(BLADE if drone_is_far(start, track, i) else SOLIDS):
        low = gap(solid, start, track, i, base, scene, work)
        if low > travel:
            continue
        high = gap(solid, end, track, i, base + scale, scene, work)
        upper = first_negative(
            solid, start, dt, low, high, travel, track, i, base, scale, scene, work
        )
        if upper < 0.0 or (low < 0.0 and high > low):
            continue
        f = contact_fraction(solid, start, dt, upper, track, i, base, scale, scene, work)
        if hit < 0 or f < first:
            hit, first = solid, f
    return hit, first


@kernel
def touch(solid, state, track, i, fraction, time, scene, work, row):
    """Bounce the ball off a solid and write the contact; return whether it is worth noting.

    A ball that rolls touches again and again at no speed: that is not noted.
    """
    surface_normal(solid, state, track, i, fraction, scene, work)
    surface_velocity(solid, state, track, i, scene.tick, work)
    approach_speed = 0.0
    row[0], row[1], row[11], row[12], row[13] = time, solid, 0.0, 0.0, 0.0
    for k in range(3):
        row[2 + k], row[5 + k], row[8 + k] = state[k], state[3 + k], work.normal[k]
        approach_speed -= (state[3 + k] - work.velocity[k]) * work.normal[k]
    if solid >= BLADE:
        pose_between(track, i, fraction, work.rotation, work.position)
        body_point(state[0], state[1], state[2], work.rotation, work.position, work.body)
        y, z = work.body[1] - scene.racket.y, work.body[2] - scene.racket.z
        y, z, _ = ellipse_gap(y, z, scene.racket.half_width, scene.racket.half_height)
        row[12], row[13] = y / scene.racket.half_width, z / scene.racket.half_height
        for k in range(3):
            row[11] += work.normal[k] * work.rotation[k, 0]
    bounce(state, work.normal, work.velocity, surface_of(solid, scene))
    for k in range(3):
        state[k] += 1e-9 * work.normal[k]
    return approach_speed >= SLOWEST_CONTACT


@kernel
def advance(state, start_time, ticks, track, scene, work, contacts, path):
    """Fly one ball for `ticks` ticks among court and drone.

    Args:
        state: (9,), changed in place.
        start_time: seconds at the first tick.
        ticks: how many.
        track: (ticks + 1, 7) poses of the drone, or (0, 7) where there is none.
        scene: parameters.
        work: scratch arrays.
        contacts: (m, 14) rows of time, solid, position, velocity, normal, face, blade y, z.
        path: (ticks, 9), the state after each tick.

    Returns:
        The number of contacts.
    """
    count = 0
    tick = scene.tick
    for i in range(ticks):
        done = 0.0
        for _ in range(MOST_CONTACTS_PER_STEP):
            rest = 1.0 - done
            copy_state(state, work.start)
            step(work.start, rest * tick, scene.air, state)
            travel = longest_way(work.start, state, rest * tick)
            if court_is_far(work.start, travel) and drone_is_far(work.start, track, i):
                break
            solid, f = nearest_contact(
                work.start, state, rest * tick, track, i, done, rest, scene, work
            )
            if solid < 0:
                break
            step(work.start, f * rest * tick, scene.air, state)
            done += f * rest
            time = start_time + (i + done) * tick
            row = contacts[count] if count < contacts.shape[0] else work.row
            if touch(solid, state, track, i, done, time, scene, work, row):
                count += 1
        copy_state(state, path[i])
    return count


@kernel
def approach(state, plane_x, longest, scene, work, contacts, crossing):
    """Fly a ball over the empty court until its centre passes the plane x = plane_x.

    Returns:
        (time of the crossing, negative if there is none; number of contacts on the way).
    """
    track, path = np.empty((0, 7)), np.empty((1, 9))
    count, time = 0, 0.0
    while time < longest:
        copy_state(state, work.before)
        new = advance(state, time, 1, track, scene, work, contacts[count:], path)
        if state[0] <= plane_x:
            if new > 0:
                return -1.0, count + new
            return time + crossing_time(work.before, state, plane_x, scene, crossing), count
        count += new
        if count >= contacts.shape[0]:
            return -1.0, count
        time += scene.tick
    return -1.0, count


@kernel
def crossing_time(before, after, plane_x, scene, crossing):
    """Write the state at x = plane_x within a step and return its time in the step."""
    t = scene.tick * (before[0] - plane_x) / (before[0] - after[0])
    for _ in range(20):
        step(before, t, scene.air, crossing)
        error = crossing[0] - plane_x
        if abs(error) < ROOT_TOLERANCE:
            break
        t -= error / crossing[3]
    return t


@kernel
def blade_gaps(positions, track, racket, rotation, position, body, out):
    """Write the gap between ball k and the blade at pose k."""
    for k in range(positions.shape[0]):
        pose_between(track, k, 0.0, rotation, position)
        body_point(positions[k, 0], positions[k, 1], positions[k, 2], rotation, position, body)
        out[k] = blade_gap(body, racket)


@kernel
def lateness(positions, track, racket, longest, scratch):
    """Return the smallest lag (ticks, either sign) at which blade and ball meet face to face.

    Longer than `longest` if there is none.
    """
    for size in range(longest + 1):
        for lag in (size, -size):
            if blade_meets(positions, track, racket, lag, scratch):
                return lag
    return longest + 1


@kernel
def blade_meets(positions, track, racket, lag, scratch):
    """Tell whether the blade, `lag` ticks after each ball position, would have been struck."""
    rotation, position, body = scratch
    centre = math.sqrt(racket.x**2 + racket.y**2 + racket.z**2)
    reach = centre + max(racket.half_width, racket.half_height) + BALL_RADIUS
    for k in range(max(0, -lag), min(positions.shape[0], track.shape[0] - lag)):
        px, py, pz, j = positions[k, 0], positions[k, 1], positions[k, 2], k + lag
        dx, dy, dz = px - track[j, 0], py - track[j, 1], pz - track[j, 2]
        if dx * dx + dy * dy + dz * dz > reach * reach:
            continue
        pose_between(track, j, 0.0, rotation, position)
        body_point(px, py, pz, rotation, position, body)
        if body[0] > racket.x and blade_gap(body, racket) <= 0.0:
            y, z = body[1] - racket.y, body[2] - racket.z
            off = ellipse_gap(y, z, racket.half_width, racket.half_height)[2]
            if body[0] - racket.x >= off:
                return True
    return False
