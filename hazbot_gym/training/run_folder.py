"""Output folder of a training run, owned by a single run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.inputs import changed
from hazbot_gym.policies import actor_file
from hazbot_gym.utils.files import owner, read_json, remove_partial

MANIFEST, POLICY, RESULT = "manifest.json", "policy.npz", "result.json"
CHECKPOINTS, TENSORBOARD = "checkpoints", "tensorboard"


class PolicyLost(InvalidInput):
    """The policy of a run is missing or damaged, and no checkpoint holds its model."""


def claim(
    folder: Path, identity: str, *, resume: bool, inputs: Mapping[str, str] | None = None
) -> None:
    """Check that a folder is new or empty, or with ``resume`` this run's own.

    Args:
        folder: Folder of the run.
        identity: Identity of the run.
        resume: Whether an unfinished run is accepted.
        inputs: Digests of its input files, which must be those of its start.

    Raises:
        InvalidInput: The folder holds another run or foreign files, or is no folder.
    """
    if resume and folder.is_dir():
        remove_partial(folder)
    found = owner(folder, MANIFEST, "run")
    if found is None:
        return
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
    edited = changed(read_json(folder / MANIFEST).get("inputs", {}), inputs or {})
    if edited is not None:
        raise InvalidInput(
            f"out: {str(folder)!r} holds a run that was begun with another {edited!r}; bring that "
            "file back, or give another --out"
        )


def has_policy(folder: Path, identity: str) -> bool:
    """Return True if the policy of this run exists undamaged."""
    try:
        about = actor_file.read(folder / POLICY).about
    except InvalidInput:
        return False
    training = about.get("training")
    return isinstance(training, Mapping) and training.get("run") == identity


def has_result(folder: Path, identity: str) -> bool:
    """Return True if this run is finished and its result exists undamaged."""
    try:
        result = read_json(folder / RESULT)
    except InvalidInput:
        return False
    return result.get("run") == identity and has_policy(folder, identity)
