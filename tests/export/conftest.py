"""Random actors of every kind, as files."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.actor import Actor, Normalisation
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.task.observation import PERSON_SLOTS, layout_for


@pytest.fixture
def spec_of(tmp_path: Path) -> Callable[..., str]:
    """Return a function that writes a random actor and returns its spec."""

    def written(
        *, tier: str = "sonar", activation: str = "tanh", head: str = "clipped",
        lstm: int = 0, normalised: bool = False, residual: Any = None,
        slots: int = PERSON_SLOTS,
    ) -> str:  # fmt: skip
        rng = np.random.default_rng(7)
        layout = layout_for(tier, person_slots=slots)
        width = layout.width

        def layer(inputs: int, outputs: int) -> Layer:
            weight = rng.normal(size=(inputs, outputs)) / np.sqrt(inputs)
            return Layer(weight.astype(np.float32), rng.normal(size=outputs).astype(np.float32))

        sizes = (lstm or width, 10, 7, 5 if head == "levels" else 1)
        actor = Actor(
            tuple(layer(*pair) for pair in itertools.pairwise(sizes)),
            activation,
            head,
            Normalisation(
                rng.normal(size=width).astype(np.float32),
                rng.uniform(0.1, 2.0, width).astype(np.float32),
                clip=1.5,
                epsilon=1e-8,
            )
            if normalised
            else None,
            Lstm(layer(width + lstm, 4 * lstm)) if lstm else None,
        )
        file = tmp_path / "actor.npz"
        with file.open("wb") as opened:
            about = {"algorithm": "PPO", "tier": tier, "residual": residual}
            write(describe(actor, layout=layout, **about), opened)
        return f"learned:path={file}"

    return written
