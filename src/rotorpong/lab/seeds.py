"""Where randomness comes from: (seed, purpose, trial) and nothing else.

Every trial has five generators of its own, so a result depends on neither order nor workers. The
same seed gives the same serves, whoever plays. Demonstrations, training and evaluation with the
same seed throw different balls.
"""

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

Purpose = Literal["demonstrate", "train", "evaluate"]
PURPOSES: dict[Purpose, int] = {"demonstrate": 1, "train": 2, "evaluate": 3}
RUN = 0  # spawn key of what is drawn once for all trials


@dataclass(frozen=True, slots=True)
class Generators:
    """The five independent sources of randomness of one trial."""

    serve: np.random.Generator
    vehicle: np.random.Generator
    sensors: np.random.Generator
    player: np.random.Generator
    world: (
        np.random.Generator
    )  # what `--randomize` draws; last, so that the others stay as they were


def trial_generators(seed: int, purpose: Purpose, trial: int) -> Generators:
    """Return the generators of one trial."""
    sequence = np.random.SeedSequence(seed, spawn_key=(PURPOSES[purpose], trial))
    return Generators(
        *(np.random.default_rng(child) for child in sequence.spawn(len(fields(Generators))))
    )


def run_generator(seed: int) -> np.random.Generator:
    """Return the generator of what all trials of a seed share."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(RUN,)))
