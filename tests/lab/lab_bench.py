"""Players of one's own for the lab's tests, written where a user would write them."""

STILL = """
from rotorpong.drone import HOVER

class Own:
    def play(self, drone, eyes, rng):
        while drone.observe() is not None:
            drone.command(HOVER)

    def learn(self, verdict):
        raise AssertionError("evaluate never learns")
"""
LOOKING = STILL.replace(
    "while drone.observe() is not None:\n            drone.command(HOVER)",
    "while (seen := drone.observe()) is not None:\n            eyes.see(seen)",
)
RAISING = STILL.replace(
    "while drone.observe() is not None:\n            drone.command(HOVER)", "{}"
)


def write_player(folder, text, name="own.py"):
    """Write a player's file; return the name by which the lab knows it."""
    path = folder / name
    path.write_text(text)
    return f"{path}:Own"
