"""A quadrotor that learns to play table tennis with one onboard camera.

Importing this package makes its Gymnasium environments known by name, without importing Gymnasium.
"""

from rotorpong.registration import register_environments

__version__ = "0.1.0"

register_environments()
