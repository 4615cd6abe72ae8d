"""Table II, Fig. 5 and Fig. 6: how motions are flown, re-targeted and begun."""

import numpy as np
import pytest

from rotorpong.conventions import BALL_RADIUS
from rotorpong.lab.spec import Spec
from rotorpong.paper import fig5, fig6, table2
from rotorpong.paper.findings import Scale
from rotorpong.paper.tally import arrival
from rotorpong.world.racket import HOME_BLADE

QUICK = Scale(quick=True)


@pytest.fixture(scope="module")
def open_loop():
    return table2.flown("tum_gazebo", "one motion", "open", 0, 2)


def test_open_loop_the_drone_is_late_by_its_lag(open_loop):
    wanted, was = np.array(open_loop["wanted"]), np.array(open_loop["was"])
    lag, step = 0.4, 0.02
    model = np.zeros_like(wanted)  # lag v' + v = u, forward in time, with u the motion's velocity
    speed = np.zeros(3)
    for k in range(1, len(wanted)):
        command = (wanted[k] - wanted[k - 1]) / step
        speed = command + (speed - command) * np.exp(-step / lag)
        model[k] = model[k - 1] + step * speed
    np.testing.assert_allclose(was[-1, 1:], model[-1, 1:], atol=0.03)


def test_errors_of_table_ii_are_means_over_time_and_runs():
    answer = {"errors": [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3.0, 2.0, 1.0, 0.0, 5.0, 8.0]]}
    found = table2._numbers(answer)
    assert (found["x_cm"], found["vz_cm_s"]) == (2.0, 7.0)
    assert found["x_cm_sd"] == pytest.approx(np.sqrt(2.0))


def test_table_ii_gives_all_controls_the_same_runs(open_loop):
    again = table2.flown("tum_gazebo", "one motion", "open", 0, 2)
    assert again == open_loop
    assert table2.flown("tum_gazebo", "one motion", "open", 1, 2) != open_loop


def test_a_primitive_meets_its_goal_and_keeps_its_shape():
    answer = fig5.rolled_out()
    found = fig5.findings(QUICK, {"it": answer})
    for line in found.ours[1:]:
        assert line.values["end_cm"] < 1e-9
        assert line.values["shape_cm"] < 1e-9
    assert found.ours[0].values["rms_cm"] < 0.2
    shown = np.array(answer["demonstration"])
    apart = np.abs(shown[-1] - shown[0])
    assert answer["axis"] == int(apart.argmax())


def test_within_the_sphere_is_later_than_behind_the_plane():
    found = fig6.watched(Spec("hover", eyes="truth"), 6)
    for plane, distance in zip(found["plane"], found["distance"], strict=True):
        assert plane is not None
        assert distance is None or distance[0] <= plane[0]
        assert plane[3] < 2.5
        assert distance is None or np.linalg.norm(distance[1:]) < 2.5


def test_a_ball_arrives_when_it_passes_the_blades_plane_or_when_its_path_ends():
    plane = HOME_BLADE[0] + BALL_RADIUS
    passing = np.array([[plane + 0.3, 0.0, 0.0], [plane + 0.01, 0.0, 0.0], [plane - 0.01, 0, 0]])
    assert arrival(passing) == 2
    assert arrival(passing[:2]) == 1


def test_numbers_of_a_trigger_that_hardly_ever_fires_are_none():
    found = fig6._numbers([None, None, None, [0.5, 0.0, 0.0, 2.4]])
    assert found["triggered_percent"] == 25.0
    assert found["depth_m"] is None
