"""Synthetic recording, so that replay works without external data.

People walk through a corridor on lanes, on the right-hand side, and queue behind slower people. The
lanes leave just enough room for a robot in the middle.
"""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.task.tracks import Corridor, Recording

LENGTH_M, WIDTH_M = 12.0, 3.0
PEOPLE = 25
DT_S = 0.1
LANES_M = (0.65, 1.15)  # from the middle line; the robot there is 0.30 m, a person 0.20 m in radius
SPEED_MPS, SPEED_SD_MPS = 1.34, 0.26  # Weidmann 1993, the usual free walking speed
SLOWEST_MPS, FASTEST_MPS = 0.7, 2.0  # bounds
SWAY_M, SWAY_HZ = 0.04, 0.5  # of the body's lateral sway; a stride takes two steps
LAST_ENTRY_S, HORIZON_S = 50.0, 90.0  # everyone has left long before the horizon
SMALLEST_GAP_M, HEADWAY_S = 0.8, 0.8  # minimum gap, and time headway


def synthetic_recording(seed: int = 0) -> Recording:
    """Return people walking both ways through a corridor along x, 12 m long and 3 m wide.

    25 people enter in a Poisson process, with truncated normal speeds, and keep at least 0.4 m
    apart.
    """
    rng = np.random.default_rng(seed)
    entries = np.sort(rng.uniform(0.0, LAST_ENTRY_S, PEOPLE))  # Poisson, given their number
    speeds = np.clip(rng.normal(SPEED_MPS, SPEED_SD_MPS, PEOPLE), SLOWEST_MPS, FASTEST_MPS)
    phases = rng.uniform(0.0, 2.0 * math.pi, PEOPLE)
    lanes = rng.integers(0, 4, PEOPLE)
    ahead: dict[int, Floats] = {}
    firsts, tracks = [], []
    for entry, speed, phase, lane in zip(entries, speeds, phases, lanes, strict=True):
        walked = _walk(entry, speed, ahead.get(lane))
        ahead[lane] = walked
        is_inside = (walked >= 0.0) & (walked <= LENGTH_M)
        firsts.append(int(np.argmax(is_inside)))
        tracks.append(_on_lane(walked[is_inside], phase, lane))
    return Recording(
        name="synthetic",
        dt_s=DT_S,
        ids=np.arange(1, PEOPLE + 1),
        first_steps=np.array(firsts) - min(firsts),
        lengths=np.array([len(track) for track in tracks]),
        positions=np.concatenate(tracks),
        walls=np.array([[0.0, y, LENGTH_M, y] for y in (-WIDTH_M / 2, WIDTH_M / 2)]),
        corridor=Corridor("x", (0.0, LENGTH_M), (-WIDTH_M / 2, WIDTH_M / 2)),
        source="hazbot_gym.task.synthetic_tracks",
        licence="that of hazbot_gym",
    )


def _walk(entry_s: float, speed_mps: float, ahead: Floats | None) -> Floats:
    """Return the distance walked at every step, NaN before the entry [m].

    Free, or limited by the leader: v = clip((gap - smallest gap)/headway, 0, v0).
    """
    steps = round(HORIZON_S / DT_S)
    walked = np.full(steps, np.nan)
    first = math.ceil(entry_s / DT_S)
    if ahead is not None:  # keeps behind the leader
        first = max(first, int(np.argmax(ahead >= SMALLEST_GAP_M + HEADWAY_S * speed_mps)))
    walked[first] = 0.0
    for k in range(first + 1, steps):
        speed = speed_mps
        if ahead is not None:
            gap = ahead[k - 1] - walked[k - 1]
            speed = min(speed, max(0.0, (gap - SMALLEST_GAP_M) / HEADWAY_S))
        walked[k] = walked[k - 1] + speed * DT_S
    return walked


def _on_lane(walked: Floats, phase: float, lane: int) -> Floats:
    """Return positions (n, 2) on one of four lanes: 0 and 1 along x, 2 and 3 against it."""
    sway = SWAY_M * np.sin(2.0 * math.pi * SWAY_HZ * DT_S * np.arange(len(walked)) + phase)
    sideways = LANES_M[lane % 2] + sway
    if lane < 2:
        return np.stack([walked, -sideways], axis=1)
    return np.stack([LENGTH_M - walked, sideways], axis=1)
