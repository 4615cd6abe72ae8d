"""Let Stable-Baselines3 check the environments; run by `check_env_sb3.sh`."""

import gymnasium
from stable_baselines3.common.env_checker import check_env

import rotorpong  # noqa: F401 - registers the environments

for name in ("Intercept", "InterceptVision", "Primitive"):
    check_env(gymnasium.make(f"rotorpong/{name}-v0", render_mode="rgb_array"))
    print(f"rotorpong/{name}-v0: ok")
