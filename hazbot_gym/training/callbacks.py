"""Callbacks of a training run: intervals, and at the end of each validation, export, checkpoint.

A run is divided into intervals of ``validation.every_steps`` decisions. At the beginning of an
interval, worlds, NumPy, torch and Python are seeded from the run's seed and the interval's number.
Therefore a run that resumes from its last checkpoint has bit-identical results, on one torch thread
of the same machine. The cost: episodes are truncated at the end of an interval. Their last value is
bootstrapped, as at the end of every rollout, but terminal states are slightly underrepresented.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import cast

import numpy as np
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, EventCallback

from hazbot_gym.evaluation import rollout
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.residual import on_its_base
from hazbot_gym.task.observation import layout_in
from hazbot_gym.training import checkpoints
from hazbot_gym.training.config import TrainConfig
from hazbot_gym.training.curriculum import Curriculum, check_overrides
from hazbot_gym.training.export import export_model
from hazbot_gym.training.inputs import check_unedited
from hazbot_gym.training.priced_rewards import AtPrice, price_input_of
from hazbot_gym.training.run_folder import CHECKPOINTS, MANIFEST, POLICY
from hazbot_gym.training.validation import Validated, best_of, validate, validate_at_prices
from hazbot_gym.utils.files import read_json


@dataclass
class Progress:
    """State of a run beside its model; part of each checkpoint."""

    begun: int = 0  # intervals
    seconds: float = 0.0  # training time without validations
    validations: list[Validated] = field(default_factory=list)
    imitation_seconds: float = 0.0  # of the imitation before the training


def restart_episodes(model: BaseAlgorithm, seed: int) -> None:
    """Seed all random numbers of a training, and start new episodes everywhere."""
    env = model.get_env()
    assert env is not None
    model.set_random_seed(seed)
    model._last_obs = cast(Observations, env.reset())
    model._last_episode_starts = np.ones(env.num_envs, np.bool_)  # also clears the LSTM state


def export_best(model: BaseAlgorithm, config: TrainConfig, out: Path, best: Validated) -> None:
    """Export the best model of a run so far, with its validation."""
    environment = config.environments()[0]
    export_model(
        model,
        out / POLICY,
        tier=environment.tier,
        layout=layout_in(environment),
        prices=price_input_of(config),
        residual=config.residual.model_dump() if config.residual else None,
        training=read_json(out / MANIFEST),
        results=best,
        overwrite=True,
    )


class Intervals(EventCallback):
    """Divides a run into intervals, seeds each, and triggers a callback at the end of each."""

    def __init__(
        self,
        callback: BaseCallback,
        config: TrainConfig,
        progress: Progress,
        curriculum: Curriculum | None = None,
    ) -> None:
        super().__init__(callback)
        self.config, self.progress, self.curriculum = config, progress, curriculum

    def _on_rollout_start(self) -> None:
        due = self.progress.begun * self.config.validation.every_steps
        if self.model.num_timesteps >= due:
            if self.n_calls:  # an interval has run in this process
                self._end()
            self._begin()

    def _on_training_end(self) -> None:
        self._end()

    def _begin(self) -> None:
        number = self.progress.begun
        if self.curriculum:
            overrides = self.curriculum(self.model.num_timesteps, self.progress.validations)
            check_overrides(self.config, overrides)
            self.training_env.unwrapped.set_options({"config": overrides})
        restart_episodes(self.model, rollout.episode_seed(self.config.seed, "training", number))
        self.progress.begun += 1
        self._began = time.perf_counter()

    def _end(self) -> None:
        self.progress.seconds += time.perf_counter() - self._began
        self._on_event()


class Validate(BaseCallback):
    """Validates the model and logs the result."""

    def __init__(
        self,
        config: TrainConfig,
        progress: Progress,
        console: Console,
        read: Mapping[str, str],
    ) -> None:
        super().__init__()
        self.config, self.progress, self.console = config, progress, console
        self.read = read  # digests of the environments' input files

    def _on_step(self) -> bool:
        step, residual = self.model.num_timesteps, self.config.residual
        base, prices = residual.model_dump() if residual else None, price_input_of(self.config)
        if prices is None:
            found = validate(on_its_base(self.model, base), self.config)
        else:
            driver = {
                price: on_its_base(AtPrice(self.model, float(prices.entry(price))), base)
                for price in prices
            }
            found = validate_at_prices(driver, prices.usual, self.config)
        found = {"step": step, **found}
        check_unedited(self.read)  # validations build new environments
        for name, value in found.items():
            if value is not None:
                self.logger.record(f"validation/{name}", value)
        self.logger.dump(step)  # now, since the process may be killed
        self.progress.validations.append(found)
        self.console.print(f"step {step:,}: validation return {found['return']:.1f}")
        return True


class ExportBest(BaseCallback):
    """Exports the model if its validation, the last one, is the best so far."""

    def __init__(self, config: TrainConfig, progress: Progress, out: Path) -> None:
        super().__init__()
        self.config, self.progress, self.out = config, progress, out

    def _on_step(self) -> bool:
        last = self.progress.validations[-1]
        if best_of(self.progress.validations, self.config) is last:
            export_best(self.model, self.config, self.out, last)
        return True


class Checkpoint(BaseCallback):
    """Saves the model and the progress of its run."""

    def __init__(self, config: TrainConfig, progress: Progress, out: Path) -> None:
        super().__init__()
        self.run, self.progress, self.folder = config.identity(), progress, out / CHECKPOINTS

    def _on_step(self) -> bool:
        checkpoints.save(self.folder, self.model, {"run": self.run, **asdict(self.progress)})
        return True
