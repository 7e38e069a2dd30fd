"""Compare policies over the same scenarios: how each differs from the first, with its interval."""

import argparse
from pathlib import Path

from hazbot_gym.policies import Permissions
from hazbot_gym.study.config import load_study
from hazbot_gym.study.run import run_study

if __name__ == "__main__":  # the study starts processes that read this file again
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policies", nargs="*", default=["fuzzy_expert", "constant:0.5"])
    parser.add_argument("--sets", nargs="+", default=["Crossing", "Confronting"])
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--out", type=Path, default=Path("results/compare_policies"))
    arguments = parser.parse_args()

    study = load_study(
        policies=arguments.policies, sets=arguments.sets, episodes=arguments.episodes
    )
    summary = run_study(study, arguments.out, allowed=Permissions(allow_code=True))

    for scenarios, policies in summary["sets"].items():
        for policy in study.policies[1:]:
            print(f"{scenarios}: {policy} minus {study.reference_policy}")
            for metric, difference in policies[policy]["difference"].items():
                print(f"  {metric:24} {difference['mean']:+.3f}", end="")
                print(f"  [{difference['low']:+.3f}, {difference['high']:+.3f}]")
