from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.state import GAS, records
from hazbot_gym.evaluation.encounters import encounters, post_encroachment_s, proxemics
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import clearances, distances

R, R_I, DT = 0.3, 0.2, 0.1


def drive(people: Any, speed_mps: float = 0.5) -> Episode:
    """A robot that drives along x from the origin, with people (T + 1, K, 4): x, y, vx, vy."""
    walkers = np.asarray(people, float)
    instants = len(walkers)
    time_s = DT * np.arange(instants)
    x = speed_mps * time_s
    return Episode(
        time_s=time_s,
        pose=np.column_stack([x, 0 * x, 0 * x]),
        speed_mps=np.full(instants, speed_mps),
        command_mps=np.full(instants, speed_mps),
        pose_error=np.zeros((instants, 3)),
        people=np.concatenate([walkers, np.full((*walkers.shape[:2], 1), R_I)], axis=-1),
        people_alone=walkers[..., :2],
        rewards=np.zeros(instants - 1),
        reward_terms={},
        costs=np.zeros(instants - 1),
        outcome="arrived",
        contact_caused_by="",
        contact_speed_mps=np.nan,
        time_free_s=1.0,
        horizon_s=10.0,
        robot_radius_m=R,
        deceleration_mps2=1.0,
        nominal_mps=0.5,
        sensor_rise_s=4.0,
        gas=records(GAS, 0),
    )


def walker(x: float, y: float, vx: float, vy: float, instants: int = 61) -> Any:
    t = DT * np.arange(instants)
    return np.column_stack([x + vx * t, y + vy * t, np.full_like(t, vx), np.full_like(t, vy)])


def met(*walkers: Any, speed_mps: float = 0.5) -> dict[str, Any]:
    episode = drive(np.stack(walkers, axis=1), speed_mps)
    return encounters(episode, clearances(episode, distances(episode)))


def test_time_to_collision_and_exposure_are_those_of_a_head_on_course() -> None:
    # 10 m apart, closing at 1.5 m/s, over 2 s: 9.5 m of clearance shrinks to 6.5 m.
    row = met(walker(10.0, 0.0, -1.0, 0.0, instants=21))
    assert row["ttc_min_s"] == pytest.approx(6.5 / 1.5)
    assert row["ttc_exposed_s"] == 0.0
    # Over 6 s it shrinks to 0.5 m: less than 1.5 s away from when 2.25 m are left, at 4.83 s.
    row = met(walker(10.0, 0.0, -1.0, 0.0))
    assert row["ttc_exposed_s"] == pytest.approx(1.2, abs=0.051)
    assert row["drac_max_mps2"] == pytest.approx(1.5**2 / (2 * 0.5))
    # More than 1 m/s^2 is required where less than 1.125 m are left, for 0.42 s.
    assert row["drac_share"] == pytest.approx(0.42 / 6, abs=0.02)


def test_who_walks_past_is_on_no_collision_course() -> None:
    assert met(walker(10.0, 0.6, -1.0, 0.0))["ttc_min_s"] == np.inf


def test_post_encroachment_is_the_time_between_two_at_the_place_where_they_cross() -> None:
    # The robot is at x = 2 after 4 s; the person crosses there, at its centre line after 1 s.
    # The discs, 0.5 m apart, overlap for places within 0.5 m: (0.5, 0.5) m/s against 1 m/s.
    person = walker(2.0, -1.0, 0.0, 1.0)
    gap = post_encroachment_s(drive(person[:, None]))
    pairs = [
        abs(t - u)
        for t in DT * np.arange(61)
        for u in DT * np.arange(61)
        if np.hypot(0.5 * t - 2.0, u - 1.0) < R + R_I
    ]
    assert gap == pytest.approx(min(pairs))
    assert 1.5 < gap < 3.0


def test_who_comes_towards_the_robot_does_not_cross_its_way() -> None:
    assert post_encroachment_s(drive(walker(4.0, 0.0, -0.5, 0.0)[:, None])) == np.inf


def test_limits_count_from_there_on() -> None:
    d = np.array([[9.0], [0.3], [0.5], [1.1], [2.0], [4.0], [1.2], [0.45], [3.6]])
    row = proxemics(d)
    assert row["compliance_045"] == pytest.approx(7 / 8)
    assert row["compliance_050"] == pytest.approx(6 / 8)
    assert row["compliance_100"] == pytest.approx(5 / 8)
    assert row["compliance_120"] == pytest.approx(4 / 8)


def test_where_nobody_is_nothing_is_met() -> None:
    episode = drive(np.zeros((5, 0, 4)))
    row = encounters(episode, clearances(episode, distances(episode)))
    assert row["ttc_min_s"] == row["post_encroachment_s"] == np.inf
    assert row["drac_max_mps2"] == row["ttc_exposed_s"] == 0.0
