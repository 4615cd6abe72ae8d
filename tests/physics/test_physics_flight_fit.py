import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotorpong.conventions import BALL_RADIUS, GRAVITY, InputError
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, Surface, fly
from rotorpong.physics.flight_arcs import find_arcs
from rotorpong.physics.flight_fit import Table, fit_flight, follow, rewind

AIR = Air(drag=0.14)
BALL = Ball(np.array([1.4, 0.2, 0.3]), np.array([-6.5, -0.3, 0.6]), np.array([20.0, -120.0, 40.0]))
TABLE = Table(Surface(0.9, 0.2))
TIMES = np.linspace(0.0, 0.6, 110)


def measured(ball, times, *, table=TABLE, most=4, noise=0.0, seed=0):
    path = follow(ball, times, AIR, table, most=most).position
    return path + np.random.default_rng(seed).normal(0.0, noise, path.shape)


def test_following_a_free_flight_is_flying_it():
    path = follow(BALL, TIMES, AIR, TABLE, most=0)
    for i in (1, 50, 109):
        flown = fly(BALL, AIR, float(TIMES[i]))
        assert np.allclose(path.position[i], flown.position, atol=1e-9)
        assert np.allclose(path.velocity[i], flown.velocity, atol=1e-8)


def test_a_followed_flight_solves_the_equation_of_motion():
    def derivative(time, state):
        v = state[3:]
        pull = np.array([0.0, 0.0, -GRAVITY])
        turn = np.cross(np.exp(-AIR.spin_decay * time) * BALL.spin, v)
        ratio = BALL_RADIUS * np.linalg.norm(turn) / (v @ v)
        lift = AIR.magnus * turn / (1.0 + AIR.saturation * ratio)
        return np.r_[v, pull - AIR.drag * np.linalg.norm(v) * v + lift]

    start = np.r_[BALL.position, BALL.velocity]
    solved = solve_ivp(derivative, (0.0, 0.6), start, t_eval=TIMES, rtol=1e-11, atol=1e-11)
    path = follow(BALL, TIMES, AIR, TABLE, most=0)
    assert np.allclose(path.position, solved.y[:3].T, atol=1e-8)


def test_a_bouncing_ball_never_sinks_into_the_table_and_never_gains_energy():
    times = np.linspace(0.0, 1.5, 400)
    path = follow(BALL, times, AIR, TABLE, most=20)
    energy = GRAVITY * path.position[:, 2] + 0.5 * np.sum(path.velocity**2, axis=1)
    energy += BALL_RADIUS**2 / 3 * np.sum(path.spin**2, axis=1)  # thin shell: I = 2/3 m r^2
    assert path.position[:, 2].min() >= BALL_RADIUS - 1e-9
    assert np.diff(energy).max() < 1e-9


def test_where_the_times_lie_does_not_change_a_bounce():
    coarse = follow(BALL, np.array([0.0, 0.6]), AIR, TABLE)
    fine = follow(BALL, TIMES, AIR, TABLE)
    assert np.allclose(coarse.position[-1], fine.position[-1], atol=1e-7)


def test_going_back_in_time_undoes_the_flight():
    back = rewind(fly(BALL, AIR, 0.2), AIR, 0.2)
    assert np.allclose(back.position[-1], BALL.position, atol=1e-8)
    assert np.allclose(back.velocity[-1], BALL.velocity, atol=1e-7)


def test_a_fit_recovers_velocity_drag_and_the_spin_that_bends_the_flight():
    fit = fit_flight(TIMES[:60], measured(BALL, TIMES[:60], most=0, noise=0.001), bounces=False)
    across = np.cross(BALL.velocity, fit.spin - BALL.spin) / np.linalg.norm(BALL.velocity)
    assert np.abs(fit.ball.velocity - BALL.velocity).max() < 0.03
    assert abs(fit.drag - AIR.drag) < 0.02
    assert np.linalg.norm(across) < 30.0
    assert fit.residual_rms < 0.002
    assert fit.points == 60


def test_a_fit_recovers_the_bounce_and_the_height_of_the_table():
    table = Table(Surface(0.92, 0.2), height=-0.02)
    points = measured(BALL, TIMES, table=table, most=1, noise=0.001)
    fit = fit_flight(TIMES, points, bounces=True)
    assert abs(fit.table.surface.restitution - 0.92) < 0.02
    assert abs(fit.table.height + 0.02) < 0.003
    assert fit.residual_rms < 0.002


def test_a_few_bad_points_hardly_bend_a_fit():
    points = measured(BALL, TIMES[:60], most=0, noise=0.001)
    points[[7, 30, 51]] += [0.0, 0.0, 0.3]
    fit = fit_flight(TIMES[:60], points, bounces=False)
    flown = measured(fit.ball, TIMES[:60], most=0)
    assert np.abs(flown - measured(BALL, TIMES[:60], most=0))[8:].max() < 0.008


def test_without_a_bounce_the_table_is_the_usual_one():
    fit = fit_flight(TIMES[:40], measured(BALL, TIMES[:40], most=0), bounces=False)
    assert fit.table == Table(TABLE_SURFACE, 0.0)


def test_too_few_points_are_an_error():
    with pytest.raises(InputError, match="4 points"):
        fit_flight(TIMES[:4], np.zeros((4, 3)), bounces=False)


@pytest.mark.parametrize("seed", range(5))
def test_arcs_end_where_the_ball_bounces(seed):
    points = measured(BALL, TIMES, noise=0.003, seed=seed)
    truth = follow(BALL, TIMES, AIR, TABLE).velocity[:, 2]
    bounce = int(np.argmax(np.diff(truth) > 1.0)) + 1
    first, second = find_arcs(TIMES, points)
    assert abs(second.first - bounce) <= 1
    assert (first.follows_bounce, second.follows_bounce) == (False, True)


def test_a_stroke_begins_a_flight_of_its_own():
    there = measured(BALL, TIMES[:50], most=0)
    back = Ball(there[-1], np.array([8.0, 1.0, 1.5]), np.zeros(3))
    points = np.concatenate([there, measured(back, TIMES[:40], most=0)[1:]])
    times = np.arange(len(points)) * TIMES[1]
    arcs = find_arcs(times, points)
    assert [arc.follows_bounce for arc in arcs] == [False, False]
    assert abs(arcs[1].first - 50) <= 1


def test_a_free_flight_is_one_arc():
    points = measured(BALL, TIMES[:60], most=0, noise=0.003)
    assert len(find_arcs(TIMES[:60], points)) == 1


def test_a_wrong_time_stamp_is_no_stroke():
    points = measured(BALL, TIMES[:60], most=0, noise=0.001)
    late = TIMES[:60].copy()
    late[30:] += 0.004
    assert len(find_arcs(late, points)) == 1


def test_where_the_ball_was_not_seen_for_long_an_arc_ends():
    times = np.delete(TIMES, slice(20, 50))
    arcs = find_arcs(times, measured(BALL, times, most=0))
    assert [(arc.first, arc.last) for arc in arcs] == [(0, 20), (20, 80)]
