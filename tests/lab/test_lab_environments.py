"""The environments play what `evaluate` plays, and keep Gymnasium's rules."""

import warnings
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from rotorpong.conventions import InputError
from rotorpong.drone import VelocityCommand
from rotorpong.lab.environments.arena import Place, arena
from rotorpong.lab.environments.intercept import reward_of
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Stage, new_drone, play_trial

INTERCEPT, VISION = "rotorpong/Intercept-v0", "rotorpong/InterceptVision-v0"
PRIMITIVE = "rotorpong/Primitive-v0"
LIMITS = np.array([2.0, 2.0, 0.5, 1.5])
SEED = 5


def actions(trial, n=120):
    generator = np.random.default_rng(trial)
    steady = generator.uniform(-0.6, 0.6, 4) * [1.0, 1.0, 1.0, 0.3]
    return (steady + generator.normal(0.0, 0.1, (n, 4))).astype(np.float32)


class Replaying:
    """A player that gives the commands of given actions, one per frame."""

    def __init__(self, actions):
        self._actions = iter(actions)

    def play(self, drone, eyes, rng):
        while drone.observe() is not None:
            drone.command(VelocityCommand(*(np.float64(next(self._actions)) * LIMITS).tolist()))

    def learn(self, verdict):
        raise AssertionError


def evaluated(trial, **spec):
    made = Spec(player="own", eyes="truth", seed=SEED, **spec)
    stage = Stage(made, made.setting(), serve_source(made.serves, made.seed), "evaluate")
    return play_trial(stage, trial, Replaying(actions(trial))).truth


def episode(env, trial, **reset):
    observation, info = env.reset(**reset)
    assert (info["hit"], info["outcome"], info["miss_distance_m"]) == (False, None, None)
    for steps, action in enumerate(actions(trial), start=1):
        observation, reward, terminated, truncated, info = env.step(action)
        assert not truncated
        if terminated:
            return observation, reward, info, steps
    raise AssertionError("the serve never ended")


def assert_as_evaluated(info, truth):
    assert info["outcome"] == truth.verdict.outcome
    assert info["hit"] == (truth.verdict.outcome == "hit")
    assert info["miss_distance_m"] == truth.miss_distance
    assert info["time_error_s"] == truth.time_error


GAMES = (
    {},
    {"camera": "ardrone2_720p"},
    {"camera": "ardrone2_360p", "randomize": True},
)


@pytest.mark.parametrize("name", [INTERCEPT, VISION])
@pytest.mark.parametrize("game", GAMES, ids=str)
def test_an_episode_is_the_trial_that_evaluate_plays(name, game):
    env = gymnasium.make(name, purpose="evaluate", **game)
    trials = range(12 if name == INTERCEPT else 2)
    ends = set()
    for trial in trials:
        info = episode(env, trial, seed=SEED if trial == 0 else None)[2]
        assert (info["seed"], info["trial"]) == (SEED, trial)
        assert_as_evaluated(info, evaluated(trial, **game))
        ends.add(info["outcome"])
    assert len(ends) > 1 or name == VISION


@pytest.mark.parametrize("vehicle", ["tum_gazebo", "ardrone2"])
def test_a_randomised_trial_meets_the_drone_ball_camera_and_room_of_evaluate(vehicle):
    game = arena(vehicle=vehicle, camera="ardrone2_720p", purpose="evaluate", randomize=True)
    spec = Spec("hover", vehicle=vehicle, camera="ardrone2_720p", seed=SEED, randomize=True)
    stage = Stage(spec, spec.setting(), serve_source("human", SEED), "evaluate")
    vehicles = set()
    for trial in range(4):
        ours, theirs = game.drone(Place(SEED, trial)), new_drone(stage, trial)
        assert ours.vehicle == theirs.vehicle
        assert ours.camera == theirs.camera != spec.camera_profile()
        assert game.meet(Place(SEED, trial))[0].scene != spec.setting().scene
        assert np.array_equal(ours.now.ball, theirs.now.ball)
        assert ours.now.solids == theirs.now.solids
        vehicles.add(repr(ours.vehicle))
    assert len(vehicles) == 4


def test_an_action_is_a_share_of_the_nominal_vehicles_limits_whatever_is_drawn():
    plain, drawn = (gymnasium.make(INTERCEPT, randomize=r).unwrapped for r in (False, True))
    drawn.reset(seed=SEED)
    assert np.array_equal(drawn._limits, plain._limits)


def test_the_same_seed_and_trial_give_the_same_episode_and_others_do_not():
    env = gymnasium.make(INTERCEPT)
    first = env.reset(seed=3)[0]
    second = env.reset()[0]
    assert np.array_equal(env.reset(seed=3)[0], first)
    assert np.array_equal(env.reset(options={"trial": 1})[0], second)
    assert not np.array_equal(first, second)
    assert not np.array_equal(env.reset(seed=4)[0], first)
    other = gymnasium.make(INTERCEPT, purpose="evaluate")
    assert not np.array_equal(other.reset(seed=3)[0], first)


@pytest.mark.parametrize("name", [INTERCEPT, VISION, PRIMITIVE])
def test_nobody_learns_on_the_serves_that_evaluate_throws_unless_asked(name):
    seen = {
        purpose: gymnasium.make(name, **keywords).reset(seed=3)[0]
        for purpose, keywords in (
            ("default", {}),
            ("train", {"purpose": "train"}),
            ("evaluate", {"purpose": "evaluate"}),
        )
    }
    default, train, evaluate = ({"all": s} if name != VISION else s for s in seen.values())
    assert all(np.array_equal(default[part], train[part]) for part in default)
    assert not any(np.array_equal(default[part], evaluate[part]) for part in default)


@pytest.mark.parametrize("randomize", [False, True])
def test_a_vector_of_environments_is_each_of_them_trial_by_trial(randomize):
    rows, trials = (4, 2) if randomize else (6, 3)
    game = {"shaping": 0.5, "randomize": randomize}
    many = gymnasium.make_vec(INTERCEPT, num_envs=rows, **game)
    assert many.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    singles = [gymnasium.make(INTERCEPT, **game) for _ in range(rows)]
    seen, info = many.reset(seed=SEED)
    assert info == {}
    alone = [env.reset(seed=SEED + i)[0] for i, env in enumerate(singles)]
    assert np.array_equal(seen, np.stack(alone))
    over, finished, generator = np.zeros(rows, bool), np.zeros(rows, int), np.random.default_rng(0)
    while finished.min() < trials:
        told = generator.uniform(-1.2, 1.2, (rows, 4)).astype(np.float32)
        seen, rewards, ended, truncated, info = many.step(told)
        for i, env in enumerate(singles):
            if over[i]:
                single, reward, terminated, mine = env.reset()[0], 0.0, False, {}
            else:
                single, reward, terminated, _, mine = env.step(told[i])
            assert np.array_equal(seen[i], single)
            assert (rewards[i], ended[i], truncated[i]) == (reward, terminated, False)
            if terminated:
                assert info["_hit"][i]
                for key in ("hit", "outcome", "miss_distance_m", "seed", "trial", "reachable"):
                    assert info[key][i] == mine[key]
                late = info["time_error_s"][i]
                assert (None if np.isnan(late) else late) == mine["time_error_s"]
        over = ended
        finished += ended


@pytest.mark.parametrize("name", [INTERCEPT, VISION])
def test_gymnasiums_own_checks_pass_without_a_warning(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name, render_mode="rgb_array").unwrapped)


def test_observations_stay_in_their_space_and_pictures_have_their_size():
    env = gymnasium.make(VISION, render_mode="rgb_array")
    observation, _ = env.reset(seed=1)
    assert observation["frame"].shape == (360, 640, 3)
    assert np.array_equal(env.render(), observation["frame"])
    state = gymnasium.make(INTERCEPT, render_mode="rgb_array")
    state.reset(seed=1)
    assert np.array_equal(state.render(), observation["frame"])
    for trial in range(5):
        assert state.observation_space.contains(episode(state, trial)[0])


def test_actions_beyond_the_range_are_clipped_and_nan_is_refused():
    env, far = gymnasium.make(INTERCEPT), gymnasium.make(INTERCEPT)
    env.reset(seed=0)
    far.reset(seed=0)
    for _ in range(8):
        one = env.step(np.array([1, -1, 1, -1], np.float32))[0]
        two = far.step(np.array([7, -1e30, 1, -2], np.float32))[0]
        assert np.array_equal(one, two)
    for bad in (np.full(4, np.nan, np.float32), np.zeros(3), "left", [np.inf, 0, 0, 0]):
        with pytest.raises(InputError, match="expected"):
            env.unwrapped.step(bad)
    many = gymnasium.make_vec(INTERCEPT, num_envs=2)
    many.reset(seed=0)
    with pytest.raises(InputError, match=r"shape \(2, 4\)"):
        many.step(np.full((2, 4), np.nan, np.float32))


@pytest.mark.parametrize("name", [INTERCEPT, VISION])
def test_who_steps_before_a_reset_or_after_the_end_is_told_so(name):
    env = gymnasium.make(name).unwrapped
    with pytest.raises(InputError, match="call reset"):
        env.step(np.zeros(4))
    episode(env, 0, seed=0)
    with pytest.raises(InputError, match="call reset"):
        env.step(np.zeros(4))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"vehicle": "crazyflie"}, "unknown vehicle 'crazyflie'"),
        ({"camera": "nikon"}, "camera 'nikon'"),
        ({"serves": "smash"}, "serves 'smash'"),
        ({"racket": "wood"}, "unknown racket 'wood'"),
        ({"purpose": "fun"}, "unknown purpose 'fun'"),
        ({"shaping": 1.0}, "shaping 1.0: expected a number from 0 to below 1"),
        ({"shaping": float("nan")}, "shaping nan"),
    ],
)
def test_an_unknown_argument_is_refused_with_what_there_is(arguments, message):
    for make in (gymnasium.make, gymnasium.make_vec):
        with pytest.raises(InputError, match=message):
            make(INTERCEPT, **arguments)


@pytest.mark.parametrize("trial", [-1, 1.5, "one", True])
def test_a_trial_is_a_whole_number(trial):
    with pytest.raises(InputError, match="trial"):
        gymnasium.make(INTERCEPT).reset(options={"trial": trial})


def test_seeds_of_a_vector_are_one_number_or_one_for_each_row():
    many = gymnasium.make_vec(INTERCEPT, num_envs=3)
    one = many.reset(seed=7)[0]
    assert np.array_equal(many.reset(seed=[7, 8, 9])[0], one)
    with pytest.raises(InputError, match="2 seeds: expected one for each of 3"):
        many.reset(seed=[1, 2])
    with pytest.raises(InputError, match="num_envs 0"):
        gymnasium.make_vec(INTERCEPT, num_envs=0)


def test_nothing_is_worth_as_much_as_a_hit():
    assert reward_of("hit", 0.0, 0.9) == 1.0
    assert reward_of("fault", 0.0, 0.9) == 0.0
    for outcome in ("hull", "near_hit", "miss", "unseen"):
        worth = [reward_of(outcome, miss, 0.9) for miss in (0.0, 0.05, 0.5)]
        assert 1.0 > worth[0] > worth[1] > worth[2] > 0.0
        assert reward_of(outcome, 0.0, 0.0) == 0.0


def test_what_is_reachable_is_told_by_whoever_can_tell():
    game = arena(tell_reachable=False)
    assert game.reachable(Place(3, 1)) is None
    released = []

    def soon(drone):
        released.append(drone.truth().ball_path[0])
        return True

    assert replace(game, reach=soon).reachable(Place(3, 1)) is True
    assert np.array_equal(released[0], game.meet(Place(3, 1))[1].serve.ball.position)


def test_an_environment_tells_what_evaluate_calls_reachable():
    env = gymnasium.make(INTERCEPT, serves="hard", vehicle="ardrone2", purpose="evaluate")
    told = []
    for trial in range(12):
        env.reset(seed=5, options={"trial": trial})
        over = False
        while not over:
            _, _, over, _, info = env.step(np.zeros(4, np.float32))
        told.append(info["reachable"])
    spec = Spec(player="hover", serves="hard", vehicle="ardrone2", seed=5)
    assert told == [result.reachable for result in evaluate(spec, 12)]
    assert {type(answer) for answer in told} == {bool}
