"""Random configs and random actions: no NaN, and no observation outside its space."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE
from hazbot_gym.task.reward import SURVEY_TERM

IDS = [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]
STEPS = 100_000 // len(IDS)
LONGEST_HOLD = 30  # decisions for which a random action is kept


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Return numbers in a range, none of them smaller than a config allows but 0."""
    return st.floats(low, high).map(lambda number: round(number, 9))


shares = numbers(0.0, 1.0)
weights = st.tuples(*[numbers(0.01, 1.0)] * 4)


def fractions(low: float, high: float) -> st.SearchStrategy[float | int]:
    """Return numbers in a range, whole ones now and then as integers."""
    return numbers(low, high) | st.integers(math.ceil(low), math.floor(high))


clocks = st.sampled_from(
    [
        {},
        {"physics_s": 0.02, "social_s": 0.1, "decision_s": 0.2},
        {"physics_s": 0.005, "social_s": 0.05, "decision_s": 0.05},
    ]
)
drives = st.fixed_dictionaries(
    {},
    optional={
        "nominal_speed_mps": numbers(0.3, 2.0),
        "acceleration_mps2": fractions(0.3, 5.0),
        "deceleration_mps2": fractions(0.3, 5.0),
        "reflex_stop_m": fractions(0.0, 2.0),
        "latency_steps": st.integers(0, 50),
        "line_sensor": st.fixed_dictionaries(
            {"pitch_m": numbers(0.0, 0.1)}, optional={"line_m": numbers(0.001, 0.1)}
        ),
        "wheel_loop": st.sampled_from(["fuzzy_pid", "pid", "ideal"]),
        "plant": st.sampled_from(["A", "B", "A0", "C"]),
        "tables": st.sampled_from(["textbook", "symmetric"]),
        "wheel_noise_radps": fractions(0.0, 0.1),
        "heading_noise_rad": numbers(0.0, 0.02),
    },
)
people = st.fixed_dictionaries(
    {"model": st.sampled_from(["scripted", "social_force", "replay", "seeded"])},
    optional={
        "count": st.tuples(st.integers(0, 3), st.integers(3, 12)).map(list),
        "mix": weights,
        "reaction_shares": weights,
        "speeds": st.fixed_dictionaries(
            {}, optional={"mean_mps": fractions(0.5, 2.0), "sd_mps": fractions(0.0, 1.0)}
        ),
        "force": st.fixed_dictionaries(
            {},
            optional={
                "relaxation_time_s": numbers(0.1, 2.0),
                "person_strength_mps2": fractions(0.0, 40.0),
                "robot_strength_mps2": fractions(0.0, 40.0),
                "wall_strength_mps2": fractions(0.0, 60.0),
                "jitter_mps2": fractions(0.0, 3.0),
            },
        ),
    },
)
sensors = st.fixed_dictionaries(
    {},
    optional={
        "ultrasonic": st.fixed_dictionaries(
            {},
            optional={
                "noise_m": fractions(0.0, 2.0),
                "range_m": numbers(0.5, 8.0),
                "half_cone_rad": numbers(0.01, 1.0),
                "gaussian": st.booleans(),
                "miss_angle_rad": numbers(0.2, 1.6),
                "cross_talk": shares,
                "sequential": st.booleans(),
            },
        ),
        "tracker": st.fixed_dictionaries(
            {},
            optional={
                "range_m": fractions(1.0, 20.0),
                "position_noise_m": fractions(0.0, 2.0),
                "velocity_noise_mps": fractions(0.0, 5.0),
                "dropout": shares,
                "latency_steps": st.integers(0, 20),
            },
        ),
    },
)
sizes = st.sampled_from([1e-12, 1e-3, 1.0, 1e9])
gases = st.fixed_dictionaries(
    {"leak_share": st.just(1.0)},
    optional={
        "sensor": st.sampled_from(["TGS2611", "TGS2620", "TGS2600"])
        | st.fixed_dictionaries(
            {"rise_s": sizes, "decay_s": sizes, "half_ppm": sizes, "exponent": numbers(0.1, 2.0)},
            optional={"noise": sizes, "false_alarms_per_h": numbers(0.01, 3600.0)},
        ),
        "strength_ppm": st.tuples(sizes, st.just(1e9)).map(list),
        "draught_mps": st.tuples(st.sampled_from([1e-12, 0.1]), numbers(0.1, 10.0)).map(list),
        "plume": st.fixed_dictionaries(
            {},
            optional={
                "filaments_per_s": sizes,
                "sigma0_m": numbers(0.001, 1.0),
                "growth_m2ps": sizes | st.just(0.0),
                "mixing_m2ps": sizes | st.just(0.0),
                "meander_mps": sizes | st.just(0.0),
                "meander_s": sizes,
            },
        ),
    },
)
configs = st.fixed_dictionaries(
    {"place": st.sampled_from(["corridor", "intersection", "doorway", "circle", "aisle", "open"])},
    optional={
        "tier": st.sampled_from(["sonar", "tracks", "privileged"]),
        "action_type": st.sampled_from(["continuous", "discrete"]),
        "arrival_tolerance_m": numbers(0.02, 0.5),
        "nearness": st.sampled_from(["depth", "discomfort"]),
        "clock": clocks,
        "drive": drives,
        "people": people,
        "sensors": sensors,
        "gas": gases,
    },
)


def bare(env_id: str, **options: Any) -> CorridorEnv:
    env = gymnasium.make(env_id, **options).unwrapped
    assert isinstance(env, CorridorEnv)
    return env


def check(env: CorridorEnv, observations: list[Any], rewards: list[float]) -> None:
    """Assert that observations are numbers inside their space, and rewards numbers."""
    seen = np.stack(observations)
    space = env.observation_space
    assert seen.dtype == np.float32
    assert np.isfinite(seen).all()
    assert np.all(seen >= space.low)
    assert np.all(seen <= space.high)
    assert np.isfinite(rewards).all()


@pytest.mark.parametrize("env_id", IDS)
def test_ten_thousand_random_steps_stay_inside_the_spaces(env_id: str) -> None:
    env, rng = bare(env_id), np.random.default_rng(7)
    env.action_space.seed(7)
    observations, rewards, hold = [env.reset(seed=7)[0]], [], 0
    for _ in range(STEPS):
        if hold == 0:
            action, hold = env.action_space.sample(), int(rng.integers(1, LONGEST_HOLD))
        hold -= 1
        observation, reward, terminated, truncated, _ = env.step(action)
        observations.append(observation)
        rewards.append(float(reward))
        if terminated or truncated:
            observations.append(env.reset()[0])
    check(env, observations, rewards)


@settings(
    max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
@given(config=configs, seed=st.integers(0, 2**31 - 1))
def test_any_config_gives_numbers_inside_the_spaces(config: dict[str, Any], seed: int) -> None:
    env = bare(IDS[0], **config)
    env.action_space.seed(seed)
    observation, info = env.reset(seed=seed)
    observations, rewards = [observation], [0.0]
    for _ in range(40):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        observations.append(observation)
        rewards.append(float(reward))
        terms = dict(info["reward_terms"])
        assert -1.0 <= terms.pop(SURVEY_TERM, 0.0) <= 1.0
        assert all(0.0 <= value <= 1.0 for value in terms.values())
        assert np.isfinite([*info.get("gas", {}).values()]).all()
        if terminated or truncated:
            observations.append(env.reset()[0])
    check(env, observations, rewards)
