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
from rotorpong.physics._ball_kernels import bounce
from rotorpong.world._solid_kernels import (
    ACROSS,
    BLADE,
    END,
    HALF_POST,
    OTHER,
    PLACE,
    POINT,
    PROBE,
    ROTATION,
    SOLIDS,
    SPEED,
    START,
    TABLE,
    body_point,
    copy_row,
    ellipse_gap,
    gap,
    least_blade_gap,
    make_work,
    part_of,
    pose_between,
    scene_of,
    step_row,
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
LOOK_AHEAD = 8  # ticks
PASSED, LOST = -1, -2  # the plane; nothing happened in time


@kernel
def ball_travel(work, duration):
    """Return more than the ball at START can move in a step, m."""
    vx, vy, vz = work[START, 3], work[START, 4], work[START, 5]
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    return 1.001 * (speed + GRAVITY * duration) * duration


@kernel
def court_is_near(work, travel):
    """Tell whether the ball at START can touch table, net or floor."""
    reach = BALL_RADIUS + travel
    if work[START, 2] <= reach:
        return True
    return abs(work[START, 0]) <= HALF_POST + reach and work[START, 2] <= NET_HEIGHT + reach


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
    j, way, turn, dot = min(i + 1, track.shape[0] - 1), 0.0, 0.0, 0.0
    for k in range(3):
        way += (track[j, k] - track[i, k]) ** 2
    for k in range(3, 7):
        dot += track[i, k] * track[j, k]
    sign = math.copysign(1.0, dot)
    for k in range(3, 7):  # squared chord of unit quaternions, 2 sin(angle / 4)
        turn += (track[j, k] - sign * track[i, k]) ** 2
    return 1.001 * math.sqrt(way) + 2.5 * reach * math.sqrt(turn) + 1e-12


@kernel
def drone_is_near(work, travel, track, i, reach):
    """Tell whether the ball at START can touch the drone in tick i."""
    if track.shape[0] == 0:
        return False
    dx, dy = work[START, 0] - track[i, 0], work[START, 1] - track[i, 1]
    dz = work[START, 2] - track[i, 2]
    distance = dx * dx + dy * dy + dz * dz
    if distance > 9.0 * (reach + travel) ** 2 + 1.0:  # a drone at 1 km/s gets no further in a tick
        return False
    return distance <= (reach + travel + drone_travel(track, i, reach)) ** 2


@kernel
def clear_fraction(solid, low, travel, dt, track, span, scene, work):
    """Return the first fraction of a step seen with a negative gap, -1 if there is none.

    Goes forward as far as the gap allows, but no less than 1/64 of the step: a graze that is missed
    is shallower than 10 micrometres.
    """
    f, here = 0.0, low
    while True:
        f += max(here / travel, 1.0 / LOOKS)
        if f >= 1.0:
            return -1.0
        here = gap_within(solid, f, dt, track, span, scene, work)
        if here < 0.0:
            return f


@kernel
def gap_within(solid, f, dt, track, span, scene, work):
    """Return the gap at a fraction of the step from START; the ball there is PROBE."""
    step_row(work, START, f * dt, scene.air, PROBE)
    i, base, scale = span
    return gap(solid, PROBE, track, i, base + scale * f, scene, work)


@kernel
def contact_fraction(solid, low, upper, dt, track, span, scene, work):
    """Return where in (0, upper] of the step the gap vanishes: regula falsi as Illinois has it."""
    a, fa, b, side = 0.0, max(low, 0.0), upper, 0
    fb = gap_within(solid, b, dt, track, span, scene, work)
    for _ in range(ROOT_STEPS):
        c = b - fb * (b - a) / (fb - fa) if fa > fb else a
        fc = gap_within(solid, c, dt, track, span, scene, work)
        if abs(fc) < ROOT_TOLERANCE or b - a < 1e-15:
            return c
        if fc > 0.0:
            a, fa = c, fc
            fb = 0.5 * fb if side == 1 else fb
            side = 1
        else:
            b, fb = c, fc
            fa = 0.5 * fa if side == -1 else fa
            side = -1
    return a


@kernel
def stays_above(work, dt, air):
    """Tell whether the ball stays above the table's plane through the step from START to END.

    Under an upward acceleration a the path dips a dt^2 / 8 below its chord at most.
    """
    low, high = work[START, 2] - BALL_RADIUS, work[END, 2] - BALL_RADIUS
    if low < 0.0 or high < 0.0:
        return False
    speed = ball_travel(work, dt) / dt
    spin = math.sqrt(work[START, 6] ** 2 + work[START, 7] ** 2 + work[START, 8] ** 2)
    push = (air.drag * speed + abs(air.magnus) * spin) * speed - GRAVITY
    return push <= 0.0 or min(low, high) >= push * dt * dt / 8.0


@kernel
def is_clear(solid, travel, dt, track, span, scene, work):
    """Tell at small cost whether a solid cannot be touched in the step; False where unsure."""
    if solid == TABLE:
        return stays_above(work, dt, scene.air)
    if solid == BLADE:
        i, base, _ = span
        pose_between(track, i, base, work)
        x, y, z = body_point(work[START, 0], work[START, 1], work[START, 2], work)
        return least_blade_gap(x, y, z, scene.racket) > travel
    return False


@kernel
def nearest_contact(solids, dt, way, track, span, scene, work):
    """Return (solid, fraction) of the first contact of the step from START to END.

    Args:
        solids: the first to look at, one beyond the last.
        dt: of the step, s.
        way: more than the ball, and than the drone, moves in it, m.
        track: poses.
        span: tick, where in it the step begins, and its share of it.
        scene: parameters.
        work: scratch.

    Returns:
        (-1, 1) if there is none.
    """
    hit, first = -1, 1.0
    i, base, scale = span
    for solid in range(solids[0], solids[1]):
        travel = way[0] if solid < BLADE else way[0] + way[1]
        if is_clear(solid, travel, dt, track, span, scene, work):
            continue
        low = gap(solid, START, track, i, base, scene, work)
        if low > travel:
            continue
        high = gap(solid, END, track, i, base + scale, scene, work)
        if (high >= 0.0 and low + high > travel) or (low < 0.0 and high > low):
            continue
        upper = 1.0
        if high >= 0.0:
            upper = clear_fraction(solid, low, travel, dt, track, span, scene, work)
            if upper < 0.0:
                continue
        f = contact_fraction(solid, low, upper, dt, track, span, scene, work)
        if hit < 0 or f < first:
            hit, first = solid, f
    return hit, first


@kernel
def surface_normal(solid, track, i, fraction, scene, work):
    """Write the outward normal of a solid at the ball at END, by central differences of the gap."""
    h = 1e-6
    copy_row(work, END, OTHER)
    for k in range(3):
        work[OTHER, k] = work[END, k] + h
        up = gap(solid, OTHER, track, i, fraction, scene, work)
        work[OTHER, k] = work[END, k] - h
        down = gap(solid, OTHER, track, i, fraction, scene, work)
        work[OTHER, k] = work[END, k]
        work[ACROSS, k] = up - down
    size = math.sqrt(work[ACROSS, 0] ** 2 + work[ACROSS, 1] ** 2 + work[ACROSS, 2] ** 2)
    for k in range(3):
        work[ACROSS, k] /= size
        work[POINT, k] = work[END, k] - BALL_RADIUS * work[ACROSS, k]


@kernel
def surface_velocity(solid, track, i, tick, work):
    """Write the velocity of the drone's point that the ball touches; zero for the court."""
    for k in range(3):
        work[SPEED, k] = 0.0
    if solid < BLADE or i + 1 >= track.shape[0]:
        return
    pose_between(track, i, 0.5, work)
    x, y, z = body_point(work[POINT, 0], work[POINT, 1], work[POINT, 2], work)
    for side in range(2):
        pose_between(track, i, float(side), work)
        sign = 1.0 if side == 1 else -1.0
        for k in range(3):
            r = ROTATION + k
            point = work[r, 0] * x + work[r, 1] * y + work[r, 2] * z
            work[SPEED, k] += sign * (point + work[PLACE, k]) / tick


@kernel
def touched_part(solid, track, i, fraction, scene, work, row):
    """Write facing and blade point of a contact; return which part of the solid it touches."""
    forward, up = 0.0, 0.0
    row[BLADE_POINT], row[BLADE_POINT + 1] = 0.0, 0.0
    if solid >= BLADE:
        racket = scene.racket
        pose_between(track, i, fraction, work)
        _, y, z = body_point(work[END, 0], work[END, 1], work[END, 2], work)
        y, z, _ = ellipse_gap(y - racket.y, z - racket.z, racket.half_width, racket.half_height)
        row[BLADE_POINT], row[BLADE_POINT + 1] = y / racket.half_width, z / racket.half_height
        for k in range(3):
            forward += work[ACROSS, k] * work[ROTATION + k, 0]
            up += work[ACROSS, k] * work[ROTATION + k, 2]
    row[FACING] = forward
    return part_of(solid, forward, up, work)


@kernel
def touch(solid, track, i, fraction, time, scene, work, row):
    """Bounce the ball at END off a solid, write the contact; return whether it is worth noting.

    A ball that rolls touches again and again at no speed: that is not noted.
    """
    surface_normal(solid, track, i, fraction, scene, work)
    surface_velocity(solid, track, i, scene.tick, work)
    part = touched_part(solid, track, i, fraction, scene, work, row)
    row[TIME], row[SOLID], row[PART] = time, solid, part
    approach_speed = 0.0
    for k in range(3):
        row[POSITION + k], row[VELOCITY + k] = work[END, k], work[END, 3 + k]
        row[SPIN + k], row[NORMAL + k] = work[END, 6 + k], work[ACROSS, k]
        row[SURFACE_VELOCITY + k] = work[SPEED, k]
        approach_speed -= (work[END, 3 + k] - work[SPEED, k]) * work[ACROSS, k]
    bounce(work[END], work[ACROSS], work[SPEED], surface_of(solid, part, scene))
    for k in range(3):
        row[VELOCITY_AFTER + k], row[SPIN_AFTER + k] = work[END, 3 + k], work[END, 6 + k]
        work[END, k] += 1e-9 * work[ACROSS, k]
    return approach_speed >= SLOWEST_CONTACT


@kernel
def fly_tick(start_time, i, track, reach, scene, work, contacts, count):
    """Fly from START to END through a tick with solids near; return the number of contacts."""
    done, tick = 0.0, scene.tick
    for _ in range(MOST_CONTACTS_PER_STEP):
        rest = 1.0 - done
        step_row(work, START, rest * tick, scene.air, END)
        travel, drone = ball_travel(work, rest * tick), 0.0
        first, last = 0 if court_is_near(work, travel) else BLADE, BLADE
        if drone_is_near(work, travel, track, i, reach):
            last, drone = SOLIDS, drone_travel(track, i, reach)
        solid, f = nearest_contact(
            (first, last), rest * tick, (travel, drone), track, (i, done, rest), scene, work
        )
        if solid < 0:
            return count
        step_row(work, START, f * rest * tick, scene.air, END)
        done += f * rest
        row = contacts[min(count, contacts.shape[0] - 1)]
        if touch(solid, track, i, done, start_time + (i + done) * tick, scene, work, row):
            count += 1
        copy_row(work, END, START)
    return count


@kernel
def advance(state, start_time, first, track, scene, work, contacts, path):
    """Fly one ball among court and drone.

    Args:
        state: (9,), at tick `first`.
        start_time: seconds at tick 0.
        first: the tick at which to begin.
        track: (ticks + 1, 7) poses of the drone, or (0, 7) where there is none.
        scene: parameters.
        work: scratch.
        contacts: (m, 27) rows; the last is overwritten when there are more.
        path: (ticks, 9), the state after each tick; of those before `first` nothing is written.

    Returns:
        The number of contacts.
    """
    count, reach = 0, drone_reach(scene)
    for k in range(9):
        work[START, k] = state[k]
    for i in range(first, path.shape[0]):
        travel = ball_travel(work, scene.tick)
        if court_is_near(work, travel) or drone_is_near(work, travel, track, i, reach):
            count = fly_tick(start_time, i, track, reach, scene, work, contacts, count)
        else:
            step_row(work, START, scene.tick, scene.air, END)
        for k in range(9):
            path[i, k] = work[END, k]
            work[START, k] = work[END, k]
    return count


@kernel
def first_near(states, track, scene, work):
    """Return a tick of a free flight before which nothing can be touched; ticks if nothing can.

    Args:
        states: (ticks + 1, 9) of the ball, flown as if there were nothing.
        track: (ticks + 1, 7) poses of the drone.
        scene: parameters.
        work: scratch.
    """
    reach, i, ticks = drone_reach(scene), 0, states.shape[0] - 1
    while i < ticks:
        last = min(i + LOOK_AHEAD, ticks)
        for k in range(6):
            work[START, k] = states[i, k]
        travel, way = ball_travel(work, (last - i) * scene.tick), 0.0
        if court_is_near(work, travel):
            return i
        x, y, z = track[i, 0], track[i, 1], track[i, 2]
        for j in range(i + 1, last + 1):
            dx, dy, dz = track[j, 0] - x, track[j, 1] - y, track[j, 2] - z
            way = max(way, dx * dx + dy * dy + dz * dz)
        dx, dy, dz = states[i, 0] - x, states[i, 1] - y, states[i, 2] - z
        near = reach + travel + math.sqrt(way) + 1e-9
        if dx * dx + dy * dy + dz * dz <= near * near:
            return i
        i = last
    return ticks


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
            states[ball], start_time, 0, tracks[ball], scene, work, contacts[ball], paths[ball]
        )


@kernel
def next_event(time, plane_x, longest, scene, track, work, row, crossing):
    """Fly the ball at START over the empty court to its next contact, or through x = plane_x.

    Args:
        time: s.
        plane_x: m.
        longest: s, when the flight is given up.
        scene: parameters; its tick is the longest step.
        track: (0, 7), nobody's.
        work: scratch; START is the ball, afterwards as it leaves the contact.
        row: (27,) of the contact.
        crossing: (9,), the state at the plane.

    Returns:
        (solid, PASSED or LOST; time).
    """
    tick = scene.tick
    for _ in range(2 * MOST_CONTACTS_PER_STEP + int(longest / tick)):
        if time >= longest:
            break
        step_row(work, START, tick, scene.air, END)
        travel, solid, f = ball_travel(work, tick), -1, 1.0
        if court_is_near(work, travel):
            solid, f = nearest_contact(
                (0, BLADE), tick, (travel, 0.0), track, (0, 0.0, 1.0), scene, work
            )
            if solid >= 0:
                step_row(work, START, f * tick, scene.air, END)
        if work[START, 0] > plane_x >= work[END, 0]:
            return PASSED, time + crossing_time(f * tick, plane_x, scene, work, crossing)
        time += f * tick
        noted = solid >= 0 and touch(solid, track, 0, 0.0, time, scene, work, row)
        copy_row(work, END, START)
        if noted:
            return solid, time
    return LOST, time


@kernel
def approach(state, plane_x, longest, parameters, contacts, crossing):
    """Fly a ball over the empty court until its centre passes the plane x = plane_x.

    Returns:
        (time of the crossing, negative if there is none; number of contacts on the way).
    """
    scene, work, track, time = scene_of(parameters), make_work(), np.empty((0, 7)), 0.0
    for k in range(9):
        work[START, k] = state[k]
    for count in range(contacts.shape[0]):
        event, time = next_event(
            time, plane_x, longest, scene, track, work, contacts[count], crossing
        )
        if event < 0:
            return (time if event == PASSED else -1.0), count
    return -1.0, contacts.shape[0]


@kernel
def crossing_time(dt, plane_x, scene, work, crossing):
    """Write the state at x = plane_x in the step of dt from START to END; return when, s."""
    start, end = work[START, 0], work[END, 0]
    t = dt * (start - plane_x) / (start - end)
    for _ in range(20):
        step_row(work, START, t, scene.air, PROBE)
        error = work[PROBE, 0] - plane_x
        if abs(error) < ROOT_TOLERANCE:
            break
        t -= error / work[PROBE, 3]
    for k in range(9):
        crossing[k] = work[PROBE, k]
    return t
