"""Encounter metrics: proxemics, time to collision, required deceleration, post-encroachment time.

Symbols as in ``metrics.py``; w_i is the velocity of person i relative to the robot. Minima are
infinite if no person was present or on a collision course.
"""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.post_encroachment import post_encroachment_time
from hazbot_gym.core.state import Floats
from hazbot_gym.core.ttc import time_to_collision
from hazbot_gym.evaluation.episode import RADIUS, VX, VY, Episode, X, Y

CRITICAL_TTC_S = 1.5  # Hyden 1987
WALKING_MPS = 0.1  # median speed below which a person counts as standing
COMPLIANCE_M = (0.45, 0.5, 1.0, 1.2)  # SocNavGym, Francis et al. 2023, Habitat, Hall

Row = dict[str, float | int | str]


def proxemics(d: Floats) -> Row:
    """Measure the share of time with no person closer than a limit, by centre distance d.

    ``compliance_050`` is that of 0.50 m, and likewise for the other limits.
    """
    nearest = d[1:].min(axis=1)
    return {
        f"compliance_{round(100 * limit):03d}": float((nearest >= limit).mean())
        for limit in COMPLIANCE_M
    }


def encounters(episode: Episode, c: Floats) -> Row:
    """Measure time to collision, required deceleration, and post-encroachment time.

    ``ttc_min_s``: least time until robot and person touch if both keep their velocities.
    ``ttc_exposed_s``: ``TET = sum dt 1[TTC < 1.5 s]`` (Minderhoud and Bovy 2001).
    ``drac_max_mps2``: ``max u_i^2 / (2 c_i)`` with closing speed u_i >= 0, while clear.
    ``drac_share``: share of instants at which this value exceeds the drive's deceleration.
    ``post_encroachment_s``: see ``post_encroachment_s``.
    """
    if episode.people.shape[1] == 0:
        return {
            "ttc_min_s": np.inf,
            "ttc_exposed_s": 0.0,
            "drac_max_mps2": 0.0,
            "drac_share": 0.0,
            "post_encroachment_s": np.inf,
        }
    dt, ttc = np.diff(episode.time_s), times_to_collision(episode)
    drac = _required_deceleration(episode, c)
    return {
        "ttc_min_s": float(ttc.min()),
        "ttc_exposed_s": float((ttc[1:].min(axis=1) < CRITICAL_TTC_S) @ dt),
        "drac_max_mps2": float(drac.max()),
        "drac_share": float((drac[1:].max(axis=1) > episode.deceleration_mps2).mean()),
        "post_encroachment_s": post_encroachment_s(episode),
    }


def times_to_collision(episode: Episode) -> Floats:
    """Return the time to collision with each person (T + 1, K) [s], infinite where absent."""
    if episode.people.shape[1] == 0:
        return np.full((len(episode.time_s), 1), np.inf)
    px, py, wx, wy = _relative(episode)
    reach = episode.people[..., RADIUS] + episode.robot_radius_m
    return np.where(np.isnan(px), np.inf, time_to_collision(px, py, wx, wy, reach))


def post_encroachment_s(episode: Episode) -> float:
    """Return the least post-encroachment time over walking people; infinite if paths never cross.

    The time from the robot or the person leaving a place to the other's arrival there:
    ``core/post_encroachment.py``.
    """
    least = np.inf
    for person in np.moveaxis(episode.people, 1, 0):
        there = np.isfinite(person[:, X])
        seen = person[there]
        if len(seen) and np.median(np.hypot(seen[:, VX], seen[:, VY])) > WALKING_MPS:
            reach = float(seen[0, RADIUS]) + episode.robot_radius_m
            way = np.ascontiguousarray(seen[:, [X, Y, VX, VY]])
            times_s = episode.time_s[there]
            apart = post_encroachment_time(episode.time_s, episode.pose, times_s, way, reach)
            least = min(least, apart)
    return least


def _relative(episode: Episode) -> tuple[Floats, Floats, Floats, Floats]:
    """Return each person's position and velocity relative to the robot, each (T + 1, K)."""
    heading, v = episode.pose[:, 2:], episode.speed_mps[:, None]
    people = episode.people
    return (
        people[..., X] - episode.pose[:, :1],
        people[..., Y] - episode.pose[:, 1:2],
        people[..., VX] - v * np.cos(heading),
        people[..., VY] - v * np.sin(heading),
    )


def _required_deceleration(episode: Episode, c: Floats) -> Floats:
    """Return ``max(u_i, 0)^2 / (2 c_i)`` [m/s^2], (T + 1, K); 0 where absent or touching."""
    px, py, wx, wy = _relative(episode)
    with np.errstate(divide="ignore", invalid="ignore"):
        closing = np.maximum(-(px * wx + py * wy) / np.hypot(px, py), 0.0)
        required = closing**2 / (2.0 * c)
    return np.where(np.isfinite(required) & (c > 0.0), required, 0.0)
