"""The same seed gives the same episode, with every source of noise switched on."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.state import PRESENT, Records
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE

IDS = [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]
ALL_NOISE = {
    "ultrasonic": {"noise_m": 0.05, "gaussian": True, "cross_talk": 0.1, "sequential": True},
    "tracker": {
        "position_noise_m": 0.05,
        "velocity_noise_mps": 0.1,
        "dropout": 0.2,
        "latency_steps": 2,
    },
}

everywhere = pytest.mark.parametrize("env_id", IDS)


def noisy(env_id: str = IDS[0], **options: Any) -> CorridorEnv:
    env = gymnasium.make(env_id, sensors=ALL_NOISE, **options).unwrapped
    assert isinstance(env, CorridorEnv)
    return env


def episodes(env: CorridorEnv, seed: int, count: int = 3) -> list[Any]:
    """Return everything that is seen in some episodes, only the first of which is seeded."""
    env.action_space.seed(seed)
    seen: list[Any] = []
    for episode in range(count):
        observation, info = env.reset(seed=seed if episode == 0 else None)
        seen.append((observation.tobytes(), info))
        is_over = False
        while not is_over:
            observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
            seen.append((observation.tobytes(), reward, terminated, truncated, info))
            is_over = terminated or truncated
    return seen


def drawn(env: CorridorEnv) -> Records:
    env.reset()
    return env._world.people


@everywhere
def test_two_environments_agree_bit_by_bit(env_id: str) -> None:
    assert episodes(noisy(env_id), 5, count=2) == episodes(noisy(env_id), 5, count=2)


def test_an_environment_agrees_with_itself_after_other_episodes() -> None:
    env = noisy()
    first = episodes(env, 5)
    episodes(env, 6, count=1)
    assert episodes(env, 5) == first


def test_another_seed_is_another_episode() -> None:
    assert episodes(noisy(), 5, count=1) != episodes(noisy(), 6, count=1)


def test_resets_without_a_seed_go_on_where_the_seeded_one_began() -> None:
    """The n-th scenario after a seeded reset is fixed, and all of them differ."""

    def keys(seed: int) -> list[int]:
        env = noisy()
        first = env.reset(seed=seed)[1]["scenario_key"]
        return [first, *(env.reset()[1]["scenario_key"] for _ in range(5))]

    assert keys(3) == keys(3)
    assert len(set(keys(3) + keys(4))) == 12


def test_scenarios_vary_within_an_id() -> None:
    env = noisy()
    observations = {env.reset()[0].tobytes() for _ in range(10)}
    counts = {int(np.sum(drawn(env)["status"] <= PRESENT)) for _ in range(10)}
    assert len(observations) == 10
    assert len(counts) > 1


def test_scenarios_do_not_depend_on_how_the_episodes_before_were_driven() -> None:
    fast, slow = noisy(), noisy()
    for env, action in ((fast, 1.0), (slow, -0.6)):
        env.reset(seed=8)
        for _ in range(30):
            env.step(np.array([action]))
    observation, info = fast.reset()
    other_observation, other_info = slow.reset()
    assert info == other_info
    assert observation.tobytes() == other_observation.tobytes()


def tracker_errors(action: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return (decisions, people) errors of the tracked x, NaN where nobody is tracked."""
    env = noisy(place="open", people={"model": "scripted", "count": [4, 4]})
    env.reset(seed=2)
    errors = []
    for _ in range(80):
        env.step(np.array([action]))
        reported = env._history[(env._world.decision + 1) % len(env._history)]
        is_seen = env._tracks["visible"] == 1
        errors.append(np.where(is_seen, env._tracks["x"] - reported["x"], np.nan))
    return np.array(errors)


def test_sensor_noise_does_not_depend_on_the_actions() -> None:
    driving, standing = tracker_errors(1.0), tracker_errors(-1.0)
    both = ~np.isnan(driving) & ~np.isnan(standing)
    assert both.sum() > 20
    assert driving[both] == pytest.approx(standing[both], abs=1e-12)
    assert np.ptp(driving[both]) > 0.05


def test_people_who_react_to_nothing_walk_the_same_whatever_the_robot_does() -> None:
    places = []
    for action in (1.0, -1.0):
        env = noisy(people={"model": "scripted", "count": [4, 4]})
        env.reset(seed=2)
        for _ in range(20):
            env.step(np.array([action]))
        places.append(env._world.people[["x", "y", "vx", "vy", "status"]].tolist())
    assert places[0] == places[1]


def test_the_seed_of_the_action_space_survives_a_reset() -> None:
    env, other = noisy(), noisy()
    for each in (env, other):
        each.action_space.seed(4)
    env.reset(seed=1)
    assert env.action_space.sample().tolist() == other.action_space.sample().tolist()


def test_a_scenario_can_be_asked_for_by_its_key() -> None:
    env = noisy()
    observation, info = env.reset(seed=9)
    again, same = noisy().reset(options={"key": info["scenario_key"]})
    assert same["scenario_key"] == info["scenario_key"]
    assert again.tobytes() == observation.tobytes()
