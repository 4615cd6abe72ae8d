"""Motor primitives: the shape of a demonstrated motion, sent to any goal in any time."""

from rotorpong.primitives.dmp import Dmp, Motion, State, integrate_dmp
from rotorpong.primitives.fitting import fit_dmp
from rotorpong.primitives.library import Library
from rotorpong.primitives.mixing import mix

__all__ = ["Dmp", "Library", "Motion", "State", "fit_dmp", "integrate_dmp", "mix"]
