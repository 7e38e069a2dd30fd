"""Train SAC of Stable-Baselines3 by hand on the batched engine, and export what it learned."""

import argparse
from pathlib import Path

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from hazbot_gym import evaluate, means
from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.training.export import export_model

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--steps", type=int, default=200_000)
parser.add_argument("--worlds", type=int, default=32)
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", type=Path, default=Path("results/train_sac/policy.npz"))
arguments = parser.parse_args()

torch.set_num_threads(1)  # the networks are too small to share among cores
envs = VecNormalize(VecMonitor(CorridorVecEnv(arguments.worlds, seed=arguments.seed)))
model = SAC(
    "MlpPolicy",
    envs,
    gradient_steps=8,
    policy_kwargs={"net_arch": [64, 64]},
    seed=arguments.seed,
    device="cpu",
    verbose=1,
)
model.learn(arguments.steps)

training = {"script": "train_sac.py", "steps": arguments.steps, "seed": arguments.seed}
export_model(model, arguments.out, tier="tracks", normalize=envs, training=training)
found = means(evaluate(f"learned:{arguments.out}", "hazbot_gym/Corridor-v1", episodes=20))
print(f"saved to {arguments.out}, return {found['return']:.1f}")
