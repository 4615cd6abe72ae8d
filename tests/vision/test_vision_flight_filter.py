import math
from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from rotorpong.conventions import BALL_RADIUS, CAMERA_FROM_BODY_AXES, InputError
from rotorpong.physics.ball import Air
from rotorpong.vision import _flight_filter_kernels as kernels
from rotorpong.vision import flight_filter
from rotorpong.vision.flight_filter import (
    HUMAN_PRIOR,
    Sight,
    begun,
    crossing,
    fit_window,
    ground,
    place,
    predict,
    read_level,
    update,
)
from rotorpong.world.contact import Solids, fly_over_court, state_of
from rotorpong.world.court import TABLE_HALF_LENGTH
from rotorpong.world.serves import HUMAN, draw

FIRST = 4  # sights, whose NIS is mostly the prior's
EYE = np.array([-1.69, 0.0, 0.20])
PLANE = -1.65  # m, x
FOCAL = 1124.0
SDS = np.array([0.10, 0.10, 0.08]) / FOCAL
LEVEL = replace(
    HUMAN_PRIOR,
    spin_sd=20.0,
    drag_sd=1e-6,
    unmodelled=1e-4,
    restitution=(HUMAN_PRIOR.restitution[0], 1e-6),
    friction=(HUMAN_PRIOR.friction[0], 1e-6),
    table=(0.0, 1e-6),
    attitude=replace(HUMAN_PRIOR.attitude, start_sd=1e-7, reading_offset_sd=0.0, walk=1e-9),
)
"""All but ball and spin is known."""


def seen_from(ball, turn=None):
    """Return (X/Z, Y/Z, angular radius) of a ball, the camera's body turned by a rotation."""
    rotation = CAMERA_FROM_BODY_AXES if turn is None else CAMERA_FROM_BODY_AXES @ turn.T
    x, y, z = rotation @ (ball[:3] - EYE)
    return np.array([x / z, y / z, math.asin(BALL_RADIUS / math.sqrt(x * x + y * y + z * z))])


def sight(time, ball, *, rng=None, turn=None):
    seen = seen_from(ball, turn)
    if rng is not None:
        seen = seen + SDS * rng.standard_normal(3)
    return Sight(time, seen, np.diag(SDS**2), EYE, CAMERA_FROM_BODY_AXES)


def watched(seed, *, until=0.45, turn=None):
    """Return a human serve's true states and noisy sights at 30 frames/s, and its whole path."""
    rng = np.random.default_rng(seed)
    serve = draw(HUMAN, rng)
    path = fly_over_court(state_of(serve.ball), 1500, Solids())
    ticks = np.arange(0, int(1000 * until), 33)
    sights = [sight(1e-3 * k, path[k], rng=rng, turn=turn) for k in ticks]
    return path[ticks], sights, path


def filtered(sights, prior=LEVEL):
    """Return the belief after all sights, and the NIS of those after the first four."""
    belief, levels = flight_filter.filtered(ground(prior, 0.0), sights, prior)
    return belief, levels[FIRST - 1 :]


def some_mean(seed=0):
    rng = np.random.default_rng(seed)
    mean = np.zeros(kernels.SIZE)
    mean[:3] = [1.0, 0.2, 0.3]
    mean[3:6] = [-6.0, 0.4, 1.5]
    mean[6:9] = rng.normal(0.0, 30.0, 3)
    mean[9], mean[10], mean[11:14] = 0.15, 1e-4, [0.004, -0.003, 0.002]
    return mean


def pose(turn=None):
    rotation = CAMERA_FROM_BODY_AXES if turn is None else CAMERA_FROM_BODY_AXES @ turn.T
    return np.concatenate([EYE, rotation.ravel()])


def test_slopes_of_a_sight_are_its_differences():
    mean, step = some_mean(), 1e-7
    expected, slopes = np.empty(3), np.empty((3, kernels.SIZE))
    there = pose(Rotation.from_euler("xyz", [0.05, -0.1, 0.2]).as_matrix())
    assert kernels.look(mean, there, expected, slopes)
    up, down, unused = np.empty(3), np.empty(3), np.empty((3, kernels.SIZE))
    for k in range(kernels.SIZE):
        nudge = step * np.eye(kernels.SIZE)[k]
        kernels.look(mean + nudge, there, up, unused)
        kernels.look(mean - nudge, there, down, unused)
        assert slopes[:, k] == pytest.approx((up - down) / (2 * step), abs=1e-6)


def test_tilt_turns_what_the_camera_sees():
    """To first order a tilt t is the rotation vector by which the true attitude leads."""
    mean, tilt = some_mean(), np.array([0.002, -0.001, 0.0015])
    mean[10], mean[11:14] = 0.0, tilt
    expected, slopes = np.empty(3), np.empty((3, kernels.SIZE))
    kernels.look(mean, pose(), expected, slopes)
    true = seen_from(mean[:3], Rotation.from_rotvec(tilt).as_matrix())
    assert expected == pytest.approx(true, abs=1e-5)


def test_a_prediction_is_the_worlds_flight_bounce_included():
    states, _, path = watched(3)
    mean = ground(LEVEL, 0.0).mean
    mean[:9] = states[0]
    start = replace(ground(LEVEL, 0.0), mean=mean)
    low = int(np.argmax(np.diff(path[:, 5]) > 1.0))  # the tick of the bounce
    for tick in (100, low - 1, low + 2, 1000):
        end = predict(start, 1e-3 * tick, LEVEL)
        assert end.mean[:9] == pytest.approx(path[tick], abs=1e-6)
    through = predict(start, 1e-3 * (low + 30), LEVEL, bounces=False)
    assert through.position[2] < BALL_RADIUS


def test_covariance_through_a_bounce_is_that_of_many_flights():
    """2,000 flights: the standard error of a variance is 3 %; 12 % are 4 sigma."""
    _, _, path = watched(3)
    low = int(np.argmax(np.diff(path[:, 5]) > 1.0))
    prior = replace(LEVEL, restitution=(0.94, 0.01), friction=(0.23, 0.02), table=(0.0, 0.002))
    sds = np.array([0.002] * 3 + [0.02] * 3 + [5.0] * 3 + [0.005])
    covariance, mean = np.zeros((16, 16)), np.zeros(16)
    covariance[np.arange(10), np.arange(10)] = sds**2
    mean[:9], mean[9] = path[low - 20], 0.15
    belief = predict(replace(ground(prior, 0.0), mean=mean, covariance=covariance), 0.04, prior)
    rng, ends, work = np.random.default_rng(0), [], np.empty((3, 9))
    for _ in range(2000):
        moved = mean[:10] + sds * rng.standard_normal(10)
        table = np.array([0.94, 0.23, 0.0]) + [0.01, 0.02, 0.002] * rng.standard_normal(3)
        kernels.flow(np.concatenate([moved, table]), 0.04, Air(), work)
        ends.append(work[0].copy())
    spread = np.cov(np.array(ends).T)
    found = belief.covariance[:9, :9]
    assert np.sqrt(np.diag(found)) == pytest.approx(np.sqrt(np.diag(spread)), rel=0.08)
    scale = np.sqrt(np.outer(np.diag(spread), np.diag(spread)))
    assert np.abs((found - spread) / scale).max() < 0.12


def test_the_filter_is_consistent():
    """Mean NIS of 60 serves, 9 sights each, is 3 within 4 sigma; so is that of the errors, 6."""
    nis, errors = [], []
    for seed in range(60):
        states, sights, _ = watched(seed)
        belief, levels = filtered(sights)
        nis += levels
        error = belief.mean[:6] - states[-1, :6]
        errors.append(error @ np.linalg.solve(belief.covariance[:6, :6], error))
    assert np.mean(nis) == pytest.approx(3.0, abs=4.0 * np.sqrt(6.0 / len(nis)))
    assert np.mean(errors) == pytest.approx(6.0, abs=4.0 * np.sqrt(12.0 / len(errors)))


def test_the_filter_comes_near_the_cramer_rao_bound():
    """The bound: inverse information of all sights, carried to the last; 60 serves, 4 sigma."""
    ratios = []
    for seed in range(60):
        states, sights, _ = watched(seed)
        belief, _ = filtered(sights)
        fit, _ = fit_window(ground(LEVEL, 0.0), sights, LEVEL)
        bound = predict(fit, sights[-1].time, LEVEL).covariance[:6, :6]
        error = belief.mean[:6] - states[-1, :6]
        ratios.append(error**2 / np.diag(bound))
    assert np.mean(ratios, axis=0) == pytest.approx(np.ones(6), abs=4.0 * np.sqrt(2.0 / 60))


def test_a_flight_begun_anew_knows_what_the_gyro_walked():
    """40 serves, tilt walks by 0.5 degrees/sqrt(s): NIS of the next sight is 3 within 4 sigma."""
    walk, levels = math.radians(0.5), []
    prior = replace(LEVEL, attitude=replace(LEVEL.attitude, walk=walk))
    for seed in range(40):
        rng = np.random.default_rng(1000 + seed)
        states, _, _ = watched(seed)
        tilt, sights = np.zeros(3), []
        for k, state in enumerate(states):
            time = 0.033 * k
            turn = Rotation.from_rotvec(tilt).as_matrix()
            sights.append(sight(time, state, rng=rng, turn=turn))
            tilt = tilt + walk * math.sqrt(0.033) * rng.standard_normal(3)
        belief, _ = begun(ground(prior, 0.0), sights[:-1], prior)
        levels.append(flight_filter.seen(belief, sights[-1], prior)[1])
    assert np.mean(levels) == pytest.approx(3.0, abs=4.0 * np.sqrt(6.0 / len(levels)))


def test_sights_that_no_flight_explains_have_levels_that_say_so():
    _, sights, _ = watched(5)
    moved = replace(sights[6], seen=sights[6].seen + np.array([0.05, 0.0, 0.0]))
    _, levels = begun(ground(LEVEL, 0.0), [*sights[:6], moved, *sights[7:]], LEVEL)
    _, good = begun(ground(LEVEL, 0.0), sights, LEVEL)
    assert levels.sum() > 1000.0
    assert good.sum() < 3 * len(sights) + 4.0 * np.sqrt(6.0 * len(sights))


def test_a_window_is_the_least_squares_solution():
    _, sights, _ = watched(5)
    fit, cost = fit_window(ground(LEVEL, 0.0), sights, LEVEL)
    known = place(ground(LEVEL, 0.0), sights[0])
    free = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8])
    sds = np.sqrt(np.diag(known.covariance))[free]
    work = np.empty((3, 9))
    table = np.array([LEVEL.restitution[0], LEVEL.friction[0], 0.0])

    def residuals(moving):
        found = [(moving - known.mean[free]) / sds]
        for one in sights:
            kernels.flow(np.concatenate([moving, [0.15], table]), one.time, Air(), work)
            found.append((one.seen - seen_from(work[0])) / SDS)
        return np.concatenate(found)

    wanted = least_squares(residuals, fit.mean[free] + 0.1 * sds * 1e-2, xtol=1e-15, ftol=1e-15)
    assert fit.mean[:6] == pytest.approx(wanted.x[:6], abs=2e-3)
    assert cost == pytest.approx(2.0 * wanted.cost, rel=1e-3)


def test_an_unknown_bias_of_the_radius_is_found():
    states, sights, _ = watched(7)
    swollen = [replace(s, seen=s.seen - np.array([0.0, 0.0, 0.37 / FOCAL])) for s in sights]
    ignorant, _ = filtered(swollen)
    aware, _ = filtered(swollen, replace(LEVEL, swelling_sd=0.5 / FOCAL))
    wrong, right = (abs(b.position[0] - states[-1, 0]) for b in (ignorant, aware))
    assert right < 0.02 < wrong
    assert aware.mean[kernels.SWELLING] == pytest.approx(-0.37 / FOCAL, abs=0.1 / FOCAL)


def test_readings_of_the_level_tell_the_tilt():
    quality = replace(LEVEL.attitude, start_sd=math.radians(1.0))
    belief = ground(replace(LEVEL, attitude=quality), 0.0)
    tilt, rng = np.radians([0.8, -0.6, 0.0]), np.random.default_rng(0)
    heading = 0.3
    cosine, sine = math.cos(heading), math.sin(heading)
    true = np.array([cosine * tilt[0] + sine * tilt[1], -sine * tilt[0] + cosine * tilt[1]])
    for _ in range(400):
        belief = read_level(belief, true + rng.normal(0.0, 0.03, 2), heading, 0.03)
    assert belief.mean[11:13] == pytest.approx(tilt[:2], abs=4.0 * 0.03 / 20.0)
    assert belief.covariance[11, 11] == pytest.approx(0.03**2 / 400, rel=0.05)


def test_a_crossing_is_where_the_world_has_it_and_its_covariance_holds():
    """30 serves: mean squared error over covariance is 2 (left, up) within 4 sigma."""
    squares = []
    for seed in range(30):
        _, sights, path = watched(seed, until=0.60)
        belief, _ = filtered(sights)
        found = crossing(belief, np.array([1.0, 0.0, 0.0]), PLANE, LEVEL)
        k = int(np.argmax(path[:, 0] < PLANE))
        share = (path[k - 1, 0] - PLANE) / (path[k - 1, 0] - path[k, 0])
        there = path[k - 1] + share * (path[k] - path[k - 1])
        error = (found.position - there[:3])[1:]
        assert found.position[0] == pytest.approx(PLANE, abs=1e-9)
        assert found.time == pytest.approx(1e-3 * (k - 1 + share), abs=0.02)
        squares.append(error @ np.linalg.solve(found.covariance[1:3, 1:3], error))
    assert np.mean(squares) == pytest.approx(2.0, abs=4.0 * np.sqrt(4.0 / 30))


def test_a_ball_that_flies_away_crosses_nothing():
    mean = ground(LEVEL, 0.0).mean
    mean[:6] = [1.0, 0.0, 0.5, 6.0, 0.0, 1.0]
    belief = replace(ground(LEVEL, 0.0), mean=mean)
    assert crossing(belief, np.array([1.0, 0.0, 0.0]), PLANE, LEVEL) is None


def test_there_is_no_prediction_of_the_past():
    with pytest.raises(InputError, match="later time"):
        predict(ground(LEVEL, 1.0), 0.9, LEVEL)
    with pytest.raises(InputError, match="later time"):
        predict(ground(LEVEL, 1.0), math.nan, LEVEL)


def test_a_ball_behind_the_camera_is_no_sight():
    mean = some_mean()
    mean[0] = -3.0
    belief = replace(ground(LEVEL, 0.0), mean=mean)
    _, nis = update(belief, sight(0.0, np.array([1.0, 0.0, 0.3])))
    assert math.isinf(nis)


def test_prediction_and_update_are_those_of_filterpy():
    """Its EKF takes the flow's and the sight's slopes by scipy; one step, near the prediction."""
    prior = replace(LEVEL, unmodelled=0.3)
    belief, _ = filtered(watched(4)[1], prior)
    after = predict(belief, belief.time + 0.03, prior)
    work, table = np.empty((3, 9)), [prior.restitution[0], prior.friction[0], 0.0]

    def flown(state):
        kernels.flow(np.concatenate([state[:10], table]), 0.03, Air(), work)
        return np.concatenate([work[0], state[9:]])

    oracle = ExtendedKalmanFilter(dim_x=16, dim_z=3)
    steps = np.array([1e-5] * 3 + [1e-4] * 3 + [1e-2] * 3 + [1e-4] + [1e-7] * 6)
    oracle.x, oracle.P = flown(belief.mean), belief.covariance.copy()
    oracle.F = np.array(
        [(flown(belief.mean + s * e) - flown(belief.mean - s * e)) / (2 * s)
         for s, e in zip(steps, np.eye(16), strict=True)]
    ).T  # fmt: skip
    q = np.array([[0.03**3 / 3, 0.03**2 / 2], [0.03**2 / 2, 0.03]]) * 0.3**2
    oracle.Q = np.zeros((16, 16))
    for axis in range(3):
        oracle.Q[np.ix_([axis, 3 + axis], [axis, 3 + axis])] = q
    oracle.P = oracle.F @ oracle.P @ oracle.F.T + oracle.Q
    assert after.mean == pytest.approx(oracle.x, abs=1e-12)
    assert after.covariance == pytest.approx(oracle.P, rel=1e-3, abs=1e-9)

    ball = after.mean[:9] + 3e-6 * np.array([10, 1, -1, 0, 0, 0, 0, 0, 0])
    one = sight(after.time, ball)
    updated, nis = update(after, one)
    expected, slopes = np.empty(3), np.empty((3, 16))
    kernels.look(after.mean, one.pose, expected, slopes)
    oracle.x, oracle.P = after.mean.copy(), after.covariance.copy()
    oracle.update(one.seen, lambda x: slopes, lambda x: expected, R=one.covariance)
    assert updated.mean == pytest.approx(oracle.x, abs=1e-6)
    assert updated.covariance == pytest.approx(oracle.P, rel=1e-3, abs=1e-9)
    assert nis == pytest.approx(float(oracle.y @ np.linalg.solve(oracle.S, oracle.y)), rel=1e-6)


def test_a_ball_that_hardly_bounces_goes_on():
    """Many bounces within one prediction: it slides on, and no time is lost."""
    mean = ground(HUMAN_PRIOR, 0.0).mean.copy()
    mean[:6] = [0.5, 0.0, BALL_RADIUS + 1e-4, -1.0, 0.0, 0.0]
    lying = flight_filter.Belief(0.0, mean, ground(HUMAN_PRIOR, 0.0).covariance)
    places = [predict(lying, time, HUMAN_PRIOR).position for time in (0.2, 0.3, 0.4)]
    steps = -np.diff([place[0] for place in places])
    np.testing.assert_allclose(steps, steps[0], rtol=0.05)  # but for the air
    assert steps[0] > 0.05
    assert min(place[2] for place in places) >= BALL_RADIUS


def test_a_crossing_over_the_very_edge_of_the_table_is_no_less_sure_than_one_beside_it():
    """Flights a little shorter or longer bounce or do not: they tell nothing of this one."""
    mean, covariance = ground(HUMAN_PRIOR, 0.0).mean.copy(), 1e-6 * np.eye(kernels.SIZE)
    mean[:6] = [-1.0, 0.0, 0.4, -3.0, 0.0, -1.0]
    before = flight_filter.Belief(0.0, mean, covariance)
    sds = []
    for short in (1e-3, 5e-6):
        shifted = mean.copy()
        fall = _landing_of(before)
        shifted[0] += -TABLE_HALF_LENGTH + short - fall
        belief = flight_filter.Belief(0.0, shifted, covariance)
        crossed = flight_filter.crossing(belief, np.array([1.0, 0.0, 0.0]), -1.67, HUMAN_PRIOR)
        sds.append(np.sqrt(np.diag(crossed.covariance)))
    np.testing.assert_allclose(sds[1], sds[0], rtol=0.05, atol=1e-6)


def _landing_of(belief):
    """Where a ball is when it comes down to the table's height, as if there were none."""
    low, high = 0.0, 0.5
    for _ in range(60):
        middle = 0.5 * (low + high)
        there = predict(belief, middle, HUMAN_PRIOR, bounces=False).position
        low, high = (middle, high) if there[2] > BALL_RADIUS else (low, middle)
    return predict(belief, low, HUMAN_PRIOR, bounces=False).position[0]
