"""Demonstrations can be recorded anew to the bit, and replayed before other eyes and cameras."""

from dataclasses import replace

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.experience import shipped_demonstrations
from rotorpong.lab.demonstrate import lessons_of, record_demonstrations, replay
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.play.paper import PaperSettings

SHIPPED = shipped_demonstrations()


def assert_sound(lesson):
    """A lesson of finite numbers, of a ball at the plane and a motion that ends in a hit."""
    path = lesson.path
    for numbers in (lesson.ball, lesson.hitting_point, path.times, path.positions, path.velocities):
        assert np.isfinite(numbers).all()
    assert 1.0 < lesson.ball[2] < 2.5  # the first sight beyond the plane
    assert lesson.ball[5] < -3.0
    assert np.all(np.diff(path.times) > 0.0)
    assert 0.1 < lesson.hitting_point[6] < 1.5
    assert np.abs(path.positions).max() < 1.0
    assert 0.5 <= lesson.reward <= 1.0


def test_ten_ship_and_say_that_they_are_scripted():
    assert len(SHIPPED) == 10
    assert {one.pilot for one in SHIPPED} == {"scripted"}
    assert {one.seed for one in SHIPPED} == {0}
    assert len({one.trial for one in SHIPPED}) == 10


def test_recorded_anew_they_are_the_same_to_the_bit():
    told = []
    assert record_demonstrations(0, 2, lambda *done: told.append(done)) == SHIPPED[:2]
    assert told == [(1, 2), (2, 2)]


@pytest.mark.parametrize("eyes", ["truth", "paper"])
def test_every_one_of_them_teaches_something(eyes):
    told = []
    lessons = lessons_of(SHIPPED, Spec(eyes=eyes), lambda *done: told.append(done))
    assert len(lessons) == 10
    assert told == [(n, 10) for n in range(1, 11)]
    for lesson in lessons:
        assert_sound(lesson)


def test_another_camera_sees_the_same_motion():
    for one in SHIPPED[:2]:
        other = replay(one, Spec(camera="ardrone2_720p"))
        assert other is not None
        assert_sound(other)
        known = replay(one, Spec(eyes="truth"))
        assert known is not None
        end = known.path.times[-1]
        assert other.path.times[-1] == end  # the contact is one
        assert other.path.times[0] != known.path.times[0]  # the frames are not


def test_a_replay_depends_on_the_demonstration_and_not_on_the_spec_that_asks():
    one = replay(SHIPPED[0], Spec(eyes="truth"))
    two = replay(SHIPPED[0], Spec("hover", "truth", serves="constant", seed=9, blackout=False))
    assert one is not None
    assert two is not None
    np.testing.assert_array_equal(one.ball, two.ball)
    np.testing.assert_array_equal(one.path.positions, two.path.positions)


def test_replays_of_other_commands_eyes_and_triggers_are_not_taken_for_one_another():
    spec = Spec(eyes="truth")
    later = SHIPPED[0].commands + np.array([0.01, 0.0, 0.0, 0.0, 0.0])
    late = replace(SHIPPED[0], commands=later)
    lessons = [
        replay(SHIPPED[0], spec),
        replay(late, spec),
        replay(SHIPPED[0], Spec()),
        replay(SHIPPED[0], replace(spec, player_settings=PlayerSettings(plane_distance=2.0))),
        replay(SHIPPED[1], spec),
    ]
    told = {(*one.ball.tolist(), *one.path.positions[-1].tolist()) for one in lessons if one}
    assert len(told) == 5


@pytest.mark.parametrize(("trigger", "plane"), [("plane", 1.2), ("distance", 1.2), ("plane", 3.3)])
def test_a_lesson_begins_where_the_players_own_trigger_lies(trigger, plane):
    asked = PlayerSettings(trigger=trigger, plane_distance=plane)
    usual = lessons_of(SHIPPED[:3], Spec(eyes="truth"))
    lessons = lessons_of(SHIPPED[:3], Spec(eyes="truth", player_settings=asked))
    for lesson, before in zip(lessons, usual, strict=True):
        near = lesson.ball[2] if trigger == "plane" else np.linalg.norm(lesson.ball[:3])
        assert plane - 0.2 < near < plane  # the ball flies 0.15 m a frame
        shorter = lesson.hitting_point[6] < before.hitting_point[6]
        assert shorter == (plane < PaperSettings().plane_distance)


def test_what_was_flown_on_something_else_is_refused():
    foreign = replace(SHIPPED[0], spec={"vehicle": "crazyflie", "serves": "human"})
    with pytest.raises(InputError, match=r"crazyflie.*expected .*tum_gazebo"):
        replay(foreign, Spec())


def test_commands_that_no_longer_hit_are_refused():
    away = SHIPPED[0].commands.copy()
    away[:, 2] = 2.0
    with pytest.raises(InputError, match="no longer hits: it was recorded with another version"):
        replay(replace(SHIPPED[0], commands=away), Spec(eyes="truth"))


def test_eyes_that_see_nothing_learn_nothing():
    tiny = replace(Spec().camera_profile(), name="keyhole", focal_length_px=(37000.0, 37000.0))
    assert replay(SHIPPED[0], Spec(eyes="truth", camera=tiny)) is None
    assert lessons_of(SHIPPED[:2], Spec(eyes="truth", camera=tiny)) == ()
