"""LSTM of one layer (Hochreiter and Schmidhuber, Neural Computation 1997).

With input x, hidden state h and cell state c, gates in torch's order, and the forget gate of Gers,
Schmidhuber and Cummins (2000):

    i, f, g, o = [x, h] W + b, each as wide as h
    c <- sigmoid(f) c + sigmoid(i) tanh(g)
    h <- sigmoid(o) tanh(c)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.policies.layer import Floats32, Layer


class Memory(NamedTuple):
    """LSTM state."""

    hidden: Floats32  # (..., size) h
    cell: Floats32  # (..., size) c


class Lstm(NamedTuple):
    """The weights of all four gates: inputs are x and then h, outputs i, f, g and o."""

    gates: Layer

    @property
    def size(self) -> int:
        """Number of entries of h."""
        return len(self.gates.bias) // 4

    @property
    def width(self) -> int:
        """Number of entries of x."""
        return len(self.gates.weight) - self.size

    def remember(
        self, x: Floats32, memory: Memory | None, starts: npt.NDArray[np.bool_] | None = None
    ) -> Memory:
        """Return the state after one more observation.

        Args:
            x: (..., width) input.
            memory: Previous state; None for zeros.
            starts: (...) whether an episode has just begun; resets the state.
        """
        nothing = np.zeros((*x.shape[:-1], self.size), np.float32)
        hidden, cell = memory or Memory(nothing, nothing)
        if starts is not None:
            anew = np.reshape(starts, (*x.shape[:-1], 1))
            hidden, cell = np.where(anew, nothing, hidden), np.where(anew, nothing, cell)
        gates = self.gates.apply(np.concatenate([x, hidden], axis=-1))
        i, f, g, o = np.split(gates, 4, axis=-1)
        cell = _sigmoid(f) * cell + _sigmoid(i) * np.tanh(g)
        return Memory(_sigmoid(o) * np.tanh(cell), cell)


def _sigmoid(x: Floats32) -> Floats32:
    """Return 1 / (1 + exp(-x)), without overflow."""
    share: Floats32 = np.float32(0.5) * (np.tanh(np.float32(0.5) * x) + np.float32(1.0))
    return share
