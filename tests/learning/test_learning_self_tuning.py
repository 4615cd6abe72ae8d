"""CrKR that tunes itself: when, and that nothing but the samples counts."""

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.learning import CrKR, SelfTuningCrKR, tune

rng = np.random.default_rng(0)
STATES = rng.normal(size=(40, 3))
POINTS = np.stack([np.sin(STATES[:, 0]), STATES[:, 0] * STATES[:, 1]], axis=1)
COSTS = rng.uniform(1.0, 3.0, size=40)
QUERIES = rng.normal(size=(7, 3))


def grown(count, *, asked=()):
    ours = SelfTuningCrKR(2.0, 0.1)
    for i in range(count):
        ours.partial_fit(STATES[i : i + 1], POINTS[i : i + 1], COSTS[i : i + 1])
        if i in asked:
            ours.predict(QUERIES)
    return ours


def test_with_few_samples_it_is_untuned():
    plain = CrKR(2.0, 0.1).fit(STATES[:9], POINTS[:9], COSTS[:9])
    np.testing.assert_allclose(grown(9).predict(QUERIES), plain.predict(QUERIES), atol=1e-12)


@pytest.mark.parametrize(("count", "due"), [(10, 10), (14, 10), (15, 15), (21, 15), (40, 33)])
def test_its_parameters_are_those_of_the_first_so_many_samples(count, due):
    expected = tune(STATES[:due], POINTS[:due], COSTS[:due]).crkr()
    expected.fit(STATES[:count], POINTS[:count], COSTS[:count])
    ours = grown(count)
    np.testing.assert_allclose(ours.predict(QUERIES), expected.predict(QUERIES), atol=1e-9)
    np.testing.assert_array_equal(ours.tuned().length_scales, expected.length_scales)


def test_it_does_not_matter_when_it_was_asked():
    never, often = grown(40), grown(40, asked=range(40))
    np.testing.assert_allclose(never.predict(QUERIES), often.predict(QUERIES), atol=1e-9)
    np.testing.assert_array_equal(never.tuned().length_scales, often.tuned().length_scales)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="not fitted"):
        SelfTuningCrKR().predict(QUERIES)
    with pytest.raises(InputError, match="negative"):
        SelfTuningCrKR().fit(STATES, POINTS, -COSTS)
    with pytest.raises(InputError, match="3, as in fit"):
        grown(12).partial_fit(STATES[:, :2], POINTS)
