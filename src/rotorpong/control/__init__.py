"""From a desired motion to velocity commands: open loop, feed-forward, closed loop."""

from rotorpong.control.course import Course, Departure, Follower
from rotorpong.control.following import Control, follower
from rotorpong.control.open_loop import held_velocity
from rotorpong.control.plant import Plant

__all__ = ["Control", "Course", "Departure", "Follower", "Plant", "follower", "held_velocity"]
