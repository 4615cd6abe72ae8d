"""A player of one's own: it flies towards where it sees the ball, and beats one that hovers.

rotorpong evaluate --player examples/own_player.py:Chaser --eyes truth --balls 40
"""

import numpy as np

from rotorpong.drone import HOVER, Drone, Eyes, VelocityCommand, Verdict
from rotorpong.lab.evaluate import evaluate, summary
from rotorpong.lab.spec import Spec

GAIN, BLADE = 3.0, 0.15  # 1/s, m that the blade is above the camera


class Chaser:
    """Any class with `play` and `learn` that can be made without arguments is a player."""

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve: a frame, perhaps a ball, a command, until no frame comes."""
        command = HOVER
        while (observation := drone.observe()) is not None:
            if (ball := eyes.see(observation)) is not None:
                right, down, _ = ball.position
                command = VelocityCommand(left=-GAIN * right, up=-GAIN * (down + BLADE))
            drone.command(command)

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing; `rotorpong evaluate` never calls this."""


if __name__ == "__main__":
    for name in ("hover", f"{__file__}:Chaser"):
        spec = Spec(name, eyes="truth")
        print(summary(spec, evaluate(spec, 40))["hits"], "hits of 40 balls,", name.split(":")[-1])
