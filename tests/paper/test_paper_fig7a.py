"""Fig. 7a: errors by an independent Eq. (6), averages over runs, and words that follow numbers."""

import json

import numpy as np
import pytest

from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demonstrate import lessons_of
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import knowledge_of, train
from rotorpong.paper import fig7a, fig7b
from rotorpong.paper.findings import Scale
from rotorpong.paper.hits import hits_again, serves_seen
from rotorpong.paper.reproduce import as_json
from rotorpong.play.lessons import cost_of
from rotorpong.play.paper import PaperSettings

QUICK = Scale(0, quick=True)
SPECS = tuple(Spec(eyes="truth", seed=seed) for seed in (11, 12))


def equation_6(balls, goals, costs, lam, asked, standard):
    """Return hitting points by the formula as it is printed, with an inverse."""
    mean, sd = standard[0].mean(axis=0), standard[0].std(axis=0)
    rows, queries = (
        (np.array(b) - mean) / sd / PaperSettings().length_scale for b in (balls, asked)
    )
    middle = standard[1].mean(axis=0)

    def kernel(a, b):
        return np.exp(-0.5 * np.sum((a[:, None] - b[None]) ** 2, axis=2))

    inverse = np.linalg.inv(kernel(rows, rows) + lam * np.diag(costs))
    return kernel(queries, rows) @ inverse @ (np.array(goals) - middle) + middle


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Return the answer of a small job, the hits of its two runs, and its serves."""
    runs = [tmp_path_factory.mktemp("runs") / f"{spec.seed}" for spec in SPECS]
    for spec, run in zip(SPECS, runs, strict=True):
        train(spec, 2, run)
    hits = [
        list(hits_again(spec, knowledge_of(run)[1])) for spec, run in zip(SPECS, runs, strict=True)
    ]
    return fig7a.measured(SPECS, (0, 1), 4, *runs), hits, serves_seen(SPECS[0], 4)


@pytest.mark.parametrize("labels", fig7a.LABELS)
def test_errors_are_those_of_equation_6(labels, small):
    answer, (own, test), serves = small
    assert answer["samples"] == [10.0, 11.0]
    lessons = lessons_of(shipped_demonstrations(), SPECS[0])
    standard = (
        np.stack([one.ball for one in lessons]),
        np.stack([one.hitting_point for one in lessons]),
    )
    lam = fig7a.LAMBDAS[1]
    found = answer["errors"][labels][f"{lam:g}"]
    for at, mark in enumerate((0, 1)):
        tried = [hit.attempt(labels) for hit in own[:mark]]
        balls = [*standard[0], *(one.state for one in tried)]
        goals = [*standard[1], *(one.hitting_point for one in tried)]
        rewards = [*(one.reward for one in lessons), *(hit.trial.reward for hit in own[:mark])]
        learnt = (balls, goals, [cost_of(reward) for reward in rewards], lam)
        told = [hit.attempt(labels) for hit in test]
        expected = {
            "label": ([one.state for one in told], [one.hitting_point[:2] for one in told]),
            "place": ([serve.ball for serve in serves], [serve.need for serve in serves]),
        }
        for kind, (asked, right) in expected.items():
            away = equation_6(*learnt, asked, standard)[:, :2] - np.array(right)
            mean = 100.0 * np.mean(np.linalg.norm(away, axis=1))
            assert found[kind][0][at] == pytest.approx(mean, rel=1e-6)


def answers(vision, truth):
    """Return hand-made errors: curves of two runs, 2 cm apart; a larger lambda is worse."""
    found = {}
    for eyes, curve in (("truth", truth), ("vision", vision)):
        rows = {
            f"{lam:g}": {
                kind: [[value + shift + k for value in curve] for shift in (-1.0, 1.0)]
                for kind in fig7a.ERRORS
            }
            for k, lam in enumerate(fig7a.LAMBDAS)
        }
        errors = dict.fromkeys(fig7a.LABELS, rows)
        found[eyes] = {"samples": [10.0, 13.0, 16.0], "errors": errors}
    return found


def test_lines_are_means_and_deviations_over_runs():
    told = fig7a.findings(QUICK, answers([20.0, 15.0, 14.0], [12.0, 9.0, 8.0]))
    assert len(told.ours) == 2 * 2 * len(fig7a.LAMBDAS)
    values = {line.label: line.values for line in told.ours}["vision, achieved, lambda 0.0005"]
    assert values["samples"] == [10.0, 13.0, 16.0]
    assert values["place_first_cm"] == 20.0
    assert values["label_last_cm"] == 14.0
    assert values["label_curve_cm"] == [20.0, 15.0, 14.0]
    assert values["place_last_cm_sd"] == pytest.approx(2.0**0.5)


def test_words_follow_numbers():
    said = fig7a.findings(QUICK, answers([20.0, 15.0, 14.0], [12.0, 9.0, 8.0])).remarks
    assert (
        "Vision, commanded: the best lambda at the end is 0.0005, and places are predicted to "
        in said
    )
    assert "20.0 cm with 10 samples, 15.0 cm with 13 and 14.0 cm with 16" in said
    assert "the error at the end is 6.0 cm smaller" in said
    said = fig7a.findings(QUICK, answers([8.0, 8.0, 8.0], [9.0, 9.0, 9.0])).remarks
    assert "predict no better" in said


def test_same_answers_give_the_same_plain_json():
    given = answers([20.0, 15.0, 14.0], [12.0, 9.0, 8.0])
    texts = {
        json.dumps(as_json("fig7a", fig7a.findings(QUICK, given), QUICK), allow_nan=False)
        for _ in range(2)
    }
    assert len(texts) == 1


def test_its_runs_are_those_of_fig_7b():
    for scale in (Scale(4), QUICK):
        theirs = {training for job in fig7b.jobs(scale) for training in job.trainings}
        ours = {training for job in fig7a.jobs(scale) for training in job.trainings}
        assert ours <= theirs
        assert len(ours) == 2 * scale.of(fig7a.RUNS, fig7a.FEW_RUNS)


def test_the_players_own_lambda_is_among_those_shown():
    assert PaperSettings().regularization in fig7a.LAMBDAS
    assert list(fig7a.LAMBDAS) == sorted(set(fig7a.LAMBDAS))
