"""Do true ball states help a player that knows ten demonstrations only?

    python benchmarks/untrained_eyes.py [SETS] [BALLS]

Records SETS sets of ten demonstrations (of the scripted pilot, seeds 0, 1, ...) and lets the
untrained paper's player meet the same BALLS serves with the paper's eyes and with true states. One
set tells little: which serves ten demonstrations happen to cover decides more than the eyes do.
Prints one JSON object per set, then one with the mean difference of hits and its standard error.
"""

import json
import sys
from statistics import mean, stdev

from rotorpong.lab.demonstrate import record_demonstrations
from rotorpong.lab.evaluate import Knowledge, evaluate
from rotorpong.lab.spec import Spec

SERVES_SEED = 1000  # none of the demonstrations' seeds
WORKERS = 2


def main() -> None:
    """Compare both eyes on every set of demonstrations."""
    sets, balls = (int(word) for word in (*sys.argv[1:], *("8", "300")[len(sys.argv) - 1 :]))
    rows = [hits_of_set(seed, balls) for seed in range(sets)]
    more = [row["truth"] - row["paper"] for row in rows]
    spread = stdev(more) / sets**0.5 if sets > 1 else None
    print(json.dumps({"mean_difference": mean(more), "standard_error": spread}))


def hits_of_set(seed: int, balls: int) -> dict[str, int]:
    """Return the hits with either eyes, after the demonstrations of one seed."""
    known = Knowledge(record_demonstrations(seed))
    row = {"demonstrations_seed": seed, "balls": balls}
    for eyes in ("paper", "truth"):
        spec = Spec(player="paper", eyes=eyes, seed=SERVES_SEED)
        results = evaluate(spec, balls, knowledge=known, workers=WORKERS)
        row[eyes] = sum(result.outcome == "hit" for result in results)
    print(json.dumps(row), flush=True)
    return row


if __name__ == "__main__":
    main()
