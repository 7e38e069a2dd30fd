from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.evaluation.episode import PERSON_COLUMNS, X, stack_people
from hazbot_gym.evaluation.rollout import (
    Shard,
    environment_ids,
    episode_seed,
    evaluate,
    make_env,
    run_episode,
    run_shard,
    scenario_set,
)
from hazbot_gym.evaluation.scenario_set import DEFAULT_SETS, ScenarioSet
from hazbot_gym.policies.constant import Constant
from tests.refusals import refused

CROSSING = ScenarioSet(name="Crossing", env="hazbot_gym/Crossing-v1")


class Recorder:
    """A policy that remembers what it was told, to see how policies are called."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, Any, bool]] = []

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, int]:
        self.calls.append((state, episode_start.tolist(), deterministic))
        return np.ones(1, dtype=np.float32), len(self.calls)


def test_an_episode_is_recorded_from_start_to_end() -> None:
    env = make_env(CROSSING)
    episode, labels = run_episode(env, Constant(1.0), seed=1)
    instants = len(episode.time_s)
    assert episode.time_s[0] == 0.0
    np.testing.assert_allclose(np.diff(episode.time_s), 0.1)
    assert episode.pose.shape == episode.pose_error.shape == (instants, 3)
    assert len(episode.rewards) == len(episode.costs) == instants - 1
    assert {len(values) for values in episode.reward_terms.values()} == {instants - 1}
    assert episode.people.shape[::2] == (instants, 5)
    assert episode.outcome in ("arrived", "contact_person", "contact_wall", "timeout")
    assert labels["scenario_key"]
    assert labels["place"]


def test_without_people_full_speed_takes_the_free_time() -> None:
    nobody = {"people": {"count": [0, 0]}}
    (row,) = evaluate("constant:1.0", "hazbot_gym/Corridor-v1", episodes=1, overrides=nobody)
    assert row["arrived"] == 1
    assert row["time_ratio"] == pytest.approx(1.0, abs=0.02)
    assert row["delay_s"] == pytest.approx(0.0, abs=0.5)
    assert row["personal_m"] == row["discomfort_s"] == row["person_delay_s"] == 0.0
    assert row["cross_track_max_m"] < 0.1


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_discomfort_is_the_intrusion_of_a_reward_that_charges_it(engine: str) -> None:
    overrides = {"nearness": "discomfort"}
    rows = evaluate(
        "constant:0.8", "hazbot_gym/Crossing-v1", episodes=3, overrides=overrides, engine=engine
    )
    felt_s = [row["discomfort_s"] for row in rows]
    assert felt_s == pytest.approx([0.1 * row["reward_intrusion"] for row in rows])
    assert max(felt_s) > 0.1


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_a_standing_robot_times_out_at_a_limit_set_from_outside(engine: str) -> None:
    limit = {"max_episode_steps": 20}
    (row,) = evaluate(
        "constant:0.0", "hazbot_gym/Corridor-v1", episodes=1, overrides=limit, engine=engine
    )
    assert row["timeout"] == 1
    assert row["steps"] == 20
    assert row["time_s"] == pytest.approx(2.0)
    assert row["time_ratio"] == pytest.approx(2.0 / row["time_free_s"])


def test_a_policy_gets_its_state_back_and_is_told_where_an_episode_starts() -> None:
    recorder = Recorder()
    run_episode(make_env(CROSSING), recorder, seed=0)
    assert recorder.calls[:3] == [(None, [True], True), (1, [False], True), (2, [False], True)]


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_rows_do_not_depend_on_how_episodes_are_cut_into_blocks(engine: Any) -> None:
    shard = Shard("constant:0.5", CROSSING, first=0, episodes=3, seed=5, engine=engine)
    whole = run_shard(shard, threads=2)
    first = run_shard(shard._replace(episodes=1))
    rest = run_shard(shard._replace(first=1, episodes=2))
    np.testing.assert_equal(first + rest, whole)


def test_all_policies_meet_the_same_scenarios() -> None:
    slow, fast = (
        run_shard(Shard(policy, CROSSING, first=0, episodes=2, seed=5))
        for policy in ("constant:0.25", "constant:1.0")
    )
    assert [row["scenario_key"] for row in slow] == [row["scenario_key"] for row in fast]
    assert slow[0]["scenario_key"] != slow[1]["scenario_key"]


def test_evaluation_meets_the_scenarios_of_the_study() -> None:
    for scenarios in (DEFAULT_SETS[0], DEFAULT_SETS[4]):
        (alone,) = evaluate(
            "constant", scenarios.env, episodes=1, seed=3, overrides=scenarios.overrides
        )
        (within,) = run_shard(Shard("constant", scenarios, first=0, episodes=1, seed=3))
        np.testing.assert_equal(alone, within)


def test_every_episode_of_every_set_has_a_seed_of_its_own() -> None:
    seeds = {
        episode_seed(root, name, index)
        for root in (0, 1)
        for name in ("E*", "C*")
        for index in range(50)
    }
    assert len(seeds) == 200
    assert episode_seed(0, "E*", 3) == episode_seed(0, "E*", 3)


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_levels_are_played_where_an_environment_has_them(engine: str) -> None:
    (row,) = evaluate(
        "constant:0.5",
        "hazbot_gym/Corridor-v1",
        episodes=1,
        overrides={"action_type": "discrete", "people": {"count": [0, 0]}},
        engine=engine,
    )
    assert row["time_ratio"] == pytest.approx(2.0, abs=0.1)


def test_people_are_stacked_with_gaps_where_they_are_absent() -> None:
    columns = np.zeros((3, len(PERSON_COLUMNS)))
    columns[:, X] = [1.0, 2.0, 3.0]
    instants, persons = np.array([1, 1, 2]), np.array([4, 7, 7])
    who, stacked = stack_people(instants, persons, columns, 3)
    assert who.tolist() == [4, 7]
    np.testing.assert_array_equal(stacked[..., X], [[np.nan, np.nan], [1.0, 2.0], [np.nan, 3.0]])
    assert np.isnan(stacked[0]).all()
    none = np.empty(0, np.int64)
    assert stack_people(none, none, np.empty((0, len(PERSON_COLUMNS))), 2)[1].shape == (2, 0, 5)


@pytest.mark.parametrize("env_id", ["CartPole-v1", "hazbot_gym/Nowhere-v1", "nowhere:Env-v0", "x"])
def test_an_environment_that_is_not_ours_is_refused_with_those_that_are(env_id: str) -> None:
    with refused("hazbot_gym/Corridor-v1"):
        evaluate("constant", env_id, episodes=1)


def test_an_environment_may_be_named_without_its_namespace() -> None:
    assert scenario_set("Circle-v1") == scenario_set("hazbot_gym/Circle-v1")
    assert scenario_set("Circle-v1").env == "hazbot_gym/Circle-v1"


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_horizon_that_is_set_is_the_one_that_is_run(engine: str) -> None:
    longer = {"max_episode_steps": 700, "people": {"count": [0, 0]}}
    (row,) = evaluate("constant:0.0", "Corridor-v1", episodes=1, overrides=longer, engine=engine)

    assert (row["outcome"], row["steps"]) == ("timeout", 700)


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
@pytest.mark.parametrize("horizon", [0, -5, "abc", 7.5, [20], True, 10**12])
def test_horizon_that_is_none_is_refused_in_one_line(horizon: Any, engine: str) -> None:
    with refused("max_episode_steps"):
        evaluate(
            "constant:0.0",
            "Corridor-v1",
            episodes=1,
            overrides={"max_episode_steps": horizon},
            engine=engine,
        )


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
@pytest.mark.parametrize("key", ["given", "preset", "render_mode", "num_envs", "id", "threads"])
def test_override_that_is_no_field_is_refused(key: str, engine: str) -> None:
    with refused(f"{key}"):
        evaluate("constant", "Corridor-v1", episodes=1, overrides={key: 1}, engine=engine)


def test_all_environments_of_the_default_study_exist() -> None:
    assert {scenarios.env for scenarios in DEFAULT_SETS} <= set(environment_ids())


def test_an_engine_that_is_none_is_refused() -> None:
    with refused("engine ... 'steam' ... batched ... pymunk"):
        evaluate("constant", "hazbot_gym/Corridor-v1", episodes=1, engine="steam")


@pytest.mark.parametrize(("episodes", "seed"), [(0, 0), (1, -1)])
def test_senseless_numbers_are_refused(episodes: int, seed: int) -> None:
    with refused("given"):
        evaluate("constant", "hazbot_gym/Corridor-v1", episodes=episodes, seed=seed)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"policy": Constant()}, "policy ... Constant"),
        ({"policy": Constant}, "policy ... <class"),
        ({"env_id": None}, "env ... None"),
        ({"episodes": "3"}, "episodes ... '3'"),
        ({"episodes": 2.5}, "episodes ... 2.5"),
        ({"episodes": 10**30}, "1 to 1,000,000"),
        ({"seed": None}, "seed ... None"),
        ({"overrides": ["tier=sonar"]}, "overrides ... ['tier=sonar']"),
        ({"overrides": {3: 1}}, "overrides ... {3: 1}"),
    ],
)
def test_arguments_of_another_type_are_one_line(changed: dict[str, Any], named: str) -> None:
    usual = {"policy": "constant", "env_id": "hazbot_gym/Corridor-v1", "episodes": 1}
    with refused(named):
        evaluate(**(usual | changed))  # type: ignore[arg-type]


class Answers:
    """A policy that answers the same to everything."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def predict(self, *_: Any, **__: Any) -> Any:
        return self.answer


@pytest.mark.parametrize(
    ("env", "policy", "seed", "named"),
    [
        ("hazbot_gym/Corridor-v1", Constant(), 0, "env ... 'hazbot_gym/Corridor-v1'"),
        (None, "constant", 0, "policy ... 'constant'"),
        (None, Constant, 0, "policy ... <class"),
        (None, Constant(), -1, "seed ... -1"),
        (None, Constant(), "a", "seed ... 'a'"),
        (None, Answers(np.ones(1)), 0, "policy ... ndarray"),
        (None, Answers(None), 0, "policy ... NoneType"),
        (None, Answers((1.0, None, 2)), 0, "policy ... 3"),
        (None, Answers((np.ones((1, 1)), None)), 0, "action ... (1, 1)"),
    ],
)
def test_small_mistakes_in_an_episode_are_one_line(
    env: Any, policy: Any, seed: Any, named: str
) -> None:
    with refused(named):
        run_episode(env or make_env(scenario_set("hazbot_gym/Corridor-v1")), policy, seed)
