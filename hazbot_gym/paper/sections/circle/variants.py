"""Sensitivity of the four numbers of the circle to parameters that the paper leaves open.

Plant, sign and tables of the rules, speed, radius, sampling, the motors' limit, the band that
"converged" means, and the sensor noise of Table 2; each for both controllers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.fuzzy_pid import FuzzyPid
from hazbot_gym.core.pid import PLANTS, Plant
from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.intervals import (
    Estimate,
    bootstrap_mean,
    scenario_draws,
)
from hazbot_gym.paper.sections.circle.experiment import (
    BAND,
    NOISE,
    Figures,
    Lap,
    converged_s,
    drive_lap,
    figures,
    paper_drive,
)
from hazbot_gym.utils.json_object import JsonObject

LOOPS = {"fuzzy-PID": "fuzzy_pid", "PID": "pid"}
BANDS = (0.0005, BAND, 0.002, 0.005)  # of a converged error [m, rad]
SHARES = (0.05, 0.02)  # the same relative to the lap's largest error
LAST_S = 10.0  # of a lap, in which only noise is left


def on_plant(plant: Plant, controller: str) -> Figures:
    """Return the four numbers of a lap with one of the paper's controllers on a plant."""
    return figures(drive_lap(paper_drive(plant=plant._asdict(), wheel_loop=LOOPS[controller])))


def plants() -> dict[str, Figures]:
    """Return the four numbers of both controllers on every plant with a name."""
    return {
        f"{name}, {controller}": on_plant(plant, controller)
        for name, plant in PLANTS.items()
        for controller in LOOPS
    }


def variants() -> dict[str, Figures]:
    """Return the four numbers on plant B with one change, for the controllers that it affects."""
    both: dict[str, tuple[dict[str, object], JsonObject]] = {
        "0.3 m/s": ({"nominal_speed_mps": 0.3}, {}),
        "radius 3.5 m": ({}, {"radius_m": 3.5}),
        "steps of 0.005 s": ({}, {"physics_s": 0.005}),
        "steps of 0.02 s": ({}, {"physics_s": 0.02}),
        "|u| at most 10": ({"plant": PLANTS["B"]._replace(u_max=10.0)._asdict()}, {}),
        "reference speeds up at 0.5 m/s²": ({"acceleration_mps2": 0.5}, {}),
    }
    rules: dict[str, dict[str, object]] = {
        "rules see wanted minus actual (s = +1)": {"fuzzy": FuzzyPid(sign=1.0)._asdict()},
        "symmetric tables": {"tables": "symmetric"},
    }
    fuzzy = {
        f"{what}, fuzzy-PID": figures(drive_lap(paper_drive(**drive)))
        for what, drive in rules.items()
    }
    return fuzzy | {
        f"{what}, {name}": figures(drive_lap(paper_drive(wheel_loop=loop, **drive), **lap))
        for what, (drive, lap) in both.items()
        for name, loop in LOOPS.items()
    }


class Converged(NamedTuple):
    """Convergence times of a lap's two errors."""

    position_s: float
    angle_s: float


def bands(lap: Lap) -> dict[str, Converged]:
    """Return convergence times of a lap by several definitions; the paper gives none (A12)."""
    errors = (lap.position_m, lap.angle_rad)
    absolute = {
        f"{band:g}": Converged(*(converged_s(lap.time_s, error, band) for error in errors))
        for band in BANDS
    }
    return absolute | {
        f"{share:.0%} of the largest": Converged(
            *(converged_s(lap.time_s, error, share * float(error.max())) for error in errors)
        )
        for share in SHARES
    }


class Spread(NamedTuple):
    """Distribution of a number over noise seeds, by percentiles as times are not normal."""

    low: float  # 5 % of the seeds are below
    median: float
    high: float  # 5 % are above


class Noisy(NamedTuple):
    """A controller on plant B over noise seeds."""

    seeds: int
    spreads: dict[str, Spread]  # of ``Figures``, and of the RMS errors that noise alone leaves
    unsettled_position: float  # share of laps whose error still exceeds ``BAND`` in ``LAST_S``
    unsettled_angle: float


def noisy_laps(loop: str, seeds: int) -> list[Lap]:
    """Drive laps with the noise of Table 2."""
    return [drive_lap(paper_drive(wheel_loop=loop, **NOISE), key=key) for key in range(seeds)]


def steady_state_m(laps: Sequence[Lap]) -> Floats:
    """Return the RMS position error in the last ``LAST_S`` of each lap."""
    return np.array([np.sqrt(np.mean(_late(lap.position_m, lap) ** 2)) for lap in laps])


def steady_state_ratio(fuzzy: Sequence[Lap], fixed: Sequence[Lap]) -> Estimate:
    """Estimate the ratio of two controllers' steady-state errors, paired by noise seed."""
    ratios = steady_state_m(fuzzy) / steady_state_m(fixed)
    draws = scenario_draws(np.zeros(len(ratios)), np.random.default_rng(0))
    return bootstrap_mean(ratios, draws)


def noisy(laps: Sequence[Lap]) -> Noisy:
    """Summarize laps with noise."""
    position = np.array([_late(lap.position_m, lap) for lap in laps])
    angle = np.array([_late(lap.angle_rad, lap) for lap in laps])
    columns = dict(zip(Figures._fields, np.array([figures(lap) for lap in laps]).T, strict=True))
    columns["position_left_m"] = steady_state_m(laps)
    columns["angle_left_rad"] = np.sqrt(np.mean(angle**2, axis=1))
    return Noisy(
        len(laps),
        {name: _spread(values) for name, values in columns.items()},
        float(np.mean(position.max(axis=1) >= BAND)),
        float(np.mean(angle.max(axis=1) >= BAND)),
    )


def _late(error: Floats, lap: Lap) -> Floats:
    late: Floats = error[lap.time_s > lap.time_s[-1] - LAST_S]
    return late


def _spread(values: Floats) -> Spread:
    return Spread(*(float(value) for value in np.quantile(values, (0.05, 0.5, 0.95))))
