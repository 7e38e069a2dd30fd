"""Plume in a picture: the concentration on a grid over the floor, as opacity of one color."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.gas import Plume, concentration
from hazbot_gym.core.gas_sensor import Nose, gas_sensor_of, nose_of, steady_response
from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import Floats, Ints, Place, Records, as_record

CELL_M = 0.1  # of the grid
SAMPLE_M = 0.05  # distance of the points of the path that cells are projected on
BEYOND_M = 3.0  # drawn beyond the ends of the path, and beside it where there is no wall
OPAQUE = 190  # opacity, 0 to 255, of gas far above the alarm threshold

Reading = TypeVar("Reading", float, Floats)


class GasFrame(NamedTuple):
    """Gas in a picture.

    Attributes:
        record: (1,) GAS record.
        plume: Dispersion.
        nose: Gas sensor.
        key: Key of the scenario's noise.
    """

    record: Records
    plume: Plume
    nose: Nose
    key: int


def gas_frame_of(config: Config, gas: Records, key: int) -> GasFrame | None:
    """Return the gas of a picture; None without gas.

    Args:
        config: Of the environment.
        gas: (1,) GAS record; (0,) without gas.
        key: Key of the scenario.
    """
    if config.gas is None:
        return None
    nose = nose_of(gas_sensor_of(config.gas.sensor), config.clock.decision_s)
    return GasFrame(gas.copy(), config.gas.plume, nose, key)


class PlumeGrid:
    """Grid over the floor of a place, in the coordinates of its path.

    Attributes:
        left_m: Left edge of the grid.
        top_m: Upper edge.
        shape: Number of rows and columns.
        cells: (N,) flat indices of the cells with floor.
        s_m: (N,) arc length of the path beside them.
        aside_m: (N,) their lateral position.
    """

    def __init__(self, place: Place, left_m: float, right_m: float) -> None:
        """Project the cells on the path.

        Args:
            place: The place.
            left_m: Distance from the path to the wall on the left.
            right_m: The same on the right.
        """
        length = path_length(place.path.view(np.recarray))
        at_m = np.linspace(0.0, length, math.ceil(length / SAMPLE_M) + 1)
        poses = sample_path(place.path, at_m)[:, :3]
        margin_m = BEYOND_M + CELL_M
        low, high = poses[:, :2].min(axis=0) - margin_m, poses[:, :2].max(axis=0) + margin_m
        self.left_m, self.top_m = float(low[0]), float(high[1])
        columns, rows = np.ceil((high - low) / CELL_M).astype(int)
        x_m = self.left_m + CELL_M * (0.5 + np.arange(columns))
        y_m = self.top_m - CELL_M * (0.5 + np.arange(rows))
        s_m, aside_m = _project(np.stack(np.meshgrid(x_m, y_m), axis=-1), poses, at_m)
        self.shape = rows, columns
        is_inside = (aside_m < min(left_m, BEYOND_M)) & (aside_m > -min(right_m, BEYOND_M))
        self.cells: Ints = np.flatnonzero(is_inside & (s_m > -BEYOND_M) & (s_m < length + BEYOND_M))
        self.s_m, self.aside_m = s_m.ravel()[self.cells], aside_m.ravel()[self.cells]

    def opacity(self, gas: GasFrame, time_s: float) -> npt.NDArray[np.uint8]:
        """Return the opacity (rows, columns) of each cell, 0 without gas."""
        u, opacity = np.zeros(len(self.cells)), np.zeros(self.shape)
        steady_readings(
            gas.record, as_record(gas.plume), as_record(gas.nose), self.s_m, self.aside_m,
            time_s, np.uint64(gas.key), u,
        )  # fmt: skip
        opacity.flat[self.cells] = opacity_of(u)
        return opacity.astype(np.uint8)


@scalar
def opacity_of(u: Reading) -> Reading:
    """Return the opacity for steady readings u of the sensor, in units of the alarm threshold.

    It is half of the largest where the gas just suffices for an alarm.
    """
    return OPAQUE * u / (1.0 + u)


def _project(points: Floats, poses: Floats, at_m: Floats) -> tuple[Floats, Floats]:
    """Return arc length and lateral position (rows, columns) of points (rows, columns, 2)."""
    s_m, aside_m = np.empty(points.shape[:2]), np.empty(points.shape[:2])
    for row, some in enumerate(points):  # all at once would take much memory
        offset = some[:, None, :] - poses[None, :, :2]
        nearest = np.argmin((offset**2).sum(axis=-1), axis=1)
        dx, dy = offset[np.arange(len(some)), nearest].T
        cos, sin = np.cos(poses[nearest, 2]), np.sin(poses[nearest, 2])
        s_m[row], aside_m[row] = at_m[nearest] + cos * dx + sin * dy, cos * dy - sin * dx
    return s_m, aside_m


@lean_kernel
def steady_readings(
    gases: Records, plumes: Records, noses: Records, s_m: Floats, y_m: Floats, t_s: float,
    key: np.uint64, out: Floats,
) -> None:  # fmt: skip
    """Write the steady reading at each of some points, in units of the alarm threshold."""
    nose = noses[0]
    for k in range(len(s_m)):
        ppm = concentration(gases[0].leak, plumes[0], s_m[k], y_m[k], t_s, np.uint64(key))
        out[k] = steady_response(ppm, nose.half_ppm, nose.exponent) / nose.threshold
