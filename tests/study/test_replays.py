from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.rollout import Shard, make_env, run_episode, run_shard
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies import Permissions
from hazbot_gym.policies import make as make_policy
from hazbot_gym.study import replays, store
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.replays import (
    Choice,
    choices,
    choose,
    choose_worst,
    contact_of,
    gives_again,
    replay,
)
from hazbot_gym.study.report import page


@pytest.fixture(scope="module")
def study(finished: Path) -> page.Study:
    return page.read(finished)


def crossing(study: page.Study) -> ScenarioSet:
    return next(each for each in study.config.all_sets if each.name == "Crossing")


def specs(config: StudyConfig) -> dict[str, str]:
    return dict(zip(config.names, config.names, strict=True))


def episodes(**columns: list[float]) -> pd.DataFrame:
    return pd.DataFrame({"episode": range(len(columns["return"])), **columns})


def test_median_closest_and_slowest_episodes_are_chosen() -> None:
    rows = episodes(
        **{
            "return": [5.0, 1.0, 3.0, 2.0],
            "clearance_min_m": [0.5, 0.1, 0.4, np.inf],
            "time_ratio": [1.0, 1.5, 1.2, 2.0],
        }
    )
    assert choose(rows) == {3: "median and slowest", 1: "closest"}


def test_one_episode_is_all_three() -> None:
    rows = episodes(**{"return": [5.0], "clearance_min_m": [0.5], "time_ratio": [1.0]})
    assert choose(rows) == {0: "median and closest and slowest"}


def test_where_nobody_came_no_episode_is_the_closest() -> None:
    rows = episodes(
        **{
            "return": [5.0, 1.0],
            "clearance_min_m": [np.inf, np.inf],
            "time_ratio": [np.nan, np.nan],
        }
    )
    assert choose(rows) == {1: "median"}


def test_the_worst_episode_of_each_policy_says_whose_it_is() -> None:
    rows = pd.DataFrame(
        {
            "policy": ["a", "a", "b", "b"],
            "episode": [0, 1, 0, 1],
            "return": [3.0, 2.0, 5.0, 4.0],
        }
    )
    assert choose_worst(rows, ["a", "b"]) == {1: "worst of a, b"}


def test_the_worst_episode_of_many_policies_says_of_how_many() -> None:
    rows = pd.DataFrame({"policy": list("abcd"), "episode": 0, "return": 1.0})
    assert choose_worst(rows, list("abcd")) == {0: "worst of 4 policies"}


def test_worst_episodes_are_of_the_headlines_sets(study: page.Study) -> None:
    found = {each.scenarios.name: each.episodes for each in choices(study.config, study.rows, None)}
    assert list(found) == ["E*", "Crossing", "Corridor"]
    assert any("worst of" in why for why in found["Crossing"].values())
    assert not any("worst of" in why for why in found["E*"].values())


def test_recorded_drives_are_those_of_either_engine(study: page.Study) -> None:
    reference = study.config.model_copy(update={"engine": "pymunk"})
    kept = study.replays.chosen["Crossing"]
    choice = Choice(crossing(study), {each.number: each.why for each in kept})
    again = replay(reference, choice, study.rows, specs(study.config))
    for ours, theirs in zip(kept, again, strict=True):
        for policy, run in ours.runs.items():
            np.testing.assert_allclose(run.pose, theirs.runs[policy].pose, atol=1e-5)
            assert run.ranges_m.shape == (len(run.time_s) - 1, 4)
            np.testing.assert_allclose(run.ranges_m, theirs.runs[policy].ranges_m, atol=0.0051)
            assert run.is_recorded
            assert theirs.runs[policy].is_recorded


def test_the_reward_of_a_replay_sums_to_the_recorded_return(study: page.Study) -> None:
    returns = study.rows.set_index(["scenario_set", "policy", "episode"])["return"]
    for name, some in study.replays.chosen.items():
        for each in some:
            for policy, run in each.runs.items():
                expected = returns.loc[name, policy, each.number]
                assert run.earned[-1] == pytest.approx(expected, abs=1e-4)


def test_the_mark_of_a_contact_is_on_the_robots_rim() -> None:
    env = make_env(ScenarioSet(name="Corridor", env="hazbot_gym/Corridor-v1"))
    episode, _ = run_episode(env, make_policy("constant:0.5"), 0)
    (x, y), radius = episode.pose[-1, :2], episode.robot_radius_m
    wall = np.array([[x - 5.0, y - 9.0, x + 5.0, y - 9.0], [x - 5.0, y + 0.3, x + 5.0, y + 0.3]])
    person = np.array([x - 0.4, y, 0.0, 0.0, 0.2])
    people = np.repeat(person[None, None], len(episode.time_s), axis=0)
    ended = {
        each: episode._replace(outcome=each, people=people)
        for each in ("contact_wall", "contact_person", "arrived")
    }
    assert contact_of(ended["contact_wall"], wall) == pytest.approx([x, y + radius])
    assert contact_of(ended["contact_person"], wall) == pytest.approx([x - radius, y])
    assert contact_of(ended["arrived"], wall).shape == (0,)


def test_discrete_speeds_are_replayed() -> None:
    scenarios = ScenarioSet(
        name="levels", env="hazbot_gym/Crossing-v1", overrides={"action_type": "discrete"}
    )
    study = StudyConfig(policies=("constant:0.4", "stop_on_sight"), sets=(scenarios,))
    shards = [Shard(policy, scenarios, 0, 2, study.seed) for policy in study.policies]
    rows = pd.DataFrame([row for shard in shards for row in run_shard(shard)])
    (first, *_) = replay(study, choices(study, rows, None)[0], rows, specs(study))
    assert set(first.runs) == set(study.policies)
    assert all(run.is_recorded for run in first.runs.values())


def test_more_drives_than_fit_a_batch_are_the_same(
    study: page.Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batch_rollout, "MOST_WORLDS", 5)
    kept = study.replays.chosen["Crossing"]
    choice = Choice(crossing(study), {each.number: each.why for each in kept})
    for each in replay(study.config, choice, study.rows, specs(study.config)):
        assert all(run.is_recorded for run in each.runs.values())


class Whimsical:
    """A policy that draws its speed, and so drives otherwise each time."""

    rng = np.random.default_rng(0)

    def predict(self, observation: Any, **_: Any) -> tuple[Any, None]:
        return self.rng.uniform(-1.0, 1.0, (len(observation), 1)), None


def test_a_policy_that_does_not_repeat_itself_is_named_and_marked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenarios = ScenarioSet(name="Crossing", env="hazbot_gym/Crossing-v1")
    name = f"{__name__}:Whimsical"
    study = StudyConfig(policies=("constant:0.4", name), sets=(scenarios,))
    allowed, console = Permissions(allow_code=True), Console(width=200)
    shards = [
        Shard(policy, scenarios, 0, 2, study.seed, allowed=allowed) for policy in study.policies
    ]
    rows = pd.DataFrame([row for shard in shards for row in run_shard(shard)])
    path = tmp_path / store.REPLAYS
    replays.record(
        study,
        path,
        rows,
        None,
        specs(study),
        stamp="1",
        threads=1,
        console=console,
        allowed=allowed,
    )  # fmt: skip
    said = capsys.readouterr().out
    assert name in said
    assert "does not repeat itself" in said
    assert "constant" not in said
    found = page.from_rows(store.read_episodes(path))
    for each in found.chosen["Crossing"]:
        assert each.runs["constant:0.4"].is_recorded
        assert not each.runs[name].is_recorded


@pytest.mark.parametrize(
    ("name", "value"),
    [("outcome", "timeout"), ("time_s", 10.1), ("contact_speed_mps", 0.0)],
)
def test_every_kind_of_number_is_compared(name: str, value: Any) -> None:
    now = {"outcome": "arrived", "time_s": 10.0, "contact_speed_mps": float("nan")}
    assert gives_again(now, now)
    assert not gives_again(now, now | {name: value})


def test_replays_are_recorded_once(finished: Path, study: page.Study, tmp_path: Path) -> None:
    path = tmp_path / store.REPLAYS

    def record(stamp: str) -> int:
        replays.record(
            study.config, path, study.rows, None, specs(study.config),
            stamp=stamp, threads=1, console=Console(quiet=True),
        )  # fmt: skip
        return path.stat().st_mtime_ns

    before = record("1")
    assert record("1") == before
    assert record("2") != before
    path.write_bytes(path.read_bytes()[:-100])
    assert record("2") != before
    assert page.from_rows(store.read_episodes(path)).chosen.keys() == {
        each.name for each in study.config.all_sets
    }
