"""
A player of your own
====================

It flies towards where it sees the ball, and beats one that hovers. It is measured like any
other::

    rotorpong evaluate --player examples/own_player.py:Chaser --eyes truth --balls 40
"""

import numpy as np

from rotorpong.drone import HOVER, Drone, Eyes, VelocityCommand, Verdict

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


# %%
# That is the whole player. From here on it is measured: it plays the same 40 balls as a drone that
# stays where it is. With the eyes ``truth`` both are told where the ball is, so what is compared is
# how they move.

if __name__ == "__main__":
    import sys

    from rotorpong.lab.evaluate import evaluate, summary
    from rotorpong.lab.spec import Spec

    results = {}
    for name in ("hover", f"{sys.argv[0]}:Chaser"):
        spec = Spec(name, eyes="truth")
        results[name] = evaluate(spec, 40)
        hits = summary(spec, results[name])["hits"]
        print(hits, "hits of 40 balls,", name.split(":")[-1])

# %%
# One of the balls that only the chaser hit, as ``rotorpong throw`` shows it: through the drone's
# eyes, and below that from beside the table.

if __name__ == "__main__":
    import tempfile
    from pathlib import Path

    import matplotlib.pyplot as plt

    from rotorpong.lab.throw import throw

    plt.switch_backend("agg")  # it needs no display
    hover, chaser = results.values()
    index = next(
        one.index
        for one, other in zip(chaser, hover, strict=True)
        if one.outcome == "hit" != other.outcome
    )
    with tempfile.TemporaryDirectory() as folder:
        throw(spec, index, Path(folder) / "serve.png")
        sheet = plt.imread(Path(folder) / "serve.png")
    axes = plt.figure(figsize=(9.68, 6.03)).add_axes((0, 0, 1, 1))
    axes.imshow(sheet, interpolation="antialiased")
    axes.set_axis_off()
