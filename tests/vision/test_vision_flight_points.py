"""The flight filter on measured places, against closed forms, scipy and many drawn flights."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.physics.ball import Air, Ball, Surface
from rotorpong.physics.flight_fit import Table, follow
from rotorpong.vision import _flight_filter_kernels as kernels
from rotorpong.vision import _flight_window_kernels as window_kernels
from rotorpong.vision.flight_filter import (
    HUMAN_PRIOR,
    Point,
    fit_window,
    ground,
    path,
    place,
    predict,
    update,
)
from rotorpong.vision.flight_points import (
    DRAG_ONLY,
    GRAVITY_ONLY,
    MATCH,
    TRACKED,
    PointNoise,
    belief_after,
    prior_of,
)

TIMES = np.arange(0.0, 0.15, 0.006)
LATER = 0.35  # s
START = np.array([1.2, 0.1, 0.4, -7.0, 0.3, 1.5, 10.0, -180.0, 60.0])
EXACT = PointNoise(1e-6, 0.0)


def law(_, state, drag=0.15):
    """The right-hand side of `physics.ball`, written again."""
    air = Air()
    velocity, spin = state[3:6], state[6:9]
    speed, across = np.linalg.norm(velocity), np.cross(spin, velocity)
    lift = air.magnus / (1.0 + air.saturation * BALL_RADIUS * np.linalg.norm(across) / speed**2)
    pull = np.array([0.0, 0.0, -GRAVITY]) - drag * speed * velocity + lift * across
    return np.concatenate([velocity, pull, -air.spin_decay * spin])


def flown(times, start=START, drag=0.15):
    """States at times after 0 by DOP853."""
    solved = solve_ivp(
        law, (0.0, times[-1]), start, "DOP853", times, args=(drag,), rtol=1e-9, atol=1e-9
    )
    return solved.y.T


def expected_at(time, times, places, expectation=MATCH, **more):
    belief = belief_after(times, places, expectation, **more)
    return predict(belief, time, prior_of(expectation, more.get("table_height", 0.0)))


def test_a_point_is_the_place_itself():
    mean, expected, slopes = np.arange(16.0), np.empty(3), np.empty((3, 16))
    point = Point(0.0, np.zeros(3), np.eye(3))
    assert kernels.look(mean, point.pose, expected, slopes)
    assert expected == pytest.approx(mean[:3])
    assert slopes == pytest.approx(np.eye(3, 16))


def test_taking_in_a_point_is_the_linear_kalman_update():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(16, 16))
    belief = replace(ground(HUMAN_PRIOR, 0.0), covariance=root @ root.T)
    point = Point(0.0, rng.normal(size=3), np.diag([1.0, 2.0, 3.0]))
    after, nis = update(belief, point)
    information = np.linalg.inv(belief.covariance)
    information[:3, :3] += np.diag([1.0, 1 / 2, 1 / 3])
    assert after.covariance == pytest.approx(np.linalg.inv(information), abs=1e-8)
    miss = point.seen - belief.position
    spread = belief.covariance[:3, :3] + point.covariance
    assert nis == pytest.approx(miss @ np.linalg.solve(spread, miss))
    assert after.mean == pytest.approx(
        belief.mean + belief.covariance[:, :3] @ np.linalg.solve(spread, miss), abs=1e-8
    )


def test_a_spinning_flight_without_noise_is_predicted_to_a_tenth_of_a_millimetre():
    states = flown(np.append(TIMES, LATER))
    found = expected_at(LATER, TIMES, states[:-1, :3], noise=EXACT)
    assert found.position == pytest.approx(states[-1, :3], abs=1e-4)
    assert found.velocity == pytest.approx(states[-1, 3:6], abs=2e-3)


def test_by_gravity_alone_it_is_the_parabola_of_least_squares():
    rng = np.random.default_rng(1)
    places = flown(TIMES)[:, :3] + rng.normal(0.0, 0.002, (len(TIMES), 3))
    risen = places + 0.5 * GRAVITY * TIMES[:, None] ** 2 * [0.0, 0.0, 1.0]
    line = np.polyfit(TIMES, risen, 1)
    wanted = line[1] + line[0] * LATER - [0.0, 0.0, 0.5 * GRAVITY * LATER**2]
    found = expected_at(LATER, TIMES, places, GRAVITY_ONLY, rounds=0)
    assert found.position == pytest.approx(wanted, abs=1e-5)


def test_twice_the_noise_is_twice_the_error_of_a_linear_law():
    true, rng = flown(TIMES)[:, :3], np.random.default_rng(2)
    noise = rng.normal(0.0, 0.002, true.shape)
    none, once, twice = (
        expected_at(LATER, TIMES, true + k * noise, GRAVITY_ONLY, rounds=0).position
        for k in (0.0, 1.0, 2.0)
    )
    assert twice - none == pytest.approx(2.0 * (once - none), abs=1e-6)


def test_a_fit_is_the_least_squares_solution():
    rng = np.random.default_rng(3)
    places = flown(TIMES)[:, :3] + rng.normal(0.0, 0.002, (len(TIMES), 3))
    belief = belief_after(TIMES, places, rounds=0)
    velocity = (places[-1] - places[0]) / (TIMES[-1] - TIMES[0])
    spread = TRACKED.place_sd**2 * np.eye(3)
    spread += TRACKED.stamp_sd**2 * np.outer(velocity, velocity)
    white = np.linalg.inv(np.linalg.cholesky(spread))
    c, s = velocity[:2] / np.hypot(*velocity[:2])
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def residuals(unknowns):
        missed = (places - flown(TIMES, unknowns[:9], unknowns[9])[:, :3]) @ white.T
        spin = (axes.T @ unknowns[6:9] - MATCH.spin) / MATCH.spin_sd
        known = [unknowns[:3] - places[0], unknowns[3:6] / 20.0, spin]
        return np.concatenate([missed.ravel(), *known, [(unknowns[9] - 0.15) / MATCH.drag_sd]])

    solved = least_squares(residuals, np.append(START, 0.15), x_scale="jac", xtol=1e-12)
    end = flown(np.array([0.0, TIMES[-1]]), solved.x[:9], solved.x[9])[-1]
    assert belief.mean[:3] == pytest.approx(end[:3], abs=1e-4)
    assert belief.mean[3:6] == pytest.approx(end[3:6], abs=5e-3)
    later = predict(belief, LATER, prior_of(MATCH)).position
    end = flown(np.array([0.0, LATER]), solved.x[:9], solved.x[9])[-1]
    assert later == pytest.approx(end[:3], abs=1e-3)


def test_the_covariance_of_a_prediction_is_that_of_its_errors():
    """80 flights drawn as believed: mean of 3 degrees of freedom, within 4 sigma."""
    rng, squares = np.random.default_rng(4), []
    for _ in range(80):
        spin = np.array(MATCH.spin) + MATCH.spin_sd * rng.standard_normal(3)
        velocity = np.array([rng.uniform(5.0, 9.0), 0.0, rng.normal(1.5, 0.5)])
        start = np.concatenate([[-1.2, 0.0, 0.8], velocity, spin])
        drag = 0.15 + MATCH.drag_sd * rng.standard_normal()
        states = flown(np.append(TIMES, LATER), start, drag)
        places = states[:-1, :3] + rng.normal(0.0, 0.002, (len(TIMES), 3))
        noise = PointNoise(0.002, 0.0)
        end = expected_at(LATER, TIMES, places, noise=noise, rounds=0)
        error = end.position - states[-1, :3]
        squares.append(error @ np.linalg.solve(end.covariance[:3, :3], error))
    assert np.mean(squares) == pytest.approx(3.0, abs=4.0 * np.sqrt(6.0 / 80))


def test_a_gross_error_of_the_tracker_hardly_bends_the_flight():
    rng = np.random.default_rng(5)
    places = flown(TIMES)[:, :3] + rng.normal(0.0, 0.001, (len(TIMES), 3))
    wrong = places.copy()
    wrong[9, 2] += 0.2
    whole = expected_at(LATER, TIMES, places).position
    bent, plain = (expected_at(LATER, TIMES, wrong, rounds=rounds).position for rounds in (2, 0))
    assert np.linalg.norm(bent - whole) < 0.01
    assert np.linalg.norm(plain - whole) > 0.03


def test_a_bounce_ahead_and_one_inside_the_window_are_flown_through():
    ball = Ball(np.array([1.0, 0.0, 0.30]), np.array([-6.0, 0.2, -1.0]), np.array([0, -90.0, 20]))
    height = -0.03
    times = np.append(TIMES, LATER)
    states = follow(ball, times, Air(), Table(height=height))
    low = int(np.argmax(np.diff(states.velocity[:, 2]) > 1.0))
    assert low == len(TIMES) - 1  # it bounces after the window
    found = expected_at(LATER, TIMES, states.position[:-1], noise=EXACT, table_height=height)
    assert found.position == pytest.approx(states.position[-1], abs=2e-3)
    later = TIMES + 0.12
    states = follow(ball, np.concatenate([[0.0], later, [0.5]]), Air(), Table(height=height))
    places = states.position[1:-1]
    assert np.argmin(places[:, 2]) not in (0, len(later) - 1)
    found = expected_at(0.5, later, places, noise=EXACT, table_height=height)
    assert found.position == pytest.approx(states.position[-1], abs=2e-3)


def test_a_table_unlike_the_believed_leads_the_filter_less_astray_than_a_fit():
    """Tables 2 sd off in restitution or friction or both, spins to either side; means of all."""
    prior, spread = prior_of(MATCH), TRACKED.place_sd**2 * np.eye(3)
    times, errors = np.append(TIMES + 0.1, 0.4), []
    for change in ((-0.04, 0.1), (-0.04, 0.0), (0.0, 0.1), (0.02, -0.05)):
        surface = Surface(*np.array([prior.restitution[0], prior.friction[0]]) + change)
        for spin in (-200.0, -90.0, 90.0, 200.0):
            velocity = np.array([-6.0, 0.2, -1.0])
            ball = Ball(np.array([1.0, 0.0, 0.30]), velocity, np.array([0.0, spin, 20.0]))
            states = follow(ball, np.append(0.0, times), Air(), Table(surface)).position[1:]
            points = [Point(*row, spread) for row in zip(times, states, strict=True)][:-1]
            wide = ground(replace(prior, spin_sd=200.0, velocity_sd=(20.0,) * 3), times[0])
            fit, _ = fit_window(wide, points, prior)
            filtered = expected_at(times[-1], times[:-1], states[:-1])
            fitted = predict(fit, times[-1], prior)
            errors.append([np.linalg.norm(one.position - states[-1]) for one in (filtered, fitted)])
    filtered, fitted = np.mean(errors, axis=0)
    assert filtered < 0.7 * fitted


@pytest.mark.parametrize("expectation", [MATCH, DRAG_ONLY])
def test_a_turned_flight_is_predicted_turned(expectation):
    c, s = np.cos(2.0), np.sin(2.0)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    rng = np.random.default_rng(6)
    places = flown(TIMES)[:, :3] + rng.normal(0.0, 0.001, (len(TIMES), 3))
    found = expected_at(LATER, TIMES, places, expectation).position
    turned = expected_at(LATER, TIMES, places @ turn.T, expectation).position
    assert turned == pytest.approx(turn @ found, abs=2e-4)


def test_a_path_is_where_predictions_are():
    belief = belief_after(TIMES, flown(TIMES)[:, :3])
    prior, times = prior_of(MATCH), np.array([TIMES[-1], 0.2, 0.31, 0.9])
    places, bounces = path(belief, times, prior)
    wanted = [predict(belief, time, prior).position for time in times]
    assert places == pytest.approx(np.array(wanted), abs=1e-6)
    assert bounces.tolist() == [0, 0, 0, 1]


def test_a_point_puts_a_ball_where_it_was_measured():
    put = place(ground(HUMAN_PRIOR, 0.0), Point(0.5, np.array([1.0, 2.0, 3.0]), np.eye(3)))
    assert put.time == 0.5
    assert put.position == pytest.approx([1.0, 2.0, 3.0])


def test_a_gyro_that_does_not_walk_leaves_every_sight_its_own_weight():
    rng = np.random.default_rng(0)
    rows, slopes = np.zeros((4, 25)), rng.normal(size=(12, kernels.SIZE))
    rows[:, 0] = np.arange(4) / 30.0
    for row in rows:
        own = rng.normal(size=(3, 3))
        row[4:13] = (own @ own.T + np.eye(3)).ravel()
    still, walking = (window_kernels.weights_of(rows, slopes, walk) for walk in (0.0, 1e-9))
    np.testing.assert_allclose(still, walking, atol=1e-9)
