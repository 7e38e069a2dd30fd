"""Fuzzy-PID and PID, tuned with equal budgets and compared over many plants.

The paper compares its fuzzy-PID with an untuned PID of the same initial gains. Here PID and
fuzzy-PID are tuned with the same search, number of laps and objective, on plant B alone, with gains
bounded by those that the paper's fuzzy-PID can reach. Then all four drive the circle on other
plants and under disturbances.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.core.fuzzy_pid import FuzzyPid
from hazbot_gym.core.pid import PidGains, Plant
from hazbot_gym.core.state import Floats
from hazbot_gym.paper.evolution import search
from hazbot_gym.paper.sections.circle.experiment import (
    NO_LOAD,
    NOISE,
    Figures,
    Load,
    drive_lap,
    figures,
    paper_drive,
)
from hazbot_gym.utils.json_object import JsonObject

REACH = 2.69  # of a fuzzy output on [-3, 3]
BASE, SPAN = PidGains(), FuzzyPid()
# The largest gains that the paper's fuzzy-PID reaches: kp, ki, kd.
MOST = np.array(
    [
        BASE.kp + SPAN.kp_span * REACH,
        BASE.ki + SPAN.ki_span * REACH,
        BASE.kd + SPAN.kd_span * REACH,
    ]
)
LOST_M = 1.0  # a position error beyond which a controller has diverged

Drive = JsonObject  # values of the config's drive section


def pid(gains: PidGains) -> Drive:
    """Return the drive with fixed gains."""
    return {"wheel_loop": "pid", "pid": gains._asdict()}


def fuzzy_pid(base: PidGains, fuzzy: FuzzyPid) -> Drive:
    """Return the drive with fuzzy gains."""
    return {"wheel_loop": "fuzzy_pid", "pid": base._asdict(), "fuzzy": fuzzy._asdict()}


def pid_of(shares: Floats) -> Drive:
    """Return the PID of three numbers in [0, 1]: each gain as a share of the largest allowed."""
    return pid(PidGains(*(float(gain) for gain in shares * MOST)))


def fuzzy_pid_of(shares: Floats) -> Drive:
    """Return the fuzzy-PID of six numbers in [0, 1].

    The first three are the initial gains as shares of the largest allowed, the others the rules'
    shares of the remaining range.
    """
    base = shares[:3] * MOST
    spans = [float(span) for span in shares[3:] * (MOST - base) / REACH]
    return fuzzy_pid(
        PidGains(*(float(gain) for gain in base)),
        FuzzyPid(kp_span=spans[0], ki_span=spans[1], kd_span=spans[2]),
    )


def objective(found: Figures, of_paper_pid: Figures) -> float:
    """Return the mean of the four figures, each relative to those of the paper's PID."""
    return float(np.mean(np.divide(found, of_paper_pid)))


def run(drive: Drive, plant: Plant | str = "B", **changes: Any) -> Figures:
    """Drive a lap with a controller on a plant and return its figures."""
    values = plant._asdict() if isinstance(plant, Plant) else plant
    return figures(drive_lap(paper_drive(plant=values, **drive), **changes))


class Tuned(NamedTuple):
    """A tuned controller."""

    drive: Drive
    objective: float
    laps: int  # driven in the search


def tune(
    controller_of: Callable[[Floats], Drive],
    size: int,
    *,
    generations: int,
    seed: int,
    room: float = 1.0,
) -> Tuned:
    """Tune a controller on plant B.

    Args:
        controller_of: Maps numbers in [0, room] to a drive.
        size: How many numbers.
        generations: Generations of the search; see ``evolution.search``.
        seed: Seed of the search.
        room: Gain bound of a PID, as a multiple of the largest gains.
    """
    of_paper_pid = run(pid(BASE))
    found = search(
        lambda shares: objective(run(controller_of(shares)), of_paper_pid),
        size,
        generations=generations,
        seed=seed,
        room=room,
    )
    return Tuned(controller_of(found.shares), found.cost, found.tries)


class Grid(NamedTuple):
    """The paper's fuzzy-PID against its PID by the four published figures, over plants."""

    plants: int
    kept: int  # on which both stay on the circle
    in_all: int  # of these: fuzzy-PID smaller in all four
    median_ratios: Figures


def grid(fuzzy: FuzzyPid = SPAN) -> Grid:
    """Compare on a grid of plants with matched wheels, undisturbed."""
    plants = [Plant(K=K, T1=T1, a=0.0) for K, T1 in itertools.product(GAINS, TIMES_S)]
    pairs = [(run(fuzzy_pid(BASE, fuzzy), plant), run(pid(BASE), plant)) for plant in plants]
    ratios = np.array(
        [np.divide(*pair) for pair in pairs if all(each.position_max_m <= LOST_M for each in pair)]
    )
    return Grid(
        len(plants),
        len(ratios),
        int((ratios < 1.0).all(axis=1).sum()),
        Figures(*(float(ratio) for ratio in np.median(ratios, axis=0))),
    )


# --- the sweep -----------------------------------------------------------------------------------

# Plants with and without mismatched wheels.
GAINS, TIMES_S, MISMATCHES = (0.2, 0.5, 1.0, 2.0, 5.0), (0.3, 1.0, 3.0, 10.0), (0.0, -0.25)
DISTURBANCES: dict[str, JsonObject] = {
    "none": {},
    "sensor noise": {"noise": True},
    "load": {"load": Load(20.0, 1.0)},  # after 20 s, 1 rad/s of 2.5
    "saturation": {"u_max": 10.0},
}


class Errors(NamedTuple):
    """Errors of a lap of the sweep; infinite if the robot was lost."""

    position_max_m: float
    angle_max_rad: float
    position_rms_m: float
    angle_rms_rad: float


def sweep(controllers: Mapping[str, Drive], *, every: int = 1) -> list[dict[str, object]]:
    """Drive all controllers on all plants under all disturbances; return a row for each lap.

    Args:
        controllers: By name.
        every: Use only every n-th plant.
    """
    plants = list(itertools.product(GAINS, TIMES_S, MISMATCHES))[::every]
    return [
        {"K": K, "T1": T1, "a": a, "disturbance": name, "controller": controller}
        | _errors(drive, Plant(K=K, T1=T1, a=a), **how)._asdict()
        for (K, T1, a) in plants
        for name, how in DISTURBANCES.items()
        for controller, drive in controllers.items()
    ]


def _errors(
    drive: Drive, plant: Plant, *, noise: bool = False, load: Load = NO_LOAD, u_max: float = 0.0
) -> Errors:
    levels = NOISE if noise else {}
    values = plant._replace(u_max=u_max)._asdict()
    lap = drive_lap(paper_drive(plant=values, **drive, **levels), load=load)
    if not np.isfinite(lap.position_m).all() or lap.position_m.max() > LOST_M:
        return Errors(np.inf, np.inf, np.inf, np.inf)
    return Errors(
        float(lap.position_m.max()),
        float(lap.angle_rad.max()),
        float(np.sqrt(np.mean(lap.position_m**2))),
        float(np.sqrt(np.mean(lap.angle_rad**2))),
    )


class Wins(NamedTuple):
    """Pairwise comparison of two controllers."""

    cases: int  # in which at least one of the two stays on the circle
    in_all: float  # share of these in which it is better in all four errors
    on_average: float  # share in which the mean ratio of the four errors is below 1
    median_ratio: float  # of the mean ratio, where both keep to the circle


def wins(rows: list[dict[str, object]], ours: str, theirs: str) -> Wins:
    """Compare two controllers over rows of a sweep; a lost robot counts as a loss."""
    a, b = (
        np.array(
            [[row[field] for field in Errors._fields] for row in rows if row["controller"] == name]
        )
        for name in (ours, theirs)
    )
    is_kept = np.isfinite(a[:, 0]) | np.isfinite(b[:, 0])
    a, b = a[is_kept], b[is_kept]
    both = np.isfinite(a[:, 0]) & np.isfinite(b[:, 0])
    ratios = np.where(np.isfinite(a[:, 0]), 0.0, np.inf)
    ratios[both] = np.mean(a[both] / b[both], axis=1)
    return Wins(
        cases=len(a),
        in_all=float(np.mean((a < b).all(axis=1))),
        on_average=float(np.mean(ratios < 1.0)),
        median_ratio=float(np.median(ratios[both])),
    )


def lost(rows: list[JsonObject], controller: str) -> int:
    """Return the number of cases in which a controller left the circle by more than ``LOST_M``."""
    rows = [row for row in rows if row["controller"] == controller]
    return sum(1 for row in rows if np.isinf(row["position_max_m"]))
