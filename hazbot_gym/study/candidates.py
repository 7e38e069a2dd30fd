"""Candidates of a study: fixed policies, rule families tuned first, and learners trained first.

    OUT/tuned/FAMILY.json   a search on validation scenarios
    OUT/trained/NAME/SEED/  a training run

Searches and runs are parallel jobs; a run takes one core, and the scenario sets of a search's trial
run in parallel. Each resumes by itself, so that a killed study continues with the unfinished part.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rich.console import Console

from hazbot_gym.config.deltas import merge
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.inputs import digests, of_set
from hazbot_gym.evaluation.workers import Pool
from hazbot_gym.policies.base import NO_CODE, Permissions, spec_of
from hazbot_gym.policies.tuning_spaces import SPACES
from hazbot_gym.study.config import Learner, StudyConfig
from hazbot_gym.study.costs import Training
from hazbot_gym.training import run_folder
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.inputs import of_training
from hazbot_gym.utils.files import file_name, read_json

if TYPE_CHECKING:
    from hazbot_gym.study import tuning

TUNED, TRAINED = "tuned", "trained"
_FILE = spec_of("learned", {"path": ""})


class Candidate(NamedTuple):
    """Candidate: a name and the argument of ``policies.base.make``."""

    name: str
    specs: tuple[str, ...]  # one per training seed of a learner


class Job(Protocol):
    """Preparatory job of a study."""

    def files(self) -> list[Path]:
        """Return the input files."""
        ...

    def run(self, pool: Pool) -> None:
        """Do the job on a pool's workers."""
        ...


class TrainingJob(NamedTuple):
    """Training run of one seed of a learner."""

    config: TrainConfig
    folder: Path
    allowed: Permissions

    def files(self) -> list[Path]:
        """Return the input files."""
        return of_training(self.config, self.allowed)

    def run(self, pool: Pool) -> None:
        """Train on one worker."""
        pool.submit_in(self.folder, _train, self.config, self.allowed).result()


class SearchJob(NamedTuple):
    """Search for the options of a rule family."""

    search: tuning.Search
    path: Path

    def files(self) -> list[Path]:
        """Return the input files."""
        return [path for each in self.search.sets for path in of_set(each)]

    def run(self, pool: Pool) -> None:
        """Run one trial after the other, each on all workers."""
        from hazbot_gym.study import tuning

        tuning.tune(self.search, self.path, pool=pool)


def check(study: StudyConfig, allowed: Permissions = NO_CODE) -> None:
    """Check that all families can be tuned and all learners trained.

    Raises:
        InvalidInput: there is no such family, or a learner's training file, changes or seeds
            cannot be used, or its teacher is not allowed.
    """
    unknown = [family for family in study.tuned if family not in SPACES]
    if unknown:
        raise InvalidInput(f"tuned: given {unknown[0]!r}, allowed are {', '.join(SPACES)}")
    for learner in study.learners:
        _check_learner(learner, allowed)


def _check_learner(learner: Learner, allowed: Permissions) -> None:
    from hazbot_gym.training import run as training

    try:
        training.make_all(training_of(learner, learner.seeds - 1), allowed)
    except InvalidInput as fault:
        raise InvalidInput(f"learners: {learner.name!r}: {fault}") from None


def jobs(
    study: StudyConfig,
    out: Path,
    allowed: Permissions = NO_CODE,
    console: Console | None = None,
) -> list[Job]:
    """Return the unfinished jobs; learners first, since they take longest.

    A search with changed code or data restarts, as shards do; so does a run with changed data.

    Args:
        study: the study.
        out: its folder.
        allowed: permissions of a teacher.
        console: output for restart messages; None for silence.
    """
    console = console or Console(quiet=True)
    return [*_trainings(study, out, allowed, console), *_searches(study, out, console)]


def _trainings(
    study: StudyConfig, out: Path, allowed: Permissions, console: Console
) -> Iterator[TrainingJob]:
    """Yield the training runs that are unfinished, damaged or outdated."""
    for learner in study.learners:
        read = digests(of_training(training_of(learner, 0), allowed))
        for k in range(learner.seeds):
            training, folder = training_of(learner, k), folder_of(learner, k, out)
            try:
                run_folder.claim(folder, training.identity(), resume=True, inputs=read)
            except InvalidInput as error:
                console.print(f"a run is begun anew: {error}", markup=False)
                shutil.rmtree(folder)
            if run_folder.has_result(folder, training.identity()):
                continue
            if (folder / run_folder.RESULT).exists():
                console.print(f"a damaged run is done again: {folder}", markup=False)
            yield TrainingJob(training, folder, allowed)


def _searches(study: StudyConfig, out: Path, console: Console) -> Iterator[SearchJob]:
    """Yield the unfinished searches."""
    if not study.tuned:
        return
    from hazbot_gym.study import tuning

    sets = tuning.validation(study.trial_overrides)
    for family in study.tuned:
        search = tuning.Search(family, study.trials, 0, study.trial_episodes, sets)
        path = out / TUNED / f"{family}.json"
        trials = tuning.found(search, path)
        if trials is None:
            console.print(f"a search of other code or data is begun anew: {path}", markup=False)
            path.unlink()
        if trials is None or len(trials) < search.trials:
            yield SearchJob(search, path)


def of_study(study: StudyConfig, out: Path) -> list[Candidate]:
    """Return all candidates; requires that every job is finished."""
    tuned = [read_json(out / TUNED / f"{family}.json")["best"]["policy"] for family in study.tuned]
    trained = [
        tuple(
            _FILE + str(folder_of(learner, k, out) / run_folder.POLICY)
            for k in range(learner.seeds)
        )
        for learner in study.learners
    ]
    specs = [*((policy,) for policy in (*study.policies, *tuned)), *trained]
    return [Candidate(name, each) for name, each in zip(study.names, specs, strict=True)]


def swept(study: StudyConfig) -> list[Candidate]:
    """Return the policies that only serve the fronts."""
    families = study.fronts.swept.values() if study.fronts else ()
    names = dict.fromkeys(policy for family in families for policy in family)
    return [Candidate(name, (name,)) for name in names if name not in study.names]


def portable(found: list[Candidate], out: Path) -> dict[str, list[str]]:
    """Return specs by name for a manifest, with files named from the study's folder."""
    there, here = _FILE + str(out / TRAINED), _FILE + TRAINED
    return {each.name: [spec.replace(there, here) for spec in each.specs] for each in found}


def training_of(learner: Learner, k: int) -> TrainConfig:
    """Return the training run of a learner's k-th seed.

    Changes merge into sections: ``overrides: {reward: {burden: 0}}`` keeps other overrides.
    """
    values = merge(learner.training, learner.changes)
    values |= {"steps": learner.steps} if learner.steps else {}
    return load_training(**{**values, "seed": load_training(**values).seed + k})


def folder_of(learner: Learner, k: int, out: Path) -> Path:
    """Return the folder of the run of a learner's k-th seed."""
    return out / TRAINED / file_name(learner.name) / str(k)


def trainings(study: StudyConfig, out: Path) -> list[Training]:
    """Return the training costs of every learner of a finished study."""
    found = []
    for learner in study.learners:
        results = [
            read_json(folder_of(learner, k, out) / run_folder.RESULT) for k in range(learner.seeds)
        ]
        found.append(
            Training(
                learner.name,
                learner.config.name,
                learner.seeds,
                max(result["steps"] for result in results),
                sum(result["training_seconds"] for result in results) / len(results),
                sum(result["best"]["return"] for result in results) / len(results),
            )
        )
    return found


def _train(folder: Path, config: TrainConfig, allowed: Permissions) -> None:
    from hazbot_gym.training import run as training

    try:
        training.train(config, folder, resume=True, allowed=allowed)
    except run_folder.PolicyLost:
        shutil.rmtree(folder)
        training.train(config, folder, allowed=allowed)
