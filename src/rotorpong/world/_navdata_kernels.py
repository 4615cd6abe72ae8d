"""What the sensors measure along a path, compiled; the equations are in `sensors`.

`errors` holds the numbers of `sensors.Sensors` in one row: the sizes of the white noise of the
eleven channels 0:11, biases of gyro 11:14, of roll and pitch 14:16, of optical flow 16:19, and one
number each at the places named below. `keys`: white at 200 Hz, attitude, slow attitude.
"""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.physics._noise_kernels import normal, wander
from rotorpong.physics._vehicle_kernels import TICK
from rotorpong.physics.noise import NODES_PER_TIME
from rotorpong.world.court import FLOOR_HEIGHT, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH

NAVDATA_TICKS = 5  # 200 Hz, as both tum_simulator and the AR.Drone in full mode publish
CHANNELS = 11  # gyro 0:3, accelerometer 3:6, flow 6:9, heading 9, sonar 10
GYRO, FORCE, FLOW, HEADING, SONAR = 0, 3, 6, 9, 10
GYRO_BIAS, ATTITUDE_BIAS, FLOW_BIAS = 11, 14, 16
ATTITUDE_WHITE, ATTITUDE_RATE, SLOW, SLOW_TIME, GRAVITY, CHARGE, LIFE = range(19, 26)
NODE_DECAY = math.exp(-1.0 / NODES_PER_TIME)


@kernel
def measure(flown, first_tick, first, errors, keys, out):
    """Fill `out` with the samples at the ticks first, first + 5, ...

    Args:
        flown: position, seen velocity, quaternion, body rates, acceleration, a row per tick.
        first_tick: of the world, at the path's departure.
        first: tick of the first sample.
        errors: see above.
        keys: see above.
        out: times, body rates, acceleration, attitude, velocity, height, battery.
    """
    positions, velocities, quaternions, rates, accelerations = flown
    times, gyro, force, attitude, flow, height, battery = out
    n = times.shape[0]
    nodes = slow_nodes((first + NAVDATA_TICKS * (n - 1)) * TICK if n > 0 else -1.0, errors, keys[2])
    for i in range(n):
        tick = first + NAVDATA_TICKS * i
        at, time = tick - first_tick, tick * TICK
        sample = tick // NAVDATA_TICKS * CHANNELS
        battery[i] = max(0.0, errors[CHARGE] - time / errors[LIFE])
        height[i] = sonar(positions[at]) + white(keys[0], sample, errors, SONAR)
        roll, pitch, yaw = angles(quaternions[at])
        attitude[i, 0] = roll + attitude_error(time, 0, errors, keys[1], nodes)
        attitude[i, 1] = pitch + attitude_error(time, 1, errors, keys[1], nodes)
        attitude[i, 2] = yaw + white(keys[0], sample, errors, HEADING)
        level(velocities[at], yaw, flow[i])
        felt(accelerations[at], quaternions[at], errors[GRAVITY], force[i])
        times[i] = time
        for k in range(3):
            gyro[i, k] = rates[at, k] + errors[GYRO_BIAS + k]
            gyro[i, k] += white(keys[0], sample, errors, GYRO + k)
            force[i, k] += white(keys[0], sample, errors, FORCE + k)
            flow[i, k] += errors[FLOW_BIAS + k]
            flow[i, k] += white(keys[0], sample, errors, FLOW + k)


@kernel
def white(key, sample, errors, channel):
    """Return the white noise of one channel of a sample."""
    if errors[channel] == 0.0:
        return 0.0
    return errors[channel] * normal(key, sample + channel)


@kernel
def slow_nodes(last, errors, key):
    """Return the nodes (n, 2) of the slow process that reach up to the time `last`."""
    if last < 0.0 or errors[SLOW] == 0.0:
        return np.empty((0, 2))
    nodes = np.empty((int(last * (NODES_PER_TIME / errors[SLOW_TIME])) + 2, 2))
    wander(key, NODE_DECAY, nodes)
    return nodes


@kernel
def attitude_error(time, axis, errors, key, nodes):
    """Return how far roll (axis 0) or pitch (1) is off: white of its message, bias, slow."""
    error = errors[ATTITUDE_BIAS + axis]
    if errors[ATTITUDE_WHITE] > 0.0:
        message = math.floor(time * errors[ATTITUDE_RATE] + 1e-6)
        error += errors[ATTITUDE_WHITE] * normal(key, 2 * message + axis)
    if nodes.shape[0] > 0:
        place = time * (NODES_PER_TIME / errors[SLOW_TIME])
        node = int(place)
        share = place - node
        error += errors[SLOW] * ((1.0 - share) * nodes[node, axis] + share * nodes[node + 1, axis])
    return error


@kernel
def sonar(position):
    """Return the height above what lies below: the table top or the floor."""
    x, y, z = position[0], position[1], position[2]
    over_table = abs(x) <= TABLE_HALF_LENGTH and abs(y) <= TABLE_HALF_WIDTH
    return z if over_table and z >= 0.0 else z - FLOOR_HEIGHT


@kernel
def angles(quaternion):
    """Return roll, pitch, yaw."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    return roll, pitch, math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@kernel
def level(velocity, yaw, out):
    """Turn a velocity into the level axes of a heading."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    out[0] = cosine * velocity[0] + sine * velocity[1]
    out[1] = cosine * velocity[1] - sine * velocity[0]
    out[2] = velocity[2]


@kernel
def felt(acceleration, quaternion, gravity, out):
    """Write the specific force R' (a + (0, 0, g)) in body axes."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    a, b, c = acceleration[0], acceleration[1], acceleration[2] + gravity
    out[0] = (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c
    out[1] = 2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c
    out[2] = 2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c
