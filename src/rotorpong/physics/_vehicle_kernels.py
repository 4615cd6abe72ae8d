"""Compiled flight of the `tum_gazebo` cascade; the equations are in `vehicle`.

Rows of `motion`: position 0:3, velocity 3:6, quaternion 6:10, body rates 10:13, acceleration 13:16.
Rows of `memory`: last sampled velocity 0:3; what the loops see until the next sample 3:15, named
below; last inputs of the six loops 15:21 (forward, left, up, roll, pitch, yaw); held command 21:25.
Rows of `counters`: ticks flown, messages received.
"""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.physics._noise_kernels import normal, uniform
from rotorpong.physics.cascade import Cascade

TICK = 0.001  # s, the world's step
PER_TICK = 1000.0  # its inverse, 1/s
SIXTH = 1.0 / 6.0
COMMAND_STREAM, OFFSET_STREAM, ATTITUDE_STREAM = 0, 1, 2
STREAM_LENGTH = 2**40
LANES = 16  # rows that fly side by side
WIDTH = 8  # lanes of one vector: a loop over fewer is slower than one over these
SETTLING = 3  # ticks: a kick, its end, its end one loop further in; then nothing changes
MEMORY_SIZE = 25
PULL, MEMORY = 16, 20  # where in a lane: thrust over mass, three angular accelerations; the memory
LANE_SIZE = MEMORY + MEMORY_SIZE
LAST, SEEN, INPUT, HELD = MEMORY, MEMORY + 3, MEMORY + 15, MEMORY + 21
FORWARD, LEFT, UP, FORWARD_CHANGE, LEFT_CHANGE, UP_CHANGE = range(SEEN, SEEN + 6)  # m/s, m/s^2
ROLL, PITCH, ROLL_RATE, PITCH_RATE, TURN, HOVER = range(SEEN + 6, SEEN + 12)
"""Of the controller: rad, rad/s; thrust over mass that would hold the height."""


@kernel
def fly(
    numbers, rows, motions, memories, counters, keys, commands, are_new, starts, ticks, poses, rest
):
    """Fly rows of a batch, in place.

    LANES rows fly side by side: each decides alone, and all are integrated by vector instructions.

    Args:
        numbers: of the `Cascade`. (A NamedTuple costs microseconds at this door, arrays little.)
        rows: which, the longest leg first: those that fly as far as their neighbours waste least.
        motions: of the batch, a row each, as what follows.
        memories: see above.
        counters: see above.
        keys: of the noise.
        commands: as in `vehicle.Legs`, and what follows.
        are_new: whether a message brought the command.
        starts: instant of the tracks at which the leg begins.
        ticks: of the leg.
        poses: (n, :, 7) track of position and quaternion.
        rest: (n, :, 9) of velocity, body rates and acceleration; (0, :, 9) if nobody asks for it.
    """
    constants, tracks = Cascade(*numbers), (poses, rest)
    side_by_side, wait = np.zeros(LANE_SIZE * LANES), np.empty(LANES, np.int64)
    period = int(constants.sample_ticks)
    for first in range(0, rows.shape[0], LANES):
        lanes = min(LANES, rows.shape[0] - first)
        longest, unsettled = ticks[rows[first]], SETTLING
        for j in range(lanes):
            row = rows[first + j]
            if are_new[row]:
                receive(constants, memories[row], counters[row], keys[row], commands[row])
            into_lane(motions[row], memories[row], side_by_side, j)
            wait[j] = -counters[row, 0] % period
        record(tracks, rows[first : first + lanes], starts, 0, side_by_side)
        for i in range(1, longest + 1):
            while ticks[rows[first + lanes - 1]] < i:
                lanes -= 1
            for j in range(lanes):
                if wait[j] == 0:
                    row = rows[first + j]
                    index = (counters[row, 0] + i - 1) // period
                    sample(constants, side_by_side, j, index, keys[row])
                    wait[j], unsettled = period, SETTLING
                wait[j] -= 1
            if unsettled > 0:
                control(constants, side_by_side, width_of(lanes))
                unsettled -= 1
            integrate(constants, side_by_side, width_of(lanes))
            record(tracks, rows[first : first + lanes], starts, i, side_by_side)
            for j in range(lanes):
                row = rows[first + j]
                if i == ticks[row]:
                    out_of_lane(side_by_side, j, motions[row], memories[row])
                    counters[row, 0] += i


@kernel
def width_of(lanes):
    """Return how many lanes to compute so that a few are flown: all in whole vectors, or one."""
    return lanes if lanes == 1 else (lanes + WIDTH - 1) // WIDTH * WIDTH


@kernel
def into_lane(motion, memory, lanes, j):
    """Write the state of one vehicle into lane j: number k lies at k LANES + j."""
    for k in range(16):
        lanes[k * LANES + j] = motion[k]
    for k in range(MEMORY_SIZE):
        lanes[(MEMORY + k) * LANES + j] = memory[k]


@kernel
def out_of_lane(lanes, j, motion, memory):
    """Write lane j into the state of one vehicle."""
    for k in range(16):
        motion[k] = lanes[k * LANES + j]
    for k in range(MEMORY_SIZE):
        memory[k] = lanes[(MEMORY + k) * LANES + j]


@kernel
def record(tracks, rows, starts, i, lanes):
    """Write instant i of the legs into the rows' tracks.

    Args:
        tracks: poses and the rest, see `fly`.
        rows: in the order of their lanes.
        starts: (n,), where in the tracks a leg begins.
        i: instant of the leg.
        lanes: as `into_lane` fills them.
    """
    poses, rest = tracks
    for j in range(rows.shape[0]):
        row = rows[j]
        at = starts[row] + i
        for k in range(3):
            poses[row, at, k] = lanes[k * LANES + j]
        for k in range(4):
            poses[row, at, 3 + k] = lanes[(6 + k) * LANES + j]
        if rest.shape[0] > 0:
            for k in range(3):
                rest[row, at, k] = lanes[(3 + k) * LANES + j]
                rest[row, at, 3 + k] = lanes[(10 + k) * LANES + j]
                rest[row, at, 6 + k] = lanes[(13 + k) * LANES + j]


@kernel
def receive(constants, memory, counter, key, command):
    """Hold a new command, with the noise of its message and of its five seconds."""
    era = int(counter[0] * TICK / constants.command_offset_period)
    for axis in range(4):
        white = 2.0 * uniform(key, COMMAND_STREAM * STREAM_LENGTH + 4 * counter[1] + axis) - 1.0
        slow = 2.0 * uniform(key, OFFSET_STREAM * STREAM_LENGTH + 4 * era + axis) - 1.0
        noise = constants.command_white * white + constants.command_offset * slow
        memory[HELD - MEMORY + axis] = command[axis] + noise
    counter[1] += 1


@kernel
def sample(constants, lanes, j, index, key):
    """Let the controller of lane j take the state as it sees it until the next sample."""
    w, x = lanes[6 * LANES + j], lanes[7 * LANES + j]
    y, z = lanes[8 * LANES + j], lanes[9 * LANES + j]
    roll_rate, pitch_rate = lanes[10 * LANES + j], lanes[11 * LANES + j]
    first = ATTITUDE_STREAM * STREAM_LENGTH + 2 * index
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    roll += constants.attitude_noise * normal(key, first)
    pitch = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    pitch += constants.attitude_noise * normal(key, first + 1)
    aside, cos_pitch, down = math.sin(roll), math.cos(pitch), math.cos(roll)
    aside, down = aside * cos_pitch, down * cos_pitch
    turn = aside * pitch_rate - math.sin(pitch) * roll_rate + down * lanes[12 * LANES + j]
    lanes[ROLL * LANES + j], lanes[ROLL_RATE * LANES + j] = roll, roll_rate
    lanes[PITCH * LANES + j], lanes[PITCH_RATE * LANES + j] = pitch, pitch_rate
    lanes[TURN * LANES + j], lanes[HOVER * LANES + j] = turn, constants.gravity / down
    cosine, sine = 1.0 - 2.0 * (y * y + z * z), 2.0 * (w * z + x * y)  # of yaw, times cos pitch
    size = math.sqrt(cosine * cosine + sine * sine)
    if size > 0.0:
        cosine, sine = cosine / size, sine / size
    rate = 1.0 / (constants.sample_ticks * TICK)
    vx, vy, vz = lanes[3 * LANES + j], lanes[4 * LANES + j], lanes[5 * LANES + j]
    ax = rate * (vx - lanes[LAST * LANES + j])
    ay = rate * (vy - lanes[(LAST + 1) * LANES + j])
    az = rate * (vz - lanes[(LAST + 2) * LANES + j])
    level = cosine * vx + sine * vy, cosine * vy - sine * vx, vz
    level_change = cosine * ax + sine * ay, cosine * ay - sine * ax, az
    for k in range(3):
        lanes[(LAST + k) * LANES + j] = lanes[(3 + k) * LANES + j]
        lanes[(FORWARD + k) * LANES + j] = level[k]
        lanes[(FORWARD_CHANGE + k) * LANES + j] = level_change[k]


@inlined_kernel
def control(constants, rows, lanes):
    """Write into each lane the thrust over mass and angular accelerations that its loops ask for.

    Args:
        constants: of the vehicle.
        rows: number k of lane j at k LANES + j.
        lanes: how many.
    """
    horizontal = constants.horizontal_p, constants.horizontal_d, constants.horizontal_limit
    vertical = constants.vertical_p, constants.vertical_d, constants.vertical_limit
    tilt = constants.tilt_p, constants.tilt_d, constants.tilt_limit
    yaw = constants.yaw_p, constants.yaw_d, constants.yaw_limit
    strongest, per_gravity = constants.thrust_limit / constants.mass, 1.0 / constants.gravity
    for j in range(lanes):
        inputs = (
            rows[INPUT * LANES + j], rows[(INPUT + 1) * LANES + j], rows[(INPUT + 2) * LANES + j],
            rows[(INPUT + 3) * LANES + j], rows[(INPUT + 4) * LANES + j],
            rows[(INPUT + 5) * LANES + j],
        )  # fmt: skip
        seen = rows[FORWARD * LANES + j], rows[FORWARD_CHANGE * LANES + j]
        ahead, forward = loop(horizontal, rows[HELD * LANES + j], seen, inputs[0])
        seen = rows[LEFT * LANES + j], rows[LEFT_CHANGE * LANES + j]
        aside, left = loop(horizontal, rows[(HELD + 1) * LANES + j], seen, inputs[1])
        seen = rows[UP * LANES + j], rows[UP_CHANGE * LANES + j]
        lift, up = loop(vertical, rows[(HELD + 2) * LANES + j], seen, inputs[2])
        seen = rows[ROLL * LANES + j], rows[ROLL_RATE * LANES + j]
        roll_pull, roll = loop(tilt, -per_gravity * aside, seen, inputs[3])
        seen = rows[PITCH * LANES + j], rows[PITCH_RATE * LANES + j]
        pitch_pull, pitch = loop(tilt, per_gravity * ahead, seen, inputs[4])
        seen = rows[TURN * LANES + j], 0.0
        yaw_pull, turn = loop(yaw, rows[(HELD + 3) * LANES + j], seen, inputs[5])
        thrust = min(max(lift + rows[HOVER * LANES + j], 0.0), strongest)
        rows[PULL * LANES + j], rows[(PULL + 1) * LANES + j] = thrust, roll_pull
        rows[(PULL + 2) * LANES + j], rows[(PULL + 3) * LANES + j] = pitch_pull, yaw_pull
        rows[INPUT * LANES + j], rows[(INPUT + 1) * LANES + j] = forward, left
        rows[(INPUT + 2) * LANES + j], rows[(INPUT + 3) * LANES + j] = up, roll
        rows[(INPUT + 4) * LANES + j], rows[(INPUT + 5) * LANES + j] = pitch, turn


@inlined_kernel
def loop(gains, wanted, seen, before):
    """Return P (in - x) + D (din - dx) of one loop, and its input.

    Args:
        gains: P, D and limit of the input.
        wanted: the input before it is limited.
        seen: x and dx.
        before: the input a tick ago.
    """
    p, d, limit = gains
    limited = min(max(wanted, -limit), limit)
    return p * (limited - seen[0]) + d * ((limited - before) * PER_TICK - seen[1]), limited


@inlined_kernel
def integrate(constants, rows, lanes):
    """Integrate rigid bodies over one tick by the classical Runge-Kutta method.

    Thrust depends on attitude alone, attitude on the body rates, these on themselves: so the four
    stages of the rates come first, then those of the quaternion, of velocity, of position.

    Args:
        constants: of the vehicle.
        rows: number k of lane j at k LANES + j. One array, which the compiler need not compare
            with others.
        lanes: how many.
    """
    xx, yy, zz = constants.inertia_x, constants.inertia_y, constants.inertia_z
    gyro = ((yy - zz) / xx, (zz - xx) / yy, (xx - yy) / zz)
    gravity = constants.gravity
    for j in range(lanes):
        thrust = rows[PULL * LANES + j]
        torque = (
            rows[(PULL + 1) * LANES + j], rows[(PULL + 2) * LANES + j],
            rows[(PULL + 3) * LANES + j],
        )  # fmt: skip
        rates = (rows[10 * LANES + j], rows[11 * LANES + j], rows[12 * LANES + j])
        rates, after = spun(gyro, torque, rates)
        rows[10 * LANES + j], rows[11 * LANES + j], rows[12 * LANES + j] = after
        attitude = (
            rows[6 * LANES + j], rows[7 * LANES + j],
            rows[8 * LANES + j], rows[9 * LANES + j],
        )  # fmt: skip
        q1, q2, q3, q4, (w, x, y, z) = turned(attitude, rates)
        rows[6 * LANES + j], rows[7 * LANES + j] = w, x
        rows[8 * LANES + j], rows[9 * LANES + j] = y, z
        f1, f2 = push(thrust, gravity, q1), push(thrust, gravity, q2)
        f3, f4 = push(thrust, gravity, q3), push(thrust, gravity, q4)
        v1 = (rows[3 * LANES + j], rows[4 * LANES + j], rows[5 * LANES + j])
        v2 = along3(v1, 0.5 * TICK, f1)
        v3 = along3(v1, 0.5 * TICK, f2)
        v4 = along3(v1, TICK, f3)
        place = (rows[j], rows[LANES + j], rows[2 * LANES + j])
        place = along3(place, TICK, mean3(v1, v2, v3, v4))
        rows[j], rows[LANES + j], rows[2 * LANES + j] = place
        pull = mean3(f1, f2, f3, f4)
        rows[13 * LANES + j], rows[14 * LANES + j], rows[15 * LANES + j] = pull
        v1 = along3(v1, TICK, pull)
        rows[3 * LANES + j], rows[4 * LANES + j], rows[5 * LANES + j] = v1


@inlined_kernel
def spun(gyro, torque, r1):
    """Return the body rates at the four stages, and after the tick."""
    a1 = spin(gyro, torque, r1)
    r2 = along3(r1, 0.5 * TICK, a1)
    a2 = spin(gyro, torque, r2)
    r3 = along3(r1, 0.5 * TICK, a2)
    a3 = spin(gyro, torque, r3)
    r4 = along3(r1, TICK, a3)
    return (r1, r2, r3, r4), along3(r1, TICK, mean3(a1, a2, a3, spin(gyro, torque, r4)))


@inlined_kernel
def turned(q1, rates):
    """Return the quaternion at the four stages, and after the tick with length 1."""
    r1, r2, r3, r4 = rates
    t1 = turn(q1, r1)
    q2 = along4(q1, 0.5 * TICK, t1)
    t2 = turn(q2, r2)
    q3 = along4(q1, 0.5 * TICK, t2)
    t3 = turn(q3, r3)
    q4 = along4(q1, TICK, t3)
    t4 = turn(q4, r4)
    w = q1[0] + TICK * SIXTH * (t1[0] + 2.0 * (t2[0] + t3[0]) + t4[0])
    x = q1[1] + TICK * SIXTH * (t1[1] + 2.0 * (t2[1] + t3[1]) + t4[1])
    y = q1[2] + TICK * SIXTH * (t1[2] + 2.0 * (t2[2] + t3[2]) + t4[2])
    z = q1[3] + TICK * SIXTH * (t1[3] + 2.0 * (t2[3] + t3[3]) + t4[3])
    shrink = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return q1, q2, q3, q4, (shrink * w, shrink * x, shrink * y, shrink * z)


@inlined_kernel
def mean3(s1, s2, s3, s4):
    """Return the slope of a whole step from those of its four stages."""
    return (
        (s1[0] + 2.0 * (s2[0] + s3[0]) + s4[0]) * SIXTH,
        (s1[1] + 2.0 * (s2[1] + s3[1]) + s4[1]) * SIXTH,
        (s1[2] + 2.0 * (s2[2] + s3[2]) + s4[2]) * SIXTH,
    )


@inlined_kernel
def along3(start, step, slope):
    """Return start + step slope."""
    return (
        start[0] + step * slope[0],
        start[1] + step * slope[1],
        start[2] + step * slope[2],
    )


@inlined_kernel
def along4(start, step, slope):
    """Return start + step slope."""
    return (
        start[0] + step * slope[0],
        start[1] + step * slope[1],
        start[2] + step * slope[2],
        start[3] + step * slope[3],
    )


@inlined_kernel
def spin(gyro, torque, rates):
    """Return the angular acceleration in body axes, by Euler's equations."""
    p, q, r = rates
    return (
        torque[0] + gyro[0] * q * r,
        torque[1] + gyro[1] * r * p,
        torque[2] + gyro[2] * p * q,
    )


@inlined_kernel
def turn(attitude, rates):
    """Return q' = q (0, w) / 2."""
    w, x, y, z = attitude
    p, q, r = rates
    return (
        0.5 * (-x * p - y * q - z * r),
        0.5 * (w * p + y * r - z * q),
        0.5 * (w * q + z * p - x * r),
        0.5 * (w * r + x * q - y * p),
    )


@inlined_kernel
def push(thrust, gravity, attitude):
    """Return the acceleration in the world by thrust and gravity."""
    w, x, y, z = attitude
    return (
        thrust * 2.0 * (x * z + w * y),
        thrust * 2.0 * (y * z - w * x),
        thrust * (1.0 - 2.0 * (x * x + y * y)) - gravity,
    )
