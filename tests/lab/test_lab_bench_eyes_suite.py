"""Rows of `bench eyes` about whole serves: what they are made of."""

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.bench import prediction_rows, tracking_rows
from rotorpong.lab.bench.suites import SUITES, Order
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import stage_of

STAGE = stage_of(Spec("hover"))


def test_a_suite_is_asked_for_what_is_its_own(tmp_path):
    titles = [section.title for section in SUITES["eyes"] if section.asked(Order("eyes"))]
    assert titles == ["measuring", "tracking", "predicting"]
    Order("eyes").check()
    with pytest.raises(InputError, match="--flights with bench eyes: belongs to bench world"):
        Order("eyes", flights=tmp_path).check()


def test_a_tracked_serve_is_measured_at_the_plane_and_at_the_blade():
    one = tracking_rows._tracked(STAGE, 0)
    assert np.abs(one.at_plane[0]).max() < 0.1
    assert 0.3 < one.ahead < 1.2
    assert one.miss < 0.3
    assert one.sights > 5
    assert one.nees > 0.0


def test_tracking_beats_the_papers_eyes_on_the_same_serve():
    tracked, paper = tracking_rows._tracked(STAGE, 1), tracking_rows._paper(STAGE, 1)
    assert np.linalg.norm(tracked.at_plane[1]) < np.linalg.norm(paper.at_plane[1])


def test_the_band_of_nis_is_that_of_chi_square():
    def one(level, sights=20):
        sds = np.full(6, 0.1)
        return tracking_rows.Watched(None, 1.0, sds, 0.5, 0.1, level, sights)

    assert tracking_rows._in_band(one(3.0))
    assert not tracking_rows._in_band(one(1.5))
    assert not tracking_rows._in_band(one(5.0))


def test_predictions_get_worse_with_a_wrong_attitude_and_further_ahead():
    errors = {}
    for tilt in (0.0, 1.0):
        serves = [prediction_rows._predicted(seed, tilt) for seed in range(12)]
        good = [one for one in serves if one is not None]
        assert len(good) > 8
        errors[tilt] = {a: np.mean([one.ahead[a] for one in good]) for a in prediction_rows.AHEAD}
    assert errors[0.0][0.4] < errors[1.0][0.4] < 0.2
    assert errors[0.0][0.2] < errors[0.0][0.4] * 1.2
