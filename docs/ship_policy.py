"""Ship a training run: ``python docs/ship_policy.py NAME RUN``, the name tracks, sonar or prices.

When the study that trained it has been kept (``benchmarks/study.json``, part ``shipped``), ``python
docs/ship_policy.py tracks`` puts what its learner reached in it, over all seeds, onto its card.
"""

from __future__ import annotations

import sys
from pathlib import Path

from study_report import LEARNED, STUDY

from hazbot_gym.policies.actor_file import Trained, read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.study.headline import TEST
from hazbot_gym.training.export import export_actor
from hazbot_gym.training.run_folder import POLICY
from hazbot_gym.utils.files import read_json

FILES = {"tracks": "ppo_tracks", "sonar": "ppo_sonar", "prices": "prices_tracks"}


def on_card() -> dict[str, str]:
    """Return what the learner of the tier tracks reached on the test scenarios."""
    block = read_json(STUDY)["shipped"]["sets"][TEST][LEARNED]
    metrics = {
        name: "{mean:.4g} ({low:.4g} to {high:.4g})".format(**estimate)
        for name, estimate in block["metrics"].items()
    }
    seeds = str(block["training_seeds"])
    return {"training seeds": seeds, "episodes": str(block["episodes"]), **metrics}


def ship(name: str, run: Path | None) -> None:
    """Ship the policy of a run, or, without one, put the study's results onto the card."""
    shipped = SHIPPED / f"{FILES[name]}.npz"
    actor, about = read(run / POLICY if run else shipped)
    if run is None:
        if name != "tracks":
            raise SystemExit(f"{name}: the study of the shipped policy is of the tier tracks alone")
        about["study"] = on_card()
    export_actor(Trained(actor, about), shipped, overwrite=True)


if __name__ == "__main__":
    name, *runs = sys.argv[1:]
    ship(name, Path(runs[0]) if runs else None)
