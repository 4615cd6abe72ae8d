import numpy as np
import pytest

from rotorpong.vision._gather_kernels import ENOUGH, thinning
from rotorpong.vision._outline_kernels import (
    NEAR,
    PLACES,
    RAMP,
    SECTOR,
    SECTORS,
    deep_span,
    place_row,
)

SHAPE = np.array([[1.1, 0.04], [0.04, (1 + 0.04**2) / 1.1]])
INVERSE = np.linalg.inv(SHAPE)
STATES = (
    np.array([20.3, 17.8, 12.0, 0.0, 0.0, 0.5]),
    np.array([20.3, 17.8, 9.0, 3.1, -4.2, 0.5]),
)


def own_frame(state, row, columns):
    pixels = np.stack([columns, np.full(len(columns), row)], axis=-1)
    return (pixels - state[:2]) @ INVERSE.T


@pytest.mark.parametrize("state", STATES, ids=["at rest", "moving"])
@pytest.mark.parametrize("step", [1, 2])
def test_pixels_of_a_row_lie_where_plain_geometry_has_them(state, step):
    places, u = np.zeros(5 * PLACES, np.float32), state[3:5]
    places[RAMP:] = np.arange(PLACES)
    for row in range(0, 40, 3):
        place_row(places, state, INVERSE, row, 5, step)
        q = own_frame(state, row, 5 + step * np.arange(PLACES))
        np.testing.assert_allclose(places[: 2 * PLACES].reshape(2, -1).T, q, atol=1e-4)
        along = q @ u / (u @ u) if u.any() else np.zeros(PLACES)
        near = np.linalg.norm(q - np.clip(along, -1.0, 1.0)[:, None] * u, axis=1)
        np.testing.assert_allclose(np.sqrt(places[NEAR : NEAR + PLACES]), near, atol=1e-3)
        length = np.linalg.norm(u)
        squeezed = q - along[:, None] * length / (state[2] + length) * u
        angle = np.arctan2(squeezed[:, 1], squeezed[:, 0]) * SECTORS / (2 * np.pi)
        off = (places[SECTOR : SECTOR + PLACES] - angle + SECTORS / 2) % SECTORS - SECTORS / 2
        assert np.abs(off).max() < 0.02


@pytest.mark.parametrize("state", STATES, ids=["at rest", "moving"])
@pytest.mark.parametrize("reach", [0.0, 6.0, 9.5])
def test_the_deep_span_is_where_both_ends_are_within_reach(state, reach):
    columns = np.arange(-5, 50)
    for row in range(40):
        q, u = own_frame(state, row, columns), state[3:5]
        farthest = np.maximum(*(np.linalg.norm(q - sign * u, axis=1) for sign in (-1, 1)))
        first, end = deep_span(state, SHAPE, INVERSE, row, reach)
        np.testing.assert_array_equal(columns[farthest < reach], np.arange(first, end))


def test_of_a_large_edge_enough_pixels_are_left_and_alike_in_every_row_and_column():
    for radius in (5.0, 12.0, 30.0, 80.0, 400.0):
        state, half = np.array([0.0, 0.0, radius, 0.0, 0.0, 0.45]), 2.2
        every, stride = thinning(state, half)
        pixels = 2.0 * half * 2.0 * np.pi * radius
        assert pixels / every > min(0.5 * ENOUGH, 0.99 * pixels)
        assert pixels / every < 1.5 * ENOUGH
        rows, columns = np.indices((3 * every, 3 * every))
        kept = (rows + stride * columns) % every == 0
        assert (kept.sum(axis=0) == 3).all()
        assert (kept.sum(axis=1) == 3).all()
