"""A quadrotor that learns to play table tennis with one onboard camera.

Importing this package registers its Gymnasium environments by name; what they need is loaded when
one is made.
"""

from gymnasium.envs.registration import register

__version__ = "0.1.0"

_ENVIRONMENTS = "rotorpong.lab.environments"

register(
    id="rotorpong/Intercept-v0",
    entry_point=f"{_ENVIRONMENTS}.intercept:InterceptEnv",
    vector_entry_point=f"{_ENVIRONMENTS}.intercept_vector:InterceptVectorEnv",
)
register(
    id="rotorpong/InterceptVision-v0",
    entry_point=f"{_ENVIRONMENTS}.intercept_vision:InterceptVisionEnv",
)
register(
    id="rotorpong/Primitive-v0",
    entry_point=f"{_ENVIRONMENTS}.primitive:PrimitiveEnv",
)
