from typing import NamedTuple

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.physics.constants import drawn, require_constants


class Spring(NamedTuple):
    stiffness: float = 10.0
    damping: float = 1.0
    rest: float = 0.0


RANGES = {"damping": (0.5, 1.5), "stiffness": (8.0, 9.0)}


def test_what_has_a_range_is_drawn_from_it_and_the_rest_stays():
    springs = [drawn(Spring(), RANGES, np.random.default_rng(i)) for i in range(300)]
    assert {spring.rest for spring in springs} == {0.0}
    for name, (low, high) in RANGES.items():
        share = (np.array([getattr(s, name) for s in springs]) - low) / (high - low)
        assert 0.0 <= share.min() < share.max() <= 1.0
        assert share.std() == pytest.approx(np.sqrt(1 / 12), abs=4 / np.sqrt(300) / 6)  # 4 sigma


def test_the_order_in_which_ranges_are_written_changes_nothing():
    turned = dict(reversed(RANGES.items()))
    one, two = (drawn(Spring(), r, np.random.default_rng(1)) for r in (RANGES, turned))
    assert one == two


def test_a_range_of_no_width_is_its_value():
    assert drawn(Spring(), {"rest": (2.0, 2.0)}, np.random.default_rng(0)).rest == 2.0


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"stiffness": -1.0}, "mine: stiffness -1.0: expected a finite number 0.0 to inf"),
        ({"rest": np.nan}, "rest nan"),
        ({"rest": np.inf}, "rest inf"),
        ({"damping": 2.5}, "mine: damping 2.5: expected a finite number 0.1 to 2.0"),
    ],
)
def test_constants_that_cannot_be_are_refused(change, said):
    limits = {"damping": (0.1, 2.0), "rest": (-1.0, np.inf), "unknown": (0.0, 1.0)}
    require_constants("mine", Spring(), limits)
    with pytest.raises(InputError) as refusal:
        require_constants("mine", Spring()._replace(**change), limits)
    assert said in str(refusal.value)
