"""Motor primitives: the shape of a demonstrated motion, sent to any goal in any time.

Beside what is here: `batch` (many primitives to many goals at once), `limits` (what a vehicle can
fly), `warping` (a motion that waits), `contextual` (a primitive for every situation), `shapes` (few
for many), `scaling` (eta by amplitude), `sampling` (instants).
"""

from rotorpong.primitives.dmp import Dmp, Motion, State, integrate_dmp
from rotorpong.primitives.fitting import fit_dmp
from rotorpong.primitives.library import Library
from rotorpong.primitives.mixing import mix
from rotorpong.primitives.regoal import Flight

__all__ = ["Dmp", "Flight", "Library", "Motion", "State", "fit_dmp", "integrate_dmp", "mix"]
