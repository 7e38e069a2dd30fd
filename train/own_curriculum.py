"""Train with a curriculum over randomised scenarios, and compare with the fuzzy expert."""

import argparse
from pathlib import Path

from hazbot_gym import evaluate, load_training, means, train

ROOT, ENV = Path(__file__).parents[1], "hazbot_gym/Crossing-v1"
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--config", type=Path, default=ROOT / "configs/ppo.yaml")
parser.add_argument("--episodes", type=int, default=100)
parser.add_argument("--out", type=Path, default=Path("results/own_curriculum"))
arguments = parser.parse_args()

randomised = {
    "people": {"speeds": {"mean_mps": {"normal": [1.3, 0.1]}}},
    "drive": {"plant": {"choice": ["A", "B"]}, "acceleration_mps2": {"choice": [0.4, 0.5, 0.6]}},
}


def harder(steps, validations):
    """Return more people for each validation with at least 8 of 10 arrivals."""
    passed = sum(each["arrived"] >= 0.8 for each in validations)
    most = min(2 + 2 * passed, 12)
    print(f"from decision {steps:,} on: 1 to {most} people")
    return {"people": {"count": [1, most]}}


config = load_training(arguments.config, env=ENV, overrides=randomised)
result = train(config, arguments.out, resume=True, curriculum=harder)
for policy in (f"learned:{result.policy}", "fuzzy_expert"):
    found = means(evaluate(policy, ENV, episodes=arguments.episodes, overrides=randomised))
    print(f"{policy}: return {found['return']:.1f}, arrived {found['arrived']:.2f}")
