"""Headline of a study: the aggregate shown first on the terminal and in the report.

It pools the episodes of the in-distribution scenario sets, the environments with randomly drawn
people as they are registered. These are

1. the sets of the bank's group ``test``, if a study has any; else
2. the sets of the same environments with no override but the tier; else
3. all sets.

    mean of a metric = sum over the episodes of all these sets / number of those episodes

where an episode with an undefined metric counts in neither. Each set is resampled separately, so
that an interval refers to these sets. Studies of different scenarios (the full study on the frozen
bank, a small one on scenarios of its own) estimate the same quantity with other samples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.study.bank_sets import GROUPS
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.results import OneResult, SetResults, Summary

POOLED, IN_DISTRIBUTION, TEST = "all sets", "in distribution", "test"  # name of the pooled sets
_PRESETS = {f"{preset}-v1" for preset, _ in GROUPS[TEST].sets.values()}


class Headline(NamedTuple):
    """Headline results of a study.

    Attributes:
        name: Of the aggregate, a key of ``summary["sets"]``.
        sets: Names of the scenario sets that it pools.
        policies: Results of each policy, in the format of a single set.
    """

    name: str
    sets: Sequence[str]
    policies: SetResults

    @property
    def episodes(self) -> int:
        """The number of scenarios per policy."""
        return scenarios_of(self.policies)


def scenarios_of(policies: Mapping[str, OneResult] | SetResults) -> int:
    """Return the number of scenarios per policy in a block of a summary, seeds not counted."""
    first = next(iter(policies.values()))
    return first["episodes"] // first["training_seeds"]


def headline(summary: Summary) -> Headline:
    """Return the headline of a study's summary."""
    name, sets = summary["headline"]["name"], summary["headline"]["sets"]
    return Headline(name, sets, summary["sets"][name])


def headline_sets(study: StudyConfig) -> tuple[str, list[str]]:
    """Return the name of a study's headline, and the names of its sets."""
    names = [each.name for each in study.all_sets]
    test = [name for name in names if name.startswith(f"{TEST}/")]
    found = test or [each.name for each in study.all_sets if _is_in_distribution(each)] or names
    if len(found) == 1:
        return found[0], found
    if found == test:
        return TEST, found
    return (POOLED if found == names else IN_DISTRIBUTION), found


def pooled_sets(study: StudyConfig) -> dict[str, list[str]]:
    """Return the sets of each aggregate of a study, by its name.

    Raises:
        InvalidInput: A set has the name of an aggregate.
    """
    names = [each.name for each in study.all_sets]
    found = {
        group: [name for name in names if name.rpartition("/")[0] == group]
        for group in groups(names)
    }
    title, sets = headline_sets(study)
    if len(sets) > 1:
        found = {title: sets} | found
    if len(names) > 1 and not groups(names):
        found[POOLED] = names
    taken = next((name for name in found if name in names), None)
    if taken is not None:
        raise InvalidInput(
            f"sets: given the name {taken!r}, which several sets together have; rename that set"
        )
    return found


def groups(names: Sequence[str]) -> list[str]:
    """Return the groups of the bank's sets, such as ``test`` of ``test/Crossing``."""
    prefixes = [name.rpartition("/")[0] for name in names]
    return [group for group in dict.fromkeys(prefixes) if group and prefixes.count(group) > 1]


def _is_in_distribution(scenarios: ScenarioSet) -> bool:
    return scenarios.env.rpartition("/")[2] in _PRESETS and scenarios.overrides.keys() <= {"tier"}
