"""Keep searches for the documentation: ``python docs/keep_search.py FOLDER...``.

Each folder is that of a search with a file of ``configs/search``, and has its name. Writes their
records into ``benchmarks/search.json`` and the training file of each winner into
``configs/tuned``. Of each search as many trials count as of the shortest.
"""

from __future__ import annotations

import sys
from pathlib import Path

import yaml

from hazbot_gym.study.learner_search import RECORD, laid_over
from hazbot_gym.utils.files import read_json, write_json, write_text
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import read_yaml

ROOT = Path(__file__).parents[1]
KEPT, CONFIGS = ROOT / "benchmarks" / "search.json", ROOT / "configs"
VALIDATION_EPISODES, VALIDATIONS = 225, 4  # half as many, of a training in a study of many seeds
HEAD = """# Written by docs/keep_search.py: {base} with the best values of {trials} trials of
# configs/search/{name}.yaml, {seconds} each; validated on half as many scenarios.
"""


def tuned(name: str, search: JsonObject) -> str:
    """Return the training file of the best trial of a search."""
    best = search["trials"][search["best"]]
    base = read_yaml(CONFIGS / search["config"].removeprefix("../"))
    every = -(-best["steps"] // VALIDATIONS)
    values = laid_over(base, best["values"]) | {
        "steps": best["steps"],
        "validation": {"every_steps": every, "episodes": VALIDATION_EPISODES},
    }
    seconds = search["plan"]["seconds"]
    head = HEAD.format(
        trials=len(search["trials"]),
        name=name,
        seconds=f"{seconds:.0f} s of training" if seconds else "the steps of that file",
        base=f"configs/{search['config'].removeprefix('../')}",
    )
    return head + yaml.safe_dump(values, sort_keys=False)


def kept(searches: dict[str, JsonObject]) -> dict[str, JsonObject]:
    """Return searches with equal numbers of trials, the first ones of each, by name."""
    count = min(len(search["trials"]) for search in searches.values())

    def first(search: JsonObject) -> JsonObject:
        trials = search["trials"][:count]
        best = max(range(count), key=lambda k: trials[k]["return"])
        return search | {"trials": trials, "best": best}

    return {name: first(search) for name, search in searches.items()}


if __name__ == "__main__":
    record = kept({Path(folder).name: read_json(Path(folder, RECORD)) for folder in sys.argv[1:]})
    write_json(KEPT, record)
    for name, search in record.items():
        write_text(CONFIGS / "tuned" / f"{name}.yaml", tuned(name, search))
