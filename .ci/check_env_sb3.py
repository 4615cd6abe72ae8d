"""Let Stable-Baselines3 check the environments and learn a few steps in them.

Run by `check_env_sb3.sh`.
"""

import gymnasium
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env

import rotorpong  # noqa: F401 - registers the environments

POLICIES = {
    "Intercept": "MlpPolicy",
    "InterceptVision": "MultiInputPolicy",
    "Primitive": "MlpPolicy",
}

for name, policy in POLICIES.items():
    env = gymnasium.make(f"rotorpong/{name}-v0", render_mode="rgb_array")
    check_env(env)
    PPO(policy, env, n_steps=8, batch_size=8, n_epochs=1).learn(8)
    print(f"rotorpong/{name}-v0: ok")
