"""A trained actor as plain arrays: normalise, hidden layers, head. no torch.

What Stable-Baselines3 does with its networks when it acts deterministically, written out:

    x = clip((observation - mean) / sqrt(variance + epsilon), -clip, clip)     (VecNormalize)
    h = act(x W + b), layer by layer; y = h W + b
    clipped   action = clip(y, -1, 1)             PPO: the mean of its Gaussian
    squashed  action = tanh(y)                    SAC: the mean, squashed; TD3: its output
    levels    action = 2 argmax(y) / (n - 1) - 1  DQN: the speed level of the largest value
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.jit import lean_kernel

Floats32 = npt.NDArray[np.float32]


def _relu(x: Floats32) -> Floats32:
    return np.maximum(x, 0.0, out=x)


def _tanh(x: Floats32) -> Floats32:
    return np.tanh(x, out=x)


def _clip(x: Floats32) -> Floats32:
    return np.clip(x, -1.0, 1.0, out=x)


def _level(x: Floats32) -> Floats32:
    share = x.argmax(axis=-1)[..., None] / max(x.shape[-1] - 1, 1)
    return (2.0 * share - 1.0).astype(np.float32)


ACTIVATIONS: dict[str, Callable[[Floats32], Floats32]] = {"tanh": _tanh, "relu": _relu}
HEADS: dict[str, Callable[[Floats32], Floats32]] = {
    "clipped": _clip,
    "squashed": _tanh,
    "levels": _level,
}


class Layer(NamedTuple):
    """One linear map, y = x W + b."""

    weight: Floats32  # (inputs, outputs)
    bias: Floats32  # (outputs,)

    def apply(self, x: Floats32) -> Floats32:
        """Return y for inputs (..., inputs): shape (..., outputs)."""
        rows = np.ascontiguousarray(x.reshape(-1, x.shape[-1]), np.float32)
        out = np.empty((len(rows), self.bias.size), np.float32)
        _map_rows(rows, np.ascontiguousarray(self.weight), np.ascontiguousarray(self.bias), out)
        return out.reshape(*x.shape[:-1], self.bias.size)


@lean_kernel
def _map_rows(rows: Floats32, weight: Floats32, bias: Floats32, out: Floats32) -> None:
    """Write x W + b for every row.

    Not by numpy's matrix product: its sums depend, in the last digit, on how many rows there are,
    and an episode would not be the same alone as among others. Four inputs at a time, so that a sum
    is loaded and stored once for four products; inner loops compile to vector instructions.
    """
    fours = rows.shape[1] // 4 * 4
    for i in range(rows.shape[0]):
        x, y = rows[i], out[i]
        for k in range(y.shape[0]):
            y[k] = bias[k]
        for j in range(0, fours, 4):
            a, b, c, d = x[j], x[j + 1], x[j + 2], x[j + 3]
            wa, wb, wc, wd = weight[j], weight[j + 1], weight[j + 2], weight[j + 3]
            for k in range(y.shape[0]):
                y[k] = y[k] + a * wa[k] + b * wb[k] + c * wc[k] + d * wd[k]
        for j in range(fours, rows.shape[1]):
            a, wa = x[j], weight[j]
            for k in range(y.shape[0]):
                y[k] += a * wa[k]


class Normalisation(NamedTuple):
    """What VecNormalize has learned of the observations."""

    mean: Floats32  # (width,)
    variance: Floats32  # (width,)
    clip: float
    epsilon: float


class Actor(NamedTuple):
    """Weights, and how they are put together."""

    layers: tuple[Layer, ...]  # the last one is the head's
    activation: str  # a name of ACTIVATIONS
    head: str  # a name of HEADS
    normalisation: Normalisation | None = None

    @property
    def width(self) -> int:
        """Number of entries of the observations."""
        return self.layers[0].weight.shape[0]

    def act(self, observation: npt.ArrayLike) -> Floats32:
        """Return the actions in [-1, 1] for observations (..., width): shape (..., 1)."""
        x = np.asarray(observation, np.float32)
        if self.normalisation is not None:
            mean, variance, clip, epsilon = self.normalisation
            x = np.clip((x - mean) / np.sqrt(variance + np.float32(epsilon)), -clip, clip)
        activate = ACTIVATIONS[self.activation]
        for layer in self.layers[:-1]:
            x = activate(layer.apply(x))
        return HEADS[self.head](self.layers[-1].apply(x))
