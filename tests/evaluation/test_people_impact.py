"""Costs of the robot to people, by hand and in worlds where it makes no difference."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.social_force import SocialForce, elliptical_repulsion
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import clearances, distances
from hazbot_gym.evaluation.people_impact import burden
from hazbot_gym.evaluation.rollout import make_env, resolve, run_episode
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import make
from tests.evaluation.test_encounters import DT, R_I, R, drive, walker

BLIND = {"reactions": [{"gain": 1.0, "range_m": 0.0, "attraction_mps2": 0.0}] * 4}
SEEDS = [3, 4, 5]


def taken(episode: Episode) -> dict[str, Any]:
    return burden(episode, clearances(episode, distances(episode)))


def gone_from(person: Any, instant: int) -> Any:
    person[instant:] = np.nan
    return person


def test_people_are_hurried_if_they_accelerate_more_near_the_robot() -> None:
    calm, near = walker(30.0, 0.0, 1.0, 0.0), walker(2.0, 1.0, 0.0, 0.0)
    near[:, 3] = 0.05 * (np.arange(61) % 2)  # changes by 0.05 m/s in every 0.1 s
    assert taken(drive(np.stack([calm, near], axis=1)))["people_hurried_mps2"] == pytest.approx(0.5)


def test_delay_and_detour_by_hand() -> None:
    met = [
        gone_from(walker(0.0, 2.0, 1.0, 0.0), 40),  # a second longer and 1 m farther than alone
        gone_from(walker(0.0, 3.0, 0.5, 0.0), 20),  # as long, at half the speed
        walker(0.0, 4.0, 1.0, 0.0),  # still there at the end
    ]
    alone = [
        gone_from(walker(0.0, 2.0, 1.0, 0.0), 30),
        gone_from(walker(0.0, 3.0, 1.0, 0.0), 20),
        gone_from(walker(0.0, 4.0, 1.0, 0.0), 10),
    ]
    episode = drive(np.stack(met, axis=1))
    row = taken(episode._replace(people_alone=np.stack(alone, axis=1)[..., :2]))
    assert row["person_delay_s"] == pytest.approx(1.0 + 0.0 + 5.1)  # of the last, until the end
    assert row["people_detour_m"] == pytest.approx((1.0 - 0.5 * 1.9) / 2)


def test_social_work_is_the_push_on_everybody_and_back() -> None:
    force, standing = SocialForce(), walker(3.0, 0.0, 0.0, 0.0, instants=2)
    row = taken(drive(np.stack([standing], axis=1)))
    gap = 3.0 - 0.5 * DT - R - R_I
    f = elliptical_repulsion(
        1.0, 0.0, gap, force.robot_step_time_s * 0.5, 0.0,
        force.robot_strength_mps2, force.robot_range_m,
    )  # fmt: skip
    assert row["social_work_mps"] == pytest.approx(2 * np.hypot(*f) * DT)
    # Two who push from both sides push each other's force away from the robot.
    ahead, behind = (walker(x, 0.0, 0.5, 0.0, instants=2) for x in (2.0, -2.0))
    both = taken(drive(np.stack([ahead, behind], axis=1)))["social_work_mps"]
    assert both == pytest.approx(taken(drive(np.stack([ahead], axis=1)))["social_work_mps"])


def test_nobody_is_burdened_where_nobody_is() -> None:
    row = taken(drive(np.zeros((5, 0, 4))))
    assert row["social_work_mps"] == row["person_delay_s"] == 0.0
    assert np.isnan(row["people_detour_m"])


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
@pytest.mark.parametrize("people", [{"model": "scripted"}, BLIND])
def test_who_does_not_notice_the_robot_walks_as_without_it(
    engine: str, people: dict[str, Any]
) -> None:
    for episode in episodes(engine, "Encountering", people):
        assert np.isfinite(episode.people).any()
        # at a contact, the last decision ends early
        whole = slice(-1 if episode.outcome.startswith("contact") else None)
        met, alone = episode.people[whole, :, :2], episode.people_alone[whole]
        np.testing.assert_allclose(met, alone, atol=1e-9)
        assert taken(episode)["person_delay_s"] == 0.0


def test_who_yields_to_a_robot_in_the_way_is_late() -> None:
    delays_s = [taken(each)["person_delay_s"] for each in episodes("batched", "Crossing", {})]
    assert max(delays_s) > 0.1


def test_a_recording_is_played_as_it_is() -> None:
    for episode in episodes("batched", "Replay", {}):
        assert np.isnan(episode.people_alone).all()
        assert np.isnan(taken(episode)["person_delay_s"])


def episodes(engine: str, preset: str, people: dict[str, Any]) -> list[Episode]:
    scenarios = ScenarioSet(
        name=preset, env=f"hazbot_gym/{preset}-v1", overrides={"people": people} if people else {}
    )
    policy = make("constant")
    if engine == "pymunk":
        env = make_env(scenarios)
        return [run_episode(env, policy, seed)[0] for seed in SEEDS[:1]]
    config, limit = resolve(scenarios)
    runs = batch_rollout.run_episodes(config, policy, SEEDS, limit=limit, threads=1)
    return [episode for episode, _ in runs]
