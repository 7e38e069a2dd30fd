"""Compare offline training on four data sets: ``python docs/make_offline_record.py FOLDER``.

FOLDER keeps the data sets and what is trained; runs that are there are not repeated. Writes
``benchmarks/offline.json``. Needs the extras ``train`` and ``datasets``, and d3rlpy as on the page;
half an hour on one core.
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
ENV, EPISODES = "Crossing-v1", 100
POLICIES = {
    "crossing-expert-v0": "fuzzy_expert",
    "crossing-rule-v0": "velocity_obstacle:margin_m=0.2",  # tuned in benchmarks/headroom.json
    "crossing-ppo-v0": "ppo",
    "crossing-random-v0": "random",
}
UPDATES, LONGER = 20_000, (40_000,)  # of td3_bc; longer on one data set


def record(folder: Path) -> JsonObject:
    """Return the record, and leave data sets and policies in a folder."""
    for name, policy in POLICIES.items():
        if not (folder / name).exists():
            write_dataset(policy, ENV, folder / name, episodes=EPISODES)
    runs = []
    for name in POLICIES:
        more = LONGER if name == "crossing-rule-v0" else ()
        runs.append(trained(folder / name, "bc"))
        runs += [trained(folder / name, "td3_bc", updates) for updates in (UPDATES, *more)]
    others = {name: version(name) for name in ("minari", "d3rlpy")}
    return {
        "commit": provenance.commit(),
        "versions": provenance.versions() | others,
        "env": ENV,
        "episodes": EPISODES,
        "runs": runs,
    }


def trained(dataset: Path, method: str, updates: int = UPDATES) -> JsonObject:
    """Run ``train/offline.py`` unless it has been, and return its comparison."""
    run = dataset.with_name(f"{dataset.name}-{method}-{updates}")
    compared = run.with_suffix(".json")
    if not compared.exists():
        command = [
            sys.executable, ROOT / "train/offline.py", dataset, "--method", method,
            "--updates", updates, "--episodes", EPISODES,
            "--out", run.with_suffix(".npz"), "--json", compared,
        ]  # fmt: skip
        subprocess.run([str(part) for part in command], check=True)
    return read_json(compared) | {"updates": updates}


if __name__ == "__main__":
    write_json(RECORD, record(Path(sys.argv[1])))
