"""Compiled flight of the `tum_gazebo` cascade; the equations are in `vehicle`.

Rows of `motion`: position 0:3, velocity 3:6, quaternion 6:10, body rates 10:13, acceleration 13:16.
Rows of `memory`: last sample of velocity 0:3, acceleration 3:6, roll pitch yaw 6:9, body rates
9:12; last inputs of the six loops 12:18 (forward, left, up, roll, pitch, yaw); held command 18:22.
Rows of `counters`: ticks flown, messages received.
"""

import math

from rotorpong.kernels import kernel
from rotorpong.physics._noise_kernels import normal, uniform

TICK = 0.001  # s, the world's step
COMMAND_STREAM, OFFSET_STREAM, ATTITUDE_STREAM = 0, 1, 2
STREAM_LENGTH = 2**40
SETTLING = 3  # ticks: a kick, its end, its end one loop further in; then nothing changes


@kernel
def fly(constants, start, commands, span, outputs):
    """Fly every row of the batch; fill `outputs` = (motion, memory, counters, five tracks)."""
    motions, memories, counters, keys = start
    ticks, is_new = span
    motion_out, memory_out, counter_out, position, velocity, quaternion, rates, acceleration = (
        outputs
    )
    tracks = (position, velocity, quaternion, rates, acceleration)
    period = int(constants.sample_ticks)
    for row in range(motions.shape[0]):
        motion, memory, counter = motion_out[row], memory_out[row], counter_out[row]
        copy(motions[row], motion)
        copy(memories[row], memory)
        counter[0], counter[1] = counters[row, 0], counters[row, 1]
        if is_new:
            receive(constants, memory, counter, keys[row], commands[row])
        record(tracks, row, 0, motion)
        since_sample = counter[0] % period
        unsettled = SETTLING
        pulls = (0.0, 0.0, 0.0, 0.0)
        for i in range(1, ticks + 1):
            if since_sample == 0:
                sample(constants, motion, memory, counter[0] // period, keys[row])
                unsettled = SETTLING
            if unsettled > 0:
                pulls = control(constants, memory)
                unsettled -= 1
            integrate(constants, motion, pulls)
            counter[0] += 1
            since_sample += 1
            if since_sample == period:
                since_sample = 0
            record(tracks, row, i, motion)


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
def control(constants, memory):
    """Return thrust over mass and the three angular accelerations that the cascade asks for."""
    roll, pitch, yaw = memory[6], memory[7], memory[8]
    cosine, sine = math.cos(yaw), math.sin(yaw)
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
    down = math.cos(roll) * math.cos(pitch)
    turn = -math.sin(pitch) * memory[9] + math.sin(roll) * math.cos(pitch) * memory[10]
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


@kernel
def integrate(constants, motion, pulls):
    """Integrate the rigid body over one tick by the classical Runge-Kutta method.

    Thrust depends on attitude alone, attitude on the body rates, these on themselves: so the four
    stages of the rates come first, then those of the quaternion, of velocity, of position.
    """
    thrust, roll_pull, pitch_pull, yaw_pull = pulls
    xx, yy, zz = constants.inertia_x, constants.inertia_y, constants.inertia_z
    gyro = ((yy - zz) / xx, (zz - xx) / yy, (xx - yy) / zz)
    torque = (roll_pull, pitch_pull, yaw_pull)
    half, sixth = 0.5 * TICK, TICK / 6.0

    r1 = (motion[10], motion[11], motion[12])
    a1 = spin(gyro, torque, r1)
    r2 = along3(r1, half, a1)
    a2 = spin(gyro, torque, r2)
    r3 = along3(r1, half, a2)
    a3 = spin(gyro, torque, r3)
    r4 = along3(r1, TICK, a3)
    a4 = spin(gyro, torque, r4)

    q1 = (motion[6], motion[7], motion[8], motion[9])
    t1 = turn(q1, r1)
    q2 = along4(q1, half, t1)
    t2 = turn(q2, r2)
    q3 = along4(q1, half, t2)
    t3 = turn(q3, r3)
    q4 = along4(q1, TICK, t3)
    t4 = turn(q4, r4)

    gravity = constants.gravity
    v1 = (motion[3], motion[4], motion[5])
    f1 = push(thrust, gravity, q1)
    f2 = push(thrust, gravity, q2)
    f3 = push(thrust, gravity, q3)
    f4 = push(thrust, gravity, q4)
    v2 = along3(v1, half, f1)
    v3 = along3(v1, half, f2)
    v4 = along3(v1, TICK, f3)

    for i in range(3):
        motion[i] += sixth * (v1[i] + 2.0 * (v2[i] + v3[i]) + v4[i])
        after = v1[i] + sixth * (f1[i] + 2.0 * (f2[i] + f3[i]) + f4[i])
        motion[3 + i] = after
        motion[13 + i] = (after - v1[i]) / TICK
        motion[10 + i] += sixth * (a1[i] + 2.0 * (a2[i] + a3[i]) + a4[i])
    w = q1[0] + sixth * (t1[0] + 2.0 * (t2[0] + t3[0]) + t4[0])
    x = q1[1] + sixth * (t1[1] + 2.0 * (t2[1] + t3[1]) + t4[1])
    y = q1[2] + sixth * (t1[2] + 2.0 * (t2[2] + t3[2]) + t4[2])
    z = q1[3] + sixth * (t1[3] + 2.0 * (t2[3] + t3[3]) + t4[3])
    length = math.sqrt(w**2 + x**2 + y**2 + z**2)
    motion[6], motion[7], motion[8], motion[9] = w / length, x / length, y / length, z / length


@kernel
def along3(start, step, slope):
    """Return start + step slope."""
    return (
        start[0] + step * slope[0],
        start[1] + step * slope[1],
        start[2] + step * slope[2],
    )


@kernel
def along4(start, step, slope):
    """Return start + step slope."""
    return (
        start[0] + step * slope[0],
        start[1] + step * slope[1],
        start[2] + step * slope[2],
        start[3] + step * slope[3],
    )


@kernel
def spin(gyro, torque, rates):
    """Return the angular acceleration in body axes, by Euler's equations."""
    p, q, r = rates
    return (
        torque[0] + gyro[0] * q * r,
        torque[1] + gyro[1] * r * p,
        torque[2] + gyro[2] * p * q,
    )


@kernel
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


@kernel
def push(thrust, gravity, attitude):
    """Return the acceleration in the world by thrust and gravity."""
    w, x, y, z = attitude
    return (
        thrust * 2.0 * (x * z + w * y),
        thrust * 2.0 * (y * z - w * x),
        thrust * (1.0 - 2.0 * (x * x + y * y)) - gravity,
    )
