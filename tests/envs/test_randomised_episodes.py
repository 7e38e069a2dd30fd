"""Randomised and overridden values reach both engines alike."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.rollout import evaluate

pytestmark = pytest.mark.filterwarnings("ignore:place corridor")  # no robot arrives in 150 steps
RANDOM: dict[str, Any] = {
    "people": {"count": [{"uniform": [1, 2]}, {"choice": [3, 6]}]},
    "drive": {"acceleration_mps2": {"uniform": [0.3, 0.6]}},
    "sensors": {"tracker": {"dropout": {"uniform": [0.0, 0.3]}}},
    "place_options": {"width_m": {"uniform": [2.0, 3.0]}},
    "reward": {"intrusion": {"uniform": [-1.0, -0.2]}},
    "max_episode_steps": 150,
}


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_both_engines_meet_the_same_draws_in_all_episodes(mode: str) -> None:
    env, envs = CorridorEnv(**RANDOM), CorridorVectorEnv(3, **RANDOM, autoreset_mode=mode)
    observation, info = env.reset(seed=4)
    observations, _ = envs.reset(seed=4)
    gap, is_over, drawn = np.abs(observation - observations[0]).max(), False, [info["randomised"]]
    for action in np.random.default_rng(2).uniform(0.0, 1.0, (400, 3, 1)).astype("f4"):
        observations, rewards, _, _, infos = envs.step(action)
        reward = 0.0
        if not is_over or mode == "SameStep":
            observation, reward, terminated, truncated, info = env.step(action[0])
            is_over = terminated or truncated
        else:
            is_over = False
            observation, info = env.reset()
            drawn.append(info["randomised"])
        if is_over and mode == "SameStep":
            gap = max(gap, np.abs(observation - infos["final_obs"][0]).max())
            observation, info = env.reset()
            drawn.append(info["randomised"])
        gap = max(gap, abs(reward - rewards[0]), np.abs(observation - observations[0]).max())
        told = infos["randomised"]
        assert info["randomised"] == {name: told[name][0] for name in info["randomised"]}

    assert gap < 1e-6
    assert len(drawn) > 2
    assert len({each["drive.acceleration_mps2"] for each in drawn}) == len(drawn)
    assert info["reward_terms"].keys() == CorridorEnv().reset(seed=0)[1]["reward_terms"].keys()


def test_results_do_not_depend_on_threads() -> None:
    runs = []
    for threads in (1, 2):
        envs = CorridorVectorEnv(40, **RANDOM, threads=threads, autoreset_mode="SameStep")
        envs.reset(seed=0)
        for _ in range(60):
            observations = envs.step(np.full((40, 1), 0.5, "f4"))[0]
        runs.append(observations)
    assert np.array_equal(*runs)


def test_a_reset_overrides_values_until_the_next() -> None:
    env, envs = CorridorEnv(), CorridorVectorEnv(2)
    options = {"config": {"people": {"count": [7, 7]}}, "key": 5}
    plain, _ = env.reset(options={"key": 5})
    crowded, info = env.reset(options=options)
    both, _ = envs.reset(options={**options, "key": [5, 6]})

    assert env.snapshot().people.size > 0
    assert (env._world.people["radius"] > 0.0).sum() == 7
    assert (envs.state().people["radius"] > 0.0).sum(axis=1).tolist() == [7, 7]
    assert np.array_equal(crowded, both[0])
    assert np.array_equal(env.reset(options={"key": 5})[0], plain)
    assert np.array_equal(envs.reset(options={"key": 5})[0], [plain, plain])
    assert "randomised" not in info


def test_some_worlds_are_overridden_while_others_run() -> None:
    envs, undisturbed = CorridorVectorEnv(3), CorridorVectorEnv(3)
    for each in (envs, undisturbed):
        each.reset(seed=1)
    mask = np.array([False, True, False])
    crowd = {"people": {"count": [8, 8]}, "drive": {"acceleration_mps2": 0.2}}
    envs.reset(options={"reset_mask": mask, "config": crowd, "key": 3})
    alone = CorridorEnv()
    alone.reset(options={"config": crowd, "key": 3})
    for _ in range(50):
        expected = undisturbed.step(np.ones((3, 1), "f4"))[0]
        observations = envs.step(np.ones((3, 1), "f4"))[0]
        own = alone.step(np.ones(1, "f4"))[0]

    assert np.array_equal(observations[~mask], expected[~mask])
    assert observations[1] == pytest.approx(own, abs=1e-6)


def test_an_override_that_changes_spaces_is_refused() -> None:
    for env in (CorridorEnv(), CorridorVectorEnv(2)):
        for deltas, reason in (
            ({"tier": "sonar"}, "tier: given 'sonar', but it must be the same"),
            ({"gas": {}}, "gas: all episodes"),
            ({"people": {"cuont": 3}}, "people.cuont: unknown key"),
            (3, "allowed is a mapping"),
        ):
            with pytest.raises(InvalidInput, match=reason):
                env.reset(seed=0, options={"config": deltas})


def test_metrics_are_those_of_the_drawn_episode_in_both_engines() -> None:
    rows = [
        evaluate("constant:0.8", "Corridor-v1", episodes=3, overrides=RANDOM, engine=engine)
        for engine in ("batched", "pymunk")
    ]
    for batched, alone in zip(*rows, strict=True):
        for name in ("return", "delay_s", "steps"):
            assert batched[name] == pytest.approx(alone[name], abs=1e-6)
