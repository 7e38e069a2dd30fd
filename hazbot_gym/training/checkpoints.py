"""Checkpoints of a training run, with checksum and without pickle.

    OUT/checkpoints/000000250000.pt    SHA-256 of the rest, then torch's file of tensors and numbers

The newest two are kept, so that a damaged checkpoint costs an interval and not the run. A
checkpoint holds the networks, the optimisers, the counters of schedules, the replay buffer if any,
and the attributes listed in our own algorithms' ``remembered``, such as DAgger's data set or the
Lagrange multiplier. It holds neither random state nor environments: after each checkpoint a run
reseeds everything from its own seed and the number of checkpoints so far, interrupted or not.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from pathlib import Path

import torch
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm

from hazbot_gym.utils.files import remove_partial, write_bytes
from hazbot_gym.utils.json_object import JsonObject

KEPT = 2
COUNTERS = (
    "num_timesteps",
    "_n_updates",
    "_n_calls",
    "_episode_num",
    "_current_progress_remaining",
    "exploration_rate",
)
BUFFER = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
State = JsonObject


def save(folder: Path, model: BaseAlgorithm, progress: State) -> None:
    """Write a checkpoint and remove all but the newest ones.

    Args:
        folder: Folder of checkpoints.
        model: The model in training.
        progress: Further state of the run: plain values.
    """
    content = io.BytesIO()
    torch.save({"model": state_of(model), "progress": progress}, content)
    data = content.getvalue()
    digest = hashlib.sha256(data).hexdigest().encode()
    write_bytes(folder / f"{model.num_timesteps:012d}.pt", digest + b"\n" + data)
    for old in _all(folder)[KEPT:]:
        old.unlink(missing_ok=True)


def load_newest(folder: Path, console: Console, run: str | None = None) -> State | None:
    """Return the newest undamaged checkpoint, or None; report skipped ones.

    Args:
        folder: Folder of checkpoints.
        console: Output for skipped checkpoints.
        run: Identity of the run, compared with the one in ``progress``; None: any.

    Returns:
        ``model`` for ``restore``, and ``progress`` as it was saved.
    """
    remove_partial(folder)
    for path in _all(folder):
        state = _load(path)
        if state is None:
            console.print(f"checkpoint {path.name} is damaged, the one before it is used")
        elif run is not None and state["progress"].get("run") != run:
            console.print(f"checkpoint {path.name} is another run's, the one before it is used")
        else:
            return state
    return None


def _load(path: Path) -> State | None:
    """Return the content of a checkpoint, or None if it is damaged or holds pickled code."""
    digest, _, data = path.read_bytes().partition(b"\n")
    if hashlib.sha256(data).hexdigest().encode() != digest:
        return None
    try:
        state = torch.load(io.BytesIO(data), weights_only=True)
    except (pickle.UnpicklingError, RuntimeError, EOFError):  # a foreign file
        return None
    is_ours = isinstance(state, dict) and isinstance(state.get("progress"), dict)
    return state if is_ours and isinstance(state.get("model"), dict) else None


def state_of(model: BaseAlgorithm) -> State:
    """Return the complete state of a model's updates, as tensors and plain values."""
    _, variables = model._get_torch_save_params()
    names = (*COUNTERS, *getattr(model, "remembered", ()))
    return {
        "parameters": model.get_parameters(),
        "variables": {name: getattr(model, name).detach() for name in variables},
        "counters": {name: getattr(model, name) for name in names if hasattr(model, name)},
        "buffer": _buffer_of(model),
    }


def restore(model: BaseAlgorithm, state: State) -> None:
    """Load a saved state into a new model of the same config."""
    model.set_parameters(state["parameters"], device=model.device)
    for name, value in state["variables"].items():
        getattr(model, name).data.copy_(value)  # in place, since the optimiser holds this tensor
    for name, value in state["counters"].items():
        setattr(model, name, value)
    _fill_buffer(model, state["buffer"])


def _buffer_of(model: BaseAlgorithm) -> State:
    """Return the content of the replay buffer."""
    buffer = getattr(model, "replay_buffer", None)
    if buffer is None:
        return {}
    size = buffer.buffer_size if buffer.full else buffer.pos
    arrays = {name: torch.from_numpy(getattr(buffer, name)[:size]) for name in BUFFER}
    return {"pos": buffer.pos, "full": buffer.full, **arrays}


def _fill_buffer(model: BaseAlgorithm, state: State) -> None:
    buffer = getattr(model, "replay_buffer", None)
    for name in BUFFER if state else ():
        values = state[name].numpy()
        getattr(buffer, name)[: len(values)] = values
    if state and buffer is not None:
        buffer.pos, buffer.full = state["pos"], state["full"]


def _all(folder: Path) -> list[Path]:
    """Return all checkpoints, newest first."""
    return sorted(folder.glob("[0-9]*.pt"), reverse=True)
