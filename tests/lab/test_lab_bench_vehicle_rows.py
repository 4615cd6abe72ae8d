"""The vehicles' rows say that both vehicles are those that were measured."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rotorpong.lab.bench import vehicle_rows


@pytest.fixture(scope="module")
def errors():
    """Return the rows without timings, which belong to no test."""
    return (*vehicle_rows.tum_rows(), *vehicle_rows.ardrone2_rows())


def test_every_figure_of_the_facts_is_met(errors):
    aimed = [row for row in errors if row.target is not None]
    assert len(aimed) >= 12
    assert [row.name for row in aimed if not row.met] == []
    assert all(math.isfinite(row.as_json()["value"]) for row in errors)


def test_no_two_rows_have_a_name_in_common(errors):
    names = [row.name for row in errors]
    assert len(set(names)) == len(names)


def test_speed_rows_time_both_vehicles_alone_and_in_lockstep():
    rows = vehicle_rows.speed_rows(quick=True)
    assert len(rows) == 4
    assert all(row.value > 0.0 for row in rows)


def test_the_plugin_as_written_errs_by_the_square_of_the_angle_that_it_means():
    """The same formula by scipy, for one error of the accelerometer."""
    published = next(r.value for r in vehicle_rows.tum_rows() if "plugin" in r.name)
    gravity, error = np.array([0.0, 0.0, -9.8]), np.array([0.35, 0.0, 0.0])
    meant = math.atan2(0.35, 9.8)
    vector = np.cross(gravity, error) * math.sin(meant / 2)
    vector /= np.linalg.norm(gravity + error) * 9.8
    turned = Rotation.from_quat([*vector, math.cos(meant / 2)]).magnitude()
    assert turned == pytest.approx(meant**2, rel=0.01)
    # of two axes of that size the rms of the square is sqrt(8) a^2
    assert published == pytest.approx(math.degrees(math.sqrt(8) * meant**2), rel=0.05)
