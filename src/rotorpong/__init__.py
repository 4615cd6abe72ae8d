"""A quadrotor that learns to play table tennis with one onboard camera."""

__version__ = "0.1.0"
