"""How much does one training run differ from another?

    python benchmarks/training_runs.py [RUNS] [HITS]

Trains with both eyes from seeds 0, 1, 2 ... (other balls, other exploration; the same ten
demonstrations) and lets each result meet the same 1000 balls. A p-value over balls compares two
files; what a method is worth shows only over runs. Prints a line per run, then mean and standard
deviation.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import mean, stdev

BALLS = 1000
EYES = ("paper", "truth")


def main() -> None:
    """Train, evaluate, print."""
    runs, hits = (int(word) for word in [*sys.argv[1:], *["5", "80"][len(sys.argv) - 1 :]])
    for eyes in EYES:
        rates = []
        for seed in range(runs):
            trained, after = run(eyes, seed, hits)
            rates.append(after["hits"])
            print(f"{eyes} run {seed}: {trained['balls']} balls, then {after['hits']} of {BALLS}")
        spread = stdev(rates) if runs > 1 else float("nan")
        print(f"{eyes}: mean {mean(rates):.0f}, standard deviation {spread:.0f} of {BALLS}")


def run(eyes: str, seed: int, hits: int) -> tuple[dict, dict]:
    """Return what `train` and then `evaluate` print."""
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder) / "run.sqlite")
        trained = rotorpong(
            "train", "--seed", str(seed), "--hits", str(hits), "--out", out, eyes=eyes
        )
        after = rotorpong("evaluate", "--balls", str(BALLS), "--experience", out, eyes=eyes)
    return trained, after


def rotorpong(command: str, *words: str, eyes: str) -> dict:
    """Run a command of rotorpong and return its JSON."""
    line = [sys.executable, "-m", "rotorpong", command, "--eyes", eyes, "--json", *words]
    done = subprocess.run(line, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    return json.loads(done.stdout)


if __name__ == "__main__":
    main()
