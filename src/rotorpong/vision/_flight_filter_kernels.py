"""The filter of `flight_filter`, compiled: flow and its slopes, prediction, updates, crossing."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rotorpong.kernels import kernel
from rotorpong.physics._ball_kernels import bounce, step
from rotorpong.physics._flight_fit_kernels import fall_fraction
from rotorpong.physics.ball import Air, Surface

SIZE = 16  # of the state; its parts begin at
POSITION, VELOCITY, SPIN, DRAG, SWELLING, TILT, LEVEL = 0, 3, 6, 9, 10, 11, 14
FLOWN, MOVING, INPUTS = 9, 10, 13  # what flows; what it depends on; restitution, friction, height
STEP = 0.01  # s; leaves 1e-7 m in a whole flight
ROOT_STEPS, ROOT_TOLERANCE = 40, 1e-12
NUDGES = np.array([1e-5] * 3 + [1e-4] * 3 + [1e-2] * 3 + [1e-4] * 3 + [1e-5])  # of the inputs
ITERATIONS, CONVERGED = 5, 1e-9  # of an update; squared steps, in standard deviations
MOST_BOUNCES = 2  # in a step
BACK = 1e-9  # m above the table where a ball is put that bounced


@kernel
def advance(inputs, dt, air, work):
    """Fly the state in work[0] on by dt over the table; return how often it bounced."""
    state, after = work[0], work[1]
    height = inputs[12] + BALL_RADIUS
    rest, count = dt, 0
    for _ in range(MOST_BOUNCES):
        step(state, rest, air, after)
        if state[2] < height or after[2] >= height:
            break
        share = fall_fraction(state, rest, air, height, after)
        step(state, share * rest, air, after)
        if abs(after[0]) > TABLE_HALF_LENGTH or abs(after[1]) > TABLE_HALF_WIDTH:
            step(state, rest, air, after)
            break
        bounce(after, work[2, :3], work[2, 3:6], Surface(inputs[10], inputs[11]))
        after[2] = height + BACK
        state[:] = after
        rest *= 1.0 - share
        count += 1
    if count == MOST_BOUNCES:  # it hardly leaves the table any more
        step(state, rest, air, after)
        if after[2] < height:
            after[2], after[5] = height + BACK, 0.0
    state[:] = after
    return count


@kernel
def begin(inputs, law, work):
    """Lay a flight out in `work`; return its air."""
    work[0] = inputs[:FLOWN]
    work[2] = 0.0
    work[2, 2] = 1.0
    return Air(inputs[DRAG], law.magnus, law.spin_decay, law.saturation)


@kernel
def flow(inputs, dt, law, work):
    """Fly by dt >= 0 into work[0], bouncing where the table is; return how often.

    Args:
        inputs: (13,) position, velocity, spin, drag, restitution, friction, table height.
        dt: s.
        law: the air, whose drag is not read.
        work: (3, 9) scratch.
    """
    air = begin(inputs, law, work)
    count, steps = 0, max(1, math.ceil(dt / STEP))
    for _ in range(steps):
        count += advance(inputs, dt / steps, air, work)
    return count


@kernel
def fly_to(inputs, plane, longest, law, work):
    """Fly into work[0] until normal . p = offset is reached.

    Args:
        inputs: as `flow` takes them.
        plane: (4,) normal and offset.
        longest: s.
        law: the air.
        work: (3, 9) scratch.

    Returns:
        When, nan if it is not, and after how many bounces.
    """
    air = begin(inputs, law, work)
    before, time, count = np.empty(FLOWN), 0.0, 0
    gap = beyond(work[0], plane)
    while time < longest:
        before[:] = work[0]
        bounces = advance(inputs, STEP, air, work)
        new = beyond(work[0], plane)
        if gap * new <= 0.0:
            a, b, fa, fb, c = 0.0, 1.0, gap, new, 1.0
            for k in range(ROOT_STEPS):
                c = b - fb * (b - a) / (fb - fa) if k % 3 < 2 and fa != fb else 0.5 * (a + b)
                work[0] = before
                bounces = advance(inputs, c * STEP, air, work)
                fc = beyond(work[0], plane)
                if abs(fc) < ROOT_TOLERANCE:
                    break
                if fa * fc > 0.0:
                    a, fa = c, fc
                else:
                    b, fb = c, fc
            return time + c * STEP, count + bounces
        gap = new
        time += STEP
        count += bounces
    return math.nan, count


@kernel
def beyond(state, plane):
    """Return the distance of a ball's centre from a plane, signed."""
    return plane[0] * state[0] + plane[1] * state[1] + plane[2] * state[2] - plane[3]


@kernel
def inputs_of(mean, table):
    """Return what the flow takes: the moving part of a state, and the table's numbers."""
    inputs = np.empty(INPUTS)
    inputs[:MOVING] = mean[:MOVING]
    inputs[MOVING:] = table
    return inputs


@kernel
def flow_slopes(inputs, dt, law, slopes, work):
    """Write d(flow)/d(inputs) (9, 13) by central differences; return the bounces of the flow.

    Where a nudged flight bounces more or less often, the difference is one-sided.
    """
    count = flow(inputs, dt, law, work)
    end = work[0].copy()
    columns = INPUTS if count > 0 else MOVING
    slopes[:] = 0.0
    for j in range(columns):
        x = inputs[j]
        inputs[j] = x + NUDGES[j]
        up_count = flow(inputs, dt, law, work)
        up = work[0].copy() if up_count == count else end
        inputs[j] = x - NUDGES[j]
        down_count = flow(inputs, dt, law, work)
        down = work[0] if down_count == count else end
        inputs[j] = x
        sides = int(up_count == count) + int(down_count == count)
        if sides > 0:
            for i in range(FLOWN):
                slopes[i, j] = (up[i] - down[i]) / (sides * NUDGES[j])
    work[0] = end
    return count


@kernel
def predict(mean, covariance, dt, law, table, spreads, walks):
    """Carry a belief on by dt, in place; return the bounces.

    Args:
        mean: (16,).
        covariance: (16, 16).
        dt: s.
        law: the air.
        table: (3,) restitution, friction, height.
        spreads: (3,) their standard deviations.
        walks: (2,) m/s^2/sqrt(Hz) of unmodelled acceleration, rad/sqrt(s) of the gyro's tilt.
    """
    transition = np.empty((SIZE, SIZE))
    return carry(mean, covariance, dt, law, table, spreads, walks, transition)


@kernel
def carry(mean, covariance, dt, law, table, spreads, walks, transition):
    """Do as `predict` does, and write the slopes of the step, (16, 16)."""
    work, slopes = np.empty((3, FLOWN)), np.empty((FLOWN, INPUTS))
    count = flow_slopes(inputs_of(mean, table), dt, law, slopes, work)
    transition[:] = np.eye(SIZE)
    transition[:FLOWN, :MOVING] = slopes[:, :MOVING]
    covariance[:] = transition @ covariance @ transition.T
    mean[:FLOWN] = work[0]
    for i in range(3):
        q = walks[0] ** 2
        covariance[i, i] += q * dt**3 / 3.0
        covariance[i, VELOCITY + i] += q * dt**2 / 2.0
        covariance[VELOCITY + i, i] += q * dt**2 / 2.0
        covariance[VELOCITY + i, VELOCITY + i] += q * dt
        covariance[TILT + i, TILT + i] += walks[1] ** 2 * dt
    if count > 0:
        for k in range(3):
            for i in range(FLOWN):
                for j in range(FLOWN):
                    covariance[i, j] += (
                        slopes[i, MOVING + k] * slopes[j, MOVING + k] * spreads[k] ** 2
                    )
    return count


@kernel
def look(mean, pose, expected, slopes):
    """Write what a sight would be, (X/Z, Y/Z, angular radius), and its slopes (3, 16).

    Without a camera it is the ball's place itself.

    Args:
        mean: (16,).
        pose: (12,) camera's place in the world, and rows of the rotation to it from the world;
            NaN where there is no camera.
        expected: (3,).
        slopes: (3, 16).

    Returns:
        Whether the ball is before the camera.
    """
    slopes[:] = 0.0
    if math.isnan(pose[0]):
        for i in range(3):
            expected[i], slopes[i, i] = mean[i], 1.0
        return True
    rx, ry, rz = mean[0] - pose[0], mean[1] - pose[1], mean[2] - pose[2]
    tx, ty, tz = mean[TILT], mean[TILT + 1], mean[TILT + 2]
    wx, wy, wz = rx - (ty * rz - tz * ry), ry - (tz * rx - tx * rz), rz - (tx * ry - ty * rx)
    x = pose[3] * wx + pose[4] * wy + pose[5] * wz
    y = pose[6] * wx + pose[7] * wy + pose[8] * wz
    z = pose[9] * wx + pose[10] * wy + pose[11] * wz
    squared = x * x + y * y + z * z
    if z <= 2.0 * BALL_RADIUS or squared <= 4.0 * BALL_RADIUS**2:
        return False
    distance = math.sqrt(squared)
    sine = BALL_RADIUS / distance
    expected[0], expected[1], expected[2] = x / z, y / z, math.asin(sine) + mean[SWELLING]
    falling = -sine / (squared * math.sqrt(1.0 - sine * sine))
    a = np.array([[1.0 / z, 0.0, -x / z**2], [0.0, 1.0 / z, -y / z**2],
                  [falling * x, falling * y, falling * z]])  # fmt: skip
    for i in range(3):
        gx = a[i, 0] * pose[3] + a[i, 1] * pose[6] + a[i, 2] * pose[9]
        gy = a[i, 0] * pose[4] + a[i, 1] * pose[7] + a[i, 2] * pose[10]
        gz = a[i, 0] * pose[5] + a[i, 1] * pose[8] + a[i, 2] * pose[11]
        slopes[i, 0] = gx - (gy * tz - gz * ty)
        slopes[i, 1] = gy - (gz * tx - gx * tz)
        slopes[i, 2] = gz - (gx * ty - gy * tx)
        slopes[i, TILT] = gz * -ry + gy * rz
        slopes[i, TILT + 1] = gx * -rz + gz * rx
        slopes[i, TILT + 2] = gy * -rx + gx * ry
    slopes[2, SWELLING] = 1.0
    return True


@kernel
def update(mean, covariance, seen, noise, pose):
    """Take in a sight, in place, by iterated updates; return its NIS, inf if it cannot be.

    Args:
        mean: (16,).
        covariance: (16, 16).
        seen: (3,) X/Z, Y/Z, angular radius.
        noise: (3, 3) its covariance.
        pose: as `look` takes it.
    """
    expected, slopes = np.empty(3), np.empty((3, SIZE))
    guess, first = mean.copy(), math.inf
    gain, spread = np.zeros((SIZE, 3)), np.zeros((3, 3))
    for k in range(ITERATIONS):
        if not look(guess, pose, expected, slopes):
            return math.inf
        across = covariance @ slopes.T
        spread = slopes @ across + noise
        error = seen - expected + slopes @ (guess - mean)
        inverse = np.linalg.inv(spread)
        if k == 0:
            first = error @ inverse @ error
        gain = across @ inverse
        after = mean + gain @ error
        moved = 0.0
        for i in range(SIZE):
            moved = max(moved, (after[i] - guess[i]) ** 2 / (covariance[i, i] + 1e-300))
        guess = after
        if moved < CONVERGED:
            break
    kept = np.eye(SIZE) - gain @ slopes
    covariance[:] = kept @ covariance @ kept.T + gain @ noise @ gain.T
    mean[:] = guess
    return first


@kernel
def level(mean, covariance, seen, heading, variance):
    """Take in a reading of roll and pitch beyond those of the gyro's path, in place.

    Args:
        mean: (16,).
        covariance: (16, 16).
        seen: (2,) rad.
        heading: rad.
        variance: rad^2, of each.
    """
    c, s = math.cos(heading), math.sin(heading)
    for axis in range(2):
        slope = np.zeros(SIZE)
        slope[TILT], slope[TILT + 1] = (c, s) if axis == 0 else (-s, c)
        slope[LEVEL + axis] = 1.0
        across = covariance @ slope
        spread = slope @ across + variance
        error = seen[axis] - slope @ mean
        mean += across * (error / spread)
        covariance -= np.outer(across, across) / spread


@kernel
def crossing(mean, covariance, plane, longest, law, table, spreads, out):
    """Predict where a plane is crossed; return when (s from now), nan if it is not.

    Args:
        mean: (16,).
        covariance: (16, 16).
        plane: (4,) normal and offset.
        longest: s.
        law: the air.
        table: (3,) restitution, friction, height.
        spreads: (3,) their standard deviations.
        out: (7, 8), written: first column place, velocity and time of the crossing, the others
            their covariance. Slopes are central differences, one-sided as those of `flow_slopes`.
    """
    work, inputs = np.empty((3, FLOWN)), inputs_of(mean, table)
    time, count = fly_to(inputs, plane, longest, law, work)
    if math.isnan(time):
        return time
    end, slopes, nudged = np.empty(7), np.zeros((7, INPUTS)), np.empty((2, 7))
    end[:6], end[6] = work[0, :6], time
    for j in range(INPUTS):
        x, sides = inputs[j], 0
        for k in range(2):
            inputs[j] = x + (1 - 2 * k) * NUDGES[j]
            other, other_count = fly_to(inputs, plane, longest, law, work)
            if math.isnan(other) or other_count != count:
                nudged[k] = end
                continue
            sides += 1
            nudged[k, :6], nudged[k, 6] = work[0, :6], other
        inputs[j] = x
        if sides > 0:
            slopes[:, j] = (nudged[0] - nudged[1]) / (sides * NUDGES[j])
    spread = np.zeros((INPUTS, INPUTS))
    spread[:MOVING, :MOVING] = covariance[:MOVING, :MOVING]
    for k in range(3):
        spread[MOVING + k, MOVING + k] = spreads[k] ** 2
    out[:, 0] = end
    out[:, 1:] = slopes @ spread @ slopes.T
    return time
