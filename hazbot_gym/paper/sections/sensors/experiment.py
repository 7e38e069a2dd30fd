"""The sensor experiment (paper section 5.1, Table 2), with the sensors of this library.

A driving wheel at 0.5 m/s, the robot at 90 deg, a wall 1 m in front of the ultrasonic sensors. The
printed columns "Angle" and "Ultra" are swapped: 1.00 +- 0.02 is the wall, 1.5726 the right angle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.sensor_ring import PAPER
from hazbot_gym.core.state import PERSON, ROBOT, Floats, records
from hazbot_gym.paper.sections.circle.experiment import PHYSICS_S
from hazbot_gym.sim.drive import drive_parameters
from hazbot_gym.sim.lanes import measurement_noise
from hazbot_gym.sim.perception import ring_of, sense_ranges

WHEEL_MPS, HEADING_RAD, WALL_M = 0.5, math.pi / 2, 1.0
FRONT = 0  # one of the sensors in front
READINGS = 5  # of each seed, as in Table 2
# As printed: hub motor [m/s], "Angle" (the distance) [m], "Ultra" (the heading) [rad].
TABLE_2 = (
    (0.500, 1.02, 1.573),
    (0.498, 0.98, 1.572),
    (0.502, 1.02, 1.573),
    (0.499, 1.00, 1.573),
    (0.502, 0.98, 1.572),
)


class Readings(NamedTuple):
    """Sensor readings; all arrays (seeds * READINGS,)."""

    hub_mps: Floats
    wall_m: Floats
    heading_rad: Floats

    def errors(self) -> tuple[Floats, Floats, Floats]:
        """Return the errors of the readings."""
        truth = (WHEEL_MPS, WALL_M, HEADING_RAD)
        hub, wall, heading = (column - true for column, true in zip(self, truth, strict=True))
        return hub, wall, heading


def half_range(errors: Floats) -> float:
    """Return half of the span of errors, which grows to the half width of uniform noise."""
    return float(0.5 * (errors.max() - errors.min()))


def measure(seeds: int) -> Readings:
    """Take the readings of Table 2 once for each seed."""
    config = Config()
    drive, sonar = drive_parameters(config.drive, PHYSICS_S), config.sensors.ultrasonic
    robot = records(ROBOT, 1).view(np.recarray)[0]
    robot.theta = HEADING_RAD
    # A wall perpendicular to the heading; offset of the front sensors from M.
    wall_y = WALL_M + sonar.mount_radius_m * math.cos(PAPER[FRONT].angle_rad)
    walls = np.array([[-5.0, wall_y, 5.0, wall_y]])
    ring = ring_of(config).view(np.recarray)
    no_people = records(PERSON, 0).view(np.recarray)
    rows = []
    for seed in range(seeds):
        for k in range(READINGS):
            key, ranges = np.uint64(seed), np.empty(len(ring))
            sense_ranges(robot, no_people, walls, sonar, ring, key, k, ranges)
            wheel, _, heading = measurement_noise(drive, key, k)
            hub_mps = WHEEL_MPS + wheel * drive.chassis.r
            rows.append((hub_mps, ranges[FRONT], HEADING_RAD + heading))
    return Readings(*np.array(rows).T)
