"""Input files of a training run, and checks for edits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.inputs import Blank, edited, of_policy, of_set
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.task.observation import layout_in
from hazbot_gym.training.config import TrainConfig


def of_training(config: TrainConfig, allowed: Permissions = NO_CODE) -> list[Path]:
    """Return the input files of a training run: of its environments, and of its teacher."""
    sets = [ScenarioSet(name=env, env=env, overrides=config.overrides) for env in config.env]
    configs = config.environments()
    blanks = {Blank(layout_in(each), (1,)) for each in configs}
    found = [path for each in sets for path in of_set(each)]
    for teacher in config.teachers():
        found += of_policy(teacher, blanks, allowed)
    return list(dict.fromkeys(found))


def check_unedited(before: Mapping[str, str]) -> None:
    """Check that input files still have the ``digests`` of the start of training.

    Raises:
        InvalidInput: A file was edited or removed.
    """
    name = edited(before)
    if name is not None:
        raise InvalidInput(
            f"{name!r} was edited while the training ran; bring that file back and go on with "
            "--resume"
        )
