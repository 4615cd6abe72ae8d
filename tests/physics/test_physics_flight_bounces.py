import numpy as np
import pytest

from rotorpong.conventions import BALL_RADIUS
from rotorpong.physics.ball import Air, Ball, Surface, bounce
from rotorpong.physics.flight_bounces import (
    GRIP,
    UP,
    Bounces,
    bounce_between,
    sliding_friction,
    slip_of,
)
from rotorpong.physics.flight_fit import Belief, Table, fit_flight, follow

LAW = Surface(0.91, 0.21)


def balls(count, seed=0, spin=200.0):
    rng = np.random.default_rng(seed)
    velocity = rng.normal(0.0, 4.0, (count, 3))
    velocity[:, 2] = -rng.uniform(1.0, 4.0, count)
    return Ball(np.tile(BALL_RADIUS * UP, (count, 1)), velocity, rng.normal(0.0, spin, (count, 3)))


def bounced(count=400, seed=0):
    before = balls(count, seed)
    return Bounces(before, bounce(before, UP, LAW))


def test_every_number_of_the_law_is_found_in_the_bounces_that_it_makes():
    bounces = bounced(800)
    ratio = bounces.slip_over_grip(LAW.friction)
    assert np.allclose(bounces.restitution, LAW.restitution)
    assert np.allclose(bounces.removed[ratio < 1.0], GRIP)
    assert np.allclose(bounces.friction[ratio > 1.0], LAW.friction)
    assert np.allclose(bounces.coupling, 1.0)
    assert (ratio < 1.0).sum() > 50
    assert (ratio > 1.0).sum() > 50


def test_a_ball_that_gripped_rolls_off_the_table():
    bounces = bounced(800)
    gripped = bounces.slip_over_grip(LAW.friction) < 1.0
    assert np.abs(slip_of(bounces.after)[gripped]).max() < 1e-9


def test_topspin_slips_backwards():
    forward = Ball(np.zeros((1, 3)), np.array([[5.0, 0.0, -2.0]]), np.array([[0.0, 400.0, 0.0]]))
    assert np.allclose(slip_of(forward), [[5.0 - 400.0 * BALL_RADIUS, 0.0, 0.0]])


def test_friction_is_recovered_from_noisy_bounces_within_four_sigma():
    """Median of n values of spread s: standard error 1.25 s / sqrt(n)."""
    clean = bounced(600, seed=3)
    noise = np.random.default_rng(4).normal(0.0, 0.1, (600, 3))
    after = Ball(clean.after.position, clean.after.velocity + noise, clean.after.spin)
    noisy = Bounces(clean.before, after)
    friction, sliding = sliding_friction(noisy)
    error = 1.25 * np.std(noisy.friction[sliding]) / np.sqrt(sliding.sum())
    assert abs(friction - LAW.friction) < 4.0 * error
    assert error < 0.01


def test_without_a_ball_that_slides_friction_is_unknown():
    rolling = Ball(np.zeros((1, 3)), np.array([[0.0, 0.0, -2.0]]), np.zeros((1, 3)))
    friction, sliding = sliding_friction(Bounces(rolling, bounce(rolling, UP, LAW)))
    assert np.isnan(friction)
    assert not sliding.any()


def test_many_bounces_are_measured_like_each_alone():
    bounces = bounced(20)
    for i in range(20):
        alone = Bounces(
            *(
                Ball(b.position[i : i + 1], b.velocity[i : i + 1], b.spin[i : i + 1])
                for b in (bounces.before, bounces.after)
            )
        )
        for name in ("restitution", "removed", "friction", "coupling"):
            assert getattr(alone, name)[0] == pytest.approx(getattr(bounces, name)[i], abs=1e-12)


def test_restitution_is_recovered_from_noisy_tracks_within_four_sigma():
    """30 tracks at 140 Hz with 2 mm of noise; standard error of their mean from their spread."""
    rng, found = np.random.default_rng(5), []
    belief = Belief(drag_sd=0.1, drag_range=(0.0, 0.5), spin_sd=400.0)
    air, times = Air(), np.arange(0.0, 0.5, 1 / 140)
    for _ in range(30):
        velocity = np.array([rng.uniform(-9.0, -4.0), rng.normal(0.0, 0.3), rng.uniform(-1.0, 0.3)])
        ball = Ball(np.array([1.0, 0.0, 0.25]), velocity, rng.normal(0.0, 60.0, 3))
        path = follow(ball, times, air, Table(LAW), most=1)
        at = int(np.argmax(np.diff(path.velocity[:, 2]) > 1.0)) + 1
        points = path.position + rng.normal(0.0, 0.002, path.position.shape)
        fits = [
            fit_flight(times[part], points[part], bounces=False, belief=belief)
            for part in (slice(0, at), slice(at, at + 30))
        ]
        found.append(bounce_between(fits[0], fits[1], float(times[at])).restitution[0])
    error = np.std(found) / np.sqrt(len(found))
    assert abs(np.mean(found) - LAW.restitution) < 4.0 * error
    assert error < 0.006
