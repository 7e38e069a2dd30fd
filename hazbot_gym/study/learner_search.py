"""Hyperparameter search of a learner, with the same training time for each trial.

    OUT/search.json       the search, and its trials so far
    OUT/trial-000/        the run folder of each (``training/run.py``)
    OUT/best.yaml         the training file of the best one

A search file names a training file and a space, by dotted names:

    config: ../sac.yaml
    seconds: 60
    space:
      learning_rate: {log_uniform: [1.0e-4, 3.0e-3]}
      options.gradient_steps: {choice: [8, 16, 32]}

Trial 0 has the values of the training file. A trial is worth the best mean return on the validation
scenarios of its training. A killed search resumes in the middle of a trial.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Callable, Mapping
from functools import reduce
from pathlib import Path
from typing import Annotated, Any

import yaml
from annotated_types import Ge, Gt, Le, MinLen
from pydantic import Field, ValidationError, field_validator

from hazbot_gym.config.deltas import merge
from hazbot_gym.config.section import Section, first_error, shown
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.study.proposals import Distribution, Trial, choice, interval, propose
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.run import train
from hazbot_gym.training.run_folder import RESULT
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import owner, read_json, sole_use, write_json, write_text
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import read_yaml

RECORD, BEST = "search.json", "best.yaml"
PROBED = 0.05  # share of a trial's time that the probe of its speed takes
VALIDATIONS = 4  # in each trial
KINDS = ("uniform", "log_uniform", "choice")


class LearnerSearch(Section):
    """All values that determine a search."""

    config: str  # the training file, relative to the search file
    # training time of a trial on one core [s]; None for the steps of the training file
    seconds: Annotated[float, Gt(0)] | None = None
    trials: Annotated[int, Ge(1), Le(10_000)] = 10
    first_at_random: Annotated[int, Ge(1)] = 5  # trials before the estimator starts
    seed: Annotated[int, Ge(0), Le(2**32 - 1)] = 0
    space: Annotated[dict[str, dict[str, list[Any]]], MinLen(1)] = Field(default_factory=dict)

    @field_validator("space")
    @classmethod
    def _are_distributions(cls, space: Any) -> Any:
        for name, given in space.items():
            if name in ("steps", "seed", "env"):
                raise ValueError(f"{name}: all trials have the same")
            _distribution(name, given)
        return space


def load_search(path: Path, **changes: object) -> LearnerSearch:
    """Return the search of a file, with the given changes applied.

    Raises:
        InvalidInput: The file cannot be read, or a value is not allowed; one line.
    """
    values = read_yaml(path, "config")
    values |= {name: value for name, value in changes.items() if value is not None}
    try:
        return LearnerSearch.model_validate(values)
    except ValidationError as error:
        raise InvalidInput(first_error(error, LearnerSearch)) from error


def search(
    plan: LearnerSearch,
    base: Mapping[str, object],
    out: Path,
    *,
    allowed: Permissions = NO_CODE,
    on_progress: Callable[[JsonObject], None] = lambda trial: None,
) -> JsonObject:
    """Run the remaining trials of a search, and return its record.

    Args:
        plan: The search.
        base: Values of its training file.
        out: Folder of the search; that of the same search is resumed.
        allowed: Permissions of the training file's teacher.
        on_progress: Called with each finished trial.

    Raises:
        InvalidInput: A value is not allowed, or the folder holds something else.
    """
    _first(plan, base)
    training_of(base)
    record = _resumed(plan, base, out)
    with sole_use(out):
        _run_all(plan, base, out, record, allowed, on_progress)
    return record


def _run_all(
    plan: LearnerSearch,
    base: Mapping[str, object],
    out: Path,
    record: JsonObject,
    allowed: Permissions,
    on_progress: Callable[[JsonObject], None],
) -> None:
    """Run the remaining trials, each written into the record as soon as it is known."""
    trials: list[JsonObject] = record["trials"]
    while len(trials) < plan.trials or trials[-1]["return"] is None:
        if not trials or trials[-1]["return"] is not None:
            values = _proposed(plan, trials) if trials else _first(plan, base)
            steps = _steps_in(laid_over(base, values), plan.seconds, allowed)
            trials.append({"values": values, "steps": steps, "return": None})
            write_json(out / RECORD, record)
        _run(trials[-1], base, out / f"trial-{len(trials) - 1:03d}", allowed)
        best = max(trials, key=lambda trial: trial["return"])
        record["best"] = trials.index(best)
        write_json(out / RECORD, record)
        write_text(out / BEST, _file_of(base, best))
        on_progress(trials[-1])


def _first(plan: LearnerSearch, base: Mapping[str, object]) -> JsonObject:
    """Return the training file's own values of the space."""
    first = {name: value_of(base, name) for name in plan.space}
    for name, value in first.items():
        _check_in_space(name, value, plan.space[name])
    return first


def value_of(values: Mapping[str, Any], name: str) -> object:
    """Return the value of a dotted name.

    Raises:
        InvalidInput: There is none.
    """
    try:
        return reduce(lambda node, key: node[key], name.split("."), values)
    except (KeyError, TypeError):
        raise InvalidInput(
            f"space.{name}: the training file gives no value, allowed are names of values in it"
        ) from None


def laid_over(base: Mapping[str, object], values: Mapping[str, object]) -> JsonObject:
    """Return the values of a training file with others, by dotted name, in place of its own."""
    for name, value in values.items():
        delta = reduce(lambda node, key: {key: node}, reversed(name.split(".")), value)
        base = merge(base, delta)  # type: ignore[arg-type]  # a name has at least one key
    return dict(base)


def training_of(values: Mapping[str, object], steps: int | None = None) -> TrainConfig:
    """Return the training run of a file's values, with a number of steps of its own, if given."""
    config = load_training(None, **values)
    if steps is None:
        return config
    every = -(-steps // VALIDATIONS)
    validation = config.validation.model_copy(update={"every_steps": every})
    return config.model_copy(update={"steps": steps, "validation": validation})


def _distribution(name: str, given: Mapping[str, list[Any]]) -> Distribution:
    kind, values = next(iter(given.items()), ("nothing", []))
    allowed = "one of {uniform: [low, high]}, {log_uniform: [low, high]} and {choice: [...]}"
    if len(given) != 1 or kind not in KINDS:
        raise ValueError(f"{name}: given {shown(dict(given))}, allowed is {allowed}")
    if kind == "choice":
        if not values:
            raise ValueError(f"{name}: given no values to choose from")
        return choice([json.dumps(value) for value in values])
    numbers = [each for each in values if isinstance(each, int | float) and each is not True]
    least = 0.0 if kind == "log_uniform" else -float("inf")
    if len(values) != 2 or len(numbers) != 2 or not least < numbers[0] < numbers[1]:
        raise ValueError(f"{name}: given {shown(dict(given))}, allowed is {kind}: [low, high]")
    return interval(*map(float, values), is_log=kind == "log_uniform")


def _check_in_space(name: str, value: object, given: Mapping[str, list[Any]]) -> None:
    ((kind, values),) = given.items()
    is_in = value in values
    if kind != "choice":
        is_in = isinstance(value, int | float) and values[0] <= value <= values[1]
    if not is_in:
        raise InvalidInput(
            f"space.{name}: the training file gives {shown(value)}, allowed is a value in "
            f"{shown(dict(given))}"
        )


def _proposed(plan: LearnerSearch, trials: list[JsonObject]) -> JsonObject:
    space = {name: _distribution(name, given) for name, given in plan.space.items()}
    choices = [name for name, given in plan.space.items() if "choice" in given]

    def written(values: JsonObject) -> JsonObject:
        return {**values, **{name: json.dumps(values[name]) for name in choices}}

    tried = [Trial(written(trial["values"]), trial["return"]) for trial in trials]
    chosen: JsonObject = propose(space, tried, plan.seed, first_at_random=plan.first_at_random)
    return {**chosen, **{name: json.loads(chosen[name]) for name in choices}}


def _steps_in(values: JsonObject, seconds: float | None, allowed: Permissions) -> int:
    """Return the number of steps that take a training time, found by ever longer probes.

    The last two probes tell the speed, so that neither compiling nor the steps before the first
    update count.
    """
    config = training_of(values)
    if seconds is None:
        return config.steps
    steps, before, earlier = config.worlds, 0.0, 0
    while True:
        probe = training_of(values, steps)
        check = probe.validation.model_copy(update={"every_steps": steps, "episodes": 1})
        with tempfile.TemporaryDirectory() as folder:
            train(probe.model_copy(update={"validation": check}), folder, allowed=allowed)
            result = read_json(Path(folder, RESULT))
        took, done = float(result["training_seconds"]), int(result["steps"])
        if took >= PROBED * seconds and done > earlier > 0 and took > before:
            speed = (done - earlier) / (took - before)
            return max(done, round(done + (seconds - took) * speed))
        before, earlier, steps = took, done, max(2 * steps, done + 1)


def _run(trial: JsonObject, base: Mapping[str, object], folder: Path, allowed: Permissions) -> None:
    """Train, and write what the training reached into its trial."""
    config = training_of(laid_over(base, trial["values"]), trial["steps"])
    best = train(config, folder, resume=folder.exists(), allowed=allowed).best
    result = read_json(folder / RESULT)
    trial |= {"return": best["return"], "training_seconds": result["training_seconds"]}
    trial["validations"] = [
        {name: each[name] for name in ("step", "return", "delay_s", "arrived")}
        for each in result["validations"]
    ]


def _file_of(base: Mapping[str, object], best: JsonObject) -> str:
    """Return the training file of a trial."""
    config = training_of(laid_over(base, best["values"]), best["steps"])
    values = laid_over(base, best["values"]) | {"steps": best["steps"]}
    values["validation"] = config.validation.model_dump()
    return yaml.safe_dump(values, sort_keys=False)


def _resumed(plan: LearnerSearch, base: Mapping[str, object], out: Path) -> JsonObject:
    """Return the record of the same search in a folder, or a new one."""
    # More trials of the same search are the same search.
    identity = plan.model_dump(mode="json", exclude={"trials", "config"}) | {"base": base}
    text = json.dumps(identity, sort_keys=True)
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    found = owner(out, RECORD, "search")
    if found == digest:
        return read_json(out / RECORD)
    if found:
        raise InvalidInput(f"out: {str(out)!r} holds another search; give a new folder")
    return {
        "search": digest,
        "config": plan.config,
        "plan": plan.model_dump(mode="json", exclude={"config"}),
        "commit": provenance.commit(),
        "versions": provenance.versions(),
        "machine": provenance.machine(),
        "trials": [],
    }
