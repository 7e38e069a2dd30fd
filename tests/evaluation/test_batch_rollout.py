from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.state import GAS
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.batch_rollout import run_episodes
from hazbot_gym.evaluation.rollout import (
    Shard,
    evaluate,
    make_env,
    resolve,
    run_episode,
    run_shard,
)
from hazbot_gym.evaluation.scenario_set import DEFAULT_SETS, ScenarioSet
from hazbot_gym.policies.constant import Constant
from tests.refusals import refused

REPLAYS = tuple(
    ScenarioSet(name=model, env="hazbot_gym/Replay-v1", overrides={"people": {"model": model}})
    for model in ("replay", "seeded")
)
INSPECTION = ScenarioSet(
    name="inspection", env="hazbot_gym/Inspection-v1", overrides={"gas": {"leak_share": 1.0}}
)


class Slower:
    """A policy with an inner state: the speed falls from decision to decision."""

    def __init__(self) -> None:
        self.starts: list[Any] = []

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, **_: Any
    ) -> Any:
        n = len(observation)
        state = np.zeros(n) if state is None else state + 0.01 * np.arange(n)
        self.starts.append(episode_start.tolist())
        return np.maximum(1.0 - state[:, None], -1.0), state


class OneAtATime:
    def predict(self, observation: Any, state: Any = None, **_: Any) -> Any:
        return np.array([1.0 if observation[0] > 0.5 else 0.0], np.float32), state


class NanLater:
    """A policy that answers NaN once an episode has begun."""

    def predict(self, observation: Any, state: Any = None, **_: Any) -> Any:
        later = np.nan if state is not None else 0.0
        return np.full((*np.shape(observation)[:-1], 1), later), 1


class FailsLater:
    def predict(self, observation: Any, state: Any = None, **_: Any) -> Any:
        return np.zeros((*np.shape(observation)[:-1], 1)) / {None: 1.0}[state], 1


class OneAnswer:
    def predict(self, observation: Any, state: Any = None, **_: Any) -> Any:
        return np.ones(1, np.float32), state


@pytest.fixture
def mine(monkeypatch: pytest.MonkeyPatch) -> None:
    """A module with the policies of this file."""
    module = ModuleType("mine")
    kinds = (Slower, OneAtATime, OneAnswer, NanLater, FailsLater)
    module.__dict__.update({kind.__name__: kind for kind in kinds})
    monkeypatch.setitem(sys.modules, "mine", module)


@pytest.mark.parametrize("policy", ["fuzzy_expert", "constant:1.0"])
@pytest.mark.parametrize(
    "scenarios", [*DEFAULT_SETS[::2], *REPLAYS, INSPECTION], ids=lambda s: s.name
)
def test_both_engines_give_the_same_rows(scenarios: ScenarioSet, policy: str) -> None:
    shard = Shard(policy, scenarios, first=2, episodes=3, seed=7)
    batched = run_shard(shard, threads=2)
    reference = run_shard(shard._replace(engine="pymunk"))
    for row, expected in zip(batched, reference, strict=True):
        assert row.keys() == expected.keys()
        for name, value in expected.items():
            near = value if isinstance(value, str) else pytest.approx(value, abs=1e-6, nan_ok=True)
            assert row[name] == near, name


def test_rounds_of_worlds_change_no_row(monkeypatch: pytest.MonkeyPatch) -> None:
    shard = Shard("constant:1.0", DEFAULT_SETS[4], first=0, episodes=5, seed=7)
    whole = run_shard(shard)
    monkeypatch.setattr(batch_rollout, "MOST_WORLDS", 2)  # two rounds and a half
    np.testing.assert_equal(run_shard(shard), whole)


def test_a_policy_gets_its_state_back_and_is_told_where_episodes_start() -> None:
    config, limit = resolve(DEFAULT_SETS[0])
    policy = Slower()
    episodes = list(run_episodes(config, policy, [1, 2, 3], limit=limit, threads=1))
    assert policy.starts[0] == [True] * 3
    assert not np.any(policy.starts[1:])
    for i, (episode, _) in enumerate(episodes):
        np.testing.assert_allclose(
            episode.command_mps[1:6], 0.5 * (1.0 - 0.5 * 0.01 * i * np.arange(5)), atol=1e-6
        )


def test_an_episode_ends_where_its_own_world_does() -> None:
    config, limit = resolve(DEFAULT_SETS[8])
    runs = run_episodes(config, Constant(1.0), list(range(8)), limit=limit, threads=1)
    lengths = set()
    for episode, labels in runs:
        steps = len(episode.rewards)
        lengths.add(steps)
        assert len(episode.time_s) == len(episode.pose) == len(episode.people) == steps + 1
        np.testing.assert_allclose(np.diff(episode.time_s), 0.1)
        assert set(labels) == {"scenario_key", "place", "scenario_hash"}
    assert len(lengths) > 1


def test_gas_of_an_episode_is_that_of_every_instant_in_both_engines() -> None:
    sensor = {"rise_s": 1.25, "decay_s": 4.0, "half_ppm": 5.0, "exponent": 0.5}
    scenarios = INSPECTION.model_copy(
        update={"overrides": {"gas": {"leak_share": 1.0, "sensor": sensor}}}
    )
    config, limit = resolve(scenarios)
    runs = run_episodes(config, Constant(0.8), [3, 4], limit=limit, threads=1)
    env = make_env(scenarios)
    for (batched, _), seed in zip(runs, (3, 4), strict=True):
        alone, _ = run_episode(env, Constant(0.8), seed=seed)
        assert len(alone.gas) == len(batched.gas) == len(alone.time_s) == len(batched.time_s)
        assert alone.sensor_rise_s == batched.sensor_rise_s == 1.25
        for part in ("leak", "smell"):
            for name in GAS[part].names or ():
                mine, other = batched.gas[part][name], alone.gas[part][name]
                np.testing.assert_allclose(mine, other, atol=1e-6, err_msg=name)
        assert np.ptp(alone.gas["smell"]["reading"]) > 0.1


def test_an_episode_without_gas_has_none() -> None:
    config, limit = resolve(DEFAULT_SETS[0])
    for episode, _ in run_episodes(config, Constant(1.0), [1], limit=limit, threads=1):
        assert len(episode.gas) == 0


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("OneAtATime", "ValueError"),
        ("OneAnswer", "(1,)"),
    ],
)
def test_a_policy_that_cannot_act_on_stacks_is_refused_in_a_line_and_runs_on_pymunk(
    name: str, complaint: str, mine: None
) -> None:
    where = {"scenario": "E*", "max_episode_steps": 3}
    with refused(f"'mine:{name}' ... {complaint} ... engine pymunk"):
        evaluate(f"mine:{name}", "hazbot_gym/Corridor-v1", episodes=2, overrides=where)
    rows = evaluate(
        f"mine:{name}", "hazbot_gym/Corridor-v1", episodes=1, overrides=where, engine="pymunk"
    )
    assert rows[0]["steps"] == 3


@pytest.mark.parametrize("action_type", ["continuous", "discrete"])
@pytest.mark.parametrize("engine", ["batched", "pymunk"])
@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("NanLater", "'mine:NanLater' ... nan ... -1 <= action <= 1"),
        (
            "FailsLater",
            "'mine:FailsLater' ... KeyError: 1 ... test_batch",
        ),
    ],
)
def test_a_policy_of_the_user_that_fails_in_an_episode_is_one_line(
    name: str, complaint: str, engine: str, action_type: str, mine: None
) -> None:
    where = {"scenario": "E*", "action_type": action_type}
    with refused(complaint):
        evaluate(
            f"mine:{name}", "hazbot_gym/Corridor-v1", episodes=2, overrides=where, engine=engine
        )
