"""Linear layer of a network, with results independent of the batch size."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.jit import lean_kernel

Floats32 = npt.NDArray[np.float32]


class Layer(NamedTuple):
    """One linear map, y = x W + b."""

    weight: Floats32  # (inputs, outputs)
    bias: Floats32  # (outputs,)

    def apply(self, x: Floats32) -> Floats32:
        """Return y for inputs (..., inputs): shape (..., outputs)."""
        rows = np.ascontiguousarray(x.reshape(-1, x.shape[-1]), np.float32)
        out = np.empty((len(rows), self.bias.size), np.float32)
        map_rows(rows, np.ascontiguousarray(self.weight), np.ascontiguousarray(self.bias), out)
        return out.reshape(*x.shape[:-1], self.bias.size)


@lean_kernel
def map_rows(rows: Floats32, weight: Floats32, bias: Floats32, out: Floats32) -> None:
    """Write x W + b for every row.

    NumPy's matrix product is not used: the last digit of its sums depends on the number of rows, so
    that an episode would depend on its batch. Inputs are processed four at a time, so that a sum is
    loaded and stored once for four products. Inner loops compile to vector instructions.
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
