"""Metrics of one recorded episode: a flat row of named numbers, the unit in each name.

Formulas and sources are in the docstrings. Symbols: time step dt, robot speed v, acceleration
a = dv/dt, jerk j = da/dt, clearance c_i (surface to surface) and centre distance d_i of person i,
time T, free time T_free. Sums run over the decision instants after the start, the last included.

These are proxies of safety and comfort; nobody rated these drives.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hazbot_gym.core.discomfort import discomfort, facing
from hazbot_gym.core.gas_sensor import reading_rate
from hazbot_gym.core.geometry import norm
from hazbot_gym.core.jit import kernel
from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, SOCIAL_M
from hazbot_gym.core.ssm import SsmThresholds, protective_distance
from hazbot_gym.core.state import ROBOT_MASS_KG, Floats
from hazbot_gym.evaluation.encounters import Row, encounters, proxemics, times_to_collision
from hazbot_gym.evaluation.episode import RADIUS, VX, VY, Episode, X, Y
from hazbot_gym.evaluation.people_impact import burden
from hazbot_gym.task.outcome import MOVING_MPS
from hazbot_gym.task.reward import motion
from hazbot_gym.task.step_record import DISCOMFORT

# What `hazbot eval --json` reports, in this order; the table shows the same.
HEADLINE = (
    "delay_s",
    "personal_m",
    "intimate_m",
    "person_delay_s",
    "contacts_per_km",
    "discomfort_s",
    "contact_person_caused",
    "arrived",
    "return",
)
# In environments with gas, after the others.
GAS_HEADLINE = (
    "leak_found",
    "false_alarms",
    "time_to_alarm_s",
    "leak_error_m",
    "leak_error_corrected_m",
)
# The one metric of several episodes, not of one: a ratio of two sums.
PER_KM, CONTACTS, DRIVEN = "contacts_per_km", "contact_robot_caused", "driven_m"
DEFAULT_SSM = SsmThresholds()
CALM_TTC_S = 5.0
PATCH_M = 1.0  # length of a patch of gas that an inspection should not miss; our choice
REVERSAL_MPS2 = 0.1
HARD_BRAKE = 0.8  # of the drive's deceleration
ROLLING, GRAVITY_MPS2 = 0.015, 9.81  # rubber on a hard floor


def measure(episode: Episode, ssm: SsmThresholds = DEFAULT_SSM) -> Row:
    """Return all metrics of an episode as one flat row."""
    d = distances(episode)
    c = clearances(episode, d)
    return {
        **_end(episode),
        **_duration(episode),
        **_standing(episode, c),
        **_nearness(episode, c),
        **proxemics(d),
        **encounters(episode, c),
        **burden(episode, c),
        **_separation(episode, c, ssm),
        **_smoothness(episode),
        **_energy(episode),
        **_tracking(episode),
        **_reward(episode),
        **_leak(episode),
        "ssm_profile": ssm.profile(),
    }


def distances(episode: Episode) -> Floats:
    """Return the centre distance d_i [m] to each person, (T + 1, K), infinite where absent."""
    if episode.people.shape[1] == 0:
        return np.full((len(episode.time_s), 1), np.inf)
    dx = episode.people[..., X] - episode.pose[:, :1]
    dy = episode.people[..., Y] - episode.pose[:, 1:2]
    d = np.hypot(dx, dy)
    return np.where(np.isnan(d), np.inf, d)


def clearances(episode: Episode, d: Floats) -> Floats:
    """Return the clearance c_i = d_i - R - R_i [m] to each person, infinite where absent."""
    if episode.people.shape[1] == 0:
        return d
    c = d - episode.robot_radius_m - episode.people[..., RADIUS]
    return np.where(np.isnan(c), np.inf, c)


def _end(episode: Episode) -> Row:
    """Measure the outcome: arrival, contact and its cause, timeout.

    A contact is robot-caused if the robot was driving and closed in faster than the person did; the
    simulation decides this at the contact (same criterion as SEAN 2.0 and HuNavSim). The robot was
    passive if it stood at the last instant before (Alami, Simeon and Krishna 2002).
    """
    contact = episode.outcome.startswith("contact")
    with_person = episode.outcome == "contact_person"
    stood = bool(abs(episode.speed_mps[-2:][0]) <= MOVING_MPS)
    return {
        "outcome": episode.outcome,
        "arrived": int(episode.outcome == "arrived"),
        "timeout": int(episode.outcome == "timeout"),
        "contact_robot_caused": int(with_person and episode.contact_caused_by == "robot"),
        "contact_person_caused": int(with_person and episode.contact_caused_by == "person"),
        "contact_wall": int(episode.outcome == "contact_wall"),
        "contact_passive": float(stood) if contact else float("nan"),
        "contact_speed_mps": episode.contact_speed_mps,
        "contact_energy_j": 0.5 * ROBOT_MASS_KG * episode.contact_speed_mps**2,
    }


def _duration(episode: Episode) -> Row:
    """Measure delay, time ratio, and success weighted by time.

    ``delay_s = T - T_free`` and ``time_ratio = T / T_free``, with T the horizon for every episode
    without arrival, so that a contact does not count as a short drive.
    ``stl = success * T_free / max(T, T_free)``.
    """
    time = float(episode.time_s[-1] - episode.time_s[0])
    arrived = episode.outcome == "arrived"
    counted = time if arrived else episode.horizon_s
    free = episode.time_free_s
    return {
        "steps": len(episode.rewards),
        "time_s": time,
        "time_free_s": free,
        "delay_s": counted - free,
        "time_ratio": counted / free,
        "stl": float(arrived) * free / max(time, free),
    }


def _standing(episode: Episode, c: Floats) -> Row:
    """Measure standing time, needless standing time, distance driven, and the inspected share.

    Standing is needless while no person is within 3.6 m and no contact is due within 5 s.
    ``inspected_share`` is the share of the path driven slowly enough for the gas sensor, at ``v <=
    l / tau_rise`` with a patch of gas of l = 1 m: the robot then is in the patch for at least one
    time constant of the sensor's rise, and the response reaches 1 - 1/e = 63 % of its steady value.
    """
    dt, v = np.diff(episode.time_s), np.abs(episode.speed_mps[1:])
    stands = v < MOVING_MPS
    is_clear = c[1:].min(axis=1) >= SOCIAL_M
    is_calm = times_to_collision(episode)[1:].min(axis=1) > CALM_TTC_S
    way_m = v * dt
    inspects = v <= PATCH_M / episode.sensor_rise_s
    return {
        "stalled_s": float(stands @ dt),
        "stalled_needlessly_s": float((stands & is_clear & is_calm) @ dt),
        "driven_m": float(way_m.sum()),
        "mean_speed_mps": float(v.mean()),
        "inspected_share": float(way_m[inspects].sum() / way_m.sum()) if way_m.any() else math.nan,
    }


def _nearness(episode: Episode, c: Floats) -> Row:
    """Measure minimum clearance, distance driven inside Hall's zones, and discomfort.

    ``personal_m`` and ``intimate_m``: distance driven while the nearest person is within 1.2 m and
    0.45 m, ``sum_t |v| dt 1[min_i c_i < 1.2]``. ``discomfort_s``: see ``felt_s``. A robot that
    waits beside a passing person adds to none of them. The clearance is infinite if no person was
    present.
    """
    dt = np.diff(episode.time_s)
    way_m = np.abs(episode.speed_mps[1:]) * dt
    nearest = c[1:].min(axis=1)
    return {
        "clearance_min_m": float(c.min()),
        "personal_m": float(way_m[nearest < PERSONAL_M].sum()),
        "intimate_m": float(way_m[nearest < INTIMATE_M].sum()),
        "discomfort_s": felt_s(
            dt, episode.pose, episode.speed_mps, episode.people, episode.robot_radius_m,
            episode.nominal_mps,
        ),
    }  # fmt: skip


@kernel
def felt_s(
    dt_s: Floats, pose: Floats, speed_mps: Floats, people: Floats, robot_radius_m: float,
    nominal_mps: float,
) -> float:  # fmt: skip
    """Return ``sum_t max_i D_i min(|v| / v_n, 1)^2 dt``, in seconds of full discomfort at v_n.

    With the rated discomfort D_i of person i: the reward's intrusion with ``nearness: discomfort``,
    integrated over time.

    Args:
        dt_s: (T,) steps.
        pose: (T + 1, 3) of the robot: x, y [m], heading [rad].
        speed_mps: (T + 1,) of the robot.
        people: (T + 1, K, 5) as in ``Episode``.
        robot_radius_m: Radius of the robot.
        nominal_mps: Nominal speed v_n.
    """
    felt = 0.0
    for t in range(1, len(pose)):
        largest = 0.0
        for i in range(people.shape[1]):
            x, y = pose[t, 0] - people[t, i, X], pose[t, 1] - people[t, i, Y]
            if not math.isnan(x):
                clearance_m = norm(x, y) - people[t, i, RADIUS] - robot_radius_m
                toward = facing(x, y, people[t, i, VX], people[t, i, VY])
                largest = max(largest, discomfort(clearance_m, toward))
        felt += largest * motion(speed_mps[t] / nominal_mps, DISCOMFORT) * dt_s[t - 1]
    return felt


def _separation(episode: Episode, c: Floats, ssm: SsmThresholds) -> Row:
    """Measure violations of speed and separation monitoring (SSM) over the moving steps.

    ``ssm_violation`` is the share of moving steps with min_i c_i < S_p(v), and
    ``ssm_shortfall_m`` the mean of max(S_p - c, 0) over them; both 0 if the robot never moves.
    """
    v = np.abs(episode.speed_mps[1:])
    moving = v > MOVING_MPS
    if not moving.any():
        return {"ssm_violation": 0.0, "ssm_shortfall_m": 0.0}
    nearest = c[1:].min(axis=1)[moving]
    shortfall = np.maximum(protective_distance(v[moving], ssm) - nearest, 0.0)
    return {
        "ssm_violation": float((shortfall > 0).mean()),
        "ssm_shortfall_m": float(shortfall.mean()),
    }


def _smoothness(episode: Episode) -> Row:
    """Measure root mean squares of acceleration and jerk, reversals, and hard brakes.

    ``a_k = (v_k+1 - v_k) / dt``, ``j_k = (a_k+1 - a_k) / dt``; 0 where an episode is too short. A
    reversal is a change of sign between accelerations beyond 0.1 m/s^2 (SocNavBench), a hard brake
    the onset of braking at more than 0.8 of the drive's deceleration.
    """
    dt = np.diff(episode.time_s)
    a = np.diff(episode.speed_mps) / dt
    j = np.diff(a) / dt[1:]
    signs = np.sign(a[np.abs(a) > REVERSAL_MPS2])
    is_hard = a < -HARD_BRAKE * episode.deceleration_mps2
    brakes = int((is_hard & ~np.concatenate([[False], is_hard[:-1]])).sum())
    way_m = float(np.abs(episode.speed_mps[1:]) @ dt)
    return {
        "rms_acceleration_mps2": _rms(a),
        "rms_jerk_mps3": _rms(j),
        "reversals_per_min": 60.0 * int((np.diff(signs) != 0).sum()) / float(dt.sum()),
        "hard_brakes_per_100m": 100.0 * brakes / way_m if way_m else 0.0,
    }


def _energy(episode: Episode) -> Row:
    """Measure the mechanical energy per metre [J/m] (SocNavBench's motion energy).

    ``sum (|m a v| + c_rr m g |v|) dt / way``, with the paper's 34 kg.
    """
    dt = np.diff(episode.time_s)
    a, v = np.diff(episode.speed_mps) / dt, np.abs(episode.speed_mps[1:])
    way_m = float(v @ dt)
    spent = ROBOT_MASS_KG * (np.abs(a) * v + ROLLING * GRAVITY_MPS2 * v) @ dt
    return {"energy_jpm": float(spent) / way_m if way_m else float("nan")}


def _tracking(episode: Episode) -> Row:
    """Measure cross-track error, RMS and largest, and RMS heading error.

    The pose error is given in the robot's frame; turned by theta_e into the reference's frame, its
    lateral part is the cross-track error: ``e = x_e sin(theta_e) + y_e cos(theta_e)``.
    """
    x_e, y_e, theta_e = episode.pose_error[1:].T
    cross_track = x_e * np.sin(theta_e) + y_e * np.cos(theta_e)
    return {
        "cross_track_rms_m": _rms(cross_track),
        "cross_track_max_m": float(np.abs(cross_track).max()),
        "heading_error_rms_rad": _rms(theta_e),
    }


def _reward(episode: Episode) -> Row:
    """Sum the return, every unweighted reward term, and the cost, undiscounted."""
    terms = {f"reward_{name}": float(values.sum()) for name, values in episode.reward_terms.items()}
    return {"return": float(episode.rewards.sum()), **terms, "cost": float(episode.costs.sum())}


def _leak(episode: Episode) -> Row:
    """Measure what the gas sensor's alarm told of the leak; nothing without gas.

    The leak is said to be where the filtered reading is largest, and corrected for the sensor's
    lag, where ``u = r + tau_rise dr/dt`` is largest, the reading that the sensor heads for. The
    errors are distances from the leak along the path, of leaks found only.
    """
    if not len(episode.gas):
        return {}
    smell, leak, end = episode.gas["smell"], episode.gas["leak"][-1], episode.gas[-1]
    is_there, is_found = leak["is_there"] == 1, end["is_reported"] == 1
    headed_for = smell["smooth"] + episode.sensor_rise_s * reading_rate(smell.view(np.recarray))
    peaks = np.array([smell["smooth"].argmax(), headed_for.argmax()])
    error_m, corrected_m = (
        np.abs(smell["s_m"][peaks] - leak["s_m"]) if is_found else np.full(2, np.nan)
    ).tolist()
    alarms = np.flatnonzero(smell["alarm"])
    return {
        "leak": int(is_there),
        "leak_found": float(is_found) if is_there else math.nan,
        "false_alarms": int(end["false_alarms"]),
        "time_to_alarm_s": float(episode.time_s[alarms[0]]) if len(alarms) else math.nan,
        "leak_error_m": error_m,
        "leak_error_corrected_m": corrected_m,
    }


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def means(rows: Sequence[Row]) -> dict[str, float | None]:
    """Return the headline metrics over rows, None if one is undefined in all rows.

    Those of gas are added if there is gas.

    Means over the rows that define them, but ``contacts_per_km``: contacts that the robot caused,
    all together, over the distance driven, all together.
    """
    shown = [*HEADLINE, *(GAS_HEADLINE if any("leak" in row for row in rows) else ())]
    names = [*shown, CONTACTS, DRIVEN]
    names.remove(PER_KM)
    columns = {name: np.array([row.get(name, np.nan) for row in rows], float) for name in names}
    found = {
        name: float(column[np.isfinite(column)].mean()) if np.isfinite(column).any() else None
        for name, column in columns.items()
    }
    driven_km = columns[DRIVEN].sum() / 1000.0
    found[PER_KM] = float(columns[CONTACTS].sum() / driven_km) if driven_km > 0.0 else None
    return {name: found[name] for name in shown}
