"""Constants are learnt from flights, as far as the flights tell them."""

from dataclasses import replace

import numpy as np
import pytest
from lagging_drone import INTERVAL, LaggingDrone
from scipy.optimize import least_squares
from scipy.signal import step

from rotorpong.control.feed_forward import command_of, velocity_of
from rotorpong.control.identification import Identification, Record, expected, step_answer
from rotorpong.control.plant import UNKNOWN_PLANT, Axis
from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError

TRUE = Axis(0.5, 0.0, 0.93, 0.02)
PLANT = replace(UNKNOWN_PLANT, axes=(Axis(0.4, dead_time=0.01),) * 3)
FRAMES = 60


def flights(seed, moves=0.5):
    """Commands and navdata of one serve of the true drone, frame by frame."""
    rng = np.random.default_rng(seed)
    drone, commands = LaggingDrone((TRUE,) * 3, noise=rng), []
    for k in range(FRAMES):
        if k % 10 == 0:
            velocity = moves * rng.normal(size=3)
        sent, navdata = drone.command(command_of(velocity), INTERVAL)
        commands.append((drone.time - INTERVAL, velocity_of(sent), navdata))
    return commands


def taught(known, seed, moves=0.5):
    record = Record(known.plant)
    for time, velocity, navdata in flights(seed, moves):
        record.add(time, velocity)
        known = record.learnt(known, navdata)
    return known


@pytest.mark.parametrize("seed", range(4))
def test_a_known_drone_is_recovered_within_three_standard_deviations(seed):
    known = taught(Identification.prior(PLANT), seed)
    truth = np.array([TRUE.gain, TRUE.lag, TRUE.dead_time, 0.0])
    assert (np.abs(known.mean - truth) <= 3.0 * known.sd).all()
    assert (known.sd[:, 1] < 0.6 * Identification.prior(PLANT).sd[:, 1]).all()


def test_estimates_come_nearer_with_every_serve_and_stay_sane():
    known, errors = Identification.prior(PLANT), []
    for seed in range(6):
        known = taught(known.renewed(), 10 + seed)
        errors.append(float(np.abs(known.mean[:, 1] - TRUE.lag).mean()))
    assert errors[-1] < 0.02 < abs(PLANT.axes[0].lag - TRUE.lag)
    assert (np.linalg.eigvalsh(known.covariance) > 0.0).all()


def test_it_ends_where_scipy_ends_that_has_the_whole_serve_at_once():
    prior = Identification.prior(PLANT)
    known, serve = taught(prior, 3), flights(3)
    commands = np.stack([np.append(time, velocity) for time, velocity, _ in serve])
    noise = np.sqrt(PLANT.velocity_white**2 / 33 + PLANT.command_white**2)

    def residuals(theta, axis):
        off = (theta - prior.mean[axis]) / prior.sd[axis]
        seen = []
        for k, (_, _, navdata) in enumerate(serve):
            sent = commands[: k + 1, [0, 1 + axis]]
            predicted, _ = expected(PLANT.axes[axis], theta, sent, navdata.times)
            y = (navdata.velocity @ CAMERA_FROM_BODY_AXES.T)[:, axis].mean()
            left = 0.1 * (theta[0] * sent[-1, 1] + theta[3] - predicted)
            seen.append((y - predicted) / np.sqrt(noise**2 + left**2))
        return np.concatenate([off, seen])

    for axis in range(3):
        batch = least_squares(residuals, prior.mean[axis], args=(axis,), method="lm").x
        assert (np.abs(known.mean[axis] - batch) < 1.0 * known.sd[axis]).all()


def test_a_drone_that_stands_still_teaches_nothing_but_its_bias():
    prior = Identification.prior(PLANT)
    known = taught(prior, 0, moves=0.0)
    np.testing.assert_array_equal(known.mean[:, :3], prior.mean[:, :3])
    np.testing.assert_array_equal(known.sd[:, :3], prior.sd[:, :3])
    assert (known.sd[:, 3] < prior.sd[:, 3]).all()


def test_nothing_is_learnt_before_the_first_command_or_from_no_navdata():
    prior = Identification.prior(PLANT)
    navdata = flights(0)[0][2]
    assert Record(PLANT).learnt(prior, navdata) is prior
    assert prior.updated(np.zeros((1, 4)), np.empty(0), np.empty((0, 3))) is prior


def test_what_is_forgotten_is_never_more_than_was_known_before():
    prior = Identification.prior(PLANT)
    known = taught(prior, 1)
    for _ in range(200):
        known = known.renewed()
    np.testing.assert_allclose(known.sd, prior.sd, rtol=1e-9)
    assert (np.linalg.eigvalsh(known.covariance) > 0.0).all()


def test_one_wild_measurement_does_not_carry_it_away():
    prior = Identification.prior(PLANT)
    commands, times = np.array([[0.0, 0.5, 0.5, 0.5]]), np.array([0.2, 0.21])
    wild = prior.updated(commands, times, np.full((2, 3), 1e9))
    assert (np.abs(wild.mean - prior.mean) <= 4.0 * prior.sd + 1e-12).all()


@pytest.mark.parametrize("axis", [Axis(0.4), Axis(0.43, 0.056), Axis(1.86, 0.24), Axis(0.4, 0.04)])
def test_a_step_is_answered_as_scipy_says(axis):
    t = np.linspace(0.0, 2.0, 201)
    numerator, denominator = axis.answer_at(axis.lag)
    _, theirs = step((numerator, denominator), T=t)
    ours, rate = step_answer((numerator, denominator), t[:, None])
    np.testing.assert_allclose(ours[:, 0], theirs, atol=1e-4)
    np.testing.assert_allclose(rate[1:-1, 0], np.gradient(theirs, t)[1:-1], atol=0.05)


@pytest.mark.parametrize("axis", [Axis(0.4), Axis(0.43, 0.056, 1.1, 0.05)])
def test_slopes_are_those_of_finite_differences(axis):
    theta = np.array([1.02, 0.45, 0.03, 0.01])
    commands = np.array([[0.0, 0.5], [0.1, -0.3], [0.2, 0.2]])
    times = np.array([0.25, 0.26, 0.27])
    _, slope = expected(axis, theta, commands, times)
    for k in range(4):
        little = 1e-6 * np.eye(4)[k]
        up, down = (expected(axis, theta + s * little, commands, times)[0] for s in (1, -1))
        assert slope[k] == pytest.approx((up - down) / 2e-6, abs=1e-6)


@pytest.mark.parametrize("forgetting", [0.0, -1.0, 1.1, np.nan])
def test_a_forgetting_that_is_none_is_refused(forgetting):
    with pytest.raises(InputError, match="forgetting"):
        Identification.prior(PLANT).renewed(forgetting)


def test_numbers_that_are_none_are_refused():
    with pytest.raises(InputError, match="expected finite numbers"):
        Identification.prior(PLANT).updated(np.zeros((1, 4)), np.array([np.nan]), np.zeros((1, 3)))
