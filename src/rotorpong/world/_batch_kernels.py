"""One leg of many serves, and what is seen of the ball afterwards, compiled; see `batch`.

Rows of `clocks`: ticks flown, tick at which the last frame was exposed.
"""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import AIR_NUMBERS, LANES, fly_lanes
from rotorpong.world._contact_kernels import advance, first_near
from rotorpong.world._judging_kernels import ending, judged
from rotorpong.world._solid_kernels import make_work, scene_of

FLOWN, EXPOSED = 0, 1


@kernel
def fly_leg(rows, flown, parameters, logs, ends):
    """Fly the balls of `rows` along what their drones flew, and note which serves end there.

    All fly side by side as if there were nothing to touch; from the first tick in which something
    may be touched, a ball flies again, alone.

    Args:
        rows: which of the batch.
        flown: positions (m, ticks + 1, 3) and quaternions (m, ticks + 1, 4), row by row.
        parameters: (n, k) numbers of the solids of each serve.
        logs: balls (n, :, 9), poses (n, :, 7), clocks (n, 2).
        ends: codes (n,), deciding contacts (n, 27), contacts of this leg (m, :, 27), counts (m,).

    Returns:
        -1, or the first row whose drone flew to where no number is; that and what follow wait.
    """
    positions, quaternions = flown
    balls, poses, clocks = logs
    codes, deciding, contacts, counts = ends
    work = make_work()
    ticks = positions.shape[1] - 1
    fly_free(rows, ticks, parameters, balls, clocks)
    for m in range(rows.shape[0]):
        row = rows[m]
        start = clocks[row, FLOWN]
        track, trace = poses[row, start : start + ticks + 1], 0.0
        for i in range(ticks + 1):
            for k in range(3):
                track[i, k] = positions[m, i, k]
                trace += 0.0 * positions[m, i, k]
            for k in range(4):
                track[i, 3 + k] = quaternions[m, i, k]
                trace += 0.0 * quaternions[m, i, k]
        if trace != 0.0:  # nan, from a nan or an infinity
            return row
        scene = scene_of(parameters[row])
        near = first_near(balls[row, start : start + ticks + 1], track, scene, work)
        path = balls[row, start + 1 : start + ticks + 1]
        count = advance(
            balls[row, start + near],
            start * scene.tick,
            near,
            track,
            scene,
            work,
            contacts[m],
            path,
        )
        counts[m] = min(count, contacts.shape[1])
        clocks[row, FLOWN] = start + ticks
        hull = scene.hull.radius, scene.hull.half_height
        codes[row], index = ending(contacts[m, : counts[m]], path, track, start + ticks, hull)
        if index >= 0:
            for k in range(deciding.shape[1]):
                deciding[row, k] = contacts[m, index, k]
    return -1


@kernel
def fly_free(rows, ticks, parameters, balls, clocks):
    """Fly the balls of `rows` on for some ticks as if there were nothing to touch."""
    given, to, airs = np.zeros(9 * LANES), np.zeros(9 * LANES), np.zeros(AIR_NUMBERS * LANES)
    tick = scene_of(parameters[rows[0]]).tick
    for first in range(0, rows.shape[0], LANES):
        lanes = min(LANES, rows.shape[0] - first)
        for j in range(lanes):
            row = rows[first + j]
            for k in range(AIR_NUMBERS):
                airs[k * LANES + j] = parameters[row, k]
            for k in range(9):
                given[k * LANES + j] = balls[row, clocks[row, FLOWN], k]
        for i in range(ticks):
            fly_lanes(given, tick, airs, to, lanes)
            given, to = to, given
            for j in range(lanes):
                row = rows[first + j]
                after = balls[row, clocks[row, FLOWN] + i + 1]
                for k in range(9):
                    after[k] = given[k * LANES + j]


@kernel
def judge_rows(rows, logs, codes, sizes, results):
    """Judge serves: renew `codes`; write miss distances (m) and lags (ticks) into `results`."""
    balls, poses, clocks = logs
    for m in range(rows.shape[0]):
        row = rows[m]
        end = clocks[row, FLOWN] + 1
        code, miss, lag = judged(codes[row], balls[row, :end], poses[row, :end], sizes)
        codes[row], results[0, row], results[1, row] = code, miss, lag


@kernel
def see(motions, logs, tick, out):
    """Fill `out` (n, 18) with the states that `batch.STATE` names."""
    balls, poses, clocks = logs
    for row in range(out.shape[0]):
        end = clocks[row, FLOWN]
        now = min(clocks[row, EXPOSED], end)
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
