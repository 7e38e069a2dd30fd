"""Impact on people: delay, detour, acceleration and social work.

The reference is the counterfactual scenario without the robot (``without_robot.py``), compared
person by person until the episode ends.
"""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.core.social_force import SocialForce, elliptical_repulsion
from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.episode import RADIUS, VX, VY, Episode, X, Y

NEAR_M, FAR_M = SOCIAL_M, 2 * SOCIAL_M  # distances at which people's accelerations are compared
LEAST_GAP_M = 0.01  # between surfaces, as in the simulation


def burden(episode: Episode, c: Floats) -> Row:
    """Measure people's delay, detour and extra acceleration, and social work.

    ``person_delay_s``: person-seconds ``sum_i t_i - t_i0``, with t_i the time at which person i
        leaves, at most the end of the episode, and t_i0 the same without the robot. NaN if people
        are replayed.
    ``people_detour_m``: mean path length of person i minus the length without the robot. NaN if no
        person leaves.
    ``people_hurried_mps2``: mean |acceleration| of people within 3.6 m minus the mean beyond 7.2 m.
    ``social_work_mps``: see ``social_work``.
    """
    if episode.people.shape[1] == 0:
        nothing = dict.fromkeys(("people_detour_m", "people_hurried_mps2"), np.nan)
        return {"person_delay_s": 0.0, **nothing, "social_work_mps": 0.0}
    dt = np.diff(episode.time_s)
    force = SocialForce()
    return {
        **_delay_and_detour(episode),
        "people_hurried_mps2": _hurried(episode, c, dt),
        "social_work_mps": social_work(
            dt, episode.pose, episode.speed_mps, episode.people, episode.robot_radius_m,
            force.robot_step_time_s, force.robot_strength_mps2, force.robot_range_m,
        ),
    }  # fmt: skip


def _delay_and_detour(episode: Episode) -> Row:
    """Compare people with themselves without the robot; NaN without any person to compare."""
    met, alone = episode.people[..., [X, Y]], episode.people_alone
    both = [np.isfinite(each[..., 0]) for each in (met, alone)]
    is_known = np.all([there.any(axis=0) for there in both], axis=0)
    is_replayed = both[0].any() and not is_known.any()
    has_left = is_known & np.all([~there[-1] for there in both], axis=0)
    last_s, last_alone_s = (_last(there, episode.time_s)[is_known] for there in both)
    detour = (_ways_m(met) - _ways_m(alone))[has_left]
    return {
        "person_delay_s": np.nan if is_replayed else float((last_s - last_alone_s).sum()),
        "people_detour_m": float(detour.mean()) if has_left.any() else np.nan,
    }


def _last(is_there: Floats, time_s: Floats) -> Floats:
    """Return the last time at which each person is present, (K,) [s]."""
    last: Floats = np.where(is_there, time_s[:, None], -np.inf).max(axis=0)
    return last


def _ways_m(where: Floats) -> Floats:
    """Return the path length of each person, (K,) [m], from positions (T + 1, K, 2)."""
    ways: Floats = np.nansum(np.hypot(*np.moveaxis(np.diff(where, axis=0), -1, 0)), axis=0)
    return ways


def _hurried(episode: Episode, c: Floats, dt: Floats) -> float:
    """Return people's mean acceleration near the robot minus far from it [m/s^2]."""
    velocity = episode.people[..., (VX, VY)]
    a = np.hypot(*np.moveaxis(np.diff(velocity, axis=0) / dt[:, None, None], -1, 0))
    known, between = np.isfinite(a), c[1:]
    near, far = a[known & (between < NEAR_M)], a[known & (between > FAR_M)]
    return float(near.mean() - far.mean()) if near.size and far.size else np.nan


@kernel
def social_work(
    dt_s: Floats, pose: Floats, speed_mps: Floats, people: Floats, robot_radius_m: float,
    step_time_s: float, strength_mps2: float, range_m: float,
) -> float:  # fmt: skip
    """Return ``sum_t (|sum_i f_i| + sum_i |f_i|) dt`` [m/s], after HuNavSim's social work.

    f_i is the repulsion of the robot from person i (``core.social_force.elliptical_repulsion``, in
    all directions alike); the first term is the total reaction on the robot. This is a diagnostic
    only, since the simulated people follow the same forces.

    Args:
        dt_s: (T,) steps.
        pose: (T + 1, 3) of the robot: x, y [m], heading [rad].
        speed_mps: (T + 1,) of the robot.
        people: (T + 1, K, 5) as in ``Episode``.
        robot_radius_m: Radius of the robot.
        step_time_s: Anticipation time of a step [s].
        strength_mps2: V0/sigma.
        range_m: sigma.
    """
    work = 0.0
    for t in range(1, len(pose)):
        x, y, heading = pose[t]
        vx, vy = speed_mps[t] * math.cos(heading), speed_mps[t] * math.sin(heading)
        on_robot_x, on_robot_y, on_people = 0.0, 0.0, 0.0
        for i in range(people.shape[1]):
            person = people[t, i]
            rx, ry = person[X] - x, person[Y] - y
            distance = math.hypot(rx, ry)
            if not distance > 0.0:  # absent, or no direction of the force
                continue
            gap = max(distance - robot_radius_m - person[RADIUS], LEAST_GAP_M)
            sx, sy = step_time_s * (vx - person[VX]), step_time_s * (vy - person[VY])
            fx, fy = elliptical_repulsion(
                rx / distance, ry / distance, gap, sx, sy, strength_mps2, range_m
            )
            on_robot_x, on_robot_y = on_robot_x - fx, on_robot_y - fy
            on_people += math.hypot(fx, fy)
        work += (math.hypot(on_robot_x, on_robot_y) + on_people) * dt_s[t - 1]
    return work
