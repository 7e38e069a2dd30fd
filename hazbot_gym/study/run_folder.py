"""The folder of a training run, which belongs to one run and to nothing else."""

from __future__ import annotations

from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.study.files import owner, sweep

MANIFEST, POLICY, RESULT = "manifest.json", "policy.npz", "result.json"
CHECKPOINTS, TENSORBOARD = "checkpoints", "tensorboard"


def claim(folder: Path, identity: str, *, resume: bool) -> None:
    """Check that a folder is new or empty, or with ``resume`` this run's own.

    Raises:
        InvalidInput: The folder holds another run or foreign files, or is no folder.
    """
    if resume and folder.is_dir():
        sweep(folder)
    found = owner(folder, MANIFEST, "run")
    if found is not None and not resume:
        raise InvalidInput(
            f"out: {str(folder)!r} holds a run already; go on with it by --resume, or give another "
            "--out"
        )
    if found not in (None, identity):
        raise InvalidInput(
            f"out: {str(folder)!r} holds another run ({found}, this one is {identity}); give the "
            "config, seed, steps and engine that it was begun with"
        )
