"""Training run: an algorithm of Stable-Baselines3 on the batched engine, crash-safe.

    OUT/manifest.json     provenance: config, seed, versions, commit, start time
    OUT/policy.npz, .md   best model on validation so far, and its card
    OUT/checkpoints/      state for ``--resume``
    OUT/tensorboard/      curves
    OUT/result.json       validations and speed, after the run

A run is divided into stretches of ``validation.every_steps`` decisions. Each stretch ends with a
validation and a checkpoint, and begins by seeding worlds, numpy, torch and Python from the run's
seed and the number of the stretch. So a killed run resumes from its last checkpoint with
bit-identical results, on one torch thread of the same machine. The cost: episodes are truncated at
the end of a stretch. Their last value is bootstrapped, as at the end of every rollout, but terminal
states are slightly underrepresented.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from rich.console import Console

from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.utils.json_object import JsonObject

try:
    import sb3_contrib as _contrib  # noqa: F401  (a part of the extra)
    import torch
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.logger import configure
    from torch.utils.tensorboard import SummaryWriter as _  # noqa: F401  (a part of the extra)
except ImportError as error:
    raise MissingExtra((error.name or "tensorboard").replace("_", "-"), "train") from error

from hazbot_gym.evaluation import rollout
from hazbot_gym.evaluation.inputs import digests
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.residual import on_its_base
from hazbot_gym.training import checkpoints
from hazbot_gym.training.algorithms import make_model
from hazbot_gym.training.config import PUPILS, TrainConfig
from hazbot_gym.training.export import export_model
from hazbot_gym.training.imitation import imitate, teacher_of
from hazbot_gym.training.inputs import check_unedited, of_training
from hazbot_gym.training.logging import EpisodeLog, ProgressBar, disk_errors_told_once
from hazbot_gym.training.residual_envs import ResidualEnvs
from hazbot_gym.training.run_folder import (
    CHECKPOINTS,
    MANIFEST,
    POLICY,
    RESULT,
    TENSORBOARD,
    PolicyLost,
    claim,
    has_policy,
)
from hazbot_gym.training.validation import merit, validate
from hazbot_gym.training.vec_envs import make_envs
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import read_json, sole_use, write_json


class Result(NamedTuple):
    """Result of a run."""

    model: BaseAlgorithm
    best: dict[str, float | None]  # headline metrics of the best policy
    policy: Path


def train(
    config: TrainConfig,
    out: Path | str,
    *,
    resume: bool = False,
    console: Console | None = None,
    allowed: Permissions = NO_CODE,
) -> Result:
    """Run or resume a training, and export its best policy.

    Uses one torch thread: the networks are small, and the order of sums is fixed.

    Args:
        config: The training run.
        out: Output folder: new, empty, or with ``resume`` this run's own.
        resume: Whether to resume from the last checkpoint, if any.
        console: Output of progress; None for silence.
        allowed: Permissions of the config's teacher.

    Raises:
        InvalidInput: The config or the folder is not usable; nothing was written.
    """
    if not isinstance(config, TrainConfig):
        raise InvalidInput(f"config: given {config!r}, allowed is what load_training returns")
    out, console = Path(out), console or Console(quiet=True)
    torch.set_num_threads(1)
    read = digests(of_training(config, allowed))
    claim(out, config.identity(), resume=resume, inputs=read)
    model, teacher = make_all(config, allowed)
    with sole_use(out), disk_errors_told_once(out):
        if not (out / MANIFEST).exists():
            write_json(out / MANIFEST, {**manifest(config), "inputs": read})
        stretches = Stretches(config, out, console, read)
        return _run(config, stretches, model, teacher, resume=resume)


def make_all(config: TrainConfig, allowed: Permissions = NO_CODE) -> tuple[object, object]:
    """Return the model of a run in its environments, and its teacher, if any.

    Raises:
        InvalidInput: The config is not usable.
    """
    envs: Any = make_envs(config)
    if config.residual:
        envs = ResidualEnvs(envs, config.residual)
    model = make_model(config, envs, allowed)
    if config.imitation and config.algorithm not in PUPILS:
        return model, teacher_of(config.imitation, envs, allowed)
    return model, None


def _run(
    config: TrainConfig, stretches: Stretches, model: Any, teacher: Any, *, resume: bool
) -> Result:
    """Run the remaining part of a training with a claimed folder."""
    if resume:
        stretches.resume(model)
    if teacher and model.num_timesteps == 0:
        imitate(model, model.get_env(), teacher, config)
    model.set_logger(configure(str(stretches.out / TENSORBOARD), ["tensorboard"]))
    left = config.steps - model.num_timesteps
    bar = ProgressBar(stretches.console, config.steps)
    callbacks: list[BaseCallback] = [EpisodeLog(), stretches, bar]
    try:
        if left > 0:
            is_new = model.num_timesteps == 0
            model.learn(left, callbacks, log_interval=None, reset_num_timesteps=is_new)
        else:
            stretches.conclude(model)  # its file may be missing
    finally:
        bar.stop()
        model.logger.close()
        model.get_env().close()
    return Result(model, stretches.best(), stretches.policy_path)


def manifest(config: TrainConfig) -> dict[str, object]:
    """Return the provenance of a run's policy."""
    return {
        "run": config.identity(),
        "config": config.model_dump(mode="json"),
        "environments": {
            env: each.model_dump(mode="json")
            for env, each in zip(config.env, config.environments(), strict=True)
        },
        "seed": config.seed,
        "versions": provenance.versions(),
        "commit": provenance.commit(),
        "machine": provenance.machine(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


class Stretches(BaseCallback):
    """Callback that divides a run into stretches with seeding, validation and checkpoint."""

    def __init__(
        self, config: TrainConfig, out: Path, console: Console, read: Mapping[str, str]
    ) -> None:
        super().__init__()
        self.config, self.out, self.console = config, out, console
        self.read = read  # digests of the environments' input files
        self.policy_path = out / POLICY
        self.tier = config.environments()[0].tier
        self.residual = config.residual.model_dump() if config.residual else None
        self.begun, self.is_running = 0, False
        self.seconds = 0.0  # training time without validations
        self.validations: list[JsonObject] = []

    def resume(self, model: BaseAlgorithm) -> None:
        """Restore a new model from its run's last checkpoint."""
        run = self.config.identity()
        state = checkpoints.load_newest(self.out / CHECKPOINTS, self.console, run)
        if state is None:
            self.console.print("there is no checkpoint yet, the run begins at the start")
            return
        checkpoints.restore(model, state["model"])
        progress = state["progress"]
        self.begun, self.seconds = progress["begun"], progress["seconds"]
        self.validations = progress["validations"]
        if not has_policy(self.out, self.config.identity()):
            self._write_again(model)
        self.console.print(f"the run goes on from step {model.num_timesteps:,}")

    def _write_again(self, model: BaseAlgorithm) -> None:
        """Rewrite a missing or damaged policy, if the checkpoint's model is the best so far."""
        best = self.best()
        if best["step"] != model.num_timesteps:
            raise PolicyLost(
                f"out: {POLICY} is missing or damaged in {str(self.out)!r}, and its model (step "
                f"{best['step']:,}) is kept nowhere else; give another --out to train it anew"
            )
        self._keep(model, best)
        self.console.print(f"{POLICY} was missing or damaged and is written again")

    def best(self) -> JsonObject:
        """Return the validation of the best model."""
        limit = self.config.lagrangian.limit if self.config.lagrangian else None
        return max(self.validations, key=lambda found: merit(found, limit))

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        if self.model.num_timesteps >= self.begun * self.config.validation.every_steps:
            if self.is_running:
                self._end()
            self._begin()

    def _on_training_end(self) -> None:
        self._end()
        self.conclude(self.model)

    def conclude(self, model: BaseAlgorithm) -> None:
        """Write the result of the run."""
        write_json(self.out / RESULT, self._result(model))

    def _begin(self) -> None:
        """Reseed everything and reset all worlds."""
        model, env = self.model, self.training_env
        model.set_random_seed(rollout.episode_seed(self.config.seed, "training", self.begun))
        model._last_obs = cast(Observations, env.reset())
        model._last_episode_starts = np.ones(env.num_envs, np.bool_)  # also clears the LSTM state
        self.begun, self.is_running = self.begun + 1, True
        self._began = time.perf_counter()

    def _end(self) -> None:
        """Validate the model, export it if it is the best so far, and write a checkpoint."""
        self.seconds += time.perf_counter() - self._began
        driver = on_its_base(self.model, self.residual)
        found = {"step": self.model.num_timesteps, **validate(driver, self.config)}
        check_unedited(self.read)  # validations build new environments
        for name, value in found.items():
            if value is not None:
                self.logger.record(f"validation/{name}", value)
        self.logger.dump(self.model.num_timesteps)  # now, since the process may be killed
        self.validations.append(found)
        if self.best() is found:
            self._keep(self.model, found)
        self.console.print(f"step {found['step']:,}: validation return {found['return']:.1f}")
        progress = {
            "run": self.config.identity(),
            "begun": self.begun,
            "seconds": self.seconds,
            "validations": self.validations,
        }
        checkpoints.save(self.out / CHECKPOINTS, self.model, progress)

    def _keep(self, model: BaseAlgorithm, found: JsonObject) -> None:
        """Export the model as the best so far."""
        export_model(
            model,
            self.policy_path,
            tier=self.tier,
            residual=self.residual,
            training=read_json(self.out / MANIFEST),
            results=found,
            overwrite=True,
        )

    def _result(self, model: BaseAlgorithm) -> dict[str, object]:
        return {
            "run": self.config.identity(),
            "steps": model.num_timesteps,
            "training_seconds": round(self.seconds, 1),
            "steps_per_s": round(model.num_timesteps / max(self.seconds, 1e-9)),
            "best": self.best(),
            "validations": self.validations,
        }
