"""Stamps of work units, which tell whether stored results are still valid."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.inputs import (
    Blank,
    digests,
    edited,
    last_change,
    mark,
    of_policy,
    of_set,
)
from hazbot_gym.evaluation.rollout import resolve
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.task.observation import layout_in
from hazbot_gym.utils import provenance


class Stamps:
    """Hashes of all inputs of a work unit.

    Inputs are code, versions, values, and the files read for environment and policies.
    """

    def __init__(self, study: StudyConfig, allowed: Permissions = NO_CODE) -> None:
        self.allowed = allowed  # permissions of policies; not part of the stamp
        self._common = provenance.stamp(study.tracks)
        self._watched: dict[str, tuple[str, tuple[int, int]]] = {}
        self._watch(provenance.PACKAGE.rglob("*.py"))
        side_by_side = (2,) if study.engine == "batched" else ()
        self._environments, blanks = {}, dict[Blank, None]()
        for scenarios in study.all_sets:
            config, limit = resolve(scenarios)
            files = of_set(scenarios)
            self._watch(files)
            values = (config.model_dump(mode="json"), limit, mark(files))
            self._environments[scenarios.name] = values
            blanks[Blank(layout_in(config), side_by_side)] = None
        self._blanks = tuple(blanks)
        self._policies: dict[str, str] = {}
        for spec in study.policies:  # now, since files imported later may have been edited
            self._policy(spec)

    def check(self) -> None:
        """Make sure that no file was edited since it was stamped.

        Raises:
            InvalidInput: A file was edited, so that rows may come from either version.
        """
        touched = {
            name: digest
            for name, (digest, seen) in self._watched.items()
            if not Path(name).is_file() or last_change(Path(name)) != seen
        }
        name = edited(touched)
        if name is not None:
            raise InvalidInput(
                f"{name!r} was edited while the study ran; rows from before are kept, run the same "
                "command again to go on"
            )

    def files(self) -> list[Path]:
        """Return the stamped files outside this package."""
        found = map(Path, self._watched)
        return [path for path in found if not path.is_relative_to(provenance.PACKAGE)]

    def _watch(self, files: Iterable[Path]) -> None:
        """Register input files for ``check``."""
        states = {path: last_change(path) for path in files}
        found = digests(states)
        self._watched |= {str(path): (found[str(path)], states[path]) for path in states}

    def of(self, values: Mapping[str, object], scenarios: ScenarioSet, *specs: str) -> str:
        """Return the stamp of some values, a set and policies."""
        parts: list[object] = [self._common, values, scenarios.model_dump(mode="json")]
        parts += [self._environments[scenarios.name], [self._policy(spec) for spec in specs]]
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]

    def _policy(self, spec: str) -> str:
        if spec not in self._policies:
            files = of_policy(spec, self._blanks, self.allowed)
            self._watch(files)
            self._policies[spec] = mark(files)
        return self._policies[spec]
