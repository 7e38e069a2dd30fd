"""Training configuration: algorithm, environments, budget, validation.

A training file (``configs/*.yaml``) holds deltas on the defaults below. ``options`` are passed to
the algorithm of Stable-Baselines3 and ``network`` to its policy, with the names used there.
"""

from __future__ import annotations

import fnmatch
import hashlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le
from pydantic import Field, ValidationError, ValidationInfo, field_validator

from hazbot_gym.config import Config
from hazbot_gym.config.parameters import MOST_PEOPLE
from hazbot_gym.config.section import Loose, Section, first_error
from hazbot_gym.core.sensor_ring import RINGS
from hazbot_gym.envs.registration import NAMESPACE, full_id
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import rollout
from hazbot_gym.evaluation.field_types import Engine, Names, Positive, SomeNames, Steps
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.task.observation import Layout, layout_with
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import read_yaml

Algorithm = Literal[
    "ppo", "sac", "td3", "tqc", "crossq", "dqn", "qrdqn", "recurrent_ppo", "bc", "dagger"
]  # fmt: skip
STUDENTS = ("bc", "dagger")  # pure imitation, without rewards


class Validation(Section):
    """Model selection by mean return over held-out validation scenarios."""

    every_steps: Steps = 250_000  # also the interval of checkpoints
    episodes: Annotated[int, Ge(1), Le(100_000)] = 100  # split among the environments


class Imitation(Section):
    """Imitation of a teacher: pretraining (``imitation.py``), or bc and dagger (``dagger.py``)."""

    teacher: str | dict[str, str] = "fuzzy_expert"  # of all environments, or of each by its name
    # in its place the training of a teacher for each environment (``specialists.py``); of ppo
    specialists: JsonObject | None = None
    decisions: Annotated[int, Ge(1), Le(50_000_000)] = 700_000  # demonstrations in each round
    # of ppo: in the first one the teacher drives, then the student; of dagger steps / decisions
    rounds: Annotated[int, Ge(1), Le(100)] = 1
    noise: Annotated[float, Ge(0)] = 0.2  # standard deviation of the action noise
    epochs: Annotated[int, Ge(1), Le(100_000)] = 15
    batch_size: Annotated[int, Ge(1), Le(50_000_000)] = 2048
    learning_rate: Annotated[float, Gt(0)] = 1e-3  # decays to 0


class Residual(Section):
    """Residual policy learning on a base policy (``policies/residual.py``)."""

    base: str = "fuzzy_expert"
    scale: Annotated[float, Gt(0), Le(2)] = 0.5  # of corrections in [-1, 1]; 2 overrides any base


class Lagrangian(Section):
    """Cost constraint and multiplier update (``training/ppo_lagrangian.py``)."""

    limit: Annotated[float, Ge(0)]  # d, limit of the mean cost of an episode
    rate: Annotated[float, Gt(0)] = 0.1  # eta, integral gain
    proportional: Annotated[float, Ge(0)] = 0.0  # K_P, proportional gain
    derivative: Annotated[float, Ge(0)] = 0.0  # K_D, derivative gain
    start: Annotated[float, Ge(0)] = 0.0  # initial multiplier


class Stage(Section):
    """Stage of a curriculum: overrides of the environments' config from a decision on."""

    from_step: Annotated[int, Ge(0)] = 0  # from the next beginning of an interval on
    overrides: dict[str, object] = Field(default_factory=dict)  # besides those of the run


class TrainConfig(Section):
    """All values that determine a run's weights; the output folder is not part of them."""

    algorithm: Algorithm = "ppo"
    env: SomeNames = (f"{NAMESPACE}/Corridor-v1",)
    overrides: dict[str, object] = Field(default_factory=dict)  # of the environments' config
    # stages by from_step (docs/curriculum.md); validations are in the environments without them
    curriculum: Annotated[tuple[Stage, ...], Loose] = ()
    worlds: Annotated[int, Ge(1), Le(100_000)] = (
        512  # parallel worlds, split among the environments
    )
    engine: Engine = "batched"
    threads: Annotated[int, Ge(1), Le(1024)] = 1  # of the engine; results do not depend on it
    steps: Steps = 3_000_000  # total actions of the policy
    action_repeat: Annotated[int, Ge(1), Le(100)] = 1  # decisions per action in training
    seed: Annotated[int, Ge(0), Le(2**32 - 1)] = 0
    reward_scale: Annotated[float, Gt(0)] = 0.05  # logged returns are unscaled
    shaping: Literal["none", "free_drive"] = "none"  # free_drive: see training/shaping.py
    hidden: Names = ()  # fields masked from networks (training/feature_mask.py), with *
    staggered_starts: bool = False  # see training/staggered_starts.py; on the batched engine
    asymmetric_critic: bool = False  # whether the critic observes the time left; only for ppo
    imitation: Annotated[Imitation | None, Field(validate_default=True)] = None  # ppo, bc, dagger
    residual: Residual | None = None  # residual policy; for ppo and recurrent_ppo
    lagrangian: Lagrangian | None = None  # cost constraint; only for ppo
    # range of the price of nearness, drawn for each episode (training/priced_rewards.py); for ppo
    prices: Annotated[tuple[Positive, Positive] | None, Loose] = None
    learning_rate: Annotated[float, Gt(0)] = 1e-3  # of bc and dagger ``imitation.learning_rate``
    final_learning_rate: Annotated[float, Ge(0)] = 0.0  # reached linearly
    options: JsonObject = Field(default_factory=dict)
    network: dict[str, object] = Field(default_factory=dict)
    validation: Validation = Validation()

    @field_validator("env", mode="before")
    @classmethod
    def _one_or_several(cls, env: object) -> object:
        given = [env] if isinstance(env, str) else env
        return [full_id(each) for each in given] if isinstance(given, list | tuple) else given

    @field_validator("curriculum")
    @classmethod
    def _stages_ascend(cls, stages: tuple[Stage, ...]) -> tuple[Stage, ...]:
        starts = [stage.from_step for stage in stages]
        if starts != sorted(set(starts)):
            raise ValueError(f"given stages from {starts}, each must begin after the one before")
        return stages

    @field_validator("imitation")
    @classmethod
    def _is_for_students(cls, value: object, info: ValidationInfo) -> object:
        algorithm = info.data.get("algorithm")
        if value and algorithm not in ("ppo", *STUDENTS):
            raise ValueError(
                f"given with algorithm {algorithm!r}, allowed are 'ppo', 'bc' and 'dagger'"
            )
        if isinstance(value, Imitation) and value.rounds > 1 and algorithm in STUDENTS:
            raise ValueError(
                f"rounds: given {value.rounds} with algorithm {algorithm!r}, allowed is 1; its "
                "rounds are steps / imitation.decisions"
            )
        if isinstance(value, Imitation) and value.specialists is not None:
            if algorithm in STUDENTS:
                raise ValueError(
                    f"specialists: given with algorithm {algorithm!r}, allowed is 'ppo'"
                )
            if "teacher" in value.model_fields_set:
                raise ValueError("teacher: given with specialists, allowed is one of the two")
        return value or (Imitation() if algorithm in STUDENTS else None)

    @field_validator("imitation")
    @classmethod
    def _has_a_teacher_for_each(cls, value: Imitation | None, info: ValidationInfo) -> object:
        if value is None or isinstance(value.teacher, str):
            return value
        teachers = {full_id(env): spec for env, spec in value.teacher.items()}
        if set(teachers) != set(info.data.get("env", ())):
            raise ValueError(
                f"teacher: given for {', '.join(teachers)}, allowed is one for each env of the run"
            )
        return value.model_copy(update={"teacher": teachers})

    @field_validator("prices")
    @classmethod
    def _is_a_range(
        cls, prices: tuple[float, float] | None, info: ValidationInfo
    ) -> tuple[float, float] | None:
        if prices and prices[0] >= prices[1]:
            raise ValueError(f"given {list(prices)}, allowed is [low, high] with low < high")
        if prices and info.data.get("lagrangian"):
            raise ValueError("given with lagrangian, which learns a price of its own")
        return prices

    @field_validator("asymmetric_critic", "lagrangian", "prices")
    @classmethod
    def _is_for_ppo(cls, value: object, info: ValidationInfo) -> object:
        algorithm = info.data.get("algorithm")
        if value and algorithm != "ppo":
            raise ValueError(f"given with algorithm {algorithm!r}, allowed is 'ppo'")
        return value

    @field_validator("staggered_starts")
    @classmethod
    def _is_for_batched(cls, value: bool, info: ValidationInfo) -> bool:
        engine = info.data.get("engine")
        if value and engine != "batched":
            raise ValueError(f"given with engine {engine!r}, allowed is 'batched'")
        return value

    @field_validator("imitation", "lagrangian")
    @classmethod
    def _acts_at_every_decision(cls, value: object, info: ValidationInfo) -> object:
        repeat, is_ppo = info.data.get("action_repeat", 1), info.data.get("algorithm") == "ppo"
        if value and repeat > 1 and not (is_ppo and isinstance(value, Imitation)):
            raise ValueError(f"given with action_repeat {repeat}, allowed is 1")
        return value

    @field_validator("residual")
    @classmethod
    def _starts_at_its_base(cls, value: object, info: ValidationInfo) -> object:
        algorithm = info.data.get("algorithm")
        if value and algorithm not in ("ppo", "recurrent_ppo"):
            raise ValueError(
                f"given with algorithm {algorithm!r}, allowed are 'ppo' and 'recurrent_ppo'"
            )
        if value and info.data.get("imitation"):
            raise ValueError("given with imitation, allowed is one of the two starts")
        return value

    @field_validator("hidden")
    @classmethod
    def _are_fields(cls, patterns: tuple[str, ...]) -> tuple[str, ...]:
        for pattern in patterns:
            if not any(hidden_entries([pattern], layout) for layout in _largest()):
                raise ValueError(
                    f"given {pattern!r}, allowed are names of the observation's fields, * in them "
                    "for anything"
                )
        return patterns

    def teachers(self) -> tuple[str, ...]:
        """Return the teacher of each environment; none without imitation, or to be trained."""
        if self.imitation is None or self.imitation.specialists is not None:
            return ()
        teacher = self.imitation.teacher
        return tuple(teacher if isinstance(teacher, str) else teacher[env] for env in self.env)

    def environments(self) -> tuple[Config, ...]:
        """Return the config of each environment, with its registered horizon.

        Raises:
            InvalidInput: An environment is unknown, or a value is not allowed for it.
        """
        return tuple(_environment(env, self.overrides) for env in self.env)

    def identity(self) -> str:
        """Return a hash that two runs share if and only if their values are equal."""
        # as before there were curricula, prices and specialists
        unused: JsonObject = {
            name: True for name in ("curriculum", "prices") if not getattr(self, name)
        }
        if self.imitation and self.imitation.specialists is None:
            unused["imitation"] = {"specialists"}
        text = json.dumps(self.model_dump(mode="json", exclude=unused), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _environment(env: str, overrides: dict[str, object]) -> Config:
    config, _ = rollout.resolve(ScenarioSet(name=env, env=env, overrides=overrides))
    return config


def load_training(path: Path | str | None = None, **changes: object) -> TrainConfig:
    """Return the default run with a file's deltas and then the given changes applied.

    Raises:
        InvalidInput: The file cannot be read or a value is not allowed; one line.
    """
    values = read_yaml(Path(path), "config") if path else {}
    values |= {name: value for name, value in changes.items() if value is not None}
    try:
        return TrainConfig.model_validate(values)
    except ValidationError as error:
        raise InvalidInput(first_error(error, TrainConfig)) from error


def _largest() -> Iterator[Layout]:
    """Yield layouts with all the fields that observations with a named ring can have."""
    for ring in RINGS.values():
        yield layout_with(ring, MOST_PEOPLE, True)


def hidden_entries(patterns: Sequence[str], layout: Layout) -> list[int]:
    """Return the indices of a tier's observation entries that match any pattern."""
    return [
        i
        for i, name in enumerate(layout.names)
        if any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)
    ]


def split(total: int, parts: int) -> list[int]:
    """Split a whole number as evenly as possible, larger parts first."""
    return [total // parts + (i < total % parts) for i in range(parts)]
