"""Scenario sets in words, for the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.evaluation.scenario_set import ScenarioSet

RECORDED = {
    "replay": "People walk as recorded.",
    "seeded": "People come in when, where and as fast as recorded, and react to the robot.",
}


def describe(scenarios: ScenarioSet) -> str:
    """Return one sentence on a set."""
    scenario = scenarios.overrides.get("scenario")
    if scenario is not None:
        return f"The paper's geometry {scenario}: one scripted walker, an ideal drive."
    model = scenarios.overrides.get("people", {}).get("model")
    if model in RECORDED:
        return RECORDED[model]
    text, _ = ENVIRONMENTS.get(scenarios.env.rpartition("/")[2], (f"{scenarios.env}.", {}))
    changes = ", ".join(_changes(scenarios.overrides))
    return f"{text} Changed: {changes}." if changes else text


def _changes(overrides: Mapping[str, object], path: str = "") -> Iterator[str]:
    """Yield config values as ``group.key = value``; equal entries of a list only once."""
    for name, value in overrides.items():
        if isinstance(value, Mapping):
            yield from _changes(value, f"{path}{name}.")
        elif isinstance(value, list | tuple) and value and value.count(value[0]) == len(value) > 1:
            first = value[0]
            inner = ", ".join(_changes(first)) if isinstance(first, Mapping) else str(first)
            yield f"all {path}{name}: {inner}"
        else:
            yield f"{path}{name} = {value}"
