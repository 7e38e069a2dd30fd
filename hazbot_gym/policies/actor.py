"""Inference of a trained actor in NumPy: normalization, LSTM, hidden layers, head.

Equivalent to the deterministic action of Stable-Baselines3:

    x = clip((observation - mean) / sqrt(variance + epsilon), -clip, clip)     (VecNormalize)
    x = h of an LSTM                              recurrent PPO (``lstm``)
    h = act(x W + b), layer by layer; y = h W + b
    clipped   action = clip(y, -1, 1)             PPO: the mean of its Gaussian
    squashed  action = tanh(y)                    SAC, PPO with squash_output: the mean, squashed;
                                                  TD3: its output
    levels    action = 2 argmax(y) / (n - 1) - 1  DQN: the speed level of the largest value
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.policies.layer import Floats32, Layer
from hazbot_gym.policies.lstm import Lstm, Memory
from hazbot_gym.task.action import speed_action


def _relu(x: Floats32) -> Floats32:
    return np.maximum(x, 0.0, out=x)


def _tanh(x: Floats32) -> Floats32:
    return np.tanh(x, out=x)


def _clip(x: Floats32) -> Floats32:
    clipped: Floats32 = np.clip(x, -1.0, 1.0, out=x)
    return clipped


def _level(x: Floats32) -> Floats32:
    return speed_action(x.argmax(axis=-1) / max(x.shape[-1] - 1, 1))


ACTIVATIONS: dict[str, Callable[[Floats32], Floats32]] = {"tanh": _tanh, "relu": _relu}
HEADS: dict[str, Callable[[Floats32], Floats32]] = {
    "clipped": _clip,
    "squashed": _tanh,
    "levels": _level,
}


class Normalisation(NamedTuple):
    """Observation statistics of VecNormalize."""

    mean: Floats32  # (width,)
    variance: Floats32  # (width,)
    clip: float
    epsilon: float


class Actor(NamedTuple):
    """Actor network: weights and architecture."""

    layers: tuple[Layer, ...]  # the last one is the head's
    activation: str  # a name of ACTIVATIONS
    head: str  # a name of HEADS
    normalisation: Normalisation | None = None
    lstm: Lstm | None = None

    @property
    def width(self) -> int:
        """Number of entries of the observations."""
        return self.lstm.width if self.lstm else self.layers[0].weight.shape[0]

    def act(
        self,
        observation: npt.ArrayLike,
        memory: Memory | None = None,
        starts: npt.NDArray[np.bool_] | None = None,
    ) -> tuple[Floats32, Memory | None]:
        """Return the actions in [-1, 1] for observations (..., width), and the LSTM state.

        Args:
            observation: Observations (..., width).
            memory: LSTM state; None at the beginning, and without an LSTM.
            starts: (...) whether an episode has just begun; resets the LSTM state.

        Returns:
            Actions (..., 1), NaN where an output of the network is not finite; and the memory for
            the next decision.
        """
        x = np.asarray(observation, np.float32)
        if self.normalisation is not None:
            mean, variance, clip, epsilon = self.normalisation
            x = np.clip((x - mean) / np.sqrt(variance + np.float32(epsilon)), -clip, clip)
        if self.lstm is not None:
            memory = self.lstm.remember(x, memory, starts)
            x = memory.hidden
        activate = ACTIVATIONS[self.activation]
        for layer in self.layers[:-1]:
            x = activate(layer.apply(x))
        y = self.layers[-1].apply(x)
        is_finite = np.isfinite(y).all(axis=-1, keepdims=True)  # the head would hide NaN
        return np.where(is_finite, HEADS[self.head](y), np.float32(np.nan)), memory
