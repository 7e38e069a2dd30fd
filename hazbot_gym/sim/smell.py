"""Gas at the robot: concentration at its position, and the reading of its sensor."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.gas import Plume, concentration
from hazbot_gym.core.gas_sensor import Nose, sense_gas
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import GasRecord, Records, RobotRecord


@scalar
def smell(
    robot: RobotRecord, gas: GasRecord, plume: Plume, nose: Nose, key: np.uint64, step: int
) -> None:
    """Update the gas sensor at a decision; the sensor is at the robot's center.

    Args:
        robot: The robot's record.
        gas: Record of type ``GAS``.
        plume: Dispersion of the gas.
        nose: Numbers of the sensor.
        key: Key of the scenario's noise.
        step: Number of the decision since the reset.
    """
    s_m, t_s = robot.s + robot.x_e, step * nose.decision_s
    gas.smell.s_m = s_m
    c_ppm = concentration(gas.leak, plume, s_m, robot.y_e, t_s, key)
    sense_gas(gas.smell, c_ppm, nose, key, step)


@lean_kernel
def smell_kernel(
    robots: Records, gases: Records, plumes: Records, noses: Records, key: np.uint64, step: int
) -> None:
    """Entry point from Python: ``smell`` for arrays of one record."""
    smell(robots[0], gases[0], plumes[0], noses[0], np.uint64(key), step)
