"""The ball among solids, compiled: bounces, flights along a drone's track, flights to a plane.

Ticks in which nothing can be touched are passed over (see `_nearness_kernels`); the times of
contacts are exact (see `_search_kernels`).
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import bounce
from rotorpong.world._nearness_kernels import (
    HORIZON,
    SLACK,
    ball_travel,
    box_distance,
    box_of,
    court_is_near,
    drone_is_near,
    drone_reach,
    drone_travel,
    fastest_travel,
    ticks_off_court,
    ticks_off_drone,
)
from rotorpong.world._search_kernels import ROOT_TOLERANCE, nearest_contact
from rotorpong.world._solid_kernels import (
    ACROSS,
    BLADE,
    END,
    OTHER,
    PLACE,
    POINT,
    PROBE,
    ROTATION,
    SOLIDS,
    SPEED,
    START,
    body_point,
    copy_row,
    ellipse_gap,
    gap,
    make_work,
    part_of,
    pose_between,
    scene_of,
    step_row,
    surface_of,
)

TIME, SOLID, PART, POSITION, VELOCITY, SPIN, NORMAL = 0, 1, 2, 3, 6, 9, 12
SURFACE_VELOCITY, VELOCITY_AFTER, SPIN_AFTER, FACING, BLADE_POINT = 15, 18, 21, 24, 25
CONTACT_COLUMNS = 27
SLOWEST_CONTACT = 1e-3  # m/s towards the solid
MOST_CONTACTS_PER_STEP = 16
PASSED, LOST = -1, -2  # the plane; nothing happened in time


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
    """Fly from START to END through a tick with solids near.

    Returns:
        (number of contacts noted so far, whether anything was touched).
    """
    done, tick, was_touched = 0.0, scene.tick, False
    for _ in range(MOST_CONTACTS_PER_STEP):
        rest = 1.0 - done
        step_row(work, START, rest * tick, scene.air, END)
        vx, vy, vz = work[START, 3], work[START, 4], work[START, 5]
        travel, drone = ball_travel(vx, vy, vz, rest * tick), 0.0
        is_near = court_is_near(work[START, 0], work[START, 2], travel)
        first, last = 0 if is_near else BLADE, BLADE
        if drone_is_near(work, travel, track, i, reach):
            last, drone = SOLIDS, drone_travel(track, i, reach)
        solid, f = nearest_contact(
            (first, last), rest * tick, (travel, drone), track, (i, done, rest), scene, work
        )
        if solid < 0:
            return count, was_touched
        step_row(work, START, f * rest * tick, scene.air, END)
        done, was_touched = done + f * rest, True
        row = contacts[min(count, contacts.shape[0] - 1)]
        if touch(solid, track, i, done, start_time + (i + done) * tick, scene, work, row):
            count += 1
        copy_row(work, END, START)
    return count, True


@kernel
def advance(state, start_time, flown, track, box, scene, work, contacts, path):
    """Fly one ball among court and drone.

    Args:
        state: (9,), at tick 0.
        start_time: seconds at tick 0.
        flown: of how many ticks `path` already holds what happens where there is nothing to touch.
        track: (ticks + 1, 7) poses of the drone, or (0, 7) where there is none.
        box: about the track, see `box_of`.
        scene: parameters.
        work: scratch.
        contacts: (m, 27) rows; the last is overwritten when there are more.
        path: (ticks, 9), the state after each tick.

    Returns:
        (number of contacts; `flown`, or 0 if anything was touched).
    """
    count, i, ticks, reach = 0, 0, path.shape[0], drone_reach(scene)
    drone_pace = -1.0  # not known yet
    for k in range(9):
        work[START, k] = state[k]
    while i < ticks:
        vx, vy, vz = work[START, 3], work[START, 4], work[START, 5]
        pace = ball_travel(vx, vy, vz, HORIZON * scene.tick) / HORIZON
        free = min(ticks_off_court(work, pace), ticks - i)
        away = box_distance(box, work[START, 0], work[START, 1], work[START, 2]) - reach - SLACK
        if away < free * pace:
            if drone_pace < 0.0:
                drone_pace = fastest_travel(track, i, reach)
            free = min(free, ticks_off_drone(work, track, i, pace + drone_pace, scene))
        if free == 0:
            count, is_touched = fly_tick(start_time, i, track, reach, scene, work, contacts, count)
            flown, free = 0 if is_touched else flown, 1
            put(work, path[i])
        elif i + free <= flown:
            for k in range(9):
                work[START, k] = path[i + free - 1, k]
        else:
            for j in range(i, i + free):
                step_row(work, START, scene.tick, scene.air, END)
                put(work, path[j])
        i += free
    return count, flown


@kernel
def put(work, after):
    """Write the state at END into the path; go on from it."""
    for k in range(9):
        after[k] = work[END, k]
        work[START, k] = work[END, k]


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
        track, path = tracks[ball], paths[ball]
        counts[ball], _ = advance(
            states[ball], start_time, 0, track, box_of(track), scene, work, contacts[ball], path
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
        vx, vy, vz = work[START, 3], work[START, 4], work[START, 5]
        travel, solid, f = ball_travel(vx, vy, vz, tick), -1, 1.0
        if court_is_near(work[START, 0], work[START, 2], travel):
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
