"""Which length scale and which lambda shall the paper's CrKR have?

    python benchmarks/kernel_choice.py [HITS] [BALLS]

The paper's own values are in a supplement that is lost. Trains the paper's player with each pair
from seeds that nothing else is measured with, and lets the result meet other balls of that seed.
Prints the hit rate in per cent over both seeds, and how many training balls the hits took.
"""

import sys
import tempfile
from itertools import product
from pathlib import Path

from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import knowledge_of, train
from rotorpong.lab.warmup import warm_up
from rotorpong.lab.workers import cores, in_workers

SEEDS = (100, 101)
LENGTHS = (3.0, 6.0, 12.0, 24.0)  # standard deviations of the demonstrations
LAMBDAS = (0.1, 0.01, 0.002, 0.0005)  # m^2

Task = tuple[float, float, int, int, int]


def main() -> None:
    """Train, evaluate, print."""
    hits, balls = (int(word) for word in [*sys.argv[1:], *["80", "300"][len(sys.argv) - 1 :]])
    warm_up()
    pairs = list(product(LENGTHS, LAMBDAS))
    tasks = [(*pair, seed, hits, balls) for pair in pairs for seed in SEEDS]
    answers = in_workers(measured, tasks, workers=cores())
    for length, strength in pairs:
        won, thrown = zip(*(next(answers) for _ in SEEDS), strict=True)
        rate = 100.0 * sum(won) / (balls * len(SEEDS))
        print(f"length {length:4.0f}, lambda {strength:6}: {rate:5.1f} % after {thrown} balls")
        sys.stdout.flush()


def measured(task: Task) -> tuple[int, int]:
    """Return hits of the balls of one seed, and the balls of the training."""
    length, strength, seed, hits, balls = task
    settings = PlayerSettings(length_scale=length, regularization=strength)
    spec = Spec(seed=seed, player_settings=settings)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.sqlite"
        trained = train(spec, hits, path)
        knowledge = knowledge_of(path)[1]
    results = evaluate(spec, balls, knowledge=knowledge)
    return sum(one.outcome == "hit" for one in results), trained.balls


if __name__ == "__main__":
    main()
