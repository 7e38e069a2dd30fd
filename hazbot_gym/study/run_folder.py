"""The folder of a training run, which belongs to one run and to nothing else."""

from __future__ import annotations

import json
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.study.files import sweep

MANIFEST, POLICY, RESULT = "manifest.json", "policy.npz", "result.json"
CHECKPOINTS, TENSORBOARD = "checkpoints", "tensorboard"


def claim(folder: Path, identity: str, *, resume: bool) -> None:
    """Check that a folder is new or empty, or with ``resume`` this run's own.

    Raises:
        InvalidInput: The folder holds another run or foreign files, or is no folder.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InvalidInput(
            f"out: given {str(folder)!r}, which is a file; give a new or empty folder"
        )
    if resume:
        sweep(folder)
    if not any(folder.iterdir()):
        return
    found = _identity(folder / MANIFEST)
    if found is None:
        raise InvalidInput(
            f"out: {str(folder)!r} holds files that are no run's; give a new or empty folder"
        )
    if not resume:
        raise InvalidInput(
            f"out: {str(folder)!r} holds a run already; go on with it by --resume, or give another "
            "--out"
        )
    if found != identity:
        raise InvalidInput(
            f"out: {str(folder)!r} holds another run ({found}, this one is {identity}); give the "
            "config, seed, steps and engine that it was begun with"
        )


def _identity(manifest: Path) -> str | None:
    try:
        identity = json.loads(manifest.read_text(encoding="utf-8"))["run"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return identity if isinstance(identity, str) else None
