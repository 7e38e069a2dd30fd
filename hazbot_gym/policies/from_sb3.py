"""Conversion of Stable-Baselines3 models to NumPy actors, and policies from SB3 zip files."""

from __future__ import annotations

import importlib
import json
import zipfile
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.policies.actor import Actor, Normalisation
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Flags, Guarded, Observations
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.task.action import SPEED_LEVELS, speed_action
from hazbot_gym.task.observation import Layout, known_layout

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

MOST_TEXT = 64 * 2**20  # maximum bytes of the JSON, which contains the pickles

# Module of an SB3 policy class, and the algorithm that can load it.
_LOADERS = {
    "stable_baselines3.common.policies": "stable_baselines3:PPO",
    "stable_baselines3.sac.policies": "stable_baselines3:SAC",
    "stable_baselines3.td3.policies": "stable_baselines3:TD3",
    "sb3_contrib.tqc.policies": "sb3_contrib:TQC",
    "sb3_contrib.crossq.policies": "sb3_contrib:CrossQ",
    "stable_baselines3.dqn.policies": "stable_baselines3:DQN",
    "sb3_contrib.qrdqn.policies": "sb3_contrib:QRDQN",
    "sb3_contrib.common.recurrent.policies": "sb3_contrib:RecurrentPPO",
}


def actor_of(model: Any, normalize: Any = None) -> Actor:
    """Return the deterministic actor of a trained model as plain arrays.

    Args:
        model: PPO, A2C, SAC, TD3, TQC, CrossQ, DQN or QR-DQN of Stable-Baselines3, or an extension
            in this package, with its ``MlpPolicy``; or recurrent PPO with ``MlpLstmPolicy``.
        normalize: The ``VecNormalize`` of its training; None for raw observations.

    Raises:
        InvalidInput: The model is not supported.
    """
    policy, kinds = model.policy, {kind.__name__ for kind in type(model).__mro__}
    lstm = None
    if policy is not None:
        _check_actions(model.action_space, "export")
    if kinds & {"PPO", "A2C", "DAgger", "RecurrentPPO"}:
        continuous = "squashed" if policy.squash_output else "clipped"
        head = "levels" if hasattr(model.action_space, "n") else continuous
        extractor = policy.pi_features_extractor
        modules = [*policy.mlp_extractor.policy_net, policy.action_net]
        lstm = _lstm(policy.lstm_actor) if "RecurrentPPO" in kinds else None
    elif kinds & {"SAC", "TQC", "CrossQ"}:
        if policy.actor.use_sde:  # clips the mean before squashing it
            raise InvalidInput("export: given use_sde=True, allowed is False, or PPO or A2C")
        head, extractor = "squashed", policy.actor.features_extractor
        modules = [*policy.actor.latent_pi, policy.actor.mu]
    elif "TD3" in kinds:
        head, extractor = "squashed", policy.actor.features_extractor
        modules = list(policy.actor.mu)[:-1]  # its last module is the head's tanh
    elif "DQN" in kinds:
        head, extractor = "levels", policy.q_net.features_extractor
        modules = list(policy.q_net.q_net)
    elif "QRDQN" in kinds:
        head, extractor = "levels", policy.quantile_net.features_extractor
        modules = list(policy.quantile_net.quantile_net)
    else:
        raise InvalidInput(
            f"export: {type(model).__name__} has no plain form; allowed are PPO, A2C, SAC, TD3, "
            "TQC, CrossQ, DQN, QRDQN and RecurrentPPO"
        )
    layers, activation = _chain(modules)
    if "QRDQN" in kinds:
        layers = (*layers[:-1], _mean(layers[-1], policy.quantile_net.n_quantiles))
    has_statistics = normalize is not None and normalize.norm_obs
    statistics = _normalisation(normalize) if has_statistics else None
    return _with_feature_mask(Actor(layers, activation, head, statistics, lstm), extractor)


def _check_actions(space: object, name: str) -> None:
    """Refuse actions that a wrapper has changed: what they command cannot be known.

    Args:
        space: Action space of a model.
        name: What is refused, for the message.

    Raises:
        InvalidInput: The space is not that of an environment.
    """
    if hasattr(space, "n"):
        is_known = space.n == len(SPEED_LEVELS)
    else:
        low, high = (np.asarray(getattr(space, end, None)) for end in ("low", "high"))
        is_known = low.shape == (1,) and low[0] == -1.0 and high[0] == 1.0
    if not is_known:
        raise InvalidInput(
            f"{name}: given actions {space}, allowed are those of the environments, from -1 to 1 "
            f"or {len(SPEED_LEVELS)} levels"
        )


def check_bounds(model: Any, layout: Layout, name: str) -> None:
    """Refuse observations that a wrapper has changed: the model needs them changed alike.

    Args:
        model: A model; its observations may go on after those of the layout.
        layout: Layout of the environments' observations.
        name: What is refused, for the message.

    Raises:
        InvalidInput: The bounds of its observations are not those of the layout.
    """
    space = model.observation_space
    ends = ((space.low, layout.low), (space.high, layout.high))
    if not all(np.array_equal(given[: layout.width], own) for given, own in ends):
        raise InvalidInput(
            f"{name}: given observations from {space.low.min():g} to {space.high.max():g}, other "
            "bounds than the environments': allowed are observations that no wrapper changed"
        )


def _with_feature_mask(actor: Actor, extractor: Any) -> Actor:
    """Return an actor with zero weights for the entries masked by a model's ``FeatureMask``."""
    kind = type(extractor).__name__
    if kind not in ("FlattenExtractor", "FeatureMask"):
        raise InvalidInput(f"export: given features of {kind}, allowed is what is observed itself")
    if kind == "FlattenExtractor":
        return actor
    first = actor.lstm.gates if actor.lstm else actor.layers[0]
    seen = np.ones((len(first.weight), 1), np.float32)
    seen[: actor.width, 0] = extractor.seen.cpu().numpy()[: actor.width]
    blind = Layer(first.weight * seen, first.bias)
    if actor.lstm:
        return actor._replace(lstm=Lstm(blind))
    return actor._replace(layers=(blind, *actor.layers[1:]))


def _lstm(module: Any) -> Lstm:
    """Return torch's LSTM; its two biases are summed."""
    if module.num_layers != 1:
        raise InvalidInput(f"export: given an LSTM of {module.num_layers} layers, allowed is 1")
    if not module.bias or module.proj_size or module.bidirectional:
        raise InvalidInput("export: given lstm_kwargs, allowed is an LSTM without options")
    inputs, hidden, *biases = (weights.detach().cpu().numpy() for weights in module.parameters())
    return Lstm(Layer(np.ascontiguousarray(np.hstack([inputs, hidden]).T), sum(biases)))


def _chain(modules: list[Any]) -> tuple[tuple[Layer, ...], str]:
    """Return the linear layers of a chain of modules, and the activation between them.

    A batch normalization, as CrossQ has before each linear layer, is folded into that layer.
    """
    layers, kinds, normalization = [], set(), None
    for module in modules:
        kind = type(module).__name__
        if kind == "Linear":
            weight, bias = module.weight.detach().cpu().numpy(), module.bias.detach().cpu().numpy()
            layer = Layer(np.ascontiguousarray(weight.T, np.float32), bias.copy())
            layers.append(_folded(normalization, layer) if normalization else layer)
            normalization = None
        elif kind == "BatchRenorm1d":
            normalization = module
        else:
            kinds.add(kind.lower())
    if not kinds <= {"tanh"} and not kinds <= {"relu"}:
        raise InvalidInput(f"export: given layers {', '.join(kinds)}; allowed are tanh or relu")
    return tuple(layers), kinds.pop() if kinds else "tanh"


def _folded(normalization: Any, layer: Layer) -> Layer:
    """Return a layer behind a batch normalization of its inputs, as one layer.

    y = W (a x + c) + b,  a = scale / sqrt(variance + eps),  c = shift - a mean
    """
    mean, variance, scale, shift = (
        each.detach().cpu().numpy().astype(np.float64)
        for each in (
            normalization.ra_mean, normalization.ra_var, normalization.scale, normalization.bias
        )
    )  # fmt: skip
    a = scale / np.sqrt(variance + normalization.eps)
    c = shift - a * mean
    weight, bias = a[:, None] * layer.weight, layer.bias + c @ layer.weight
    return Layer(weight.astype(np.float32), bias.astype(np.float32))


def _mean(layer: Layer, quantiles: int) -> Layer:
    """Return QR-DQN's last layer (inputs, quantiles * levels), averaged over its quantiles."""
    weight = layer.weight.reshape(len(layer.weight), quantiles, -1).mean(axis=1)
    return Layer(np.ascontiguousarray(weight), layer.bias.reshape(quantiles, -1).mean(axis=0))


def _normalisation(normalize: Any) -> Normalisation:
    statistics = normalize.obs_rms
    return Normalisation(
        statistics.mean.astype(np.float32),
        statistics.var.astype(np.float32),
        float(normalize.clip_obs),
        float(normalize.epsilon),
    )


def load_zip(path: Path) -> Policy:
    """Return the policy in a zip of Stable-Baselines3. This executes code in the file.

    A zip holds no ``VecNormalize`` statistics and no observation table; export the model to include
    both.

    Raises:
        InvalidInput: The file is missing, or is not an SB3 zip.
        MissingExtra: Stable-Baselines3 is not installed.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            if archive.getinfo("data").file_size > MOST_TEXT:
                raise ValueError("its description is too long")
            module = json.loads(archive.read("data"))["policy_class"]["__module__"]
        loader = _LOADERS[module]
    except (
        OSError, EOFError, zipfile.BadZipFile, zlib.error, KeyError, TypeError, ValueError,
        RuntimeError,
    ) as error:  # fmt: skip
        raise InvalidInput(
            f"policy: {str(path)!r} is no model that Stable-Baselines3 saved"
        ) from error
    return _Model(_checked(_load(loader, path), path))


def _load(loader: str, path: Path) -> BaseAlgorithm:
    package, _, algorithm = loader.partition(":")
    try:
        library = importlib.import_module(package)
    except ImportError as error:
        raise MissingExtra(package.replace("_", "-"), "train") from error
    try:
        model: BaseAlgorithm = getattr(library, algorithm).load(path, device="cpu")
        return model
    except Exception as error:  # exceptions of its pickles
        raise InvalidInput(
            f"policy: {str(path)!r} cannot be loaded: {type(error).__name__}: {error}"
        ) from error


def _checked(model: BaseAlgorithm, path: Path) -> BaseAlgorithm:
    """Return the model if spaces are an environment's and weights finite, else raise."""
    if len(model.observation_space.shape or ()) != 1:
        raise InvalidInput(
            f"policy: {str(path)!r} takes {model.observation_space}, allowed are flat observations"
        )
    _check_actions(model.action_space, f"policy: {str(path)!r}")
    if not all(bool(weights.isfinite().all()) for weights in model.policy.state_dict().values()):
        raise InvalidInput(f"policy: {str(path)!r} holds weights that are not finite")
    return model


class _Model(Guarded):
    """An SB3 model as a policy, with discrete levels mapped to continuous actions."""

    def __init__(self, model: BaseAlgorithm) -> None:
        self._model, self._layout = model, cast(Layout | None, None)  # that was checked
        (self._width,) = model.observation_space.shape or ()

    def act(
        self, observation: Observations, state: object, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the model's action and its state, rows first; see ``Guarded.act``."""
        if not deterministic:
            raise InvalidInput("deterministic: given False, a trained policy allows only True")
        if np.shape(observation)[-1] != self._width:
            raise InvalidInput(
                f"tier: given observations of {np.shape(observation)[-1]} entries, this policy was "
                f"trained on {self._width}"
            )
        layout = known_layout(self._width)
        if layout is not None and layout is not self._layout:
            check_bounds(self._model, layout, "policy")
            self._layout = layout
        action, state = self._model.predict(
            observation, _rows_second(state), starts, deterministic=True
        )
        if hasattr(self._model.action_space, "n"):
            action = speed_action(action / (self._model.action_space.n - 1))
        return np.asarray(action, np.float32), _rows_second(state)


def _rows_second(state: Any) -> Any:
    """Return the arrays of an LSTM's state with their first two axes, layers and rows, swapped."""
    return state if state is None else tuple(np.swapaxes(each, 0, 1) for each in state)
