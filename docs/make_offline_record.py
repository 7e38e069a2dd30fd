"""Compare offline training on four data sets: ``python docs/make_offline_record.py FOLDER``.

FOLDER keeps the data sets and what is trained; runs that are there are not repeated. Writes
``benchmarks/offline.json``. Needs the extras ``train`` and ``datasets``, and d3rlpy as on the page;
ten minutes on one core.
"""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

from hazbot_gym.evaluation.minari_dataset import write_dataset
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import read_json, write_json
from hazbot_gym.utils.json_object import JsonObject

ROOT = Path(__file__).parents[1]
RECORD = ROOT / "benchmarks" / "offline.json"
ENV, EPISODES, UPDATES = "Crossing-v1", 100, 5000
POLICIES = {
    "crossing-expert-v0": "fuzzy_expert",
    "crossing-rule-v0": "velocity_obstacle:margin_m=0.2",  # tuned in benchmarks/headroom.json
    "crossing-ppo-v0": "ppo",
    "crossing-random-v0": "random",
}
METHODS = ("bc", "td3_bc")


def record(folder: Path) -> JsonObject:
    """Return the record, and leave data sets and policies in a folder."""
    for name, policy in POLICIES.items():
        if not (folder / name).exists():
            write_dataset(policy, ENV, folder / name, episodes=EPISODES)
    runs = [trained(folder / name, method) for name in POLICIES for method in METHODS]
    others = {name: version(name) for name in ("minari", "d3rlpy")}
    return {
        "commit": provenance.commit(),
        "versions": provenance.versions() | others,
        "env": ENV,
        "episodes": EPISODES,
        "updates": UPDATES,
        "runs": runs,
    }


def trained(dataset: Path, method: str) -> JsonObject:
    """Run ``train/offline.py`` unless it has been, and return its comparison."""
    run = dataset.with_name(f"{dataset.name}-{method}")
    compared = run.with_suffix(".json")
    if not compared.exists():
        command = [
            sys.executable, ROOT / "train/offline.py", dataset, "--method", method,
            "--updates", UPDATES, "--episodes", EPISODES,
            "--out", run.with_suffix(".npz"), "--json", compared,
        ]  # fmt: skip
        subprocess.run([str(part) for part in command], check=True)
    return read_json(compared)


if __name__ == "__main__":
    write_json(RECORD, record(Path(sys.argv[1])))
