"""A run that is killed again and again ends as one that was left alone, to the last bit."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from rich.console import Console

from hazbot_gym.training.checkpoints import load_newest
from hazbot_gym.training.config import TrainConfig
from hazbot_gym.training.run import train

KILLS = 10
RUN = TrainConfig(
    worlds=4,
    steps=768,
    overrides={"max_episode_steps": 20},
    options={"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    network={"net_arch": [4]},
    validation={"every_steps": 64, "episodes": 1},
)


def last_state(out: Path) -> dict[str, Any]:
    state = load_newest(out / "checkpoints", Console(quiet=True))
    assert state is not None
    return state["model"]


def same(one: Any, other: Any) -> bool:
    """Tell whether two nests of tensors and values are equal to the last bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(torch.equal(one, other)) if isinstance(one, torch.Tensor) else one == other


def run_until(moment_s: float | None, out: Path) -> bool:
    """Go on with the run in a process of its own; tell whether it was killed."""
    # Forked, so that each attempt starts at once, with everything imported and compiled.
    context: Any = multiprocessing.get_context("fork")
    process = context.Process(target=train, args=(RUN, out), kwargs={"resume": True})
    process.start()
    process.join(moment_s)
    if process.is_alive():
        os.kill(process.pid, signal.SIGKILL)
    process.join()
    assert process.exitcode in (0, -signal.SIGKILL)
    return bool(process.exitcode)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_run_killed_at_random_moments_ends_with_the_weights_of_one_that_was_not(
    tmp_path: Path,
) -> None:
    train(RUN, tmp_path / "warm up")
    began = time.perf_counter()
    train(RUN, tmp_path / "unbroken")
    takes_s = time.perf_counter() - began
    rng, kills, runs = np.random.default_rng(0), 0, 0
    while kills < KILLS:
        out, runs = tmp_path / f"killed{runs}", runs + 1
        is_going = True
        while is_going:
            moment_s = rng.uniform(0.0, 0.4 * takes_s) if kills < KILLS else None
            is_going = run_until(moment_s, out)
            kills += is_going
        assert same(last_state(out), last_state(tmp_path / "unbroken"))
        assert not list(out.glob("**/.*.tmp"))
