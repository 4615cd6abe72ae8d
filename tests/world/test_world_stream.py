"""The video stream costs what a stream costs, and no frame depends on who looks at which."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.physics.camera import Camera
from rotorpong.world.stream import Stream

SMALL = Camera("small", 160, 90, (140.0, 140.0), (80.0, 45.0), stream_mbit_s=0.25)
COUNT = 8


def scenes():
    """A bright disc that moves over a ramp."""
    rows, columns = np.mgrid[:90, :160]
    for k in range(COUNT):
        picture = np.repeat((columns + rows)[..., None], 3, axis=2).astype(np.uint8)
        picture[(columns - 40 - 8 * k) ** 2 + (rows - 45) ** 2 < 100] = (40, 128, 250)
        yield picture


def streamed(camera=SMALL, order=range(COUNT)):
    stream = Stream(camera)
    sent = [stream.send(lambda picture=picture: picture) for picture in scenes()]
    seen = {k: sent[k]() for k in order}
    return [seen[k] for k in sorted(seen)]


def test_what_arrives_is_what_was_sent_but_for_the_losses_of_the_codec():
    for sent, seen in zip(scenes(), streamed(), strict=True):
        error = sent.astype(float) - seen
        assert seen.shape == sent.shape
        assert 0.2 < np.sqrt(np.mean(error**2)) < 12.0
        assert np.corrcoef(sent.ravel(), seen.ravel())[0, 1] > 0.98


def test_fewer_bits_cost_more_detail():
    rng, errors = np.random.default_rng(0), []
    grain = rng.integers(0, 60, (40, 90, 160, 3), dtype=np.uint8)
    for rate in (0.1, 4.0):
        stream = Stream(replace(SMALL, stream_mbit_s=rate))
        sent = [stream.send(lambda picture=picture: picture) for picture in grain]
        errors.append(np.abs(sent[-1]() - grain[-1].astype(float)).mean())
    assert errors[0] > 1.3 * errors[1]


def test_frames_are_the_same_in_whatever_order_they_are_looked_at():
    forward, backward, again = streamed(), streamed(order=range(COUNT)[::-1]), streamed()
    for a, b, c in zip(forward, backward, again, strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(a, c)


def test_nothing_is_made_before_somebody_looks():
    made = []
    stream = Stream(SMALL)
    sent = [
        stream.send(lambda k=k, picture=picture: made.append(k) or picture)
        for k, picture in enumerate(scenes())
    ]
    assert made == []
    sent[2]()
    assert made == [0, 1, 2]
    sent[1]()
    assert made == [0, 1, 2]


def test_without_the_codec_the_error_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=r"rotorpong\[drone\]"):
        Stream(SMALL)


def test_odd_sizes_are_refused():
    with pytest.raises(InputError, match="even"):
        Stream(replace(SMALL, width_px=161))
