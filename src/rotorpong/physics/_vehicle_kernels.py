"""Compiled flight of the `tum_gazebo` cascade; the equations are in `vehicle`.

Rows of `motion`: position 0:3, velocity 3:6, quaternion 6:10, body rates 10:13, acceleration 13:16.
Rows of `memory`: last sample of velocity 0:3, acceleration 3:6, roll pitch yaw 6:9, body rates
9:12; last inputs of the six loops 12:18 (forward, left, up, roll, pitch, yaw); held command 18:22.
Rows of `counters`: ticks flown, messages received.
"""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.physics._noise_kernels import normal, uniform

TICK = 0.001  # s, the world's step
COMMAND_STREAM, OFFSET_STREAM, ATTITUDE_STREAM = 0, 1, 2
STREAM_LENGTH = 2**40


@kernel
def fly(constants, start, commands, span, outputs):
    """Fly every row of the batch; fill `outputs` = (motion, memory, counters, five tracks)."""
    motions, memories, counters, keys = start
    ticks, is_new = span
    motion_out, memory_out, counter_out, position, velocity, quaternion, rates, acceleration = (
        outputs
    )
    scratch = np.empty((5, 13))
    for row in range(motions.shape[0]):
        motion, memory, counter = motion_out[row], memory_out[row], counter_out[row]
        motion[:] = motions[row]
        memory[:] = memories[row]
        counter[:] = counters[row]
        if is_new:
            receive(constants, memory, counter, keys[row], commands[row])
        for i in range(ticks + 1):
            if i > 0:
                tick(constants, motion, memory, counter, keys[row], scratch)
            position[row, i] = motion[0:3]
            velocity[row, i] = motion[3:6]
            quaternion[row, i] = motion[6:10]
            rates[row, i] = motion[10:13]
            acceleration[row, i] = motion[13:16]


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
def tick(constants, motion, memory, counter, key, scratch):
    """Advance one vehicle by one tick: sample, control, integrate."""
    if counter[0] % int(constants.sample_ticks) == 0:
        sample(constants, motion, memory, counter[0] // int(constants.sample_ticks), key)
    specific_thrust, roll, pitch, yaw = control(constants, memory)
    before_x, before_y, before_z = motion[3], motion[4], motion[5]
    integrate(constants, motion, (specific_thrust, roll, pitch, yaw), scratch)
    motion[13] = (motion[3] - before_x) / TICK
    motion[14] = (motion[4] - before_y) / TICK
    motion[15] = (motion[5] - before_z) / TICK
    counter[0] += 1


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
def integrate(constants, motion, pulls, scratch):
    """Integrate the rigid body over one tick by the classical Runge-Kutta method."""
    first, second, third, fourth, point = scratch
    here = motion[0:13]
    derivative(constants, here, pulls, first)
    for i in range(13):
        point[i] = here[i] + 0.5 * TICK * first[i]
    derivative(constants, point, pulls, second)
    for i in range(13):
        point[i] = here[i] + 0.5 * TICK * second[i]
    derivative(constants, point, pulls, third)
    for i in range(13):
        point[i] = here[i] + TICK * third[i]
    derivative(constants, point, pulls, fourth)
    for i in range(13):
        here[i] += TICK / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
    length = math.sqrt(here[6] ** 2 + here[7] ** 2 + here[8] ** 2 + here[9] ** 2)
    for i in range(6, 10):
        here[i] /= length


@kernel
def derivative(constants, body, pulls, change):
    """Fill `change` with the time derivative of position, velocity, quaternion, body rates."""
    w, x, y, z = body[6], body[7], body[8], body[9]
    p, q, r = body[10], body[11], body[12]
    thrust, roll_pull, pitch_pull, yaw_pull = pulls
    change[0], change[1], change[2] = body[3], body[4], body[5]
    change[3] = thrust * 2.0 * (x * z + w * y)
    change[4] = thrust * 2.0 * (y * z - w * x)
    change[5] = thrust * (1.0 - 2.0 * (x * x + y * y)) - constants.gravity
    change[6] = 0.5 * (-x * p - y * q - z * r)
    change[7] = 0.5 * (w * p + y * r - z * q)
    change[8] = 0.5 * (w * q + z * p - x * r)
    change[9] = 0.5 * (w * r + x * q - y * p)
    xx, yy, zz = constants.inertia_x, constants.inertia_y, constants.inertia_z
    change[10] = roll_pull + (yy - zz) / xx * q * r
    change[11] = pitch_pull + (zz - xx) / yy * r * p
    change[12] = yaw_pull + (xx - yy) / zz * p * q
