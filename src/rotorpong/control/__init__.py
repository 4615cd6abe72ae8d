"""From a desired motion to velocity commands."""

from rotorpong.control.open_loop import held_velocity

__all__ = ["held_velocity"]
