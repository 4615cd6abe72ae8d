"""Balls of single frames linked: made flights, filmed from the side, whose truth is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotorpong.vision.linking import CONFIRMED, Linker
from rotorpong.vision.located import LocatedBall

DIAMETER = 0.04  # m


def ball(x, y, diameter=12.0, score=0.8):
    return LocatedBall(float(x), float(y), float(diameter), score, "orange")


def thrown(frames, rate, start=(0.2, 1.0), velocity=(4.0, 2.0), scale=300.0, table=0.0):
    """Places (px) of a ball thrown across the picture that bounces on a table, frame by frame."""
    place, speed, step = np.array(start), np.array(velocity), 1.0 / (50 * rate)
    places = []
    for _ in range(frames):
        places.append((place[0] * scale, 600.0 - place[1] * scale))
        for _ in range(50):
            speed = speed + step * (np.array([0.0, -9.81]) - 0.15 * np.linalg.norm(speed) * speed)
            place = place + step * speed
            if place[1] < table and speed[1] < 0.0:
                speed = speed * np.array([0.8, -0.9])
    return places


def numbers(linker, frames):
    """Numbers of the tracks of every ball of every frame, after the last."""
    told = [linker.add(balls) for balls in frames]
    return [[None if t is None else t.number for t in tracks] for tracks in told]


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0, 240.0])
@pytest.mark.parametrize("scale", [100.0, 300.0, 2000.0])
def test_a_ball_that_flies_and_bounces_is_one_track_at_any_rate_and_size(rate, scale):
    places = thrown(round(1.2 * rate), rate, scale=scale)
    found = numbers(Linker(rate), [[ball(x, y, DIAMETER * scale)] for x, y in places])
    assert found == [[1]] * len(places)


def test_two_balls_that_cross_keep_their_numbers():
    one = thrown(30, 30.0, start=(0.0, 1.2), velocity=(4.0, 1.0))
    other = thrown(30, 30.0, start=(4.0, 0.9), velocity=(-4.0, 1.5))
    frames = [[ball(*a), ball(*b)] for a, b in zip(one, other, strict=True)]
    assert numbers(Linker(30.0), frames) == [[1, 2]] * 30


def test_the_order_of_candidates_does_not_matter():
    places = thrown(20, 30.0)
    still = [(50.0, 60.0), (400.0, 90.0)]
    rng = np.random.default_rng(0)
    linker, owners = Linker(30.0), {}
    for place in places:
        shown = [place, *still]
        order = rng.permutation(3)
        for k, track in zip(order, linker.add([ball(*shown[k]) for k in order]), strict=True):
            owners.setdefault(k, set()).add(track)
    assert [len(owners[k]) for k in range(3)] == [1, 1, 1]
    assert len({track.number for tracks in owners.values() for track in tracks}) == 3


def test_a_ball_unseen_for_a_while_comes_back_to_its_track_and_later_to_none():
    places = thrown(60, 30.0, velocity=(3.0, 4.0))
    seen = [[ball(*p)] if k < 8 or 12 <= k < 16 or k >= 40 else [] for k, p in enumerate(places)]
    found = numbers(Linker(30.0), seen)
    assert [f for f in found[:16] if f] == [[1]] * 12
    assert found[-1] == [2]


def test_a_flash_has_no_number():
    places = thrown(12, 30.0)
    frames = [[ball(*p)] for p in places]
    frames[4].append(ball(20.0, 30.0))
    frames[5].append(ball(21.0, 30.0))
    found = numbers(Linker(30.0), frames)
    assert found[4][1] is found[5][1] is None
    assert [f[0] for f in found] == [1] * 12


def test_numbers_go_on_from_the_sequence_before():
    first = Linker(30.0)
    numbers(first, [[ball(100, 100)]] * CONFIRMED)
    second = Linker(30.0, first=first.next_number)
    assert numbers(second, [[ball(100, 100)]] * CONFIRMED) == [[2]] * CONFIRMED


def test_what_hardly_is_a_ball_starts_no_track():
    assert numbers(Linker(30.0), [[ball(100, 100, score=0.01)]] * 5) == [[None]] * 5


def test_the_trail_is_where_the_ball_was_seen():
    places = thrown(10, 30.0)
    linker = Linker(30.0)
    for place in places:
        linker.add([ball(*place)])
    (track,) = linker.tracks
    assert [frame for frame, _, _ in track.sights] == list(range(10))
    np.testing.assert_allclose([(x, y) for _, x, y in track.sights], places)


number = st.floats(-1e5, 1e5)
candidates = st.lists(
    st.builds(ball, number, number, st.floats(1e-3, 1e5), st.floats(0.0, 1.0)), max_size=6
)


@settings(max_examples=60, deadline=None)
@given(st.lists(candidates, max_size=8), st.floats(0.1, 1000.0))
def test_whatever_is_seen_each_ball_has_at_most_one_track_and_each_track_one_ball(frames, rate):
    linker = Linker(rate)
    for balls in frames:
        tracks = linker.add(balls)
        assert len(tracks) == len(balls)
        own = [track for track in tracks if track is not None]
        assert len(own) == len(set(map(id, own)))
        for track in linker.tracks:
            assert np.isfinite(track.place).all()
