"""Compiled flight of the `tum_gazebo` cascade; the equations are in `vehicle`.

Rows of `motion`: position 0:3, velocity 3:6, quaternion 6:10, body rates 10:13, acceleration 13:16.
Rows of `memory`: last sample of velocity 0:3, acceleration 3:6, roll pitch yaw 6:9, body rates
9:12; last inputs of the six loops 12:18 (forward, left, up, roll, pitch, yaw); held command 18:22.
Rows of `counters`: ticks flown, messages received.
"""

import math

import numpy as np

from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.physics._noise_kernels import normal, uniform

TICK = 0.001  # s, the world's step
COMMAND_STREAM, OFFSET_STREAM, ATTITUDE_STREAM = 0, 1, 2
STREAM_LENGTH = 2**40
LANES = 16  # rows that fly side by side
SETTLING = 3  # ticks: a kick, its end, its end one loop further in; then nothing changes


@kernel
def fly(constants, start, commands, span, outputs):
    """Fly every row of the batch; fill `outputs` = (motion, memory, counters, five tracks).

    LANES rows fly side by side: each decides alone, and all are integrated by vector instructions.
    """
    motions, memories, counters, keys = start
    ticks, is_new = span
    motion_out, memory_out, counter_out, position, velocity, quaternion, rates, acceleration = (
        outputs
    )
    tracks = (position, velocity, quaternion, rates, acceleration)
    side_by_side, sights = np.zeros(20 * LANES), np.empty((LANES, 6))
    unsettled, since_sample = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    period = int(constants.sample_ticks)
    for first in range(0, motions.shape[0], LANES):
        lanes = min(LANES, motions.shape[0] - first)
        for j in range(lanes):
            row = first + j
            copy(motions[row], motion_out[row])
            copy(memories[row], memory_out[row])
            copy(counters[row], counter_out[row])
            if is_new:
                receive(constants, memory_out[row], counter_out[row], keys[row], commands[row])
            into_lane(motion_out[row], side_by_side, j)
            look(memory_out[row], sights[j])
            unsettled[j], since_sample[j] = SETTLING, counter_out[row][0] % period
        record_lanes(tracks, first, 0, side_by_side, lanes)
        for i in range(1, ticks + 1):
            for j in range(lanes):
                row = first + j
                if since_sample[j] == 0:
                    out_of_lane(side_by_side, j, motion_out[row])
                    index = counter_out[row][0] // period
                    sample(constants, motion_out[row], memory_out[row], index, keys[row])
                    look(memory_out[row], sights[j])
                    unsettled[j] = SETTLING
                if unsettled[j] > 0:
                    pull = control(constants, memory_out[row], sights[j])
                    for k in range(4):
                        side_by_side[(16 + k) * LANES + j] = pull[k]
                    unsettled[j] -= 1
                counter_out[row][0] += 1
                since_sample[j] = since_sample[j] + 1 if since_sample[j] + 1 < period else 0
            integrate(constants, side_by_side, lanes)
            record_lanes(tracks, first, i, side_by_side, lanes)
        for j in range(lanes):
            out_of_lane(side_by_side, j, motion_out[first + j])


@kernel
def into_lane(motion, lanes, j):
    """Write the motion of one vehicle into lane j: number k lies at k LANES + j."""
    for k in range(16):
        lanes[k * LANES + j] = motion[k]


@kernel
def out_of_lane(lanes, j, motion):
    """Write lane j into the motion of one vehicle."""
    for k in range(16):
        motion[k] = lanes[k * LANES + j]


@kernel
def copy(values, to):
    """Copy a row."""
    for i in range(values.shape[0]):
        to[i] = values[i]


@kernel
def record(tracks, row, i, motion):
    """Write instant i of a row into its tracks."""
    position, velocity, quaternion, rates, acceleration = tracks
    for axis in range(3):
        position[row, i, axis] = motion[axis]
        velocity[row, i, axis] = motion[3 + axis]
        rates[row, i, axis] = motion[10 + axis]
        acceleration[row, i, axis] = motion[13 + axis]
    for axis in range(4):
        quaternion[row, i, axis] = motion[6 + axis]


@kernel
def record_lanes(tracks, first, i, motions, lanes):
    """Write instant i of some rows into their tracks."""
    position, velocity, quaternion, rates, acceleration = tracks
    for j in range(lanes):
        for axis in range(3):
            position[first + j, i, axis] = motions[axis * LANES + j]
            velocity[first + j, i, axis] = motions[(3 + axis) * LANES + j]
            rates[first + j, i, axis] = motions[(10 + axis) * LANES + j]
            acceleration[first + j, i, axis] = motions[(13 + axis) * LANES + j]
        for axis in range(4):
            quaternion[first + j, i, axis] = motions[(6 + axis) * LANES + j]


@kernel
def receive(constants, memory, counter, key, command):
    """Hold a new command, with the noise of its message and of its five seconds."""
    era = int(counter[0] * TICK / constants.command_offset_period)
    for axis in range(4):
        white = 2.0 * uniform(key, COMMAND_STREAM * STREAM_LENGTH + 4 * counter[1] + axis) - 1.0
        slow = 2.0 * uniform(key, OFFSET_STREAM * STREAM_LENGTH + 4 * era + axis) - 1.0
        noise = constants.command_white * white + constants.command_offset * slow
        memory[18 + axis] = command[axis] + noise
    counter[1] += 1


@kernel
def sample(constants, motion, memory, index, key):
    """Take the state as the flight controller sees it until the next sample."""
    period = constants.sample_ticks * TICK
    for axis in range(3):
        memory[3 + axis] = (motion[3 + axis] - memory[axis]) / period
        memory[axis] = motion[3 + axis]
        memory[9 + axis] = motion[10 + axis]
    w, x, y, z = motion[6], motion[7], motion[8], motion[9]
    first = ATTITUDE_STREAM * STREAM_LENGTH + 2 * index
    roll_noise = constants.attitude_noise * normal(key, first)
    pitch_noise = constants.attitude_noise * normal(key, first + 1)
    memory[6] = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)) + roll_noise
    sine = 2.0 * (w * y - z * x)
    memory[7] = math.asin(min(max(sine, -1.0), 1.0)) + pitch_noise
    memory[8] = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@kernel
def look(memory, sight):
    """Write cosine and sine of the sampled roll, pitch and yaw."""
    for k in range(3):
        sight[2 * k], sight[2 * k + 1] = math.cos(memory[6 + k]), math.sin(memory[6 + k])


@kernel
def control(constants, memory, sight):
    """Return thrust over mass and the three angular accelerations that the cascade asks for."""
    roll, pitch, cosine, sine = memory[6], memory[7], sight[4], sight[5]
    forward = cosine * memory[0] + sine * memory[1]
    left = cosine * memory[1] - sine * memory[0]
    forward_change = cosine * memory[3] + sine * memory[4]
    left_change = cosine * memory[4] - sine * memory[3]
    p, d, limit = constants.horizontal_p, constants.horizontal_d, constants.horizontal_limit
    pitch_command = loop(memory, 0, (p, d, limit), (memory[18], forward, forward_change))
    roll_command = -loop(memory, 1, (p, d, limit), (memory[19], left, left_change))
    p, d, limit = constants.tilt_p, constants.tilt_d, constants.tilt_limit
    gravity = constants.gravity
    roll_pull = loop(memory, 3, (p, d, limit), (roll_command / gravity, roll, memory[9]))
    pitch_pull = loop(memory, 4, (p, d, limit), (pitch_command / gravity, pitch, memory[10]))
    down = sight[0] * sight[2]
    turn = -sight[3] * memory[9] + sight[1] * sight[2] * memory[10]
    turn += down * memory[11]
    p, d, limit = constants.yaw_p, constants.yaw_d, constants.yaw_limit
    yaw_pull = loop(memory, 5, (p, d, limit), (memory[21], turn, 0.0))
    p, d, limit = constants.vertical_p, constants.vertical_d, constants.vertical_limit
    lift = loop(memory, 2, (p, d, limit), (memory[20], memory[2], memory[5])) + gravity / down
    strongest = constants.thrust_limit / constants.mass
    return min(max(lift, 0.0), strongest), roll_pull, pitch_pull, yaw_pull


@kernel
def loop(memory, index, gains, signals):
    """Return P (in - x) + D (din - dx) of one loop and remember its input."""
    p, d, limit = gains
    wanted, x, dx = signals
    limited = min(max(wanted, -limit), limit)
    change = (limited - memory[12 + index]) / TICK
    memory[12 + index] = limited
    return p * (limited - x) + d * (change - dx)


@inlined_kernel
def integrate(constants, rows, lanes):
    """Integrate rigid bodies over one tick by the classical Runge-Kutta method.

    Thrust depends on attitude alone, attitude on the body rates, these on themselves: so the four
    stages of the rates come first, then those of the quaternion, of velocity, of position.

    Args:
        constants: of the vehicle.
        rows: number k of lane j at k LANES + j: the motion 0:16, thrust over mass and three angular
            accelerations 16:20. One array, which the compiler need not compare with others.
        lanes: how many.
    """
    xx, yy, zz = constants.inertia_x, constants.inertia_y, constants.inertia_z
    gyro = ((yy - zz) / xx, (zz - xx) / yy, (xx - yy) / zz)
    gravity = constants.gravity
    half, sixth = 0.5 * TICK, TICK / 6.0
    for j in range(lanes):
        thrust = rows[16 * LANES + j]
        torque = (rows[17 * LANES + j], rows[18 * LANES + j], rows[19 * LANES + j])
        r1 = (rows[10 * LANES + j], rows[11 * LANES + j], rows[12 * LANES + j])
        a1 = spin(gyro, torque, r1)
        r2 = along3(r1, half, a1)
        a2 = spin(gyro, torque, r2)
        r3 = along3(r1, half, a2)
        a3 = spin(gyro, torque, r3)
        r4 = along3(r1, TICK, a3)
        a4 = spin(gyro, torque, r4)
        q1 = (
            rows[6 * LANES + j], rows[7 * LANES + j],
            rows[8 * LANES + j], rows[9 * LANES + j],
        )  # fmt: skip
        t1 = turn(q1, r1)
        q2 = along4(q1, half, t1)
        t2 = turn(q2, r2)
        q3 = along4(q1, half, t2)
        t3 = turn(q3, r3)
        q4 = along4(q1, TICK, t3)
        t4 = turn(q4, r4)
        v1 = (rows[3 * LANES + j], rows[4 * LANES + j], rows[5 * LANES + j])
        f1 = push(thrust, gravity, q1)
        f2 = push(thrust, gravity, q2)
        f3 = push(thrust, gravity, q3)
        f4 = push(thrust, gravity, q4)
        v2 = along3(v1, half, f1)
        v3 = along3(v1, half, f2)
        v4 = along3(v1, TICK, f3)
        p1 = (rows[j], rows[LANES + j], rows[2 * LANES + j])
        x, y, z = mean3(p1, sixth, v1, v2, (v3, v4))
        rows[j], rows[LANES + j], rows[2 * LANES + j] = x, y, z
        x, y, z = mean3(v1, sixth, f1, f2, (f3, f4))
        rows[3 * LANES + j], rows[4 * LANES + j], rows[5 * LANES + j] = x, y, z
        rows[13 * LANES + j] = (x - v1[0]) / TICK
        rows[14 * LANES + j] = (y - v1[1]) / TICK
        rows[15 * LANES + j] = (z - v1[2]) / TICK
        x, y, z = mean3(r1, sixth, a1, a2, (a3, a4))
        rows[10 * LANES + j], rows[11 * LANES + j], rows[12 * LANES + j] = x, y, z
        w = q1[0] + sixth * (t1[0] + 2.0 * (t2[0] + t3[0]) + t4[0])
        x = q1[1] + sixth * (t1[1] + 2.0 * (t2[1] + t3[1]) + t4[1])
        y = q1[2] + sixth * (t1[2] + 2.0 * (t2[2] + t3[2]) + t4[2])
        z = q1[3] + sixth * (t1[3] + 2.0 * (t2[3] + t3[3]) + t4[3])
        length = math.sqrt(w * w + x * x + y * y + z * z)
        rows[6 * LANES + j], rows[7 * LANES + j] = w / length, x / length
        rows[8 * LANES + j], rows[9 * LANES + j] = y / length, z / length


@inlined_kernel
def mean3(start, sixth, s1, s2, rest):
    """Return start + (s1 + 2 (s2 + s3) + s4) sixth."""
    s3, s4 = rest
    return (
        start[0] + sixth * (s1[0] + 2.0 * (s2[0] + s3[0]) + s4[0]),
        start[1] + sixth * (s1[1] + 2.0 * (s2[1] + s3[1]) + s4[1]),
        start[2] + sixth * (s1[2] + 2.0 * (s2[2] + s3[2]) + s4[2]),
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
