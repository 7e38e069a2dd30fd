"""Warnings about places that may be too narrow or too long for the drive."""

from __future__ import annotations

import warnings

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.geometry import path_length
from hazbot_gym.core.state import ROBOT_RADIUS_M, Place
from hazbot_gym.errors import DoubtfulPlace
from hazbot_gym.task.place_data import narrowest

# Largest cross-track error per m/s: 0.061 m at 0.5 m/s and 0.14 m at 1 m/s, over 128 robots with
# the default drive, on straight paths and around corners.
ERROR_S = 0.14
FAR_M = 20.0  # from the nearest wall; larger distances suggest another unit
END_M = 0.1  # of the path's end, omitted: a wall ahead of it is no narrow passage


def doubt(name: str, place: Place, config: Config) -> None:
    """Warn of a path too long for an episode, too narrow for the drive, or far from all walls."""
    for message in (_too_long(place, config), _beside_walls(place, config)):
        if message:
            warnings.warn(f"{name}: {message}", DoubtfulPlace, stacklevel=3)


def _too_long(place: Place, config: Config) -> str:
    length, speed_mps = path_length(place.path.view(np.recarray)), config.drive.nominal_speed_mps
    ends_s = config.max_episode_steps * config.clock.decision_s
    goal_s = (length - config.arrival_tolerance_m) / speed_mps + _start_s(length, config)
    if goal_s <= ends_s:
        return ""
    return (
        f"the path is {length:.1f} m long, {goal_s:.0f} s at {speed_mps} m/s, and an episode ends "
        f"after {ends_s:.0f} s (max_episode_steps: {config.max_episode_steps}, needed are more "
        f"than {goal_s / config.clock.decision_s:.0f}): no robot arrives"
    )


def _start_s(length: float, config: Config) -> float:
    """Return the extra time of the start compared with nominal speed [s]."""
    drive = config.drive
    missing_mps = drive.nominal_speed_mps - drive.start_speed_mps
    delay_s = missing_mps**2 / (2.0 * drive.acceleration_mps2 * drive.nominal_speed_mps)
    is_reached = drive.nominal_speed_mps**2 < 2.0 * drive.acceleration_mps2 * length
    latency_s = drive.latency_steps * config.clock.decision_s
    return (delay_s if is_reached else 0.0) + (latency_s if missing_mps else 0.0)


def _beside_walls(place: Place, config: Config) -> str:
    error_m = ERROR_S * config.drive.nominal_speed_mps
    clearance_m, x, y = narrowest(place.walls, place.path, END_M)
    if FAR_M < clearance_m < np.inf:
        return f"the nearest wall is {clearance_m:.4g} m from the path; are both in meters?"
    if clearance_m > ROBOT_RADIUS_M + error_m:
        return ""
    return (
        f"the path passes a wall at {clearance_m:.2f} m near ({x:.1f}, {y:.1f}); a robot of radius "
        f"{ROBOT_RADIUS_M:.2f} m that leaves its path by up to {error_m:.2f} m may touch it"
    )
