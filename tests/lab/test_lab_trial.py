"""One serve from beginning to end, and who is blamed for what."""

import numpy as np
import pytest

from rotorpong.drone import HOVER, Drone, VelocityCommand
from rotorpong.lab.footage import play_again
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import encounter, new_drone, play_trial, stage_of
from rotorpong.physics.camera import GAZEBO, project
from rotorpong.play.hover import Hover

UNSEEN_BALL = 0  # of seed 0: a hovering drone misses it by far


def stage(purpose="evaluate", **spec):
    return stage_of(Spec(**spec), purpose)


class Playing:
    """A player of one's own that calls `act` at every frame."""

    def __init__(self, act):
        self._act = act

    def play(self, drone, eyes, rng):
        while (observation := drone.observe()) is not None:
            self._act(drone, eyes, observation)

    def learn(self, verdict):
        raise AssertionError


def test_the_same_serve_is_thrown_at_every_player():
    one = play_trial(stage(player="hover", eyes="truth"), 3, Hover())
    two = play_trial(stage(player="paper", eyes="paper"), 3, Playing(lambda *_: None))
    np.testing.assert_array_equal(one.serve.ball.velocity, two.serve.ball.velocity)
    np.testing.assert_array_equal(one.serve.ball.spin, two.serve.ball.spin)


def test_whoever_only_hovers_does_as_hover_does():
    for index in range(4):
        idle = play_trial(stage(), index, Playing(lambda drone, *_: drone.command(HOVER))).truth
        hover = play_trial(stage(), index, Hover()).truth
        assert (idle.verdict, idle.miss_distance) == (hover.verdict, hover.miss_distance)
        np.testing.assert_array_equal(idle.body_path, hover.body_path)


def test_demonstrations_training_and_evaluation_throw_different_balls():
    thrown = {
        play_trial(stage(purpose), 0, Hover()).serve.ball.velocity[1]
        for purpose in ("demonstrate", "train", "evaluate")
    }
    assert len(thrown) == 3


def test_who_leaves_early_is_judged_all_the_same():
    class Leaving:
        def play(self, drone, eyes, rng):
            return None

        def learn(self, verdict):
            raise AssertionError

    assert (
        play_trial(stage(), 2, Leaving()).truth.verdict == play_trial(stage(), 2, Hover()).verdict
    )


@pytest.mark.parametrize("error", [ValueError("no way"), SystemExit(0), RecursionError()])
def test_a_player_that_raises_has_played_a_fault(error, capsys):
    def act(*_):
        raise error

    played = play_trial(stage(), 1, Playing(act))
    assert played.outcome == "fault"
    assert capsys.readouterr().err.startswith(f"rotorpong: trial 1: {type(error).__name__}: ")


def test_a_serve_that_a_player_broke_off_has_no_miss_distance_and_one_that_was_over_has():
    def act(*_):
        raise ValueError

    class Late:
        def play(self, drone, eyes, rng):
            while drone.observe() is not None:
                pass
            raise ValueError

        def learn(self, verdict):
            raise AssertionError

    broken = play_trial(stage(), 1, Playing(act))  # this ball hits a hovering blade
    assert broken.truth.miss_distance == 0.0
    assert (broken.outcome, broken.miss_distance, broken.time_error) == ("fault", None, None)
    late = play_trial(stage(), UNSEEN_BALL, Late())
    assert late.outcome == "miss"
    assert late.miss_distance == late.truth.miss_distance > 0.0


@pytest.mark.parametrize("error", [ValueError("a\n b\nc"), GeneratorExit("a b c")])
def test_what_a_player_raised_is_one_line(error, capsys):
    def act(*_):
        raise error

    play_trial(stage(), 1, Playing(act))
    assert capsys.readouterr().err == f"rotorpong: trial 1: {type(error).__name__}: a b c\n"


@pytest.mark.parametrize("watched", [False, True])
def test_a_player_that_goes_on_when_its_serve_is_over_is_stopped(watched, capsys):
    class Deaf:
        def play(self, drone, eyes, rng):
            while True:
                drone.observe()
                drone.command(HOVER)

        def learn(self, verdict):
            raise AssertionError

    play = play_again if watched else play_trial
    played = play(stage(), UNSEEN_BALL, Deaf())
    assert (played.played if watched else played).outcome == "miss"
    assert "after it returned None: a serve is over then" in capsys.readouterr().err


def test_a_player_may_ask_some_times_too_often(capsys):
    class Slow:
        def play(self, drone, eyes, rng):
            for _ in range(500):
                drone.observe()

        def learn(self, verdict):
            raise AssertionError

    assert play_trial(stage(), UNSEEN_BALL, Slow()).outcome == "miss"
    assert capsys.readouterr().err == ""


def test_a_command_that_is_no_number_is_a_fault_of_the_player(capsys):
    def act(drone, eyes, observation):
        drone.command(VelocityCommand(float("nan")))

    assert play_trial(stage(), 1, Playing(act)).outcome == "fault"
    assert "expected finite velocities" in capsys.readouterr().err


def test_ctrl_c_is_no_fault_of_the_player():
    def act(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        play_trial(stage(), 1, Playing(act))


def test_eyes_that_were_asked_and_never_answered_make_it_unseen():
    dark = stage(blackout=True)
    looking = Playing(lambda drone, eyes, observation: eyes.see(observation))
    assert play_trial(dark, UNSEEN_BALL, looking).outcome == "unseen"
    assert play_trial(dark, UNSEEN_BALL, Playing(lambda *_: None)).outcome == "miss"
    assert play_trial(stage(eyes="truth"), UNSEEN_BALL, looking).outcome == "miss"


def test_an_unseen_ball_may_still_be_hit_by_chance():
    outcomes = {
        play_trial(stage(blackout=True), i, Playing(lambda d, e, o: e.see(o))).outcome
        for i in (0, 1, 2)
    }
    assert outcomes == {"unseen", "hit", "hull"}


def test_no_player_gets_a_command_beyond_the_limits():
    sent = []
    greedy = Playing(
        lambda drone, *_: sent.append(drone.command(VelocityCommand(99.0, -99.0, 9.0)))
    )
    play_trial(stage(), 0, greedy)
    assert set(sent) == {VelocityCommand(2.0, -2.0, 0.5, 0.0)}
    assert HOVER not in sent


def test_a_player_gets_nothing_of_the_drone_but_observe_and_command():
    handed = []

    def act(drone, *_):
        handed.append({name for name in dir(drone) if not name.startswith("_")})
        assert isinstance(drone, Drone)

    play_trial(stage(), 1, Playing(act))
    assert handed[0] == {"observe", "command"}


def test_a_white_ball_flies_as_an_orange_one_and_is_all_that_looks_different():
    orange, white = (new_drone(stage(ball=ball), 0) for ball in ("orange", "white"))
    for _ in range(6):
        one, other = orange.observe(), white.observe()
        assert one.frame_time == other.frame_time
        place = orange.ball_in_camera(one.frame_time)[0]
        assert np.array_equal(place, white.ball_in_camera(other.frame_time)[0])
        differing = np.argwhere(np.any(one.frame.picture != other.frame.picture, axis=2))
        center = project(GAZEBO, place)
        assert 0 < len(differing) < 40
        assert np.abs(differing[:, ::-1] - center).max() < 5.0


@pytest.mark.parametrize("ball", ["orange", "white"])
def test_with_another_room_for_every_ball_the_ball_keeps_its_colour(ball):
    rooms = stage(ball=ball, randomize=True)
    for index in range(5):
        setting, _ = encounter(rooms, index, trial_generators(0, "evaluate", index))
        blue, _, red = setting.scene.ball
        assert (red > 2.5 * blue) == (ball == "orange")
