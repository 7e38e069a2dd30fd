"""Evaluate one policy in one environment and print the mean of each headline metric."""

import argparse

from hazbot_gym import evaluate, means

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--policy", default="fuzzy_expert")
parser.add_argument("--env", default="hazbot_gym/Crossing-v1")
parser.add_argument("--episodes", type=int, default=20)
parser.add_argument("--seed", type=int, default=0)
arguments = parser.parse_args()

rows = evaluate(arguments.policy, arguments.env, episodes=arguments.episodes, seed=arguments.seed)

for metric, mean in means(rows).items():
    print(f"{metric:24} {mean:8.3f}")
