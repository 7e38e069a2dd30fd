"""Study configuration: policies, scenario sets, numbers of episodes, thresholds.

A study file (``configs/*.yaml``) holds deltas on the defaults below. Two studies with equal values
are the same study, on any machine and with any number of workers.
"""

from __future__ import annotations

import hashlib
import json
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Gt, Le, Lt, MinLen
from pydantic import Field, PrivateAttr, ValidationError, field_serializer, field_validator

from hazbot_gym.config import make_config
from hazbot_gym.config.section import Loose, Section, first_error
from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.field_types import (
    Engine,
    Episodes,
    Names,
    Positive,
    Seed,
    SomeNames,
    Steps,
)
from hazbot_gym.evaluation.scenario_set import DEFAULT_SETS, ScenarioSet, track_sets
from hazbot_gym.policies.sweeps import sweep
from hazbot_gym.study import bank_sets
from hazbot_gym.utils.files import LONGEST, file_name
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import parse_mapping, read_text, read_yaml

DEFAULT_POLICIES = (
    "fuzzy_expert",
    "fuzzy_expert:rules=literal8",
    "ppo",
    "stop_on_sight",
    "stop_when_near",
    "ssm:mode=strict",
    "ssm:mode=directional",
    "ttc",
    "constant:0.25",
    "constant:0.5",
    "constant:0.75",
    "constant:1.0",
)


class Learner(Section):
    """A policy trained by the study, once per training seed."""

    name: Annotated[str, MinLen(1)]
    config: Annotated[Path, Loose]  # training file; relative to the study file
    seeds: Annotated[int, Ge(1), Le(1000)] = 10  # consecutive seeds from the file's seed
    steps: Steps | None = None  # total decisions; None: as in the file
    changes: dict[str, object] = Field(default_factory=dict)  # overrides of the file, by section

    _text: str = PrivateAttr("")

    def model_post_init(self, _: object, /) -> None:
        """Read the training file, so that later edits of it do not change this learner."""
        if self.config.is_file():
            self._text = read_text(self.config, f"learners: {self.name!r}")

    @property
    def training(self) -> JsonObject:
        """The values in ``text``."""
        return parse_mapping(self._text, f"config: {self.config}")

    @property
    def text(self) -> str:
        """The contents of the training file, as they were when this learner was made."""
        return self._text

    @field_validator("name")
    @classmethod
    def _is_name_of_a_folder(cls, name: str) -> str:
        folder = file_name(name)
        if folder[:1] == "." or folder[-1:] == "." or len(folder.encode()) > LONGEST:
            raise ValueError(
                f"given {name!r}, allowed is a name that neither begins nor ends with a dot, of at "
                f"most {LONGEST} bytes"
            )
        return name


class Oracle(Section):
    """Sets in which policies are compared with the oracle (``evaluation/oracle/runs.py``)."""

    sets: SomeNames  # names or prefixes of sets
    episodes: Episodes = 25  # first scenarios of each set
    # of the search with reactive people: parallel plans,
    worlds: Annotated[int, Ge(1), Le(10_000)] = 96
    rounds: Annotated[int, Ge(0), Le(10_000)] = 50  # and generations


class Fronts(Section):
    """Sets and families for the Pareto fronts over sweep parameters (``front_summary.py``)."""

    sets: SomeNames  # names or prefixes of sets
    families: Names = ()  # of rules, swept as in ``policies/sweeps.py``
    groups: dict[str, SomeNames] = Field(default_factory=dict)
    # Reference point of the hypervolume: delay [s], discomfort [s].
    corner: Annotated[tuple[Positive, Positive], Loose] = (24.0, 2.0)

    @property
    def swept(self) -> dict[str, tuple[str, ...]]:
        """The policies of each family's sweep."""
        return {family: tuple(sweep(family)) for family in self.families}

    @property
    def members(self) -> dict[str, tuple[str, ...]]:
        """The policies of every front, swept families first; the first family is the reference.

        Groups are sorted by name, as in the result files.
        """
        return self.swept | dict(sorted(self.groups.items()))


class StudyConfig(Section):
    """All values that determine a study's results; workers and folder are not part of them."""

    policies: SomeNames = DEFAULT_POLICIES
    tuned: Names = ()  # rule families that are tuned on validation scenarios first
    trials: Annotated[int, Ge(1), Le(100_000)] = 50  # of each search
    trial_episodes: Episodes = bank_sets.FEW  # of each trial, in every validation set
    trial_overrides: JsonObject = Field(default_factory=dict)  # such as ``tier: sonar``
    learners: Annotated[tuple[Learner, ...], Loose] = ()  # learned policies
    shown: Names = ()  # policies in the report's plots and replays; empty: all
    fronts: Fronts | None = None
    oracle: Oracle | None = None
    reference: str | None = None  # reference of all comparisons; None: the first policy
    sets: Annotated[tuple[ScenarioSet, ...], Loose, MinLen(1)] = DEFAULT_SETS
    tracks: Annotated[Path, Loose] | None = (
        None  # folder of real tracks; adds the two sets with real people
    )
    # maximum per policy in each of these, where crowds take long; None: as elsewhere
    track_episodes: Episodes | None = None
    episodes: Episodes = 100  # maximum per policy and set
    episodes_per_shard: Episodes = 250  # lost by an interruption at most
    engine: Engine = "batched"
    seed: Seed = 0
    confidence: Annotated[float, Gt(0), Lt(1)] = 0.95  # nominal coverage of the intervals
    resamples: Annotated[int, Ge(100), Le(1_000_000)] = 2000  # of the bootstrap
    ssm: SsmThresholds = SsmThresholds()

    @field_serializer("ssm")
    def _thresholds_by_name(self, ssm: SsmThresholds) -> dict[str, float]:
        return ssm._asdict()

    @field_validator("sets", mode="before")
    @classmethod
    def _names_stand_for_sets(cls, sets: object) -> object:
        if isinstance(sets, str):
            sets = [sets]
        if not isinstance(sets, list | tuple):
            return sets
        return tuple(each for item in sets for each in _sets_meant_by(item))

    @field_validator("policies", "sets")
    @classmethod
    def _no_two_are_alike(cls, items: tuple[object, ...]) -> tuple[object, ...]:
        names = [getattr(item, "name", item) for item in items]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"given {twice!r} twice, allowed is every name once")
        return items

    @field_validator("learners")
    @classmethod
    def _no_two_share_a_folder(cls, learners: tuple[Learner, ...]) -> tuple[Learner, ...]:
        found: dict[str, str] = {}
        for learner in learners:
            # Some file systems ignore case and Unicode normalization.
            folder = unicodedata.normalize("NFC", file_name(learner.name)).casefold()
            if folder in found:
                raise ValueError(
                    f"given the names {found[folder]!r} and {learner.name!r}, which share a folder;"
                    " allowed are names that differ in letters or digits"
                )
            found[folder] = learner.name
        return learners

    @property
    def all_sets(self) -> tuple[ScenarioSet, ...]:
        """The sets to run: the declared ones, and those with real people if tracks are given."""
        if not self.tracks:
            return self.sets
        # Recordings are not part of the bank, but with it their start times are fixed as well.
        is_frozen = any(each.seed == bank_sets.ROOT for each in self.sets)
        seed = bank_sets.ROOT if is_frozen else None
        return self.sets + track_sets(self.tracks, seed, self.track_episodes)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all candidates: fixed policies, tuned families, learners."""
        return (
            *self.policies,
            *(f"{family}, tuned" for family in self.tuned),
            *(learner.name for learner in self.learners),
        )

    @property
    def shown_names(self) -> tuple[str, ...]:
        """The policies in the report's plots and replays, including the reference."""
        wanted = {*self.shown, self.reference_policy} if self.shown else set(self.names)
        return tuple(name for name in self.names if name in wanted)

    @property
    def reference_policy(self) -> str:
        """The reference of all comparisons."""
        return self.reference or self.policies[0]

    def sets_named(self, names: Iterable[str]) -> tuple[ScenarioSet, ...]:
        """Return the sets that match any of some names or prefixes."""
        return tuple(
            each
            for each in self.all_sets
            if any(f"{each.name}/".startswith(f"{name}/") for name in names)
        )

    def episodes_in(self, scenarios: ScenarioSet) -> int:
        """Return the number of episodes to run in a set."""
        return min(self.episodes, scenarios.episodes or self.episodes)

    def identity(self) -> str:
        """Return a hash that two studies share if and only if their values are equal."""
        # Training files enter by their contents, not by their path.
        trainings = [learner.text for learner in self.learners]
        values = self.model_dump(mode="json", exclude={"learners": {"__all__": {"config"}}})
        text = json.dumps([values, *trainings], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _sets_meant_by(item: object) -> Sequence[object]:
    """Expand a name in ``sets`` to its sets; other entries are returned as they are."""
    if isinstance(item, Mapping) and "bank" in item:
        overrides = item.get("overrides", {})
        if item.keys() - {"bank", "overrides"} or not isinstance(overrides, Mapping):
            raise ValueError(f"given {dict(item)}, beside bank allowed is a mapping of overrides")
        return bank_sets.select(str(item["bank"]), overrides)
    if not isinstance(item, str):
        return [item]
    if item.startswith(bank_sets.PREFIX):
        return bank_sets.select(item.removeprefix(bank_sets.PREFIX))
    found = [each for each in DEFAULT_SETS if each.name == item]
    if not found:
        names = ", ".join(each.name for each in DEFAULT_SETS)
        raise ValueError(f"given {item!r}, allowed are {names}, bank:NAME or mappings")
    return found


def load_study(path: Path | str | None = None, **changes: object) -> StudyConfig:
    """Return the default study with a file's deltas and then the given changes applied.

    Raises:
        InvalidInput: the file cannot be read or a value is not allowed; one line.
    """
    values = read_yaml(Path(path)) if path else {}
    if path:
        values["learners"] = _beside(Path(path), values.get("learners", ()))
    values |= {name: value for name, value in changes.items() if value is not None}
    for name in values.keys() - StudyConfig.model_fields.keys():
        allowed = ", ".join(StudyConfig.model_fields)
        raise InvalidInput(f"{name}: unknown key, allowed are {allowed}")
    try:
        study = StudyConfig.model_validate(values)
    except ValidationError as error:
        raise InvalidInput(first_error(error, StudyConfig)) from error
    trial = dict(study.trial_overrides)
    make_config(trial.pop("config", None), **trial)  # raises now, before a folder is written
    if study.reference_policy not in study.names:
        allowed = ", ".join(study.names)
        raise InvalidInput(f"reference: given {study.reference!r}, allowed are {allowed}")
    twice = next((name for name in study.names if study.names.count(name) > 1), None)
    if twice is not None:
        raise InvalidInput(f"learners: given the name {twice!r} twice, allowed is every name once")
    _check_parts(study)
    for learner in study.learners:
        if not learner.config.is_file():
            raise InvalidInput(f"learners: given {str(learner.config)!r}, which does not exist")
    if study.tracks and not study.tracks.exists():
        raise InvalidInput(f"tracks: given {str(study.tracks)!r}, which does not exist")
    return study


def _check_parts(study: StudyConfig) -> None:
    """Check that all names in ``shown``, fronts and oracle are candidates or sets."""
    nobody = next((name for name in study.shown if name not in study.names), None)
    if nobody is not None:
        raise InvalidInput(f"shown: given {nobody!r}, allowed are {', '.join(study.names)}")
    for part in ("fronts", "oracle"):
        wanted = getattr(study, part)
        for name in wanted.sets if wanted else ():
            if not study.sets_named([name]):
                allowed = ", ".join(each.name for each in study.all_sets)
                raise InvalidInput(f"{part}.sets: given {name!r}, allowed are {allowed}")
    sets = [each.name for each in study.all_sets]
    twice = next((name for name in sets if sets.count(name) > 1), None)
    if twice is not None:  # one of ``sets``, and one with real people
        raise InvalidInput(f"sets: given {twice!r} beside tracks, which add a set of that name")
    if study.fronts is None:
        return
    for group in study.fronts.groups.keys() & set(study.fronts.families):
        raise InvalidInput(f"fronts.groups: given {group!r}, which is one of fronts.families")
    swept = [each for some in study.fronts.swept.values() for each in some]  # raises if unknown
    for group, members in study.fronts.groups.items():
        unknown = next((each for each in members if each not in (*study.names, *swept)), None)
        if unknown is not None:
            allowed = ", ".join(study.names)
            raise InvalidInput(f"fronts.groups.{group}: given {unknown!r}, allowed are {allowed}")


def _beside(study: Path, learners: object) -> object:
    """Return a study file's learners, with training files resolved relative to it."""
    if not isinstance(learners, list | tuple):
        return learners
    return [
        {**each, "config": study.parent / str(each["config"])}
        if isinstance(each, Mapping) and "config" in each
        else each
        for each in learners
    ]
