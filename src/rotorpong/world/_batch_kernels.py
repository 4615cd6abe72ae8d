"""One leg of many serves, and what is seen of the ball afterwards, compiled; see `batch`.

Rows of `clocks`: ticks flown, tick at which the last frame was exposed. Columns of `watches`: the
box about the drone's path so far 0:6, and for each `NEARNESS` the first tick at which the ball may
have been as near to the drone.
"""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.physics._ball_kernels import AIR_NUMBERS, LANES, fly_lanes
from rotorpong.physics._vehicle_kernels import width_of
from rotorpong.world._contact_kernels import advance
from rotorpong.world._judging_kernels import (
    CLOSE,
    LONGEST_SERVE,
    NEARNESS,
    PLAYING,
    box_in_court,
    ending,
    has_passed,
    judged,
)
from rotorpong.world._nearness_kernels import (
    SLACK,
    ball_travel,
    box_distance,
    box_of,
    court_is_near,
    drone_reach,
)
from rotorpong.world._solid_kernels import make_work, scene_of

FLOWN, EXPOSED = 0, 1


@kernel
def depart(codes, schedules, frames, clocks, ticks, rows):
    """Take the next frame of every serve that is not over; return how many serves these are.

    Args:
        codes: (n,).
        schedules: exposures and arrivals (2, n, :), in ticks.
        frames: (n,) the number of the next frame.
        clocks: (2, n).
        ticks: (n,), how far to fly until it arrives.
        rows: (n,), which fly, the longest leg first.
    """
    count, most = 0, 0
    for row in range(codes.shape[0]):
        if codes[row] != PLAYING:
            continue
        flown, frame = clocks[FLOWN, row], frames[row]
        clocks[EXPOSED, row], frames[row] = schedules[0, row, frame], frame + 1
        ticks[row] = min(max(schedules[1, row, frame], flown + 1), LONGEST_SERVE) - flown
        rows[count] = row
        count, most = count + 1, max(most, ticks[row])
    if count > 1:
        places = np.zeros(most + 1, np.int64)  # how many fly further, for each number of ticks
        for m in range(count):
            places[ticks[rows[m]]] += 1
        further = 0
        for leg in range(most, -1, -1):
            places[leg], further = further, further + places[leg]
        unsorted = rows[:count].copy()
        for m in range(count):
            leg = ticks[unsorted[m]]
            rows[places[leg]] = unsorted[m]
            places[leg] += 1
    return count


@kernel
def fly_leg(
    rows, ticks, parameters, balls, poses, watches, clocks, codes, deciding, contacts, counts
):
    """Fly the balls of `rows` along what their drones flew, and note which serves end there.

    All fly side by side as if there were nothing to touch; from the first touch on a ball flies
    again, alone.

    Args:
        rows: which of the batch, the longest leg first.
        ticks: (n,), how far each of the batch flies.
        parameters: (n, k) numbers of the solids of each serve.
        balls: (n, :, 9), states at all ticks.
        poses: (n, :, 7) of the drones, those of the leg written already.
        watches: (n, 8).
        clocks: (2, n).
        codes: (n,).
        deciding: (n, 27), contacts.
        contacts: (m, :, 27) of this leg, row by row.
        counts: (m,) of them.

    Returns:
        -1, or the first row whose drone flew to where no number is; that and what follow wait.
    """
    work = make_work()
    fly_free(rows, ticks, parameters, balls, clocks)
    for m in range(rows.shape[0]):
        row = rows[m]
        start, leg = clocks[FLOWN, row], ticks[row]
        end = start + leg
        track, scene = poses[row, start : end + 1], scene_of(parameters[row])
        if not is_finite(track):
            return row
        box, reach = box_of(track), drone_reach(scene) + SLACK
        x, y, z = balls[row, start, 0], balls[row, start, 1], balls[row, start, 2]
        vx, vy, vz = balls[row, start, 3], balls[row, start, 4], balls[row, start, 5]
        travel = ball_travel(vx, vy, vz, leg * scene.tick)
        away, count = box_distance(box, x, y, z) - travel, 0
        if away <= reach or court_is_near(x, z, travel):
            time, path = start * scene.tick, balls[row, start + 1 : end + 1]
            count, flown = advance(
                balls[row, start], time, leg, track, box, scene, work, contacts[m], path
            )
            away = away if flown > 0 else 0.0  # a drone may have made it faster
        clocks[FLOWN, row], counts[m] = end, min(count, contacts.shape[1])
        watch(watches, row, start, box, away)
        hull = scene.hull.radius, scene.hull.half_height
        passed = has_passed(balls[row, end, 0], balls[row, end, 3], poses[row, end, 0])
        if count > 0 or passed or box_in_court(box, hull) or end >= LONGEST_SERVE:
            touched = contacts[m, : counts[m]]
            codes[row], index = ending(touched, passed, track, box, end, hull)
            for k in range(deciding.shape[1] if index >= 0 else 0):
                deciding[row, k] = touched[index, k]
    return -1


@inlined_kernel
def is_finite(track):
    """Tell whether all numbers of a track are finite."""
    trace = 0.0
    for i in range(track.shape[0]):
        place = track[i, 0] + track[i, 1] + track[i, 2]
        attitude = (track[i, 3] + track[i, 4]) + (track[i, 5] + track[i, 6])
        trace += 0.0 * (place + attitude)  # nan, from a nan or an infinity
    return trace == 0.0


@kernel
def watch(watches, row, start, box, away):
    """Note how far the drone's path reached in a leg, and whether the ball may have been near it.

    Args:
        watches: (n, 8).
        row: of the batch.
        start: tick at which the leg began.
        box: about the drone in the leg.
        away: no more than the ball's distance from the drone's centre of mass in the leg, m.
    """
    if start == 0:
        for k in range(3):
            watches[row, k], watches[row, 3 + k] = box[k], box[3 + k]
        watches[row, CLOSE], watches[row, CLOSE + 1] = np.inf, np.inf
    for k in range(3):
        watches[row, k] = min(watches[row, k], box[k])
        watches[row, 3 + k] = max(watches[row, 3 + k], box[3 + k])
    for k in range(2):
        if away < NEARNESS[k]:
            watches[row, CLOSE + k] = min(watches[row, CLOSE + k], start)


@kernel
def fly_free(rows, ticks, parameters, balls, clocks):
    """Fly the balls of `rows` on as if there were nothing to touch, the longest leg first."""
    given, to, airs = np.zeros(9 * LANES), np.zeros(9 * LANES), np.zeros(AIR_NUMBERS * LANES)
    tick = scene_of(parameters[rows[0]]).tick
    for first in range(0, rows.shape[0], LANES):
        lanes = min(LANES, rows.shape[0] - first)
        for j in range(lanes):
            row = rows[first + j]
            for k in range(AIR_NUMBERS):
                airs[k * LANES + j] = parameters[row, k]
            for k in range(9):
                given[k * LANES + j] = balls[row, clocks[FLOWN, row], k]
        for i in range(1, ticks[rows[first]] + 1):
            while ticks[rows[first + lanes - 1]] < i:
                lanes -= 1
            fly_lanes(given, tick, airs, to, width_of(lanes))
            given, to = to, given
            for j in range(lanes):
                row = rows[first + j]
                at = clocks[FLOWN, row] + i
                for k in range(9):
                    balls[row, at, k] = given[k * LANES + j]


@kernel
def judge_rows(rows, balls, poses, watches, clocks, codes, sizes, results):
    """Judge serves: renew `codes`; write miss distances (m) and lags (ticks) into `results`."""
    for m in range(rows.shape[0]):
        row = rows[m]
        end = clocks[FLOWN, row] + 1
        code, miss, lag = judged(
            codes[row], balls[row, :end], poses[row, :end], watches[row], sizes
        )
        codes[row], results[0, row], results[1, row] = code, miss, lag


@kernel
def see(motions, balls, poses, clocks, tick, out):
    """Fill `out` (n, 18) with the states that `batch.STATE` names."""
    for row in range(out.shape[0]):
        end = clocks[FLOWN, row]
        now = min(clocks[EXPOSED, row], end)
        ball, pose, before = balls[row, now], poses[row, now], poses[row, max(now - 1, 0)]
        cosine, sine = heading(pose[3], pose[4], pose[5], pose[6])
        for k in range(2):
            dx, dy, dz = ball[3 * k], ball[3 * k + 1], ball[3 * k + 2]
            if k == 0:
                dx, dy, dz = dx - pose[0], dy - pose[1], dz - pose[2]
            else:
                dx -= (pose[0] - before[0]) / tick
                dy -= (pose[1] - before[1]) / tick
                dz -= (pose[2] - before[2]) / tick
            out[row, 3 * k] = cosine * dx + sine * dy
            out[row, 3 * k + 1] = cosine * dy - sine * dx
            out[row, 3 * k + 2] = dz
        motion = motions[row]
        w, x, y, z = motion[6], motion[7], motion[8], motion[9]
        cosine, sine = heading(w, x, y, z)
        out[row, 6] = cosine * motion[3] + sine * motion[4]
        out[row, 7] = cosine * motion[4] - sine * motion[3]
        out[row, 8] = motion[5]
        out[row, 9] = motion[2]
        out[row, 10] = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        out[row, 11] = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
        out[row, 12] = math.atan2(sine, cosine)
        for k in range(3):
            out[row, 13 + k] = motion[10 + k]
        out[row, 16] = end * tick
        out[row, 17] = (end - now) * tick


@kernel
def heading(w, x, y, z):
    """Return cosine and sine of the yaw of a unit quaternion."""
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return math.cos(yaw), math.sin(yaw)
