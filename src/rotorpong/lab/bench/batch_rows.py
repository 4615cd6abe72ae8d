"""How fast serves are played without pictures: trials and control steps a second, on one core.

A trial is a serve from release to its end, flown by a command sequence that is known beforehand;
the serves are drawn before the clock starts, and a batch plays one after the other in the same
room, as a learner's does. A control step is one step of
`rotorpong/Intercept-v0`, the making of its observation included.
"""

import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from rotorpong.lab.bench.rows import Row
from rotorpong.lab.environments.arena import Place, arena
from rotorpong.world.batch import Cast, ServeBatch

TRIALS = 1024
INTERCEPT = "rotorpong/Intercept-v0"
SIZES = (1, 16, 256, 1024)  # trials in a batch
REPEATS = 3  # of which the fastest counts
STEPS = 20  # of an environment: no serve is over before
FASTEST_COMMAND = np.array([1.0, 1.0, 0.3, 0.0])  # m/s, rad/s


def rows() -> tuple[Row, ...]:
    """Return what was measured."""
    rates = {size: _trials_per_second(size) for size in SIZES}
    growth = tuple(
        Row(f"state-only trials, {size} at once", rate, "1/s") for size, rate in rates.items()
    )
    best = max(rates.values())
    return (
        Row("state-only trials", best, "1/s", target=5000.0),
        *growth,
        Row("control steps, one environment", _single_steps_per_second(), "1/s", target=10_000.0),
        Row("control steps, 256 environments", _vector_steps_per_second(256), "1/s"),
        Row("episodes with their serves drawn, one environment", _episodes_per_second(), "1/s"),
    )


def _trials_per_second(size: int) -> float:
    """Return how many open-loop trials are played in a second by batches of `size`."""
    game = arena(purpose="train")
    rng, batches = np.random.default_rng(0), max(1, min(TRIALS // size, 32))
    commands = rng.uniform(-FASTEST_COMMAND, FASTEST_COMMAND, (size, 4))

    def casts(batch: int) -> list[Cast]:
        return [game.meet(Place(batch, trial))[1] for trial in range(size)]

    def play(ready: list[ServeBatch]) -> None:
        for batch in ready:
            while not batch.over.all():
                batch.advance()
                batch.command(commands)

    room = [ServeBatch(game.setting, casts(batch)) for batch in range(batches)]

    def ready() -> list[ServeBatch]:
        for i, batch in enumerate(room):
            batch.restart(range(size), casts(i))
        return room

    return size * batches / _fastest(play, ready)


def _single_steps_per_second() -> float:
    """Return the steps of `InterceptEnv` in a second, resets apart."""
    env, action = gymnasium.make(INTERCEPT, tell_reachable=False), np.zeros(4, np.float32)

    def play(env: gymnasium.Env) -> None:
        for _ in range(STEPS):
            env.step(action)

    def ready() -> gymnasium.Env:
        env.reset(seed=0)
        return env

    return STEPS / _fastest(play, ready, repeats=50)


def _vector_steps_per_second(size: int) -> float:
    """Return the steps of a vector of environments in a second, each row counted."""
    envs = gymnasium.make_vec("rotorpong/Intercept-v0", num_envs=size)
    actions = np.zeros((size, 4), np.float32)

    def play(envs: gymnasium.vector.VectorEnv) -> None:
        for _ in range(STEPS):
            envs.step(actions)

    def ready() -> gymnasium.vector.VectorEnv:
        envs.reset(seed=0)
        return envs

    return size * STEPS / _fastest(play, ready)


def _episodes_per_second(episodes: int = 20) -> float:
    """Return whole episodes in a second: serve drawn, flown to its end."""
    env, action = gymnasium.make(INTERCEPT, tell_reachable=False), np.zeros(4, np.float32)
    seeds = iter(range(10**6))

    def play(env: gymnasium.Env) -> None:
        for _ in range(episodes):
            env.reset(seed=next(seeds))
            while not env.step(action)[2]:
                pass

    return episodes / _fastest(play, lambda: env)


def _fastest(
    play: Callable[[Any], None], ready: Callable[[], Any], repeats: int = REPEATS
) -> float:
    """Return the shortest processor time of `play`, s; compiled before."""
    play(ready())
    times = []
    for _ in range(repeats):
        thing = ready()
        start = time.process_time()
        play(thing)
        times.append(time.process_time() - start)
    return min(times)
