"""Reward terms and pedestrian models of users work in both engines."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.geometry import norm
from hazbot_gym.core.own_terms import REWARD_TERMS, reward_term
from hazbot_gym.core.own_walking import PEDESTRIAN_MODELS, pedestrian_model
from hazbot_gym.core.state import OWN as MODEL_OF_A_USER
from hazbot_gym.core.state import PRESENT
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import InvalidInput

OWN = {"own_terms": {"near_at_speed": -0.5}, "people": {"model": "hesitant"}}


@pytest.fixture(autouse=True)
def hooks() -> Iterator[None]:
    @reward_term(low=0.0, high=1.0)
    def near_at_speed(robot: Any, people: Any, record: Any, rules: Any) -> float:
        """Share of people within 3 m, by the robot's speed."""
        near, there = 0, 0
        for person in people:
            if person.status == PRESENT:
                there += 1
                near += norm(person.x - robot.x, person.y - robot.y) < 3.0
        share = min(max(robot.v / rules.nominal_speed_mps, 0.0), 1.0)
        return float(near / max(there, 1) * share)

    @pedestrian_model
    def hesitant(me: Any, situation: Any) -> tuple[float, float]:
        """Walk to the target ahead, slowly near the robot or behind another person."""
        speed, robot = me.desired_speed, situation.robot
        if norm(robot.x - me.x, robot.y - me.y) < situation.reaction.range_m:
            speed *= 0.3
        for j in range(situation.people.shape[0]):
            other = situation.people[j]
            if j != situation.own_index and other.status == PRESENT:
                x, y = other.x - me.x, other.y - me.y
                if norm(x, y) < 0.8 and x * situation.ahead_x + y * situation.ahead_y > 0.0:
                    speed *= 0.5
        noise = 0.05 * situation.noise_x
        return (
            speed * situation.ahead_x + noise,
            speed * situation.ahead_y + 0.05 * situation.noise_y,
        )

    yield
    REWARD_TERMS.clear()
    PEDESTRIAN_MODELS.clear()


def drive(engine: Any, action: Any) -> None:
    for _ in range(30):
        engine.step(action)


def test_both_engines_compute_the_same_episodes() -> None:
    env, envs = CorridorEnv(**OWN), CorridorVectorEnv(2, **OWN)
    actions = np.random.default_rng(1).uniform(-0.5, 1.0, (600, 2, 1)).astype("f4")
    observations, info = envs.reset(seed=7)
    observation, _ = env.reset(seed=7)
    seen, is_over = list[float](), False
    gap = np.abs(observation - observations[0]).max()
    for action in actions:
        observations, rewards, _, _, info = envs.step(action)
        observation, reward, terminated, truncated, alone = env.step(action[0])
        term = alone["reward_terms"]["near_at_speed"]
        gap = max(gap, abs(reward - rewards[0]), np.abs(observation - observations[0]).max())
        gap = max(gap, abs(term - info["reward_terms"]["near_at_speed"][0]))
        seen.append(term)
        if terminated or truncated:
            is_over = True
            break

    assert gap < 1e-6
    assert is_over
    assert np.std(seen) > 0.1  # it varies
    assert alone["outcome"] == info["outcome"][0]


def test_people_walk_by_the_model_of_the_user() -> None:
    still = CorridorEnv(own_terms={}, people={"model": "hesitant", "count": [3, 3]})
    still.reset(seed=0)
    speeds = []
    for _ in range(100):
        still.step(np.array([-1.0], "f4"))
        people = still.snapshot().people
        speeds.extend(np.hypot(people["vx"], people["vy"]) / people["desired_speed"])

    assert set(people["model"]) == {MODEL_OF_A_USER}
    assert np.median(speeds) == pytest.approx(1.0, abs=0.1)
    assert min(speeds) < 0.4  # near the robot


def test_range_and_weight_are_in_info() -> None:
    told = {"low": 0.0, "high": 1.0, "weight": -0.5}
    env = gymnasium.make("hazbot_gym/Corridor-v1", **OWN)
    envs = gymnasium.make_vec("hazbot_gym/Corridor-v1", 2, **OWN)

    assert env.reset(seed=0)[1]["own_terms"] == {"near_at_speed": told}
    seen = envs.reset(seed=0)[1]["own_terms"]["near_at_speed"]
    assert {key: seen[key].tolist() for key in told} == {k: [v, v] for k, v in told.items()}


def test_the_reward_adds_the_weighted_term() -> None:
    plain, own = CorridorEnv(), CorridorEnv(own_terms={"near_at_speed": -0.5})
    assert own._weights.tolist() == [*plain._weights, -0.5]
    for env in (plain, own):
        env.reset(seed=3)
    for _ in range(120):
        expected = plain.step(np.array([1.0], "f4"))[1]
        _, reward, _, _, info = own.step(np.array([1.0], "f4"))
        expected -= 0.5 * info["reward_terms"]["near_at_speed"]
        assert reward == pytest.approx(expected, abs=1e-12)


def test_a_term_out_of_its_range_is_refused_in_both_engines() -> None:
    @reward_term(low=0.0, high=0.2)
    def speed(robot: Any, people: Any, record: Any, rules: Any) -> float:
        return robot.v

    env, envs = (
        CorridorEnv(own_terms={"speed": 1.0}),
        CorridorVectorEnv(2, own_terms={"speed": 1.0}),
    )
    env.reset(seed=0)
    envs.reset(seed=0)
    for engine, action in ((env, np.ones(1, "f4")), (envs, np.ones((2, 1), "f4"))):
        with pytest.raises(InvalidInput, match="'speed': gave 0.2.*, allowed is its range, 0 to"):
            drive(engine, action)


@pytest.mark.parametrize("value", ["much", None, (0.1, 0.2), np.zeros(3)])
def test_a_term_that_gives_no_number_is_refused_by_plain_python(value: Any) -> None:
    reward_term(term := lambda_named("odd", value))
    env = CorridorEnv(own_terms={term.__name__: 1.0})
    env.reset(seed=0)
    with pytest.raises(InvalidInput, match="'odd': gave .*, allowed is a number") as refused:
        drive(env, np.ones(1, "f4"))
    assert "\n" not in str(refused.value)


def lambda_named(name: str, value: Any) -> Any:
    def term(robot: Any, people: Any, record: Any, rules: Any) -> Any:
        return value

    term.__name__ = name
    return term


def test_plain_python_cannot_write_into_the_simulation() -> None:
    @reward_term
    def pushing(robot: Any, people: Any, record: Any, rules: Any) -> float:
        people["x"][:] = 0.0
        return 0.5

    env = CorridorEnv(own_terms={"pushing": 1.0})
    env.reset(seed=0)
    with pytest.raises(ValueError, match="read-only"):
        drive(env, np.ones(1, "f4"))


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_what_raises_in_compiled_code_is_refused() -> None:
    @reward_term
    def beyond(robot: Any, people: Any, record: Any, rules: Any) -> float:
        return float(0.0 * people[99].x)

    @pedestrian_model
    def stubborn(me: Any, situation: Any) -> tuple[float, float]:
        if situation.robot.s > 0.0:
            raise ValueError("not me")
        return 1.0, 0.0

    for own, refused in (
        ({"own_terms": {"beyond": 1.0}}, "'beyond': gave nan"),
        ({"people": {"model": "stubborn", "count": [2, 2]}}, "'stubborn': gave a velocity that"),
    ):
        envs = CorridorVectorEnv(2, **own)
        envs.reset(seed=0)
        with pytest.raises(InvalidInput, match=refused):
            drive(envs, np.ones((2, 1), "f4"))


def test_a_model_that_walks_to_nowhere_is_refused_in_both_engines() -> None:
    @pedestrian_model
    def lost(me: Any, situation: Any) -> tuple[float, float]:
        return math.inf - math.inf if situation.robot.s > 0.0 else 1.0, 0.0

    lost_people = {"model": "lost", "count": [2, 2]}
    env, envs = CorridorEnv(people=lost_people), CorridorVectorEnv(2, people=lost_people)
    env.reset(seed=0)
    envs.reset(seed=0)
    for engine, action in ((env, np.ones(1, "f4")), (envs, np.ones((2, 1), "f4"))):
        with pytest.raises(InvalidInput, match="'lost': gave a velocity that is not finite"):
            drive(engine, action)
