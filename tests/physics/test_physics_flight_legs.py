import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.physics.ball import Air, Ball, fly
from rotorpong.physics.flight_fit import fall
from rotorpong.physics.flight_legs import Legs, fit_air, landing, taken, undelayed

AIR = Air(drag=0.135, magnus=0.007, saturation=3.0)
DELAY = 0.012


def shots(count, seed=0):
    rng = np.random.default_rng(seed)
    position = rng.uniform([-1.5, -0.5, 0.15], [-1.0, 0.5, 0.4], (count, 3))
    velocity = rng.uniform([4.0, -1.0, 0.0], [10.0, 1.0, 2.0], (count, 3))
    return Ball(position, velocity, rng.normal(0.0, 150.0, (count, 3)))


def legs(count=200, *, seed=0, noise=0.0, delay=0.0):
    """Flights to the table, their velocities measured `delay` seconds after their positions."""
    start = shots(count, seed)
    end, times = fall(start, AIR, BALL_RADIUS, 3.0)
    later = undelayed(start, AIR, -delay)
    rng = np.random.default_rng(seed + 1)
    return Legs(later, end.position + rng.normal(0.0, noise, (count, 3)), times)


def test_falling_solves_the_equation_of_motion_up_to_the_table():
    start = taken(shots(3), slice(0, 1))
    end, times = fall(start, AIR, BALL_RADIUS, 3.0)

    def derivative(time, state):
        v = state[3:]
        spin = start.spin[0] * np.exp(-AIR.spin_decay * time)
        turn = np.cross(spin, v)
        ratio = BALL_RADIUS * np.linalg.norm(turn) / (v @ v)
        lift = AIR.magnus * turn / (1.0 + AIR.saturation * ratio)
        return np.r_[v, [0, 0, -GRAVITY] - AIR.drag * np.linalg.norm(v) * v + lift]

    first = np.r_[start.position[0], start.velocity[0]]
    solved = solve_ivp(derivative, (0.0, times[0]), first, rtol=1e-11, atol=1e-11).y[:, -1]
    assert np.allclose(end.position[0], solved[:3], atol=1e-8)
    assert end.position[0, 2] == pytest.approx(BALL_RADIUS, abs=1e-10)


def test_a_ball_that_stays_above_has_no_time():
    _, times = fall(shots(4), AIR, BALL_RADIUS, 0.01)
    assert np.isnan(times).all()


def test_many_balls_fall_like_each_alone():
    start = shots(10)
    end, times = fall(start, AIR, BALL_RADIUS, 3.0)
    for i in range(10):
        alone, time = fall(taken(start, slice(i, i + 1)), AIR, BALL_RADIUS, 3.0)
        assert np.array_equal(alone.position[0], end.position[i])
        assert time[0] == times[i]


def test_undoing_a_delay_is_flying_back():
    start = shots(5)
    flown = fly(start, AIR, DELAY)
    later = Ball(start.position, flown.velocity, flown.spin)
    assert np.allclose(undelayed(later, AIR, DELAY).velocity, start.velocity, atol=1e-9)


def test_exact_legs_give_the_air_and_the_delay_back():
    fit = fit_air(legs(delay=DELAY))
    assert fit.air.drag == pytest.approx(AIR.drag, abs=1e-4)
    assert fit.air.magnus == pytest.approx(AIR.magnus, abs=1e-5)
    assert fit.air.saturation == pytest.approx(AIR.saturation, abs=1e-2)
    assert fit.delay == pytest.approx(DELAY, abs=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_noisy_legs_give_the_air_and_the_delay_back_within_four_sigma(seed):
    """The stated standard errors hold for the noise that the fit assumes, 15 mm."""
    fit = fit_air(legs(seed=seed, noise=0.015, delay=DELAY))
    assert abs(fit.air.drag - AIR.drag) < 4.0 * fit.drag_sd
    assert abs(fit.air.magnus - AIR.magnus) < 4.0 * fit.magnus_sd
    assert abs(fit.air.saturation - AIR.saturation) < 4.0 * fit.saturation_sd
    assert abs(fit.delay - DELAY) < 4.0 * fit.delay_sd
    assert fit.drag_sd < 0.01
    assert fit.magnus_sd < 1e-3
    assert fit.saturation_sd < 1.0
    assert fit.delay_sd < 2e-3


def test_what_is_known_is_not_fitted():
    fit = fit_air(legs(), drag=0.2, saturation=2.0, delay=0.003)
    assert (fit.air.drag, fit.air.saturation, fit.delay) == (0.2, 2.0, 0.003)
    assert (fit.drag_sd, fit.saturation_sd, fit.delay_sd) == (0.0, 0.0, 0.0)


def test_a_flight_through_two_places_needs_no_velocity():
    exact = legs()
    wrong = Ball(exact.start.position, 0.5 * exact.start.velocity, exact.start.spin)
    start, end = landing(Legs(wrong, exact.end, exact.duration), AIR)
    assert np.allclose(start.velocity, exact.start.velocity, atol=1e-7)
    assert np.allclose(end.position, exact.end, atol=1e-9)


def test_spin_along_the_flight_does_not_count_in_the_spin_ratio():
    velocity = np.array([[8.0, 0.0, 0.0]])
    spin = np.array([[500.0, 0.0, 120.0]])
    leg = Legs(Ball(np.zeros((1, 3)), velocity, spin), np.zeros((1, 3)), np.ones(1))
    assert leg.spin_ratio == pytest.approx(BALL_RADIUS * 120.0 / 8.0)
