"""Train PPO of Stable-Baselines3 for a short while and save it: a first step, not a study."""

import argparse
from pathlib import Path

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import hazbot_gym  # noqa: F401  (registers the environments)

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--env", default="hazbot_gym/Crossing-v0")
parser.add_argument("--steps", type=int, default=100_000)
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", type=Path, default=Path("results/ppo_quickstart.zip"))
arguments = parser.parse_args()

envs = make_vec_env(arguments.env, n_envs=4, seed=arguments.seed)
model = PPO("MlpPolicy", envs, n_steps=256, seed=arguments.seed, device="cpu", verbose=1)
model.learn(total_timesteps=arguments.steps)
model.save(arguments.out)
print(f"saved to {arguments.out}")
