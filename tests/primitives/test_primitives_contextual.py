"""Primitives by context, and few that stand for many."""

import itertools
import json

import numpy as np
import pytest
from primitive_samples import FITTED, GOAL, START, some_dmps
from scipy.spatial.distance import cdist
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF
from sklearn.linear_model import Ridge

from rotorpong.conventions import InputError
from rotorpong.primitives import Dmp, Library, State, fit_dmp
from rotorpong.primitives.contextual import ContextualLibrary
from rotorpong.primitives.shapes import reduced, representatives, shapes_of

rng = np.random.default_rng(0)
CONTEXTS = rng.uniform(-1.0, 1.0, (25, 2)) * np.array([1.0, 30.0])
T = np.linspace(0.0, 1.0, 60)
KINDS = ("linear", "gaussian")


def demonstrated(context):
    """A stroke whose back-swing and arc grow with the context, the second not linearly."""
    back, arc = 0.1 * (1.5 + context[0]), 0.1 * np.sin(context[1] / 15.0)
    return np.stack(
        [T**3 - back * np.sin(np.pi * T) ** 2, arc * np.sin(np.pi * T) ** 2 + 0.2 * T], axis=1
    )


DMPS = tuple(fit_dmp(T, demonstrated(context)) for context in CONTEXTS)


def theta(dmps):
    return np.stack([dmp.weights for dmp in dmps]).reshape(len(dmps), -1)


def test_a_linear_library_is_ridge_regression():
    ours = ContextualLibrary.fit(CONTEXTS, DMPS, kind="linear")
    scaled = (CONTEXTS - CONTEXTS.mean(axis=0)) / CONTEXTS.std(axis=0)
    peer = Ridge(alpha=ours.ridge).fit(scaled, theta(DMPS))
    for context in rng.uniform(-1.0, 1.0, (5, 2)) * np.array([1.0, 30.0]):
        there = (context - CONTEXTS.mean(axis=0)) / CONTEXTS.std(axis=0)
        np.testing.assert_allclose(
            ours.primitive(context).weights.ravel(), peer.predict(there[None])[0], atol=1e-6
        )


def test_a_gaussian_library_is_a_gaussian_process_on_what_the_mean_leaves():
    ours = ContextualLibrary.fit(CONTEXTS, DMPS)
    scaled = (CONTEXTS - CONTEXTS.mean(axis=0)) / CONTEXTS.std(axis=0)
    peer = GaussianProcessRegressor(RBF(ours.length), alpha=ours.ridge, optimizer=None)
    peer.fit(scaled, theta(DMPS) - ours.offset.ravel())
    context = np.array([0.3, -12.0])
    there = (context - CONTEXTS.mean(axis=0)) / CONTEXTS.std(axis=0)
    expected = peer.predict(there[None])[0] + ours.offset.ravel()
    found = ours.primitive(context).weights.ravel()
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize("kind", KINDS)
def test_the_error_of_leaving_one_out_is_that_of_leaving_it_out(kind):
    ours = ContextualLibrary.fit(CONTEXTS, DMPS, kind=kind)

    def kernel(a, b):
        if kind == "linear":
            return a @ b.T
        return np.exp(-0.5 * cdist(a, b, "sqeuclidean") / ours.length**2)

    errors, shapes, c = [], shapes_of(DMPS), ours.contexts
    for i in range(len(c)):
        rest = np.arange(len(c)) != i
        n = rest.sum()  # the mean is free: one more unknown, one more condition
        system = np.ones((n + 1, n + 1))
        system[:n, :n] = kernel(c[rest], c[rest]) + ours.ridge * np.eye(n)
        system[n, n] = 0.0
        right = np.vstack([shapes[rest], np.zeros(shapes.shape[1])])
        solved = np.linalg.solve(system, right)
        predicted = kernel(c[[i]], c[rest]) @ solved[:n] + solved[n]
        errors.append(np.sum((predicted - shapes[i]) ** 2))
    assert ours.left_out_error == pytest.approx(np.sqrt(np.mean(errors) / 2), rel=1e-6)


def test_what_was_never_demonstrated_is_moved_as_it_would_have_been():
    ours = ContextualLibrary.fit(CONTEXTS, DMPS)
    assert ours.left_out_error < 0.003
    for context in rng.uniform(-0.8, 0.8, (5, 2)) * np.array([1.0, 30.0]):
        wanted = demonstrated(context)
        ends = fit_dmp(T, wanted).ends
        start, goal = (State(ends.position[i], ends.velocity[i]) for i in (0, 1))
        moved = ours.primitive(context).roll_out(start, goal, 1.0, T).position
        assert np.sqrt(np.mean((moved - wanted) ** 2)) < 0.003


def test_a_curved_dependence_is_learnt_better_by_gaussians():
    errors = [ContextualLibrary.fit(CONTEXTS, DMPS, kind=k).left_out_error for k in KINDS]
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("kind", KINDS)
def test_the_goal_is_met_exactly_in_every_context(kind):
    ours = ContextualLibrary.fit(CONTEXTS, DMPS, kind=kind)
    goal = State(np.array([0.4, -0.7]), np.array([1.0, -2.0]))
    for context in (np.array([0.0, 0.0]), np.array([5.0, 300.0])):
        dmp = ours.primitive(context)
        end = dmp.roll_out(State(np.zeros(2), np.zeros(2)), goal, 0.6, np.array([0.6]))
        np.testing.assert_allclose(end.position[0], goal.position, rtol=0, atol=1e-9)
        np.testing.assert_allclose(end.velocity[0], goal.velocity, rtol=0, atol=1e-9)


def test_contexts_that_explain_nothing_give_the_mean():
    noise = some_dmps(20, 3)
    contexts = np.random.default_rng(5).normal(size=(20, 1))
    ours = ContextualLibrary.fit(contexts, noise, kind="linear")
    mean = np.mean([dmp.weights for dmp in noise], axis=0)
    spread = np.std([dmp.weights for dmp in noise])
    assert np.abs(ours.primitive(contexts[0]).weights - mean).mean() < 0.3 * spread


def test_what_is_read_is_what_was_saved(tmp_path):
    for kind in KINDS:
        ours = ContextualLibrary.fit(CONTEXTS, DMPS, kind=kind)
        ours.save(tmp_path / "contexts.json")
        read = ContextualLibrary.load(tmp_path / "contexts.json")
        context = np.array([0.2, 3.0])
        np.testing.assert_array_equal(
            read.primitive(context).weights, ours.primitive(context).weights
        )
        assert (read.kind, read.left_out_error) == (kind, ours.left_out_error)


@pytest.mark.parametrize(
    "change",
    [
        {"kind": "magic"},
        {"mean": [0.0]},
        {"deviation": [1.0, 0.0]},
        {"coefficients": [[[1.0]]]},
        {"length": 0.0},
        {"length": "long"},
        {"offset": None},
        {"contexts": []},
        {"version": 2},
        {"format": "rotorpong-library"},
    ],
)
def test_a_damaged_or_foreign_file_is_one_clear_line(tmp_path, change):
    path = tmp_path / "contexts.json"
    ContextualLibrary.fit(CONTEXTS[:4], DMPS[:4]).save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=r"contexts\.json") as caught:
        ContextualLibrary.load(path)
    assert "\n" not in str(caught.value)


def test_contexts_that_cannot_be_used_are_refused():
    holed = CONTEXTS.copy()
    holed[3, 0] = np.nan
    cases = [
        (CONTEXTS[:-1], DMPS, "gaussian", "one per primitive"),
        (CONTEXTS[:2], DMPS[:2], "gaussian", "at least 3"),
        (CONTEXTS[:0], (), "gaussian", "at least 3"),
        (holed, DMPS, "gaussian", "finite"),
        (np.ones((25, 2)), DMPS, "linear", "all the same"),
        (CONTEXTS, (*DMPS[:-1], Dmp(np.zeros((20, 3)))), "linear", "same bases"),
    ]
    for contexts, dmps, kind, message in cases:
        with pytest.raises(InputError, match=message):
            ContextualLibrary.fit(contexts, dmps, kind=kind)
    ours = ContextualLibrary.fit(CONTEXTS, DMPS)
    for context in (np.zeros(3), np.array([np.nan, 0.0])):
        with pytest.raises(InputError, match="expected 2 finite numbers"):
            ours.primitive(context)


def test_the_distance_of_shapes_is_that_of_the_motions():
    pair = (FITTED, Dmp(FITTED.weights, np.array([0.5, 1.0, 2.0])))
    times = np.linspace(0.0, 1.0, 2001)
    moved = [dmp.roll_out(START, GOAL, 1.0, times).position for dmp in pair]
    apart = np.sqrt(np.mean(np.sum((moved[0] - moved[1]) ** 2, axis=1)))
    ours = np.linalg.norm(np.subtract(*shapes_of(pair)))
    assert ours == pytest.approx(apart, rel=1e-3)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_representatives_of_separate_groups_are_the_best_of_all_choices(count):
    centres, scatter = some_dmps(3, 1), some_dmps(9, 2)
    library = Library(
        tuple(Dmp(centres[i % 3].weights + 0.05 * dmp.weights) for i, dmp in enumerate(scatter))
    )
    apart = cdist(*[shapes_of(library.primitives)] * 2)

    def cost(choice):
        return apart[:, list(choice)].min(axis=1).sum()

    chosen = representatives(library, count)
    assert len(set(chosen)) == count
    best = min(map(cost, itertools.combinations(range(9), count)))
    assert cost(chosen) == pytest.approx(best, rel=1e-12)
    if count == 3:
        assert {i % 3 for i in chosen} == {0, 1, 2}


def test_a_reduced_library_keeps_whole_primitives():
    library = Library(some_dmps(6))
    few = reduced(library, 2)
    assert all(any(dmp is one for one in library.primitives) for dmp in few.primitives)
    assert len(reduced(library, 6)) == 6
    for count in (0, 7):
        with pytest.raises(InputError, match="expected 1 to 6"):
            reduced(library, count)
