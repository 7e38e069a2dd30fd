"""Scenario bank: frozen scenarios, shared by all studies.

The file holds the people: one row per person, with the key and a hash of the scenario. An episode
draws its scenario from the key, and its row carries the hash of the drawn scenario; rows with
another hash than the bank's are rejected. ``python docs/make_bank.py`` rewrites the bank.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.rollout import episode_seed, resolve, scenario_id
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.study import store
from hazbot_gym.study.bank_sets import BANK_SETS, BankSet
from hazbot_gym.task.fingerprint import fingerprint, parameters
from hazbot_gym.utils import processors

if TYPE_CHECKING:
    import pandas as pd

FILE = Path(__file__).with_suffix(".parquet")


def write(path: Path = FILE) -> None:
    """Draw every scenario of the bank, and write the file."""
    store.write_rows(path, list(draw(BANK_SETS)), stamp="bank")


def read() -> pd.DataFrame:
    """Return the bank, one row per person."""
    return store.read_episodes(FILE)


def draw(sets: Iterable[BankSet]) -> Iterator[Row]:
    """Yield a row for each person of each scenario of some sets, as drawn now."""
    for each in sets:
        config, _ = resolve(ScenarioSet.model_validate(each._asdict()))
        seeds = [episode_seed(each.seed, each.name, index) for index in range(each.episodes)]
        worlds = CorridorVectorEnv(len(seeds), config, threads=processors.usable())
        _, start = worlds.reset(seed=seeds)
        for index, (seed, key) in enumerate(
            zip(seeds, start["scenario_key"].tolist(), strict=True)
        ):
            scenario = worlds.source.draw(key)
            head: Row = {
                "scenario": scenario_id(each.name, index),
                "scenario_hash": fingerprint(scenario),
                "seed": seed,
                "scenario_key": key,
            }
            for number, person in enumerate(parameters(scenario)):
                yield {**head, "person": number, **person}
        worlds.close()


def check(rows: pd.DataFrame) -> None:
    """Compare the scenarios of episodes in the bank's sets with the bank.

    Args:
        rows: of a study.

    Raises:
        InvalidInput: a scenario differs from the bank's.
    """
    written = read().drop_duplicates("scenario").set_index("scenario")["scenario_hash"]
    expected = rows["scenario"].map(written)
    wrong = rows[expected.notna() & (expected != rows["scenario_hash"])]
    if len(wrong):
        first = wrong.iloc[0]
        raise InvalidInput(
            f"scenario {first['scenario']!r}: drawn with hash {first['scenario_hash']}, the bank "
            f"has {written[first['scenario']]}; names of the bank are for its scenarios as they are"
        )
