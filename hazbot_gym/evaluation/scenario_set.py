"""Scenario sets: named families of scenarios that policies are evaluated on.

A set is an environment with config values that differ from its preset's. ``DEFAULT_SETS`` are
those of a study that names none.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

from annotated_types import MinLen
from pydantic import AfterValidator, Field

from hazbot_gym.config import Section
from hazbot_gym.envs.registration import NAMESPACE, full_id
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.field_types import Episodes, Seed
from hazbot_gym.utils.yaml_loader import parse_yaml


class ScenarioSet(Section):
    """A named family of scenarios: an environment, and the config values that differ in it.

    The name enters the seeds of the set's episodes, so that adding a set moves no other.
    """

    name: Annotated[str, MinLen(1)]
    env: Annotated[str, AfterValidator(full_id)]
    overrides: dict[str, Any] = Field(default_factory=dict)
    episodes: Episodes | None = None  # how many there are; None: no end of them
    seed: Seed | None = None  # root of their seeds; None: the study's


def _preset(name: str) -> ScenarioSet:
    return ScenarioSet(name=name, env=f"{NAMESPACE}/{name}-v0")


def _paper(name: str) -> ScenarioSet:
    """Return a geometry of the paper: one scenario, without noise, the same in every episode."""
    overrides = {"scenario": name}
    return ScenarioSet(name=name, env=f"{NAMESPACE}/Corridor-v0", overrides=overrides, episodes=1)


PAPER_SETS = tuple(_paper(name) for name in ("E*", "E5.5", "C*", "C90"))
PATTERN_SETS = tuple(
    _preset(name) for name in ("Crossing", "Encountering", "Leading", "Confronting")
)
PLACE_SETS = tuple(_preset(name) for name in ("Circle", "Intersection", "Doorway", "Aisle"))
DEFAULT_SETS = (*PAPER_SETS, *PATTERN_SETS, _preset("Corridor"), *PLACE_SETS)


def track_sets(folder: Path, seed: int | None = None) -> tuple[ScenarioSet, ...]:
    """Return the two sets among real people: walking as recorded, and recorded but reacting."""
    return tuple(
        ScenarioSet(
            name=f"real people, {model}",
            env=f"{NAMESPACE}/Replay-v0",
            overrides={"tracks": str(folder), "people": {"model": model}},
            seed=seed,
        )
        for model in ("replay", "seeded")
    )


def parse_overrides(changes: Iterable[str]) -> dict[str, Any]:
    """Return ``people.model=seeded`` and the like as nested config values, each value read as YAML.

    Raises:
        InvalidInput: a change has no name or value, or contradicts another one.
    """
    overrides: dict[str, Any] = {}
    for change in changes:
        name, equals, text = change.partition("=")
        *groups, field = name.split(".")
        inner: Any = overrides
        for group in groups:
            inner = inner.setdefault(group, {}) if isinstance(inner, dict) else None
        if not (equals and field and isinstance(inner, dict)):
            raise InvalidInput(f"set: cannot use {change!r}; give key=value or group.key=value")
        if field in inner:
            raise InvalidInput(f"set: {name} is given twice, allowed is every key once")
        inner[field] = parse_yaml(text, f"set: {name}")
    return overrides
