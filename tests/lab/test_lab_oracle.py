"""The oracle knows everything and still may not act before the third frame."""

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, VelocityCommand
from rotorpong.lab.bench.reach_rows import stage_of
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.oracle import Gate, Oracle, arrivals
from rotorpong.lab.oracle_search import fly, plan_of, problem_of, search
from rotorpong.lab.reachable import FRAMES_TO_DECIDE, decide, shows_ball
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import train
from rotorpong.lab.trial import new_drone, play_trial
from rotorpong.world.truth_eyes import TruthEyes

STAGE = stage_of("tum_gazebo", "human", 0)
FAST = VelocityCommand(1.0, 1.0, 0.2, 0.5)


class Hasty:
    """Commands at full speed from the first frame on and notes what was sent."""

    def __init__(self):
        self.sent, self.shown = [], 0

    def play(self, drone, eyes, rng):
        while (observation := drone.observe()) is not None:
            self.shown += shows_ball(drone.drone, observation)
            self.sent.append((self.shown, drone.command(FAST)))

    def learn(self, verdict):
        raise AssertionError("nobody learns here")


def problem(index):
    drone = new_drone(STAGE, index)
    instant = decide(drone).instant
    return problem_of(drone.vehicle, instant, arrivals(instant.tick, 30.0))


def test_whatever_is_sent_before_the_third_frame_with_the_ball_becomes_hover():
    player = Hasty()
    play_trial(STAGE, 0, player, watch=Gate)
    early = [command for shown, command in player.sent if shown < FRAMES_TO_DECIDE]
    late = [command for shown, command in player.sent if shown >= FRAMES_TO_DECIDE]
    assert len(early) >= FRAMES_TO_DECIDE - 1
    assert set(early) == {HOVER}
    assert set(late) == {FAST}


def test_a_plan_that_is_said_to_hit_does_hit():
    for index in range(4):
        plan = search(problem(index), np.random.default_rng(0))
        assert plan.hits
        assert play_trial(STAGE, index, Oracle(), watch=Gate).outcome == "hit"


def test_a_plan_to_stay_hits_just_when_hovering_hits():
    for index, result in enumerate(evaluate(Spec("hover", "truth"), 6)):
        stay = plan_of(problem(index), (0,), np.zeros((1, 4)))
        assert stay.hits == (result.outcome == "hit")


def test_a_plan_flown_in_legs_is_the_plan_flown_at_once():
    task = problem(1)
    command = np.array([0.5, -1.0, 0.3, 0.2])
    held = fly(task, (0,), command[None, None])
    frames = (0, 4, 9)
    batch = fly(task, frames, np.broadcast_to(command, (3, 2, 4)).copy())
    assert batch.position.shape[1] == held.position.shape[1] == len(task.path)
    switch = task.arrivals[4] - task.instant.tick
    np.testing.assert_array_equal(batch.position[0, : switch + 1], held.position[0, : switch + 1])
    np.testing.assert_array_equal(batch.position[0], batch.position[1])


def test_frames_are_expected_at_the_cameras_rate():
    expected = arrivals(120, 30.0)
    assert expected[0] == 120
    assert set(np.diff(expected).tolist()) == {33, 34}
    assert expected[-1] <= 3000
    assert len(arrivals(3000, 30.0)) == 1


def test_the_oracle_plays_the_same_again():
    spec = Spec("oracle", "truth", seed=2)
    assert evaluate(spec, 3) == evaluate(spec, 3)


def test_the_oracle_flies_behind_a_gate_only():
    drone = new_drone(STAGE, 0)
    with pytest.raises(InputError, match="behind a Gate"):
        Oracle().play(drone, TruthEyes(drone), np.random.default_rng(0))


def test_the_oracle_takes_truth_eyes_and_no_blackout():
    with pytest.raises(InputError, match="expected eyes truth"):
        Spec("oracle", "paper").check()
    for eyes in ("truth", "paper"):
        with pytest.raises(InputError, match="--blackout"):
            Spec("oracle", eyes, blackout=True).check()


def test_the_oracle_cannot_be_trained(tmp_path):
    with pytest.raises(InputError, match="cannot learn"):
        train(Spec("oracle", "truth"), 1, tmp_path / "own.sqlite")
