"""Make the figure of `docs/reach.md`: `python docs/lessons/reach.py`."""

from pathlib import Path

from rotorpong.lab.reach_figure import reach_figure

IMAGE = Path(__file__).resolve().parents[1] / "images" / "reach.png"

if __name__ == "__main__":
    reach_figure().savefig(IMAGE, dpi=110)
