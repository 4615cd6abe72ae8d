"""Controls by name."""

from typing import Literal

from rotorpong.control.closed_loop import ClosedLoop
from rotorpong.control.course import Follower
from rotorpong.control.feed_forward import FeedForward
from rotorpong.control.open_loop import OpenLoop
from rotorpong.control.plant import UNKNOWN_PLANT, Plant

Control = Literal["open", "feed_forward", "closed_loop"]


def follower(control: Control, plant: Plant | None = None) -> Follower:
    """Return what flies courses in one serve.

    Args:
        control: how.
        plant: what is known of the drone; a lag of 0.4 s by default.
    """
    if control == "open":
        return OpenLoop()
    known = UNKNOWN_PLANT if plant is None else plant
    return FeedForward(known) if control == "feed_forward" else ClosedLoop(known)
