"""The ball among solids, compiled: exact contact times, bounces, flights.

A gap changes no faster than ball and solid move, and drag and Magnus force make no ball faster. So
a step in which a gap can have been negative is known beforehand, is searched by going forward no
further than the gap allows, and nothing else of it is computed: what is skipped changes no result.
Contact times solve gap = 0 on the step's own RK4 path, so restitution does not depend on where in
a step the contact falls.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import bounce, step
from rotorpong.world._solid_kernels import (
    BLADE,
    HALF_POST,
    SOLIDS,
    body_point,
    copy_state,
    ellipse_gap,
    gap,
    least_blade_gap,
    make_work,
    part_of,
    pose_between,
    scene_of,
    surface_of,
)
from rotorpong.world.court import NET_HEIGHT

TIME, SOLID, PART, POSITION, VELOCITY, SPIN, NORMAL = 0, 1, 2, 3, 6, 9, 12
SURFACE_VELOCITY, VELOCITY_AFTER, SPIN_AFTER, FACING, BLADE_POINT = 15, 18, 21, 24, 25
CONTACT_COLUMNS = 27
SLOWEST_CONTACT = 1e-3  # m/s towards the solid
LOOKS = 64  # a step is looked at as often, where it may graze
ROOT_STEPS = 60
ROOT_TOLERANCE = 1e-12  # m
MOST_CONTACTS_PER_STEP = 16
PASSED, LOST = -1, -2  # the plane; nothing happened in time


@kernel
def next_probe(a, fa, b, fb, k):
    """Return where to look for a root in [a, b], fa > 0 > fb: regula falsi with bisection."""
    return b - fb * (b - a) / (fb - fa) if k % 3 < 2 and fa > fb else 0.5 * (a + b)


@kernel
def ball_travel(start, duration):
    """Return more than the ball can move in a step, m."""
    vx, vy, vz = start[3], start[4], start[5]
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    return 1.001 * (speed + GRAVITY * duration) * duration


@kernel
def court_is_near(start, travel):
    """Tell whether the ball can touch table, net or floor."""
    reach = BALL_RADIUS + travel
    if start[2] <= reach:
        return True
    return abs(start[0]) <= HALF_POST + reach and start[2] <= NET_HEIGHT + reach


@kernel
def drone_reach(scene):
    """Return how far from the centre of mass a touching ball's centre can be, m."""
    racket, hull = scene.racket, scene.hull
    centre = math.sqrt(racket.x**2 + racket.y**2 + racket.z**2)
    blade = centre + max(racket.half_width, racket.half_height)
    return max(blade, math.sqrt(hull.radius**2 + hull.half_height**2)) + BALL_RADIUS


@kernel
def drone_travel(track, i, reach):
    """Return more than any point of the drone moves in tick i, m."""
    a, b = track[i], track[min(i + 1, track.shape[0] - 1)]
    way = math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    dot = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6]
    sign = 1.0 if dot >= 0.0 else -1.0
    turn = 0.0  # squared chord of unit quaternions: 2 sin(angle / 4)
    for k in range(3, 7):
        turn += (b[k] - sign * a[k]) ** 2
    return 1.001 * way + 2.5 * reach * math.sqrt(turn) + 1e-12


@kernel
def drone_is_near(start, travel, track, i, reach):
    """Tell whether the ball can touch the drone in tick i."""
    if track.shape[0] == 0:
        return False
    dx, dy, dz = start[0] - track[i, 0], start[1] - track[i, 1], start[2] - track[i, 2]
    distance = dx * dx + dy * dy + dz * dz
    if distance > 9.0 * (reach + travel) ** 2 + 1.0:  # a drone at 1 km/s gets no further in a tick
        return False
    return distance <= (reach + travel + drone_travel(track, i, reach)) ** 2


@kernel
def clear_fraction(solid, start, dt, low, travel, track, i, base, scale, scene, work):
    """Return the first fraction of a step seen with a negative gap, -1 if there is none.

    Goes forward as far as the gap allows, but no less than 1/64 of the step: a graze that is missed
    is shallower than 10 micrometres.
    """
    f, here = 0.0, low
    while True:
        f += max(here / travel, 1.0 / LOOKS)
        if f >= 1.0:
            return -1.0
        step(start, f * dt, scene.air, work.probe)
        here = gap(solid, work.probe, track, i, base + scale * f, scene, work)
        if here < 0.0:
            return f


@kernel
def contact_fraction(solid, start, dt, upper, track, i, base, scale, scene, work):
    """Return where in (0, upper] of the step the gap vanishes."""
    a, b = 0.0, upper
    fa = max(gap(solid, start, track, i, base, scene, work), 0.0)
    step(start, b * dt, scene.air, work.probe)
    fb = gap(solid, work.probe, track, i, base + scale * b, scene, work)
    for k in range(ROOT_STEPS):
        c = next_probe(a, fa, b, fb, k)
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
def least_gap(solid, start, track, i, base, scene, work):
    """Return a gap at the start of a step that the true one is not below."""
    if solid != BLADE:
        return gap(solid, start, track, i, base, scene, work)
    pose_between(track, i, base, work.rotation, work.position)
    body_point(start[0], start[1], start[2], work.rotation, work.position, work.body)
    return least_blade_gap(work.body, scene.racket)


@kernel
def nearest_contact(first_solid, solids, dt, way, track, i, base, scale, scene, work):
    """Return (solid, fraction) of the first contact of the step from work.start to work.end.

    Args:
        first_solid: of those to look at.
        solids: one beyond the last.
        dt: of the step, s.
        way: more than the ball, and than the drone, moves in it, m.
        track: poses.
        i: tick.
        base: where in the tick the step begins.
        scale: its share of the tick.
        scene: parameters.
        work: scratch arrays.

    Returns:
        (-1, 1) if there is none.
    """
    hit, first = -1, 1.0
    for solid in range(first_solid, solids):
        travel = way[0] if solid < BLADE else way[0] + way[1]
        if least_gap(solid, work.start, track, i, base, scene, work) > travel:
            continue
        low = gap(solid, work.start, track, i, base, scene, work)
        high = gap(solid, work.end, track, i, base + scale, scene, work)
        if (high >= 0.0 and low + high > travel) or (low < 0.0 and high > low):
            continue
        upper = 1.0
        if high >= 0.0:
            upper = clear_fraction(
                solid, work.start, dt, max(low, 0.0), travel, track, i, base, scale, scene, work
            )
            if upper < 0.0:
                continue
        f = contact_fraction(solid, work.start, dt, upper, track, i, base, scale, scene, work)
        if hit < 0 or f < first:
            hit, first = solid, f
    return hit, first


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
def touched_part(solid, state, track, i, fraction, scene, work, row):
    """Write facing and blade point of a contact; return which part of the solid it touches."""
    forward, up = 0.0, 0.0
    if solid >= BLADE:
        pose_between(track, i, fraction, work.rotation, work.position)
        body_point(state[0], state[1], state[2], work.rotation, work.position, work.body)
        racket = scene.racket
        y, z = work.body[1] - racket.y, work.body[2] - racket.z
        y, z, _ = ellipse_gap(y, z, racket.half_width, racket.half_height)
        row[BLADE_POINT], row[BLADE_POINT + 1] = y / racket.half_width, z / racket.half_height
        for k in range(3):
            forward += work.normal[k] * work.rotation[k, 0]
            up += work.normal[k] * work.rotation[k, 2]
    row[FACING] = forward
    for k in range(3):
        work.position[k] = state[k] - BALL_RADIUS * work.normal[k]
    return part_of(solid, work.position, work.normal, forward, up)


@kernel
def touch(solid, state, track, i, fraction, time, scene, work, row):
    """Bounce the ball off a solid and write the contact; return whether it is worth noting.

    A ball that rolls touches again and again at no speed: that is not noted.
    """
    surface_normal(solid, state, track, i, fraction, scene, work)
    surface_velocity(solid, state, track, i, scene.tick, work)
    row[BLADE_POINT], row[BLADE_POINT + 1] = 0.0, 0.0
    part = touched_part(solid, state, track, i, fraction, scene, work, row)
    row[TIME], row[SOLID], row[PART] = time, solid, part
    approach_speed = 0.0
    for k in range(3):
        row[POSITION + k], row[VELOCITY + k], row[SPIN + k] = state[k], state[3 + k], state[6 + k]
        row[NORMAL + k], row[SURFACE_VELOCITY + k] = work.normal[k], work.velocity[k]
        approach_speed -= (state[3 + k] - work.velocity[k]) * work.normal[k]
    bounce(state, work.normal, work.velocity, surface_of(solid, part, scene))
    for k in range(3):
        row[VELOCITY_AFTER + k], row[SPIN_AFTER + k] = state[3 + k], state[6 + k]
        state[k] += 1e-9 * work.normal[k]
    return approach_speed >= SLOWEST_CONTACT


@kernel
def fly_tick(start_time, i, track, reach, scene, work, contacts, count):
    """Fly from work.start to work.end through a tick with solids near; return the contact count."""
    done, tick = 0.0, scene.tick
    for _ in range(MOST_CONTACTS_PER_STEP):
        rest = 1.0 - done
        step(work.start, rest * tick, scene.air, work.end)
        travel = ball_travel(work.start, rest * tick)
        first = 0 if court_is_near(work.start, travel) else BLADE
        solids, drone = BLADE, 0.0
        if drone_is_near(work.start, travel, track, i, reach):
            solids, drone = SOLIDS, drone_travel(track, i, reach)
        solid, f = nearest_contact(
            first, solids, rest * tick, (travel, drone), track, i, done, rest, scene, work
        )
        if solid < 0:
            return count
        step(work.start, f * rest * tick, scene.air, work.end)
        done += f * rest
        row = contacts[min(count, contacts.shape[0] - 1)]
        time = start_time + (i + done) * tick
        if touch(solid, work.end, track, i, done, time, scene, work, row):
            count += 1
        copy_state(work.end, work.start)
    return count


@kernel
def advance(state, start_time, track, scene, work, contacts, path):
    """Fly one ball among court and drone.

    Args:
        state: (9,), at the first tick.
        start_time: seconds at the first tick.
        track: (ticks + 1, 7) poses of the drone, or (0, 7) where there is none.
        scene: parameters.
        work: scratch arrays.
        contacts: (m, 27) rows; the last is overwritten when there are more.
        path: (ticks, 9), the state after each tick.

    Returns:
        The number of contacts.
    """
    count, reach = 0, drone_reach(scene)
    start, end = work.start, work.end
    copy_state(state, start)
    for i in range(path.shape[0]):
        travel = ball_travel(start, scene.tick)
        if court_is_near(start, travel) or drone_is_near(start, travel, track, i, reach):
            count = fly_tick(start_time, i, track, reach, scene, work, contacts, count)
        else:
            step(start, scene.tick, scene.air, end)
        for k in range(9):
            path[i, k] = end[k]
            start[k] = end[k]
    return count


@kernel
def advance_many(states, start_time, tracks, parameters, contacts, counts, paths):
    """Fly many balls, each along a track of its own (see `advance`).

    Args:
        states: (n, 9).
        start_time: seconds at the first tick.
        tracks: (n, ticks + 1, 7), or (n, 0, 7).
        parameters: (n or 1, k) numbers of the solids.
        contacts: (n, m, 27).
        counts: (n,), the numbers of contacts.
        paths: (n, ticks, 9).
    """
    work = make_work()
    scene = scene_of(parameters[0])
    for ball in range(states.shape[0]):
        if parameters.shape[0] > 1:
            scene = scene_of(parameters[ball])
        counts[ball] = advance(
            states[ball], start_time, tracks[ball], scene, work, contacts[ball], paths[ball]
        )


@kernel
def next_event(state, time, plane_x, longest, scene, work, row, crossing):
    """Fly a ball over the empty court to its next contact, or through the plane x = plane_x.

    Args:
        state: (9,), changed in place: just after the contact.
        time: s.
        plane_x: m.
        longest: s, when the flight is given up.
        scene: parameters; its tick is the longest step.
        work: scratch arrays.
        row: (27,) of the contact.
        crossing: (9,), the state at the plane.

    Returns:
        (solid, PASSED or LOST; time).
    """
    track = np.empty((0, 7))
    copy_state(state, work.start)
    for _ in range(2 * MOST_CONTACTS_PER_STEP + int(longest / scene.tick)):
        if time >= longest:
            break
        step(work.start, scene.tick, scene.air, work.end)
        travel, solid, f = ball_travel(work.start, scene.tick), -1, 1.0
        if court_is_near(work.start, travel):
            solid, f = nearest_contact(
                0, BLADE, scene.tick, (travel, 0.0), track, 0, 0.0, 1.0, scene, work
            )
            if solid >= 0:
                step(work.start, f * scene.tick, scene.air, work.end)
        if work.start[0] > plane_x >= work.end[0]:
            dt = f * scene.tick
            return PASSED, time + crossing_time(work.start, work.end, dt, plane_x, scene, crossing)
        time += f * scene.tick
        if solid >= 0 and touch(solid, work.end, track, 0, 0.0, time, scene, work, row):
            copy_state(work.end, state)
            return solid, time
        copy_state(work.end, work.start)
    return LOST, time


@kernel
def approach(state, plane_x, longest, parameters, contacts, crossing):
    """Fly a ball over the empty court until its centre passes the plane x = plane_x.

    Returns:
        (time of the crossing, negative if there is none; number of contacts on the way).
    """
    scene, work, time = scene_of(parameters), make_work(), 0.0
    for count in range(contacts.shape[0]):
        event, time = next_event(
            state, time, plane_x, longest, scene, work, contacts[count], crossing
        )
        if event < 0:
            return (time if event == PASSED else -1.0), count
    return -1.0, contacts.shape[0]


@kernel
def crossing_time(before, after, dt, plane_x, scene, crossing):
    """Write the state at x = plane_x within a step of dt and return its time in the step."""
    t = dt * (before[0] - plane_x) / (before[0] - after[0])
    for _ in range(20):
        step(before, t, scene.air, crossing)
        error = crossing[0] - plane_x
        if abs(error) < ROOT_TOLERANCE:
            break
        t -= error / crossing[3]
    return t
