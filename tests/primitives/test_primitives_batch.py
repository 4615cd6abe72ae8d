"""Batches of roll-outs: what each would be alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from primitive_samples import FITTED, GOAL, START, some_dmps

from rotorpong.conventions import InputError
from rotorpong.primitives import Dmp, Library, State
from rotorpong.primitives.batch import Batch, States

rng = np.random.default_rng(0)
DMPS = (FITTED, Dmp(FITTED.weights, np.array([0.5, 1.0, 2.0])), *some_dmps(2))
STARTS = States(rng.normal(size=(5, 3)), rng.normal(size=(5, 3)))
GOALS = States(rng.normal(size=(5, 3)), rng.normal(size=(5, 3)))
DURATIONS = rng.uniform(0.4, 1.6, 5)
BATCH = Batch.of(DMPS, samples=61)


def alone(k, g, duration):
    start, goal = (State(s.position[g], s.velocity[g]) for s in (STARTS, GOALS))
    return DMPS[k].roll_out(start, goal, duration, BATCH.fractions * duration)


def test_every_motion_of_a_batch_is_its_own_roll_out():
    motions = BATCH.roll_out(STARTS, GOALS, DURATIONS, derivatives=2)
    assert motions.position.shape == (4, 5, 61, 3)
    for k in range(4):
        for g in range(5):
            one = alone(k, g, DURATIONS[g])
            for name, atol in (("position", 1e-12), ("velocity", 1e-11), ("acceleration", 1e-8)):
                np.testing.assert_allclose(
                    getattr(motions, name)[k, g], getattr(one, name), rtol=1e-12, atol=atol
                )


def test_several_durations_of_each_goal_are_one_more_axis():
    durations = DURATIONS[:, None] * np.array([0.8, 1.0, 1.3])
    motions = BATCH.roll_out(STARTS, GOALS, durations)
    assert motions.velocity.shape == (4, 5, 3, 61, 3)
    one = alone(2, 3, durations[3, 2])
    np.testing.assert_allclose(motions.velocity[2, 3, 2], one.velocity, atol=1e-11)
    speeds = BATCH.peaks(STARTS, GOALS, durations).speed
    assert speeds.shape == (4, 5, 3)
    np.testing.assert_allclose(
        speeds, np.linalg.norm(motions.velocity, axis=-1).max(axis=-1), rtol=1e-12
    )


@settings(max_examples=20, deadline=None)
@given(samples=st.integers(2, 50), scale=st.floats(0.0, 100.0))
def test_peaks_are_those_of_the_samples(samples, scale):
    batch = Batch.of([Dmp(scale * dmp.weights) for dmp in some_dmps(2, 5)], samples=samples)
    motions = batch.roll_out(STARTS, GOALS, DURATIONS, derivatives=2)
    peaks = batch.peaks(STARTS, GOALS, DURATIONS, accelerations=True)
    for values, found in (
        (motions.velocity, peaks.speed),
        (motions.acceleration, peaks.acceleration),
    ):
        np.testing.assert_allclose(found, np.linalg.norm(values, axis=-1).max(axis=-1), rtol=1e-10)


def test_one_start_and_one_goal_serve_for_all():
    motions = BATCH.roll_out(START, GOAL, DURATIONS)
    one = FITTED.roll_out(START, GOAL, DURATIONS[4], BATCH.fractions * DURATIONS[4])
    np.testing.assert_allclose(motions.position[0, 4], one.position, atol=1e-12)


def test_a_library_is_batched_as_its_primitives_are():
    np.testing.assert_array_equal(Batch.of(Library(DMPS), samples=61).answers, BATCH.answers)


def test_memory_is_used_again_and_gives_the_same_motions():
    first = BATCH.roll_out(STARTS, GOALS, DURATIONS)
    kept = first.position.copy(), first.velocity.copy()
    BATCH.roll_out(GOALS, STARTS, 2 * DURATIONS, out=first)
    again = BATCH.roll_out(STARTS, GOALS, DURATIONS, out=first)
    assert np.shares_memory(again.position, first.position)
    assert np.shares_memory(again.velocity, first.velocity)
    np.testing.assert_array_equal(again.position, kept[0])
    np.testing.assert_array_equal(again.velocity, kept[1])


def test_what_is_not_asked_for_is_not_there():
    only = BATCH.roll_out(STARTS, GOALS, DURATIONS, derivatives=0)
    assert only.velocity is only.acceleration is None
    assert BATCH.peaks(STARTS, GOALS, DURATIONS).acceleration is None


def test_no_goals_give_no_motions():
    nothing = np.empty(0)
    assert BATCH.roll_out(START, GOAL, nothing).position.shape == (4, 0, 61, 3)
    assert BATCH.peaks(START, GOAL, nothing).speed.shape == (4, 0)


def test_a_batch_that_cannot_be_is_refused():
    lost = State(np.array([np.nan, 0.0, 0.0]), np.zeros(3))
    cases = [
        (STARTS, GOALS, DURATIONS[:4], "starts of shape"),
        (START, GOALS, DURATIONS[:4], "goals of shape"),
        (START, State(np.zeros(2), np.zeros(2)), DURATIONS, "goals of shape"),
        (START, GOALS, np.append(DURATIONS[:4], 0.0), "positive"),
        (START, GOALS, np.append(DURATIONS[:4], np.nan), "positive"),
        (START, GOALS, DURATIONS[:, None, None], "durations of shape"),
        (START, GOALS, np.array(1.0), "durations of shape"),
        (lost, GOALS, DURATIONS, "finite"),
        (State(np.zeros(3), np.zeros(3), np.zeros(3)), GOALS, DURATIONS, "acceleration"),
    ]
    for starts, goals, durations, message in cases:
        for work in (BATCH.roll_out, BATCH.peaks):
            with pytest.raises(InputError, match=message):
                work(starts, goals, durations)
    with pytest.raises(InputError, match="derivatives 3"):
        BATCH.roll_out(START, GOALS, DURATIONS, derivatives=3)
    with pytest.raises(InputError, match="out"):
        BATCH.roll_out(
            START,
            GOALS,
            DURATIONS,
            derivatives=1,
            out=BATCH.roll_out(START, GOALS, DURATIONS, derivatives=0),
        )
    with pytest.raises(InputError, match="out"):
        BATCH.roll_out(START, GOAL, DURATIONS[:4], out=BATCH.roll_out(START, GOALS, DURATIONS))
    with pytest.raises(InputError, match="samples 1"):
        Batch.of(DMPS, samples=1)
    for primitives in ((), (*DMPS, Dmp(np.zeros((20, 2))))):
        with pytest.raises(InputError, match="expected"):
            Batch.of(primitives)
