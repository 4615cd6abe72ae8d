import json

import numpy as np
import pytest

from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import stage_of
from rotorpong.paper import table1
from rotorpong.paper.findings import Scale
from rotorpong.paper.trajectory import FLOAT, KEYS, TRACKER, WHOLE, mean_errors, told, watched
from rotorpong.world.serves import crossing

QUICK = Scale(quick=True)
PAPERS = [*table1.PAPER.values(), 20.0, 0.03, 0.2]


def made(share):
    """Answers in which the paper's eyes err as the paper, the tracker by a share of that."""
    rows = {WHOLE: 1.0, FLOAT: 0.5, TRACKER: share}
    tables = {
        label: [[factor * value * (1.0 + k) for value in PAPERS] for k in (-0.5, 0.5)]
        for label, factor in rows.items()
    }
    return {job.key: {k: tables[k] for k in job.arguments[3] or tables}
            for job in table1.jobs(QUICK)}  # fmt: skip


def test_lines_are_means_over_trajectories():
    found = table1.findings(QUICK, made(0.05))
    values = next(line.values for line in found.ours if line.label == f"gazebo, human, {WHOLE}")
    for key, expected in table1.PAPER.items():
        assert values[key] == pytest.approx(expected)
        assert values[f"{key}_sd"] == pytest.approx(expected / np.sqrt(2.0))
    assert values["x_over_z"] == pytest.approx(0.77 / 24.15)


@pytest.mark.parametrize(("share", "word"), [(0.05, "met"), (0.2, "missed")])
def test_the_target_is_met_by_a_tenth_of_the_paper_s_eyes(share, word):
    found = table1.findings(QUICK, made(share))
    assert found.remarks.count(f"{share:.3f} ({word})") == 2 * len(table1.TARGETED)
    tracked = [line.values for line in found.ours if line.label.endswith(TRACKER)]
    assert all(v["vy_cm_per_s_of_paper_eyes"] == pytest.approx(share) for v in tracked)


def test_the_same_answers_give_the_same_json_and_no_nan():
    lines = [
        json.dumps([(line.label, dict(line.values)) for line in found.ours], allow_nan=False)
        for found in (table1.findings(QUICK, made(0.1)) for _ in range(2))
    ]
    assert lines[0] == lines[1]


def test_a_single_trajectory_is_no_average():
    answers = {key: {k: rows[:1] for k, rows in found.items()} for key, found in made(0.1).items()}
    found = table1.findings(QUICK, answers)
    assert all(line.values["z_cm"] is None for line in found.ours)


def test_centred_balls_are_planned_as_far_aside_as_the_paper_s():
    rng = np.random.default_rng(5)
    serves = [table1.centred_serves(0, rng) for _ in range(200)]
    camera_x = -1.67 - 0.23 + 0.21  # blade, body, camera
    aside = [abs(s.ball.position[1]) / (s.ball.position[0] - camera_x) for s in serves]
    sd = 0.77 / 24.15 / np.sqrt(3.0 * len(aside))  # of a mean of uniform values
    assert np.mean(aside) == pytest.approx(0.77 / 24.15, abs=4.0 * sd)


def test_centred_balls_arrive_in_the_middle():
    rng = np.random.default_rng(6)
    for _ in range(5):
        _, state = crossing(table1.centred_serves(0, rng))
        assert abs(state[1]) < 2e-3


def test_a_depth_error_alone_moves_an_estimate_along_the_ray():
    ball = np.array([0.08, 0.5, 2.5])
    row = [0.0, *(1.1 * ball), 0.0, 0.0, 0.0, *ball, 0.0, 0.0, 0.0]
    x, y, z, *_ = mean_errors(told([row]))
    assert (x / z, y / z) == pytest.approx((0.08 / 2.5, 0.5 / 2.5))


def test_a_job_watches_trajectories_of_the_spec():
    spec = Spec("hover", seed=3)
    found = table1.errors(spec, "human", 1, (WHOLE,))
    one = told(watched(stage_of(spec), 0, (WHOLE,))[WHOLE])
    assert found[WHOLE][0][: len(KEYS)] == mean_errors(one).tolist()
    assert found[WHOLE][0][len(KEYS)] == len(one.time)
