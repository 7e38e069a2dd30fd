"""Ship a run of the study: ``python docs/ship_policy.py TIER RUN``, the tier tracks or sonar.

The run is the one of the study's first learner that was best on validation; what the learner
reached in the study (``benchmarks/study.json``) goes onto the card.
"""

from __future__ import annotations

import sys
from pathlib import Path

from hazbot_gym.policies.actor_file import Trained, read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.training.export import export_actor
from hazbot_gym.training.run_folder import POLICY
from hazbot_gym.utils.files import read_json

RECORD = Path(__file__).parents[1] / "benchmarks" / "study.json"


def on_card(tier: str) -> dict[str, str]:
    """Return what the tier's first learner reached on the test scenarios."""
    found = read_json(RECORD)[tier]
    learner = found["learners"][0]
    block = found["together"]["test"][learner]
    metrics = {
        name: "{mean:.4g} ({low:.4g} to {high:.4g})".format(**estimate)
        for name, estimate in block["metrics"].items()
    }
    return {"learner": learner, "training_seeds": str(block["training_seeds"]), **metrics}


if __name__ == "__main__":
    tier, run = sys.argv[1], Path(sys.argv[2])
    actor, about = read(run / POLICY)
    about["study"] = on_card(tier)
    export_actor(Trained(actor, about), SHIPPED / f"ppo_{tier}.npz", overwrite=True)
