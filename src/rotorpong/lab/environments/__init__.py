"""Gymnasium environments: the physics and rules of `evaluate` for learners of any kind."""
