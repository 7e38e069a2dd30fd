"""File format of a trained actor: one ``.npz`` without pickle, and a model card.

The file holds the arrays of ``actor.Actor`` and JSON metadata: format version, algorithm, tier, the
observation table, provenance and results. Reading executes no code from the file, and rejects a
file whose observation table differs from the library's, since a moved field would be misread
without an error.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.sensor_ring import PAPER, RINGS, RangeSensor, Sensors
from hazbot_gym.core.state import PERSON_SLOTS
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.actor import ACTIVATIONS, HEADS, Actor, Normalisation
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.policies.price_input import PriceInput
from hazbot_gym.task.observation import (
    GAS_FIELDS,
    KNOWN,
    LAYOUTS,
    ROBOT_FIELDS,
    Layout,
    layout_for,
)
from hazbot_gym.utils import npz
from hazbot_gym.utils.json_object import JsonObject

FORMAT = 1
MOST_TEXT = 8 * 2**20  # bytes of JSON
# Exceptions of reading a foreign file. RecursionError: JSON nested too deeply.
_UNUSABLE = (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError)
_COMPARED = ("name", "unit", "low", "high", "scale")


class _NoActor(ValueError):
    """A file that does not contain a valid actor; the message gives the reason."""


class Trained(NamedTuple):
    """An actor and its metadata."""

    actor: Actor
    about: JsonObject


def describe(
    actor: Actor,
    *,
    algorithm: str,
    tier: str,
    layout: Layout | None = None,
    prices: PriceInput | None = None,
    residual: Mapping[str, object] | None = None,
    training: Mapping[str, object] | None = None,
    results: Mapping[str, object] | None = None,
) -> Trained:
    """Return an actor with its metadata, ready to be written.

    Args:
        actor: The weights.
        algorithm: Name of the training algorithm, such as ``PPO``.
        tier: Information tier of its observations.
        layout: Layout of its observations; default the one of its width with a named ring and the
            default number of people.
        prices: The prices that it was trained for, if its last input is the price of nearness.
        residual: Base policy and scale of a residual policy (``residual``), else None.
        training: Provenance: config, seed, versions, commit.
        results: Validation results by metric.

    Raises:
        InvalidInput: The tier is unknown, or its observation width differs from the actor's.
    """
    if tier not in LAYOUTS:
        raise InvalidInput(f"tier: given {tier!r}, allowed are {', '.join(LAYOUTS)}")
    width = actor.width - (prices is not None)
    layout = layout or _layout(tier, width)
    if width != layout.width:
        raise InvalidInput(
            f"tier: {tier} observations have {layout.width} entries, the actor takes {width}"
        )
    if prices and not _can_be_priced(actor):
        raise InvalidInput("prices: given with an LSTM or a normalisation, allowed is neither")
    about = {
        "format": FORMAT,
        "algorithm": algorithm,
        "tier": tier,
        "observation": observation_table(layout),
        "activation": actor.activation,
        "action": actor.head,
        "residual": dict(residual) if residual else None,
        "training": dict(training or {}),
        "results": dict(results or {}),
    }
    if prices:
        about["prices"] = prices._asdict()
    return Trained(actor, about)


def prices_of(about: JsonObject) -> PriceInput | None:
    """Return the prices that an actor was trained for; None if it does not observe the price."""
    return PriceInput(**about["prices"]) if about.get("prices") else None


def _can_be_priced(actor: Actor) -> bool:
    return actor.lstm is None and actor.normalisation is None


def _layout(tier: str, width: int) -> Layout:
    """Return the tier's known layout of that width, or else its default one."""
    default = LAYOUTS[tier]
    layout = KNOWN.get(width, default)
    return layout if layout.has_people == default.has_people else default


def layout_of_table(about: JsonObject) -> Layout:
    """Return the layout that an actor's observation table has, or comes nearest to."""
    names = [field["name"] for field in about["observation"]]
    slots = sum(name.endswith("_present") for name in names) or PERSON_SLOTS
    return layout_for(
        about["tier"], _ring(names), has_gas=GAS_FIELDS[0].name in names, person_slots=slots
    )


def _ring(names: Sequence[str]) -> Sensors:
    """Return the ring of an observation's names; only a named one has its directions."""
    first = ROBOT_FIELDS[0].name
    ranges = names[: names.index(first)] if first in names else ()
    named = [ring for ring in RINGS.values() if len(ring) == len(ranges)]
    own = tuple(RangeSensor(name[len("range_") : -len("_m")], 0.0) for name in ranges)
    return named[0] if named else own or PAPER


def observation_table(layout: Layout) -> list[dict[str, object]]:
    """Return the fields that an actor depends on: names, units and ranges."""
    return [{name: getattr(field, name) for name in _COMPARED} for field in layout.fields]


def write(trained: Trained, file: BinaryIO) -> None:
    """Write an actor into an open file."""
    actor, about = trained
    arrays: dict[str, npt.NDArray[np.generic]] = {}
    for i, layer in enumerate(actor.layers):
        arrays[f"weight{i}"], arrays[f"bias{i}"] = layer
    if actor.lstm is not None:
        arrays["gate_weight"], arrays["gate_bias"] = actor.lstm.gates
    if actor.normalisation is not None:
        arrays["mean"], arrays["variance"], clip, epsilon = actor.normalisation
        arrays["clip_epsilon"] = np.array([clip, epsilon])
    text = json.dumps(about, allow_nan=False).encode()
    size = len(text) + sum(array.nbytes for array in arrays.values())
    if size > npz.MOST_BYTES or len(text) > MOST_TEXT:
        raise InvalidInput(
            f"network: weights and description take {size:,} bytes, allowed are "
            f"{npz.MOST_BYTES:,}, of which {MOST_TEXT:,} for the description"
        )
    content: Any = {"about": np.frombuffer(text, np.uint8), **arrays}
    np.savez_compressed(file, **content)


def read(path: Path) -> Trained:
    """Return the actor in a file.

    Raises:
        InvalidInput: The file is missing, damaged or foreign, or its actor was trained on other
            observations than the library's; one line.
    """
    try:
        arrays = npz.read_arrays(path, kinds="fu")
        about = _about(arrays.pop("about"))
        check(about, path)
        return Trained(_actor(arrays, about), about)
    except FileNotFoundError:
        raise InvalidInput(f"policy: there is no file {str(path)!r}") from None
    except InvalidInput:
        raise
    except _UNUSABLE as error:
        why = f": {error}" if isinstance(error, npz.Unreadable | _NoActor) else ""
        raise InvalidInput(
            f"policy: {str(path)!r} is damaged, or no trained policy of hazbot_gym{why}"
        ) from error


def _about(text: npt.NDArray[np.generic]) -> dict[str, object]:
    if text.dtype != np.uint8 or text.nbytes > MOST_TEXT:
        raise _NoActor("its description is no text of that length")
    about = json.loads(text.tobytes())
    if not isinstance(about, dict):
        raise _NoActor("its description is no mapping")
    return about


def check(about: JsonObject, path: Path) -> None:
    """Reject an actor of another format, or with another observation table than the library's."""
    if about["format"] != FORMAT:
        raise InvalidInput(
            f"policy: {str(path)!r} has format {about['format']}, allowed is {FORMAT}"
        )
    if about["tier"] not in LAYOUTS:
        raise InvalidInput(
            f"policy: {str(path)!r} has tier {about['tier']!r}, allowed are {', '.join(LAYOUTS)}"
        )
    stored = about["observation"]
    own = observation_table(layout_of_table(about))
    for i, (theirs, ours) in enumerate(zip(stored, own, strict=False)):
        if not _reads_as(theirs, ours):
            raise InvalidInput(
                f"policy: {str(path)!r} was trained on another observation: entry {i} was "
                f"{_field(theirs)}, now it is {_field(ours)}"
            )
    if len(stored) != len(own):
        raise InvalidInput(
            f"policy: {str(path)!r} was trained on another observation: it had {len(stored)} "
            f"entries, now it has {len(own)}"
        )


def _reads_as(theirs: JsonObject, ours: JsonObject) -> bool:
    """Return True if a field is the same, or the same with wider bounds, which clip less."""
    is_within = ours["low"] <= theirs["low"] and theirs["high"] <= ours["high"]
    return is_within and {**theirs, "low": 0, "high": 0} == {**ours, "low": 0, "high": 0}


def _field(field: JsonObject) -> str:
    return "{name} in {low:g}..{high:g} {unit} / {scale:g}".format(**field)


def _actor(arrays: Mapping[str, npt.NDArray[np.generic]], about: JsonObject) -> Actor:
    """Assemble the arrays; raise ValueError or KeyError if they do not fit."""
    unlike = [name for name, array in arrays.items() if array.dtype.kind != "f"]
    with np.errstate(over="ignore"):  # overflows are rejected as not finite
        weights = {name: array.astype(np.float32) for name, array in arrays.items()}
    endless = [name for name, array in weights.items() if not np.isfinite(array).all()]
    if unlike or endless:
        raise _NoActor(f"its {(unlike + endless)[0]} holds other than finite real numbers")
    count = sum(name.startswith("weight") for name in weights)
    prices = _prices(about)
    width = len(about["observation"]) + (prices is not None)
    lstm = _lstm(weights, width)
    layers = tuple(Layer(weights[f"weight{i}"], weights[f"bias{i}"]) for i in range(count))
    _check_layers(layers, lstm.size if lstm else width)
    outputs = layers[-1].bias.size
    if about["action"] not in HEADS or (outputs == 1) != (about["action"] != "levels"):
        raise _NoActor(f"its action is {about['action']!r} with {outputs} outputs")
    if about["activation"] not in ACTIVATIONS or not _is_residual(about):
        raise _NoActor("its activation or residual is not known")
    statistics = _normalisation(weights, width)
    known = 2 * count + 2 * (lstm is not None) + 3 * (statistics is not None)
    if len(weights) != known:
        raise _NoActor("it has arrays that belong to no part of an actor")
    actor = Actor(layers, about["activation"], about["action"], statistics, lstm)
    if prices and not _can_be_priced(actor):
        raise _NoActor("its price is the input of an LSTM or of a normalisation")
    return actor


def _check_layers(layers: tuple[Layer, ...], inputs: int) -> None:
    """Reject layers with incompatible shapes."""
    if not layers:
        raise _NoActor("it has no layers")
    for i, layer in enumerate(layers):
        outputs = layer.bias.size
        if layer.bias.shape != (outputs,) or layer.weight.shape != (inputs, outputs) or not outputs:
            raise _NoActor(
                f"its layer {i} has weights {layer.weight.shape} and biases {layer.bias.shape} "
                f"where {inputs} entries come in"
            )
        inputs = outputs


def _lstm(arrays: Mapping[str, npt.NDArray[Any]], width: int) -> Lstm | None:
    if "gate_weight" not in arrays:
        return None
    lstm = Lstm(Layer(arrays["gate_weight"], arrays["gate_bias"]))
    gates, size = lstm.gates, lstm.size
    fits = gates.weight.shape == (width + size, 4 * size) and gates.bias.shape == (4 * size,)
    if not fits or not size:
        raise _NoActor("its LSTM does not fit the observations")
    return lstm


def _is_residual(about: JsonObject) -> bool:
    """Return True if the residual metadata is absent or complete; old files lack it."""
    residual = about.get("residual")
    if residual is None:
        return True
    base, scale = residual["base"], residual["scale"]
    is_number = isinstance(scale, int | float) and not isinstance(scale, bool)
    return isinstance(base, str) and is_number and 0 < scale <= 2


def _prices(about: JsonObject) -> PriceInput | None:
    """Return the prices of the metadata, if any; raise if they are no range."""
    prices = prices_of(about)
    if prices is None:
        return None
    are_numbers = all(type(each) in (int, float) and math.isfinite(each) for each in prices)
    if not are_numbers or not 0 < prices.low <= prices.usual <= prices.high > prices.low:
        raise _NoActor("its prices are no range")
    return prices


def _normalisation(arrays: Mapping[str, npt.NDArray[Any]], width: int) -> Normalisation | None:
    if "mean" not in arrays:
        return None
    clip, epsilon = arrays["clip_epsilon"].tolist()
    mean, variance = arrays["mean"], arrays["variance"]
    fits = mean.shape == (width,) and variance.shape == (width,)
    if not fits or clip <= 0.0 or epsilon < 0.0 or (variance + np.float32(epsilon) <= 0.0).any():
        raise _NoActor("its normalisation does not fit the observations, or divides by zero")
    return Normalisation(mean, variance, clip, epsilon)


_IN_STUDY = """
## Results in the study

Means on the test scenarios, with intervals.

| metric | value |
|---|---|
{rows}
"""


def card(trained: Trained, name: str) -> str:
    """Return the model card of a trained actor, as Markdown."""
    actor, about = trained
    memory = (f"LSTM of {actor.lstm.size}",) if actor.lstm else ()
    inputs = len(about["observation"])
    units = (actor.width, *memory, *(layer.bias.size for layer in actor.layers))
    sizes = " -> ".join(str(each) for each in units)
    training = {name: each for name, each in about["training"].items() if name != "environments"}
    residual = about.get("residual")
    line = "- **Corrects** `{base}`, by {scale:g} at most.\n"
    corrects = line.format(**residual) if residual else ""
    prices = prices_of(about)
    line = "- **Price of nearness**: `price={0:g}` to `{1:g}` s/s, by default `{2:g}`.\n"
    priced = line.format(*prices) if prices else ""
    results = "\n".join(f"| {key} | {value} |" for key, value in about["results"].items())
    study = "\n".join(f"| {key} | {value} |" for key, value in about.get("study", {}).items())
    in_study = _IN_STUDY.format(rows=study) if study else ""
    return f"""# {name}

A speed policy for the environments of hazbot_gym, trained with {about["algorithm"]}.

- **Sees** the {about["tier"]} tier: {inputs} entries, as listed in the file.
- **Answers** with a share of the nominal speed; the head is `{about["action"]}`, deterministic.
{corrects}{priced}- **Network**: {sizes}, {about["activation"]}.
- **Use**: `hazbot eval --policy learned:path={name}.npz`, or
  `hazbot_gym.policies.make("learned:path={name}.npz")`. The file holds arrays and JSON, no pickle.
- **Limits**: trained and evaluated in simulation only. Comfort is approximated by clearance; no
  people were surveyed. Do not let this policy drive a robot among people.

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
