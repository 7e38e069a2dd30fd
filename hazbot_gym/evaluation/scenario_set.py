"""Scenario sets: named families of scenarios for evaluation.

A set is an environment with config values that differ from its preset's. ``DEFAULT_SETS`` apply to
a study that names none.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

from annotated_types import MinLen
from pydantic import AfterValidator, Field

from hazbot_gym.config.section import Section
from hazbot_gym.envs.registration import NAMESPACE, full_id
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.field_types import Episodes, Seed
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import parse_yaml


class ScenarioSet(Section):
    """A named family of scenarios: an environment, and its config overrides.

    The name enters the seeds of the set's episodes, so that adding a set changes no other set.
    """

    name: Annotated[str, MinLen(1)]
    env: Annotated[str, AfterValidator(full_id)]
    overrides: JsonObject = Field(default_factory=dict)
    episodes: Episodes | None = None  # number of scenarios; None: unlimited
    seed: Seed | None = None  # root of their seeds; None: the study's


def _preset(name: str) -> ScenarioSet:
    return ScenarioSet(name=name, env=f"{NAMESPACE}/{name}-v1")


def _paper(name: str) -> ScenarioSet:
    """Return a scenario of the paper: fixed geometry, no noise, the same in every episode."""
    overrides = {"scenario": name}
    return ScenarioSet(name=name, env=f"{NAMESPACE}/Corridor-v1", overrides=overrides, episodes=1)


PAPER_SETS = tuple(_paper(name) for name in ("E*", "E5.5", "C*", "C90"))
PATTERN_SETS = tuple(
    _preset(name) for name in ("Crossing", "Encountering", "Leading", "Confronting")
)
PLACE_SETS = tuple(_preset(name) for name in ("Circle", "Intersection", "Doorway", "Aisle"))
DEFAULT_SETS = (*PAPER_SETS, *PATTERN_SETS, _preset("Corridor"), *PLACE_SETS)


def track_sets(
    folder: Path, seed: int | None = None, episodes: int | None = None
) -> tuple[ScenarioSet, ...]:
    """Return the two sets with real people: replayed as recorded, and recorded but reactive."""
    return tuple(
        ScenarioSet(
            name=f"real people, {model}",
            env=f"{NAMESPACE}/Replay-v1",
            overrides={"tracks": str(folder), "people": {"model": model}},
            episodes=episodes,
            seed=seed,
        )
        for model in ("replay", "seeded")
    )


def parse_overrides(changes: Iterable[str]) -> dict[str, object]:
    """Parse overrides such as ``people.model=seeded`` into nested config values, read as YAML.

    Raises:
        InvalidInput: an override has no name or value, or contradicts another override.
    """
    overrides: dict[str, object] = {}
    for change in changes:
        name, equals, text = change.partition("=")
        *groups, field = name.split(".")
        inner: object = overrides
        for group in groups:
            inner = inner.setdefault(group, {}) if isinstance(inner, dict) else None
        if not (equals and field and isinstance(inner, dict)):
            raise InvalidInput(f"set: cannot use {change!r}; give key=value or group.key=value")
        if field in inner:
            raise InvalidInput(f"set: {name} is given twice, allowed is every key once")
        inner[field] = parse_yaml(text, f"set: {name}")
    return overrides
