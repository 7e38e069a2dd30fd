"""Specialists: teachers that a run trains itself from nothing, one in each of its environments.

    OUT/specialists/Crossing-v1/    the run folder of each (``run.py``)

In Crossing a value-based learner finds from nothing how to drive among people, where PPO learns to
wait (``docs/learning.md``), but it chooses among a few levels of speed. PPO that starts from the
specialists (``imitation.py``) makes one policy of them, with speeds in between.
"""

from __future__ import annotations

from pathlib import Path

from hazbot_gym.config.deltas import merge
from hazbot_gym.errors import InvalidInput
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.run_folder import POLICY

FOLDER = "specialists"
OF_THE_RUN = ("env", "seed", "engine", "threads")  # values that they have in common with their run


def specialists_of(config: TrainConfig) -> dict[str, TrainConfig]:
    """Return the training of the specialist of each environment of a run; none without them.

    Raises:
        InvalidInput: A value is not allowed; one line.
    """
    if config.imitation is None or config.imitation.specialists is None:
        return {}
    values = config.imitation.specialists
    common = [name for name in OF_THE_RUN if name in values]
    if common:
        raise InvalidInput(
            f"imitation.specialists.{common[0]}: given {values[common[0]]!r}, allowed is that of "
            "the run itself"
        )
    shared = {name: getattr(config, name) for name in OF_THE_RUN}
    overrides = merge(config.overrides, values.get("overrides", {}))
    try:
        return {
            env: load_training(None, **{**values, **shared, "env": env, "overrides": overrides})
            for env in config.env
        }
    except InvalidInput as error:
        raise InvalidInput(f"imitation.specialists.{error}") from None


def folder_of(env: str, out: Path) -> Path:
    """Return the run folder of an environment's specialist in the folder of its run."""
    return out / FOLDER / env.rpartition("/")[2]


def taught_by_specialists(config: TrainConfig, out: Path) -> TrainConfig:
    """Return a run whose teachers are the specialists that were trained in its folder."""
    assert config.imitation is not None
    teachers = {env: f"learned:path={folder_of(env, out) / POLICY}" for env in config.env}
    imitation = config.imitation.model_copy(update={"teacher": teachers, "specialists": None})
    return config.model_copy(update={"imitation": imitation})
