"""Training run: an algorithm of Stable-Baselines3 on the batched engine, crash-safe.

    OUT/manifest.json     provenance: config, seed, versions, commit, start time
    OUT/policy.npz, .md   best model on validation so far, and its card
    OUT/checkpoints/      state for ``--resume``
    OUT/tensorboard/      curves
    OUT/specialists/      the runs of its teachers, if it trains them itself (``specialists.py``)
    OUT/result.json       validations and speed, after the run

A killed run resumes from its last checkpoint with bit-identical results (``callbacks.py``).
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console

from hazbot_gym.errors import InvalidInput, MissingExtra

try:
    import sb3_contrib as _contrib  # noqa: F401  (a part of the extra)
    import torch
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.callbacks import CallbackList
    from stable_baselines3.common.logger import configure
    from torch.utils.tensorboard import SummaryWriter as _  # noqa: F401  (a part of the extra)
except ImportError as error:
    raise MissingExtra((error.name or "tensorboard").replace("_", "-"), "train") from error

from hazbot_gym.evaluation.inputs import digests
from hazbot_gym.policies.base import NO_CODE, Permissions, Policy
from hazbot_gym.training import checkpoints
from hazbot_gym.training.algorithms import make_model
from hazbot_gym.training.callbacks import (
    Checkpoint,
    ExportBest,
    Intervals,
    Progress,
    Validate,
    export_best,
)
from hazbot_gym.training.config import STUDENTS, TrainConfig
from hazbot_gym.training.curriculum import Curriculum, curriculum_of
from hazbot_gym.training.imitation import imitate, teacher_of
from hazbot_gym.training.inputs import of_training
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
from hazbot_gym.training.specialists import (
    folder_of,
    specialists_of,
    taught_by_specialists,
)
from hazbot_gym.training.validation import Validated, best_of
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
    curriculum: Curriculum | None = None,
) -> Result:
    """Run or resume a training, and export its best policy.

    Uses one torch thread: the networks are small, and the order of sums is fixed.

    Args:
        config: The training run.
        out: Output folder: new, empty, or with ``resume`` this run's own.
        resume: Whether to resume from the last checkpoint, if any.
        console: Output of progress; None for silence.
        allowed: Permissions of the config's teacher.
        curriculum: From the decisions taken and the validations so far to overrides of the
            environments' config, asked at the beginning of each interval. A run resumes
            bit-identically with the same function.

    Raises:
        InvalidInput: The config or the folder is not usable; nothing was written.
    """
    if not isinstance(config, TrainConfig):
        raise InvalidInput(f"config: given {config!r}, allowed is what load_training returns")
    out, console = Path(out), console or Console(quiet=True)
    torch.set_num_threads(1)
    curriculum = curriculum_of(config, curriculum)
    read = digests(of_training(config, allowed))
    claim(out, config.identity(), resume=resume, inputs=read)
    model, teacher = make_all(config, allowed)
    with sole_use(out), disk_errors_told_once(out):
        if not (out / MANIFEST).exists():
            write_json(out / MANIFEST, {**manifest(config), "inputs": read})
        if specialists_of(config):
            teacher = _train_specialists(config, out, model.get_env(), console)
        return _run(config, out, console, read, model, teacher, curriculum, resume=resume)


def _train_specialists(config: TrainConfig, out: Path, envs: Any, console: Console) -> Policy:
    """Train the specialists of a run that are not finished yet; return them as its teacher."""
    for env, training in specialists_of(config).items():
        console.print(f"specialist for {env}", markup=False)
        train(training, folder_of(env, out), resume=True, console=console)
    return teacher_of(taught_by_specialists(config, out), envs)


def make_all(config: TrainConfig, allowed: Permissions = NO_CODE) -> tuple[Any, Any]:
    """Return the model of a run in its environments, and its teacher, if any.

    Raises:
        InvalidInput: The config is not usable.
    """
    envs: Any = make_envs(config)
    if config.residual:
        envs = ResidualEnvs(envs, config.residual)
    model = make_model(config, envs, allowed)
    for training in specialists_of(config).values():
        make_all(training)
    if config.teachers() and config.algorithm not in STUDENTS:
        return model, teacher_of(config, envs, allowed)
    return model, None


def _run(
    config: TrainConfig,
    out: Path,
    console: Console,
    read: Mapping[str, str],
    model: Any,
    teacher: Any,
    curriculum: Curriculum | None,
    *,
    resume: bool,
) -> Result:
    """Run the remaining part of a training with a claimed folder."""
    progress = resumed(model, config, out, console) if resume else Progress()
    if teacher and model.num_timesteps == 0:
        began = time.perf_counter()
        imitate(model, model.get_env(), teacher, config)
        progress.imitation_seconds = time.perf_counter() - began
    model.set_logger(configure(str(out / TENSORBOARD), ["tensorboard"]))
    left, bar = config.steps - model.num_timesteps, ProgressBar(console, config.steps)
    at_the_end = CallbackList(
        [
            Validate(config, progress, console, read),
            ExportBest(config, progress, out),
            Checkpoint(config, progress, out),
        ]
    )
    try:
        if left > 0:
            model.learn(
                left,
                [EpisodeLog(), Intervals(at_the_end, config, progress, curriculum), bar],
                log_interval=None,
                reset_num_timesteps=model.num_timesteps == 0,
            )
        best = best_of(progress.validations, config)
        write_json(out / RESULT, _result(config, model.num_timesteps, progress, best, out))
    finally:
        bar.stop()
        model.logger.close()
        model.get_env().close()
    return Result(model, best, out / POLICY)


def resumed(model: BaseAlgorithm, config: TrainConfig, out: Path, console: Console) -> Progress:
    """Restore a new model from its run's last checkpoint, if any; return the progress.

    Raises:
        PolicyLost: The best policy is missing or damaged, and the checkpoint's model is another.
    """
    state = checkpoints.load_newest(out / CHECKPOINTS, console, config.identity())
    if state is None:
        console.print("there is no checkpoint yet, the run begins at the start")
        return Progress()
    checkpoints.restore(model, state["model"])
    saved = state["progress"]
    progress = Progress(
        saved["begun"],
        saved["seconds"],
        saved["validations"],
        saved.get("imitation_seconds", 0.0),  # which older checkpoints lack
    )
    if not has_policy(out, config.identity()):
        best = best_of(progress.validations, config)
        if best["step"] != model.num_timesteps:
            raise PolicyLost(
                f"out: {POLICY} is missing or damaged in {str(out)!r}, and its model (step "
                f"{best['step']:,}) is kept nowhere else; give another --out to train it anew"
            )
        export_best(model, config, out, best)
        console.print(f"{POLICY} was missing or damaged and is written again")
    console.print(f"the run goes on from step {model.num_timesteps:,}")
    return progress


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


def _result(
    config: TrainConfig, steps: int, progress: Progress, best: Validated, out: Path
) -> dict[str, object]:
    specialists = [read_json(folder_of(env, out) / RESULT) for env in specialists_of(config)]
    return {
        "run": config.identity(),
        "steps": steps,
        "training_seconds": round(progress.seconds, 1),
        "imitation_seconds": round(progress.imitation_seconds, 3),
        "specialists_seconds": round(sum(each["training_seconds"] for each in specialists), 1),
        "steps_per_s": round(steps / max(progress.seconds, 1e-9)),
        "best": best,
        "validations": progress.validations,
    }
