"""Figures of growth show what was measured beside what proportion would give."""

import pytest

from rotorpong.lab.bench.growth import Growth, drawn


@pytest.mark.parametrize(("name", "proportion"), [("balls", [2.0, 20.0]), ("workers", [1.0, 0.1])])
def test_work_grows_and_workers_share_it(name, proportion):
    axes = drawn(Growth(name, "how many", "s", (1, 10), (1.0, 20.0))).axes[0]
    straight, measured = axes.lines
    assert list(straight.get_ydata()) == pytest.approx(proportion)
    assert list(measured.get_ydata()) == [1.0, 20.0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("how many", "s")
