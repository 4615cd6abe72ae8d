"""Compiled flight of the profile `ardrone2`; the equations are in `ardrone2`.

Rows of `motion`: as in `_vehicle_kernels`. Rows of `memory`: roll, pitch, yaw, yaw rate 0:4; what
the drone obeys now 4:8 (roll, pitch, climb, yaw rate); roll and pitch of the loop's model 8:10, its
velocity 10:13, the offset of the measured from the modelled velocity 13:16; then, for the last
SLOTS periods of the loop, what was sent (4 each), the model's and the true velocity (3 each);
the held command in the last four. Rows of `counters`: ticks flown, messages received.
"""

import math

from rotorpong.kernels import kernel
from rotorpong.physics._noise_kernels import normal
from rotorpong.physics._vehicle_kernels import TICK

LOOP_TICKS = 5  # the loop runs on each navdata message, 200 Hz
PERIOD = LOOP_TICKS * TICK
SLOTS = 60  # periods that are remembered
SENT = 16
MODELLED = SENT + 4 * SLOTS
FLOWN = MODELLED + 3 * SLOTS
HELD = FLOWN + 3 * SLOTS
MEMORY_SIZE = HELD + 4
WHITE_STREAM, BIAS_STREAM = 0, 1
STREAM_LENGTH = 2**40


@kernel
def fly(
    profile, rows, motions, memories, counters, keys, commands, are_new, starts, ticks, poses, rest
):
    """Fly rows of a batch, in place.

    Args:
        profile: airframe, settings, loop, noise of the measured velocity, whether commands are raw.
        rows: which.
        motions: of the batch, a row each, as what follows.
        memories: see above.
        counters: see above.
        keys: of the noise.
        commands: as in `vehicle.Legs`, and what follows.
        are_new: whether a message brought the command.
        starts: instant of the tracks at which the leg begins.
        ticks: of the leg.
        poses: (n, :, 7) track of position and quaternion.
        rest: (n, :, 12) of velocity, body rates, acceleration and what navdata see of the velocity;
            (0, :, 12) if nobody asks for it.
    """
    airframe, _, loop, noise, _ = profile
    decays = weights(airframe), model_decays(loop)
    for m in range(rows.shape[0]):
        row = rows[m]
        memory, key = memories[row], keys[row]
        first = BIAS_STREAM * STREAM_LENGTH
        biases = (
            noise[1] * normal(key, first),
            noise[1] * normal(key, first + 1),
            noise[1] * normal(key, first + 2),
        )
        if are_new[row]:
            copy(commands[row], memory[HELD:])
            counters[row, 1] += 1
        state = motions[row], memory, counters[row], key
        leg = starts[row], ticks[row]
        fly_row(profile, decays, row, state, biases, leg, (poses, rest))


@kernel
def fly_row(profile, decays, row, state, biases, leg, tracks):
    """Fly one vehicle over its leg."""
    airframe, settings, loop, noise, raw = profile
    motion, memory, counter, key = state
    steps, model = decays
    start, ticks = leg
    lag = round(airframe.velocity_delay / PERIOD)
    thrust, heading = direction(motion), facing(memory[2])
    since_loop, k = counter[0] % LOOP_TICKS, counter[0] // LOOP_TICKS
    then = FLOWN + 3 * ((k - lag) % SLOTS)
    for i in range(ticks + 1):
        if i > 0:
            if since_loop == 0:
                if raw:
                    send_raw(memory, settings, k)
                else:
                    measured = measure(memory, k - lag, k, key, noise[0], biases)
                    control((loop, model), settings, memory, k, measured)
            thrust, heading = tick(airframe, motion, memory, counter, (steps, thrust, heading))
            since_loop += 1
        if since_loop % LOOP_TICKS == 0:
            k, since_loop = counter[0] // LOOP_TICKS, 0
            then = FLOWN + 3 * ((k - lag) % SLOTS)
            here = FLOWN + 3 * (k % SLOTS)
            for axis in range(3):
                memory[here + axis] = motion[3 + axis]
        record(tracks, row, start + i, motion, memory[then : then + 3])


@kernel
def record(tracks, row, i, motion, seen):
    """Write instant i of a row into its tracks."""
    poses, rest = tracks
    for k in range(3):
        poses[row, i, k] = motion[k]
    for k in range(4):
        poses[row, i, 3 + k] = motion[6 + k]
    if rest.shape[0] > 0:
        for k in range(3):
            rest[row, i, k], rest[row, i, 3 + k] = motion[3 + k], motion[10 + k]
            rest[row, i, 6 + k], rest[row, i, 9 + k] = motion[13 + k], seen[k]


@kernel
def copy(values, to):
    """Copy a row."""
    for i in range(values.shape[0]):
        to[i] = values[i]


@kernel
def weights(airframe):
    """Return what one tick needs of the constants: decays, and weights of the thrust."""
    drag = airframe.drag
    decay = math.exp(-drag * TICK)
    whole = (1.0 - decay) / drag
    late = (1.0 - whole / TICK) / drag
    return (
        math.exp(-TICK / airframe.tilt_lag),
        decay,
        whole - late,
        late,
        math.exp(-airframe.climb_rate * TICK),
        math.exp(-airframe.turn_rate * TICK),
        round(airframe.dead_time / TICK),
    )


@kernel
def direction(motion):
    """Return the horizontal part of the body's upward axis."""
    w, x, y, z = motion[6], motion[7], motion[8], motion[9]
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)


@kernel
def tick(airframe, motion, memory, counter, step):
    """Advance one drone by one tick; return where its thrust then points, and its heading."""
    steps, (here_x, here_y), heading = step
    tilt_decay, decay, early, late, climb_decay, turn_decay, dead_ticks = steps
    since = counter[0] - dead_ticks
    if since >= 0 and since % LOOP_TICKS == 0:
        heard = SENT + 4 * (since // LOOP_TICKS % SLOTS)
        for channel in range(4):
            memory[4 + channel] = memory[heard + channel]
    charge = max(0.0, airframe.battery_charge - counter[0] * TICK / airframe.battery_life)
    strength = 1.0 - airframe.battery_sag * (1.0 - charge)
    heading = turn(airframe, motion, memory, (tilt_decay, turn_decay), heading)
    there_x, there_y = direction(motion)
    force, drag = strength * airframe.pull, airframe.drag
    vx, vy, vz = motion[3], motion[4], motion[5]
    ux = decay * vx + force * (early * here_x + late * there_x)
    uy = decay * vy + force * (early * here_y + late * there_y)
    climb = strength * airframe.climb_gain * memory[6]
    uz = climb + (vz - climb) * climb_decay
    bend = TICK * TICK / 12.0
    change_x = force * (here_x - there_x) - drag * (vx - ux)
    change_y = force * (here_y - there_y) - drag * (vy - uy)
    motion[0] += 0.5 * TICK * (vx + ux) + bend * change_x
    motion[1] += 0.5 * TICK * (vy + uy) + bend * change_y
    motion[2] += 0.5 * TICK * (vz + uz) + bend * airframe.climb_rate * (uz - vz)
    motion[3], motion[4], motion[5] = ux, uy, uz
    motion[13], motion[14], motion[15] = (ux - vx) / TICK, (uy - vy) / TICK, (uz - vz) / TICK
    counter[0] += 1
    return (there_x, there_y), heading


@kernel
def facing(yaw):
    """Return a yaw with cosine and sine of its half, which stay good while it does."""
    return yaw, math.cos(0.5 * yaw), math.sin(0.5 * yaw)


@kernel
def turn(airframe, motion, memory, decays, heading):
    """Let the attitude follow what it obeys for one tick; fill quaternion and body rates."""
    tilt_decay, turn_decay = decays
    roll = memory[4] + (memory[0] - memory[4]) * tilt_decay
    pitch = memory[5] + (memory[1] - memory[5]) * tilt_decay
    excess = memory[3] - memory[7]
    yaw = memory[2] + memory[7] * TICK + excess * (1.0 - turn_decay) / airframe.turn_rate
    yaw_rate = memory[7] + excess * turn_decay
    memory[0], memory[1], memory[2], memory[3] = roll, pitch, yaw, yaw_rate
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    if yaw != heading[0]:
        heading = facing(yaw)
    _, cy, sy = heading
    motion[6] = cr * cp * cy + sr * sp * sy
    motion[7] = sr * cp * cy - cr * sp * sy
    motion[8] = cr * sp * cy + sr * cp * sy
    motion[9] = cr * cp * sy - sr * sp * cy
    rolling = (memory[4] - roll) / airframe.tilt_lag
    pitching = (memory[5] - pitch) / airframe.tilt_lag
    sin_roll, cos_roll = 2.0 * sr * cr, 1.0 - 2.0 * sr * sr
    sin_pitch, cos_pitch = 2.0 * sp * cp, 1.0 - 2.0 * sp * sp
    motion[10] = rolling - yaw_rate * sin_pitch
    motion[11] = pitching * cos_roll + yaw_rate * sin_roll * cos_pitch
    motion[12] = yaw_rate * cos_roll * cos_pitch - pitching * sin_roll
    return heading


@kernel
def measure(memory, index, k, key, white, biases):
    """Return the velocity of period `index` with its bias and the white noise of message k."""
    then = FLOWN + 3 * (index % SLOTS)
    first = WHITE_STREAM * STREAM_LENGTH + 3 * k
    return (
        memory[then] + white * normal(key, first) + biases[0],
        memory[then + 1] + white * normal(key, first + 1) + biases[1],
        memory[then + 2] + white * normal(key, first + 2) + biases[2],
    )


@kernel
def send_raw(memory, settings, k):
    """Send the held command as fractions of the limits."""
    put(
        memory,
        k,
        -settings.tilt_limit * min(max(memory[HELD + 1], -1.0), 1.0),
        settings.tilt_limit * min(max(memory[HELD], -1.0), 1.0),
        (
            settings.climb_limit * min(max(memory[HELD + 2], -1.0), 1.0),
            settings.turn_limit * min(max(memory[HELD + 3], -1.0), 1.0),
        ),
    )


@kernel
def put(memory, k, roll, pitch, rest):
    """Remember what is sent in period k."""
    here = SENT + 4 * (k % SLOTS)
    memory[here], memory[here + 1] = roll, pitch
    memory[here + 2], memory[here + 3] = rest


@kernel
def model_decays(loop):
    """Return by how much tilt, velocity and climb of the loop's model decay in one period."""
    return (
        math.exp(-PERIOD / loop.tilt_lag),
        math.exp(-loop.drag * PERIOD),
        math.exp(-loop.climb_rate * PERIOD),
    )


@kernel
def control(model, settings, memory, k, measured):
    """Predict the velocity at which a tilt sent now begins to act, and send one that steers it."""
    loop, decays = model
    follow_model(loop, decays, memory, k)
    delay = round((loop.dead_time + loop.velocity_delay) / PERIOD)
    then = MODELLED + 3 * ((k - delay) % SLOTS)
    share = PERIOD / loop.offset_time
    for axis in range(3):
        offset = memory[13 + axis]
        memory[13 + axis] += share * (measured[axis] - memory[then + axis] - offset)
    vx, vy, vz = memory[10] + memory[13], memory[11] + memory[14], memory[12] + memory[15]
    cosine, sine = math.cos(memory[2]), math.sin(memory[2])
    forward, left = cosine * vx + sine * vy, cosine * vy - sine * vx
    top = math.sin(settings.tilt_limit)
    own_forward = cosine * memory[10] + sine * memory[11]
    own_left = cosine * memory[11] - sine * memory[10]
    side = (loop.drag * own_left + loop.gain * (memory[HELD + 1] - left)) / loop.pull
    roll = -math.asin(min(max(side, -top), top))
    ahead = loop.drag * own_forward + loop.gain * (memory[HELD] - forward)
    ahead = ahead / (loop.pull * math.cos(roll))
    pitch = math.asin(min(max(ahead, -top), top))
    climb = memory[12] + loop.gain * (memory[HELD + 2] - vz) / loop.climb_rate
    climb = min(max(climb, -settings.climb_limit), settings.climb_limit)
    yaw_rate = min(max(memory[HELD + 3], -settings.turn_limit), settings.turn_limit)
    put(memory, k, roll, pitch, (climb, yaw_rate))


@kernel
def follow_model(loop, decays, memory, k):
    """Let the loop's own drone, which has no dead time, fly one period by what was sent."""
    if k > 0:
        sent = SENT + 4 * ((k - 1) % SLOTS)
        tilt_decay, decay, climb_decay = decays
        roll = memory[sent] + (memory[8] - memory[sent]) * tilt_decay
        pitch = memory[sent + 1] + (memory[9] - memory[sent + 1]) * tilt_decay
        middle_roll, middle_pitch = 0.5 * (roll + memory[8]), 0.5 * (pitch + memory[9])
        memory[8], memory[9] = roll, pitch
        cosine, sine = math.cos(memory[2]), math.sin(memory[2])
        ahead = math.sin(middle_pitch) * math.cos(middle_roll) * loop.pull / loop.drag
        left = -math.sin(middle_roll) * loop.pull / loop.drag
        x, y, z = cosine * ahead - sine * left, sine * ahead + cosine * left, memory[sent + 2]
        memory[10] = x + (memory[10] - x) * decay
        memory[11] = y + (memory[11] - y) * decay
        memory[12] = z + (memory[12] - z) * climb_decay
    here = MODELLED + 3 * (k % SLOTS)
    for axis in range(3):
        memory[here + axis] = memory[10 + axis]
