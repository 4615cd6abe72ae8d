"""The player that stays at home: what chance alone hits."""

import numpy as np

from rotorpong.drone import HOVER, Drone, Eyes, Verdict


class Hover:
    """Hover through every serve; never look."""

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Command zero velocity at every frame."""
        while drone.observe() is not None:
            drone.command(HOVER)

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing."""
