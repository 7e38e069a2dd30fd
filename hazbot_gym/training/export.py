"""Export of trained policies: arrays without pickle, and a model card."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.actor_file import Trained, card, describe, layout_of_table, write
from hazbot_gym.policies.from_sb3 import actor_of, check_bounds
from hazbot_gym.policies.price_input import PriceInput
from hazbot_gym.task.observation import Layout
from hazbot_gym.utils.files import write_bytes, write_text


def export_model(
    model: object,
    path: Path,
    *,
    tier: str,
    layout: Layout | None = None,
    prices: PriceInput | None = None,
    normalize: object = None,
    residual: Mapping[str, object] | None = None,
    training: Mapping[str, object] | None = None,
    results: Mapping[str, object] | None = None,
    overwrite: bool = False,
) -> Trained:
    """Export the actor of a Stable-Baselines3 model.

    Args:
        model: A model supported by ``from_sb3.actor_of``.
        path: Path of the ``.npz``; the card gets the suffix ``.md``.
        tier: Information tier of its observations.
        layout: Layout of its observations, as of ``actor_file.describe``.
        prices: The prices that it was trained for, if its last input is the price of nearness.
        normalize: The ``VecNormalize`` of its training, if any.
        residual: Base policy and scale of a residual policy, else None.
        training: Provenance: config, seed, versions, commit.
        results: Validation results by metric.
        overwrite: Whether to replace an existing file.

    Raises:
        InvalidInput: The model is not supported, its observations do not fit the tier, or the file
            exists.
    """
    actor, name = actor_of(model, normalize), type(model).__name__
    trained = describe(
        actor,
        algorithm=name,
        tier=tier,
        layout=layout,
        prices=prices,
        residual=residual,
        training=training,
        results=results,
    )
    if normalize is None:
        check_bounds(model, layout_of_table(trained.about), "export")
    export_actor(trained, path, overwrite=overwrite)
    return trained


def export_actor(trained: Trained, path: Path, *, overwrite: bool = False) -> None:
    """Write an actor from any source, and its card.

    Raises:
        InvalidInput: The file exists, has another suffix, or cannot be written.
    """
    if path.suffix != ".npz":
        raise InvalidInput(f"path: given {str(path)!r}, allowed is a name that ends in .npz")
    if path.exists() and not overwrite:
        raise InvalidInput(f"path: given {str(path)!r}, which is there already")
    content = io.BytesIO()
    write(trained, content)
    write_bytes(path, content.getvalue())
    write_text(path.with_suffix(".md"), card(trained, path.stem))
