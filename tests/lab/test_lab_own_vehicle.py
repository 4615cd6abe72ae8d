"""A vehicle that a user writes plays like those that ship; the example is such a one."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.evaluate import evaluate, summary
from rotorpong.lab.spec import Spec
from rotorpong.physics.vehicle import TICK, Vehicle

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "point_mass.py"


@pytest.fixture(scope="module")
def point():
    """Return the example's vehicle."""
    spec = importlib.util.spec_from_file_location("point_mass", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses and pickle look for it
    spec.loader.exec_module(module)
    return module.PointMass()


def at_rest(point, count=None):
    home = np.array([-1.9, 0.0, 0.2])
    position = home if count is None else np.tile(home, (count, 1))
    return point.start(position, np.random.default_rng(0))


def test_it_is_a_vehicle_and_plays(point):
    assert isinstance(point, Vehicle)
    spec = Spec("paper", "truth", vehicle=point).check()
    results = evaluate(spec, 6)
    assert summary(spec, results)["vehicle"] == "point_mass"
    assert "fault" not in [result.outcome for result in results]
    still = evaluate(Spec("hover", vehicle=point), 6)
    assert [r.miss_distance for r in still] != [r.miss_distance for r in results]


def test_it_hovers_as_the_home_of_every_drone(point):
    hover = evaluate(Spec("hover", vehicle=point), 4)
    calm = evaluate(Spec("hover", vehicle=replace(point, lag=9.0)), 4)
    assert [(r.outcome, r.miss_distance) for r in hover] == [
        (r.outcome, r.miss_distance) for r in calm
    ]


def test_it_can_be_randomised(point):
    spec = Spec("hover", vehicle=point, randomize=True).check()
    assert evaluate(spec, 2) == evaluate(spec, 2)


def test_it_flies_the_closed_form_of_its_lag(point):
    order = np.array([1.0, -2.0, 0.5, 0.0])
    _, track = point.advance(at_rest(point), order, ticks=800, new_command=True)
    t = np.arange(801)[:, None] * TICK
    gone = order[:3] * (t - point.lag * (1 - np.exp(-t / point.lag)))
    assert track.position - track.position[0] == pytest.approx(gone, abs=1e-12)


def test_legs_and_batches_change_nothing(point):
    order = np.array([1.0, 0.5, -0.5, 0.0])
    whole, _ = point.advance(at_rest(point), order, ticks=50, new_command=True)
    state, _ = point.advance(at_rest(point), order, ticks=20, new_command=True)
    state, _ = point.advance(state, np.zeros(4), ticks=30, new_command=False)
    assert np.array_equal(state.motion, whole.motion)
    many, tracks = point.advance(
        at_rest(point, 3), np.tile(order, (3, 1)), ticks=50, new_command=True
    )
    assert np.array_equal(many.motion, np.tile(whole.motion, (3, 1)))
    assert tracks.quaternion.shape == (3, 51, 4)


def test_no_number_that_is_none_enters_it(point):
    with pytest.raises(InputError, match="expected finite"):
        point.advance(at_rest(point), np.full(4, np.nan), ticks=5, new_command=True)
