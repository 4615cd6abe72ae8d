import json

import numpy as np

from rotorpong.lab.spec import Spec
from rotorpong.paper import fig4
from rotorpong.paper.findings import Scale
from rotorpong.paper.trajectory import EYES, FLOAT, TRACKER, WHOLE, told
from rotorpong.physics.camera import GAZEBO

FOCAL = GAZEBO.focal_length_px[0]


def staircase(diameters, ray=(0.05, -0.1)):
    """What eyes tell that see these diameters along one ray."""
    direction = np.array([*ray, 1.0]) / np.linalg.norm([*ray, 1.0])
    rows = []
    for k, diameter in enumerate(diameters):
        place = FOCAL * 0.04 / diameter * direction
        rows.append([k / 30.0, *place, 0.0, 0.0, -7.0, *place, 0.0, 1.0 - 0.5 * k, -7.0])
    return told(rows)


def made():
    rows = np.column_stack(staircase([3.0, 3.0, 4.0, 6.0])).tolist()
    counts = {"frames": 4, "changes": 2, "steps": 2, "steps_with_change": 2}
    return {"trajectory": dict.fromkeys(EYES, rows), **dict.fromkeys(fig4.CAMERAS, counts)}


def test_whole_diameters_are_read_back():
    diameters = [3, 3, 4, 7, 12, 31]
    assert fig4.diameters(staircase(diameters)).tolist() == diameters


def test_along_one_ray_depth_steps_where_the_diameter_changes_and_nowhere_else():
    one = staircase([3, 3, 4, 4, 4, 5, 7, 7, 12, 12])
    expected = [False, True, False, False, True, True, False, True, False]
    assert fig4.changes(one).tolist() == expected
    assert fig4.steps(one).tolist() == expected


def test_a_ray_that_turns_far_steps_without_a_change():
    near, far = staircase([3, 3]), staircase([3, 3], ray=(0.9, 0.4))
    turned = told(np.concatenate([np.column_stack(one)[:1] for one in (near, far)]))
    assert fig4.changes(turned).tolist() == [False]
    assert fig4.steps(turned).tolist() == [True]


def test_a_diameter_that_is_not_rounded_has_no_steps_in_the_table():
    found = fig4.findings(Scale(quick=True), made())
    values = {line.label: line.values for line in found.ours}
    assert values[f"serve 0, {WHOLE}"]["steps"] == 2
    assert all("steps" not in values[f"serve 0, {label}"] for label in (FLOAT, TRACKER))


def test_the_same_answers_give_the_same_json():
    found = [fig4.findings(Scale(quick=True), made()) for _ in range(2)]
    lines = [json.dumps([dict(line.values) for line in one.ours], allow_nan=False) for one in found]
    assert lines[0] == lines[1]


def test_eyes_that_told_nothing_have_no_errors():
    answers = {**made(), "trajectory": {label: [] for label in EYES}}
    found = fig4.findings(Scale(quick=True), answers)
    assert all(line.values["z_cm"] is None for line in found.ours[: len(EYES)])


def test_a_job_counts_the_steps_of_every_serve():
    one, two = (fig4.stepping(Spec("hover"), serves) for serves in (1, 2))
    assert 0 < one["frames"] < two["frames"]
    assert two["steps_with_change"] <= min(two["steps"], two["changes"])
    assert two["steps_with_change"] >= 0.95 * two["steps"]
