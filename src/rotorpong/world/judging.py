"""What became of a serve: when it is over, its outcome, how near and how late the blade was.

A serve ends when the ball is hit or touches the hull, when the drone touches something, when the
ball lies on the floor or is well behind the drone, or after 3 s. The end is noticed at the end of a
leg, a piece of flight between two frames. Outcomes are those of `rotorpong.drone`, the first that
matches. One serve and a batch of them are judged by the same functions. World frame.
"""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import Outcome, Verdict
from rotorpong.world import _judging_kernels as kernels
from rotorpong.world._judging_kernels import FULL_FACE as FULL_FACE
from rotorpong.world._judging_kernels import LONGEST_SERVE as LONGEST_SERVE
from rotorpong.world.contact import Contact, box_about, sizes_of, touch_down
from rotorpong.world.racket import Racket
from rotorpong.world.solids import TICK, Solids

ENDINGS: tuple[Outcome | None, ...] = (None, "hit", "hull", "fault", "miss", "near_hit")  # by code

BallPath = Float[ndarray, "n 9"]
Track = Float[ndarray, "instants 7"]


def judge(
    outcome: Outcome, contact: Contact | None, balls: BallPath, track: Track, racket: Racket
) -> tuple[Verdict, float, float | None]:
    """Return verdict, miss distance (m) and time error (s, positive: late) of a serve.

    Args:
        outcome: as the kernel `ending` says.
        contact: which decided.
        balls: states at all ticks, the release included.
        track: the drone's poses at the same ticks.
        racket: of the drone.
    """
    watch = np.concatenate([box_about(track), np.zeros(2)])  # the ball may always be near
    code, miss, lag = kernels.judged(ENDINGS.index(outcome), balls, track, watch, sizes_of(racket))
    late = lag * TICK if abs(lag) <= kernels.LONGEST_LAG else None
    if code == kernels.HIT and contact is not None:
        return Verdict("hit", math.hypot(*contact.blade_point), contact.time), miss, late
    return Verdict(ENDINGS[code] or outcome), miss, late


def landing_of(
    outcome: Outcome, contact: Contact | None, balls: BallPath, solids: Solids
) -> float | None:
    """Return where a hit ball first touches the table beyond the net, x in m; None: it does not.

    Args:
        outcome: of the serve.
        contact: which decided.
        balls: states at all ticks, the release included.
        solids: what the ball may meet.
    """
    if outcome != "hit" or contact is None:
        return None
    after = balls[min(math.ceil(contact.time / TICK), len(balls) - 1)]
    first = touch_down(after, solids)
    if first is None or first.solid != "table" or first.position[0] <= 0.0:
        return None
    return float(first.position[0])
