"""Which controls there are, and which players have them.

    open           the paper's: a motion's own velocity is the command
    feed-forward   u = v + tau v', with what the vehicle's equations and the flight itself tell
    closed-loop    that, and navdata bring the drone back to its course

What is not asked for is open. What is asked for must have an effect on the player chosen.
"""

from typing import cast

from rotorpong.control import Control
from rotorpong.conventions import InputError
from rotorpong.lab.choices import require_choice
from rotorpong.lab.player_settings import DECIDING_ONCE

CONTROLS = ("open", "feed-forward", "closed-loop")
PAPERS_CONTROL = "open"


def require_control(control: str | None, player: str) -> None:
    """Raise InputError if a control is unknown, or has no effect on a player."""
    if control is None:
        return
    require_choice("control", control, CONTROLS)
    if player not in DECIDING_ONCE:
        raise InputError(
            f"--control {control} with player {player!r}: has no effect; expected player "
            f"{' or '.join(DECIDING_ONCE)}"
        )


def control_of(control: str | None) -> Control:
    """Return a checked control as players call it."""
    return cast("Control", (control or PAPERS_CONTROL).replace("-", "_"))
