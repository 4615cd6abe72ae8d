"""
Learning to intercept from nothing
==================================

An evolution strategy in plain numpy learns ``rotorpong/Intercept-v0``::

    python examples/train_intercept.py                # a few generations: 30 s at most
    python examples/train_intercept.py --full --out DIR      # the curve of the documentation

The policy is one linear layer and a tanh on eight numbers that are worked out from the observation:
how far to the left and up the ball will pass the blade, by a straight line and by gravity with one
bounce; the same two divided by the time that is left; the drone's own velocity; and a one. All
weights start at zero, which hovers.
"""

import argparse
import json
import math
from pathlib import Path
from typing import Any

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from gymnasium.vector import VectorEnv
from matplotlib.figure import Figure
from numpy import ndarray

import rotorpong  # noqa: F401 - registers the environments
from rotorpong.lab.statistics import wilson_interval

plt.switch_backend("agg")  # a figure needs no display

BLADE_FORWARD, BLADE_UP = 0.23 + 0.02, 0.16  # m from the centre of mass; where a touching ball is
BALL_RADIUS, GRAVITY, BOUNCE = 0.02, 9.81, 0.85
SHORTEST, LONGEST = 0.03, 1.5  # s, limits of the time to go
FEATURES, OUTPUTS = 8, 3  # forward, left, up; it never turns
SHAPING = 0.5
FIRST_STEP = 0.5  # of the weights
MOST_FRAMES = 100  # of a serve
FULL = {"generations": 16, "population": 12, "balls": 16, "test_balls": 1000, "every": 1}

Point = dict[str, Any]

# %%
# The policy: what it looks at, and what it commands.


def features(observations: ndarray) -> ndarray:
    """Return the eight numbers that the policy looks at, one row for each observation."""
    ball, relative, own, height = np.split(observations[:, :10].astype(float), [3, 6, 9], axis=1)
    velocity = relative + own
    ahead = ball[:, 0] - BLADE_FORWARD
    time = np.clip(ahead / np.maximum(-relative[:, 0], 0.1), SHORTEST, LONGEST)
    left = ball[:, 1] + velocity[:, 1] * time
    passing = height_after(height[:, 0] + ball[:, 2], velocity[:, 2], time)
    up = passing - height[:, 0] - BLADE_UP
    rest = np.maximum(time, 0.1)
    return np.column_stack([left, up, left / rest, up / rest, own, np.full(len(own), 0.2)])


def height_after(height: ndarray, rate: ndarray, time: ndarray) -> ndarray:
    """Return a ball's height over the table after some time, with one bounce if it comes down."""
    drop = np.maximum(height - BALL_RADIUS, 0.0)
    speed = np.sqrt(rate**2 + 2.0 * GRAVITY * drop)
    landing = (rate + speed) / GRAVITY
    rest = np.maximum(time - landing, 0.0)
    bounced = BALL_RADIUS + BOUNCE * speed * rest - 0.5 * GRAVITY * rest**2
    return np.where(landing < time, bounced, height + rate * time - 0.5 * GRAVITY * time**2)


def actions(weights: ndarray, observations: ndarray) -> ndarray:
    """Return what policies command: weights (n, outputs, features), one policy for each row."""
    pushed = np.einsum("nof,nf->no", weights, features(observations))
    return np.column_stack([np.tanh(pushed), np.zeros(len(pushed))]).astype(np.float32)


# %%
# Serves are played in lockstep, one in every row; what a serve pays comes at its end.


def play(
    environments: VectorEnv, weights: ndarray, seeds: list[int], trial: int
) -> tuple[ndarray, ndarray]:
    """Play one serve in every row; return what it paid and whether it was hit."""
    observations, _ = environments.reset(seed=seeds, options={"trial": trial})
    paid, hit = np.zeros(len(seeds)), np.zeros(len(seeds), bool)
    waiting = np.ones(len(seeds), bool)
    for _ in range(MOST_FRAMES):
        observations, rewards, over, _, info = environments.step(actions(weights, observations))
        ended = waiting & over
        if ended.any():
            paid[ended], hit[ended] = rewards[ended], info["hit"][ended]
            waiting &= ~over
        if not waiting.any():
            break
    return paid, hit


# %%
# CMA-ES (Hansen) turns the mean shaped reward of a batch of serves into better weights.


class Cma:
    """Covariance matrix adaptation (Hansen, "The CMA Evolution Strategy: A Tutorial")."""

    def __init__(self, size: int, population: int, step: float) -> None:
        """Start at zero with steps of `step` in every direction."""
        self.mean, self.step, self.covariance = np.zeros(size), step, np.eye(size)
        self.path, self.step_path, self.size = np.zeros(size), np.zeros(size), size
        raw = np.log(population / 2 + 0.5) - np.log(np.arange(1, population // 2 + 1))
        self.weights = raw / raw.sum()
        mass = 1.0 / np.sum(self.weights**2)
        self.step_rate = (mass + 2) / (size + mass + 5)
        self.step_damping = 1 + self.step_rate + 2 * max(0, math.sqrt((mass - 1) / (size + 1)) - 1)
        self.path_rate = (4 + mass / size) / (size + 4 + 2 * mass / size)
        self.rank_one = 2 / ((size + 1.3) ** 2 + mass)
        rank_mu = 2 * (mass - 2 + 1 / mass) / ((size + 2) ** 2 + mass)
        self.rank_mu, self.mass = min(1 - self.rank_one, rank_mu), mass

    def ask(self, population: int, rng: np.random.Generator) -> ndarray:
        """Return candidates in mirrored pairs."""
        values, vectors = np.linalg.eigh(self.covariance)
        self.root = vectors * np.sqrt(np.maximum(values, 1e-20))
        half = rng.standard_normal((population // 2, self.size))
        return self.mean + self.step * np.concatenate([half, -half]) @ self.root.T

    def tell(self, candidates: ndarray, worth: ndarray) -> None:
        """Move towards the better half."""
        best = candidates[np.argsort(-worth, kind="stable")[: len(self.weights)]]
        moves = (best - self.mean) / self.step
        move = self.weights @ moves
        self.mean = self.mean + self.step * move
        white = np.linalg.solve(self.root, move)
        keep = self.step_rate * (2 - self.step_rate) * self.mass
        self.step_path = (1 - self.step_rate) * self.step_path + math.sqrt(keep) * white
        rate = self.path_rate
        self.path = (1 - rate) * self.path + math.sqrt(rate * (2 - rate) * self.mass) * move
        self.covariance = (
            (1 - self.rank_one - self.rank_mu) * self.covariance
            + self.rank_one * np.outer(self.path, self.path)
            + self.rank_mu * (moves.T * self.weights) @ moves
        )
        length = np.linalg.norm(self.step_path) / math.sqrt(self.size)
        self.step *= math.exp(min(1.0, self.step_rate / self.step_damping * (length - 1)))


# %%
# Every candidate of a generation meets the same serves, the next generation meets others. What is
# plotted was measured on serves that are never trained on.


def learn(
    generations: int, population: int, balls: int, test_balls: int, every: int
) -> tuple[list[Point], ndarray]:
    """Return the learning curve and the weights at its end."""
    rng = np.random.default_rng(0)
    search = Cma(OUTPUTS * FEATURES, population, FIRST_STEP)
    training = gymnasium.make_vec(
        "rotorpong/Intercept-v0",
        num_envs=population * balls,
        purpose="train",
        shaping=SHAPING,
        tell_reachable=False,
    )
    test = gymnasium.make_vec(
        "rotorpong/Intercept-v0", num_envs=test_balls, purpose="evaluate", tell_reachable=False
    )
    curve = [tested(test, search.mean, test_balls, generation=0, trained=0)]
    for generation in range(1, generations + 1):
        candidates = search.ask(population, rng)
        rows = np.repeat(candidates.reshape(-1, OUTPUTS, FEATURES), balls, axis=0)
        paid, _ = play(training, rows, list(range(balls)) * population, generation)
        search.tell(candidates, paid.reshape(population, balls).mean(axis=1))
        if generation % every == 0 or generation == generations:
            trained = generation * population * balls
            curve.append(
                tested(test, search.mean, test_balls, generation=generation, trained=trained)
            )
    return curve, search.mean.reshape(OUTPUTS, FEATURES)


def tested(
    environments: VectorEnv, flat: ndarray, balls: int, *, generation: int, trained: int
) -> Point:
    """Return one point of the curve: the hit rate on serves that are never trained on."""
    weights = np.tile(flat.reshape(1, OUTPUTS, FEATURES), (balls, 1, 1))
    _, hit = play(environments, weights, list(range(balls)), 0)
    low, high = wilson_interval(int(hit.sum()), balls)
    print(f"generation {generation:3d}  {trained:6d} trials  {hit.mean():6.1%} hit", flush=True)
    return {
        "generation": generation,
        "trials_trained_on": trained,
        "hits": int(hit.sum()),
        "balls": balls,
        "hit_rate": float(hit.mean()),
        "hit_rate_interval": [low, high],
    }


# %%
# All of it together.


def draw(curve: list[Point]) -> Figure:
    """Return the learning curve, drawn with Wilson's 95 % intervals."""
    trials = [point["trials_trained_on"] for point in curve]
    low, high = np.array([point["hit_rate_interval"] for point in curve]).T
    figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    axes.fill_between(trials, 100 * low, 100 * high, alpha=0.25, linewidth=0)
    axes.plot(trials, [100 * point["hit_rate"] for point in curve], marker=".")
    axes.set(
        xlabel="trials flown in training",
        ylabel=f"hit, % of {curve[0]['balls']} other serves",
        ylim=(0, 100),
        title="rotorpong/Intercept-v0: CMA-ES, 24 weights, from zero",
    )
    axes.grid(alpha=0.3)
    return figure


def main() -> None:
    """Learn; with --out also write the curve, the weights and a figure."""
    parser = argparse.ArgumentParser(description="Learn to intercept by an evolution strategy.")
    parser.add_argument("--generations", type=int, default=4)
    parser.add_argument("--population", type=int, default=16)
    parser.add_argument("--balls", type=int, default=16, help="serves for each candidate")
    parser.add_argument("--test-balls", type=int, default=100)
    parser.add_argument("--every", type=int, default=2, help="generations between two tests")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--full", action="store_true", help="as in the documentation: minutes")
    told = parser.parse_args()
    if told.full:
        vars(told).update(FULL)
    curve, weights = learn(
        told.generations, told.population, told.balls, told.test_balls, told.every
    )
    figure = draw(curve)
    if told.out is not None:
        told.out.mkdir(parents=True, exist_ok=True)
        setting = {name: value for name, value in vars(told).items() if name in FULL}
        result = {"setting": setting, "curve": curve, "weights": weights.tolist()}
        (told.out / "intercept_es.json").write_text(json.dumps(result, indent=1) + "\n")
        figure.savefig(told.out / "intercept_es.png", dpi=150)


if __name__ == "__main__":
    main()
