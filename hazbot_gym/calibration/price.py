"""Price of nearness that recorded drives reveal, in seconds of delay per second of discomfort.

A drive costs, in seconds,

    J(p) = delay + p * felt,    felt = integral of D(t) min(v/v_n, 1)^2 dt

with the largest discomfort D of a person (``core/discomfort.py``), the speed v, and the nominal
speed v_n of the robot; the delay is the duration beyond that of the same way at v_n. Two estimates
of the price p:

break-even: compliant drives cost as much as noncompliant ones,

    p = (delay_c - delay_n) / (felt_n - felt_c),

    with means over drives of a scenario and robot, and the sum over these groups. Above this price
    the compliant drives are the better ones.

revealed: the speeds of a behaviour are nearest to the optimal ones. Where D does not depend on
    time, the optimal speed minimizes the cost per meter, 1/u + p D u with u = v/v_n:

    u = min(1, 1/sqrt(p D)),    c(p D) = 1 + p D if p D < 1, else 2 sqrt(p D).

    p minimizes the cost of the drives relative to that of the same ways at optimal speeds,
    sum (1 + p D u^2) dt / sum u c(p D) dt.

Intervals are percentiles of a bootstrap over drives, within each scenario, robot and behaviour.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.discomfort import discomfort, facing
from hazbot_gym.core.state import PERSON_RADIUS_M, Floats
from hazbot_gym.task.tracks import RecordedRobot, Recording
from hazbot_gym.utils.json_object import JsonObject

BEHAVIOURS = ("compliant", "noncompliant")
# Scenarios whose people block the way: the robot waits for room, whatever nearness costs.
BLOCKED = ("obstruction",)
STANDING_MPS = 0.05  # a robot whose nominal speed is less stands: it chooses no speed
NOMINAL_PERCENTILE = 90.0  # of the speeds of all drives of a robot
PRICES = tuple(float(price) for price in np.geomspace(0.25, 32.0, 113))
DRAWS, LEVEL = 1000, 0.95  # of the bootstrap

Group = tuple[str, str]  # scenario and robot


class Drive(NamedTuple):
    """A recorded drive among people."""

    group: Group
    behaviour: str
    dt_s: float
    delay_s: float
    felt_s: float  # seconds of full discomfort at nominal speed
    nearness: Floats  # (T,) largest discomfort of a person
    share: Floats  # (T,) speed relative to the nominal one, at most 1


def drives_of(recordings: Sequence[Recording]) -> list[Drive]:
    """Return the drives of all recordings with a moving robot, except blocked ones."""
    met = [
        (recording, recording.robot)
        for recording in recordings
        if recording.robot is not None and recording.robot.scenario not in BLOCKED
    ]
    speeds: dict[str, list[Floats]] = {}
    for recording, robot in met:
        speeds.setdefault(robot.name, []).append(_speeds(robot.positions, recording.dt_s))
    nominal_mps = {
        name: float(np.percentile(np.concatenate(each), NOMINAL_PERCENTILE))
        for name, each in speeds.items()
    }
    return [
        _drive(recording, robot, nominal_mps[robot.name])
        for recording, robot in met
        if nominal_mps[robot.name] > STANDING_MPS
    ]


def _drive(recording: Recording, robot: RecordedRobot, nominal_mps: float) -> Drive:
    length_m = float(np.linalg.norm(np.diff(robot.positions, axis=0), axis=1).sum())
    share = np.minimum(_speeds(robot.positions, recording.dt_s) / nominal_mps, 1.0)
    nearness = _nearness(recording, robot)
    return Drive(
        group=(robot.scenario, robot.name),
        behaviour=robot.behaviour,
        dt_s=recording.dt_s,
        delay_s=(len(robot.positions) - 1) * recording.dt_s - length_m / nominal_mps,
        felt_s=float(nearness @ share**2) * recording.dt_s,
        nearness=nearness,
        share=share,
    )


def _nearness(recording: Recording, robot: RecordedRobot) -> Floats:
    """Return the largest discomfort of a person at every step (T,)."""
    largest = np.zeros(len(robot.positions))
    for first, track in zip(recording.first_steps, recording.tracks(), strict=True):
        if len(track) < 2:
            continue
        velocities = np.gradient(track, recording.dt_s, axis=0)
        offsets = robot.positions[first : first + len(track)] - track
        clearances_m = np.hypot(*offsets.T) - robot.radius_m - PERSON_RADIUS_M
        for k, ((x, y), (vx, vy)) in enumerate(zip(offsets, velocities, strict=True), first):
            felt = discomfort(clearances_m[k - first], facing(x, y, vx, vy))
            largest[k] = max(largest[k], felt)
    return largest


def _speeds(positions: Floats, dt_s: float) -> Floats:
    speeds: Floats = np.linalg.norm(np.gradient(positions, dt_s, axis=0), axis=1)
    return speeds


def break_even(drives: Sequence[Drive]) -> float | None:
    """Return the price above which compliant drives cost less; None if they do not feel better."""
    strata: dict[Group, dict[str, list[tuple[float, float]]]] = {}
    for drive in drives:
        both = strata.setdefault(drive.group, {behaviour: [] for behaviour in BEHAVIOURS})
        if drive.behaviour in both:
            both[drive.behaviour].append((drive.delay_s, drive.felt_s))
    means = [
        [np.mean(both[behaviour], axis=0) for behaviour in BEHAVIOURS]
        for both in strata.values()
        if all(both.values())
    ]
    if not means:
        return None
    delay_s, felt_s = np.sum([compliant - other for compliant, other in means], axis=0)
    return float(-delay_s / felt_s) if felt_s < 0.0 else None


def costs(drives: Sequence[Drive]) -> Floats:
    """Return the cost of each drive, and of the same way at optimal speeds, by price: (N, 2, P)."""
    found = np.empty((len(drives), 2, len(PRICES)))
    for row, drive in zip(found, drives, strict=True):
        weight, u = np.outer(PRICES, drive.nearness), drive.share
        per_meter = np.where(weight < 1.0, 1.0 + weight, 2.0 * np.sqrt(weight))
        row[0] = np.sum(1.0 + weight * u**2, axis=1) * drive.dt_s
        row[1] = per_meter @ u * drive.dt_s
    return found


def excess(costs: Floats) -> Floats:
    """Return the cost of drives (N, 2, P) relative to that at optimal speeds, at least 1: (P,)."""
    driven, least = costs.sum(axis=0)
    ratio: Floats = driven / least
    return ratio


def revealed(costs: Floats) -> float:
    """Return the price at which the speeds of drives (N, 2, P) are nearest to the optimal ones."""
    return PRICES[int(excess(costs).argmin())]


def report(drives: Sequence[Drive], *, seed: int = 0) -> JsonObject | None:
    """Return both estimates with intervals; None unless there are drives of both behaviours."""
    tables = {
        behaviour: costs([drive for drive in drives if drive.behaviour == behaviour])
        for behaviour in BEHAVIOURS
    }
    if not all(map(len, tables.values())):
        return None
    rng, slow = np.random.default_rng(seed), tables[BEHAVIOURS[0]]
    compliant = [drive for drive in drives if drive.behaviour == BEHAVIOURS[0]]
    at_even = [break_even([drives[i] for i in _resampled(drives, rng)]) for _ in range(DRAWS)]
    at_best = [revealed(slow[_resampled(compliant, rng)]) for _ in range(DRAWS)]
    ratios = {behaviour: excess(table) for behaviour, table in tables.items()}
    return {
        "drives": len(drives),
        "level": LEVEL,
        "draws": DRAWS,
        "break_even": _estimate(break_even(drives), at_even),
        "revealed": _estimate(revealed(slow), at_best),
        "excess": [
            {"price": price, **{name: float(ratio[k]) for name, ratio in ratios.items()}}
            for k, price in enumerate(PRICES)
        ],
        "groups": [
            {"scenario": group[0], "robot": group[1], **_means(drives, group)}
            for group in sorted({drive.group for drive in drives})
        ],
    }


def _resampled(drives: Sequence[Drive], rng: np.random.Generator) -> list[int]:
    """Return indices drawn with replacement within each group and behaviour."""
    strata: dict[tuple[Group, str], list[int]] = {}
    for i, drive in enumerate(drives):
        strata.setdefault((drive.group, drive.behaviour), []).append(i)
    return [int(i) for _, each in sorted(strata.items()) for i in rng.choice(each, len(each))]


def _estimate(value: float | None, draws: Sequence[float | None]) -> JsonObject:
    tail = (1.0 - LEVEL) / 2.0
    known = [np.inf if draw is None else draw for draw in draws]
    bounds = np.quantile(known, (tail, 1.0 - tail), method="nearest")
    interval = [float(bound) if np.isfinite(bound) else None for bound in bounds]
    return {"value": value, "interval": interval}


def _means(drives: Sequence[Drive], group: Group) -> JsonObject:
    found: JsonObject = {}
    for behaviour in BEHAVIOURS:
        mine = [drive for drive in drives if (drive.group, drive.behaviour) == (group, behaviour)]
        found[behaviour] = {
            "drives": len(mine),
            "delay_s": float(np.mean([drive.delay_s for drive in mine])) if mine else None,
            "felt_s": float(np.mean([drive.felt_s for drive in mine])) if mine else None,
        }
    return found
