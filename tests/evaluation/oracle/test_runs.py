"""The best drives: exact where they can be, searched elsewhere, and what regret comes of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.open_loop import Plan
from hazbot_gym.evaluation.oracle.runs import OracleShard, run_oracle_shard
from hazbot_gym.evaluation.oracle.trajectory_search import Effort, search
from hazbot_gym.evaluation.rollout import resolve
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.evaluation.statistics.regret import regrets
from hazbot_gym.policies.base import make

QUIET = {
    "people": {"model": "scripted"},
    "drive": {"wheel_loop": "ideal", "wheel_noise_radps": 0.0, "heading_noise_rad": 0.0},
    "place_options": {"length_m": 5.0},
}
REACTING = ScenarioSet(name="Crossing", env="hazbot_gym/Crossing-v1")
SCRIPTED = ScenarioSet(name="quiet", env="hazbot_gym/Crossing-v1", overrides=QUIET)
EFFORT = Effort(worlds=12, rounds=3)


def returns_of(scenarios: ScenarioSet, policy: Any, seeds: list[int]) -> list[float]:
    config, limit = resolve(scenarios)
    runs = batch_rollout.run_episodes(config, policy, seeds, limit=limit, threads=1)
    return [float(episode.rewards.sum()) for episode, _ in runs]


def test_a_plan_plays_each_world_its_own_actions_and_then_the_last() -> None:
    plan = Plan(np.array([[-1.0, 0.0], [1.0, 0.5]]))
    observation, state, played = np.zeros((2, 3), np.float32), None, []
    for _ in range(3):
        actions, state = plan.predict(observation, state)
        played.append(actions[:, 0].tolist())
    assert played == [[-1.0, 1.0], [0.0, 0.5], [0.0, 0.5]]
    assert Plan(np.array([0.25])).predict(np.zeros(3, np.float32))[0].tolist() == [0.25]


def test_search_keeps_what_it_began_with_and_only_gets_better() -> None:
    config, _ = resolve(REACTING)
    starts = np.stack([np.full(config.max_episode_steps, value) for value in (0.0, 1.0)])
    values = [
        search(config, 7, starts, np.random.default_rng(1), Effort(12, rounds)).value
        for rounds in (0, 3, 6)
    ]
    assert values == sorted(values)
    assert values[0] == pytest.approx(
        max(returns_of(REACTING, Plan(start[None]), [7])[0] for start in starts)
    )
    again = search(config, 7, starts, np.random.default_rng(1), Effort(12, 6))
    assert again.value == values[-1]
    assert returns_of(REACTING, Plan(again.actions[None]), [7])[0] == pytest.approx(again.value)


def test_searched_drives_are_no_worse_than_the_policies_they_begin_with() -> None:
    specs = ("fuzzy_expert", "constant:0.5")
    rows = run_oracle_shard(OracleShard(REACTING, 0, 2, 5, specs, EFFORT))
    assert [row["is_exact"] for row in rows] == [0, 0]
    for spec in specs:
        mine = returns_of(REACTING, make(spec), [int(row["seed"]) for row in rows])
        assert all(row["bound"] >= value - 1e-9 for row, value in zip(rows, mine, strict=True))
    assert all(row["bound"] == pytest.approx(row["return"]) for row in rows)


def test_exact_drives_earn_their_bound_and_nobody_earns_more() -> None:
    (row,) = run_oracle_shard(OracleShard(SCRIPTED, 0, 1, 5, ("fuzzy_expert",), EFFORT))
    assert row["is_exact"] == 1
    assert row["return"] == pytest.approx(float(row["bound"]), abs=1e-5)
    for spec in ("fuzzy_expert", "constant:0.5", "constant:1.0", "ssm"):
        (value,) = returns_of(SCRIPTED, make(spec), [int(row["seed"])])
        assert value <= float(row["bound"]) + 1e-5


def table(policy: str, returns: Any, times: Any) -> pd.DataFrame:
    scores = np.atleast_2d(returns)
    return pd.DataFrame(
        {
            "policy": policy,
            "scenario_set": "a",
            "episode": np.tile(np.arange(scores.shape[1]), len(scores)),
            "training_seed": np.repeat(np.arange(len(scores)), scores.shape[1]),
            "return": scores.ravel(),
            "delay_s": np.atleast_2d(times).ravel(),
        }
    )


def test_regret_and_delay_are_worked_out_against_the_oracle_of_the_same_scenario() -> None:
    best = pd.DataFrame(
        {
            "scenario_set": "a",
            "episode": [0, 1],
            "bound": [10.0, 20.0],
            "delay_s": [1.0, 1.2],
            "discomfort_s": [0.0, 0.1],
        }
    )
    rows = pd.concat(
        [
            table("expert", [8.0, 14.0], [1.4, 1.8]),  # regrets 2, 6; delays 0.4, 0.6
            table("constant:0.5", [0.0, 10.0], [2.0, 2.0]),  # behind by 10, 10
            table("learner", [[9.0, 18.0], [9.0, 16.0]], [[1.2, 1.4], [1.2, 1.4]]),
        ]
    )
    names = ("expert", "constant:0.5", "learner")
    interval: Any = {"resamples": 200, "confidence": 0.95, "seed": 0}
    found = regrets(rows, best, names, **interval)
    assert found["constant"] == "constant:0.5"
    assert found["best"]["bound"] == 15.0
    learner, expert = found["policies"]["learner"], found["policies"]["expert"]
    assert learner["regret"].mean == pytest.approx((1 + 2 + 1 + 4) / 4)
    assert learner["regret"].low <= 2.0 <= learner["regret"].high
    assert learner["normalised"].mean == pytest.approx(1 - 2.0 / 10.0)
    assert learner["avoidable_delay_s"].mean == pytest.approx(0.2)
    assert expert["avoidable_delay_s"].mean == pytest.approx(0.5)
    assert found["policies"]["constant:0.5"]["normalised"] == (0.0, 0.0, 0.0)
