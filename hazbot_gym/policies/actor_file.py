"""The file of a trained actor: one ``.npz`` without pickle, and a model card beside it.

The file holds the arrays of ``actor.Actor`` and a JSON text with all that is known of them: format
version, algorithm, tier, the observation table, how it was trained and what it reached. Reading it
runs nothing that is in it, and refuses it unless the observation table is the library's own: a
field that moved would be misread in silence.
"""

from __future__ import annotations

import json
import zipfile
import zlib
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.actor import ACTIVATIONS, HEADS, Actor, Normalisation
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.task.observation import LAYOUTS, Layout

FORMAT = 1
_COMPARED = ("name", "unit", "low", "high", "scale")


class Trained(NamedTuple):
    """An actor and what is known of it."""

    actor: Actor
    about: dict[str, Any]


def describe(
    actor: Actor,
    *,
    algorithm: str,
    tier: str,
    residual: Mapping[str, Any] | None = None,
    training: Mapping[str, Any] | None = None,
    results: Mapping[str, Any] | None = None,
) -> Trained:
    """Return an actor with its description, ready to be written.

    Args:
        actor: The weights.
        algorithm: What trained it, as the field calls it, such as ``PPO``.
        tier: Information tier of its observations.
        residual: The base that it corrects and its scale, if it does (``residual``).
        training: How it was trained: config, seed, versions, commit.
        results: What it reached, by name of the metric.

    Raises:
        InvalidInput: The tier is none, or its observations have another width than the actor's.
    """
    if tier not in LAYOUTS:
        raise InvalidInput(f"tier: given {tier!r}, allowed are {', '.join(LAYOUTS)}")
    if actor.width != LAYOUTS[tier].width:
        raise InvalidInput(
            f"tier: {tier} observations have {LAYOUTS[tier].width} entries, the actor takes "
            f"{actor.width}"
        )
    about = {
        "format": FORMAT,
        "algorithm": algorithm,
        "tier": tier,
        "observation": observation_table(LAYOUTS[tier]),
        "activation": actor.activation,
        "action": actor.head,
        "residual": dict(residual) if residual else None,
        "training": dict(training or {}),
        "results": dict(results or {}),
    }
    return Trained(actor, about)


def observation_table(layout: Layout) -> list[dict[str, Any]]:
    """Return the fields that an actor depends on: names, units and ranges."""
    return [{name: getattr(field, name) for name in _COMPARED} for field in layout.fields]


def write(trained: Trained, file: BinaryIO) -> None:
    """Write an actor into an open file."""
    actor, about = trained
    arrays: dict[str, npt.NDArray[Any]] = {}
    for i, layer in enumerate(actor.layers):
        arrays[f"weight{i}"], arrays[f"bias{i}"] = layer
    if actor.lstm is not None:
        arrays["gate_weight"], arrays["gate_bias"] = actor.lstm.gates
    if actor.normalisation is not None:
        arrays["mean"], arrays["variance"], clip, epsilon = actor.normalisation
        arrays["clip_epsilon"] = np.array([clip, epsilon])
    text = json.dumps(about, allow_nan=False).encode()
    np.savez_compressed(file, about=np.frombuffer(text, np.uint8), **arrays)  # type: ignore[arg-type]


def read(path: Path) -> Trained:
    """Return the actor in a file.

    Raises:
        InvalidInput: The file is not there, is damaged or is none of ours, or its actor was trained
            on other observations than the library's; one line.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        about = json.loads(arrays.pop("about").tobytes())
        check(about, path)
        return Trained(_actor(arrays, about), about)
    except FileNotFoundError:
        raise InvalidInput(f"policy: there is no file {str(path)!r}") from None
    except InvalidInput:
        raise
    except (
        OSError, EOFError, ValueError, KeyError, TypeError, AttributeError,
        zipfile.BadZipFile, zlib.error,
    ) as error:  # fmt: skip
        raise InvalidInput(
            f"policy: {str(path)!r} is damaged, or no trained policy of hazbot_gym"
        ) from error


def check(about: Mapping[str, Any], path: Path) -> None:
    """Refuse an actor of another format, or of another observation table than the library's."""
    if about["format"] != FORMAT:
        raise InvalidInput(
            f"policy: {str(path)!r} has format {about['format']}, allowed is {FORMAT}"
        )
    if about["tier"] not in LAYOUTS:
        raise InvalidInput(
            f"policy: {str(path)!r} has tier {about['tier']!r}, allowed are {', '.join(LAYOUTS)}"
        )
    stored, own = about["observation"], observation_table(LAYOUTS[about["tier"]])
    for i, (theirs, ours) in enumerate(zip(stored, own, strict=False)):
        if theirs != ours:
            raise InvalidInput(
                f"policy: {str(path)!r} was trained on another observation: entry {i} was "
                f"{_field(theirs)}, now it is {_field(ours)}"
            )
    if len(stored) != len(own):
        raise InvalidInput(
            f"policy: {str(path)!r} was trained on another observation: it had {len(stored)} "
            f"entries, now it has {len(own)}"
        )


def _field(field: Mapping[str, Any]) -> str:
    return "{name} in {low:g}..{high:g} {unit} / {scale:g}".format(**field)


def _actor(arrays: Mapping[str, npt.NDArray[Any]], about: Mapping[str, Any]) -> Actor:
    """Put the arrays together; a ValueError or KeyError says that they do not fit."""
    count = sum(name.startswith("weight") for name in arrays)
    layers = tuple(_layer(arrays, f"weight{i}", f"bias{i}") for i in range(count))
    width = LAYOUTS[about["tier"]].width
    lstm = _lstm(arrays, width)
    sizes = [lstm.size if lstm else width, *(layer.bias.size for layer in layers)]
    shapes = [layer.weight.shape for layer in layers]
    fits = count > 0 and shapes == list(pairwise(sizes))
    has_head = about["action"] in HEADS and (sizes[-1] == 1) == (about["action"] != "levels")
    is_finite = all(np.isfinite(array).all() for array in arrays.values())
    has_form = has_head and about["activation"] in ACTIVATIONS and _is_residual(about)
    if not (fits and is_finite and has_form):
        raise ValueError("the arrays do not make an actor")
    statistics = _normalisation(arrays, width)
    return Actor(layers, about["activation"], about["action"], statistics, lstm)


def _layer(arrays: Mapping[str, npt.NDArray[Any]], weight: str, bias: str) -> Layer:
    return Layer(arrays[weight].astype(np.float32), arrays[bias].astype(np.float32))


def _lstm(arrays: Mapping[str, npt.NDArray[Any]], width: int) -> Lstm | None:
    if "gate_weight" not in arrays:
        return None
    lstm = Lstm(_layer(arrays, "gate_weight", "gate_bias"))
    if lstm.gates.weight.shape != (width + lstm.size, 4 * lstm.size):
        raise ValueError("the LSTM does not fit the observations")
    return lstm


def _is_residual(about: Mapping[str, Any]) -> bool:
    """Tell whether an actor stands alone or says whole what it corrects; old files say nothing."""
    residual = about.get("residual")
    return residual is None or (isinstance(residual["base"], str) and 0 < residual["scale"] <= 2)


def _normalisation(arrays: Mapping[str, npt.NDArray[Any]], width: int) -> Normalisation | None:
    if "mean" not in arrays:
        return None
    clip, epsilon = arrays["clip_epsilon"].tolist()
    mean, variance = arrays["mean"].astype(np.float32), arrays["variance"].astype(np.float32)
    if mean.shape != (width,) or variance.shape != (width,):
        raise ValueError("the normalisation does not fit the observations")
    return Normalisation(mean, variance, clip, epsilon)


_IN_STUDY = """
## Results in the study

On its test scenarios, means over all training seeds with intervals; this file is one of these
seeds, the best on validation.

| metric | value |
|---|---|
{rows}
"""


def card(trained: Trained, name: str) -> str:
    """Return the model card of a trained actor, as Markdown."""
    actor, about = trained
    memory = (f"LSTM of {actor.lstm.size}",) if actor.lstm else ()
    units = (actor.width, *memory, *(layer.bias.size for layer in actor.layers))
    sizes = " -> ".join(str(each) for each in units)
    training = {name: each for name, each in about["training"].items() if name != "environments"}
    residual = about.get("residual")
    line = "- **Corrects** `{base}`, by {scale:g} at most.\n"
    corrects = line.format(**residual) if residual else ""
    results = "\n".join(f"| {key} | {value} |" for key, value in about["results"].items())
    study = "\n".join(f"| {key} | {value} |" for key, value in about.get("study", {}).items())
    in_study = _IN_STUDY.format(rows=study) if study else ""
    return f"""# {name}

A speed policy for the environments of hazbot_gym, trained with {about["algorithm"]}.

- **Sees** the {about["tier"]} tier: {actor.width} entries, as listed in the file.
- **Answers** with a share of the nominal speed; the head is `{about["action"]}`, deterministic.
{corrects}- **Network**: {sizes}, {about["activation"]}.
- **Use**: `hazbot eval --policy learned:path={name}.npz`, or
  `hazbot_gym.policies.make("learned:path={name}.npz")`. The file holds arrays and JSON, no pickle.
- **Limits**: trained and judged in simulation only. Clearances stand in for comfort, which nobody
  was asked about; do not let it drive a robot among people.

## Results on validation scenarios

| metric | value |
|---|---|
{results or "| none | recorded |"}
{in_study}
## How it was trained

The environments' full configs are in the file.

```json
{json.dumps(training, indent=2)}
```
"""
