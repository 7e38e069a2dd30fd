"""Train PPO as `hazbot train` does, then compare the best policy with the fuzzy expert."""

import argparse
from pathlib import Path

from rich.console import Console

from hazbot_gym import evaluate, load_training, means, train

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--config", type=Path, default=Path(__file__).parents[1] / "configs/ppo.yaml")
parser.add_argument("--steps", type=int)
parser.add_argument("--worlds", type=int)
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--episodes", type=int, default=100)
parser.add_argument("--out", type=Path, default=Path("results/train_ppo"))
arguments = parser.parse_args()

config = load_training(
    arguments.config, steps=arguments.steps, worlds=arguments.worlds, seed=arguments.seed
)
result = train(config, arguments.out, resume=True, console=Console(stderr=True))

for policy in (f"learned:{result.policy}", "fuzzy_expert"):
    found = means(evaluate(policy, config.env[0], episodes=arguments.episodes))
    print(f"{policy}: return {found['return']:.1f}, delay {found['delay_s']:.2f} s, ", end="")
    print(f"driven inside the personal zone {found['personal_m']:.2f} m")
