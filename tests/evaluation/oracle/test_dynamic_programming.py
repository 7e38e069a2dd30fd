from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.state import PERSON, PRESENT, ROBOT, ROBOT_RADIUS_M, Floats, records
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.evaluation.oracle.dynamic_programming import optimum, reward_of
from hazbot_gym.evaluation.oracle.headroom import QUIET_DRIVE, headroom_config
from hazbot_gym.evaluation.oracle.lattice import LEVELS, Lattice, lattice_of
from hazbot_gym.task.reward import TERMS, nearness, reward_terms, total
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.task.step_record import NEARNESS, STEP, rules_of
from tests.refusals import refused

SHORT = """
name: short
path: {points: [[0.0, 0.0], [0.16, 0.0]]}
"""


def problem(tmp_path: Path, **changes: Any) -> Config:
    """Return a path of 0.16 m, on which the tolerance leaves 0.11 m to go, and eight decisions."""
    place = tmp_path / "short.yaml"
    place.write_text(SHORT, encoding="utf-8")
    given = {"place": str(place), "max_episode_steps": 8, "drive": QUIET_DRIVE}
    people = {"model": "scripted", "count": [0, 0], **changes.pop("people", {})}
    return make_config(people=people, **(given | changes))


def sequences(lattice: Lattice, length: int, level: int = 0) -> Iterator[list[int]]:
    """Yield every sequence of speeds that the limits allow."""
    if length == 0:
        yield []
        return
    for following in np.flatnonzero(lattice.ways[level] >= 0):
        for rest in sequences(lattice, length - 1, int(following)):
            yield [int(following), *rest]


def returns_of(config: Config, commands: Floats, seed: int) -> Floats:
    """Return the returns of commands (N, T), shares of the nominal speed, in a world."""
    worlds = CorridorVectorEnv(len(commands), config, autoreset_mode="Disabled")
    worlds.reset(seed=[seed] * len(commands))
    live, total = np.ones(len(commands), np.bool_), np.zeros(len(commands))
    for t in range(commands.shape[1]):
        actions = (2.0 * commands[:, t] - 1.0).astype(np.float32)[:, None]
        _, rewards, terminated, truncated, _ = worlds.step(actions, mask=live)
        total += np.where(live, rewards, 0.0)
        live &= ~(terminated | truncated)
    worlds.close()
    return total


def key_of(config: Config, seed: int) -> int:
    worlds = CorridorVectorEnv(1, config)
    _, info = worlds.reset(seed=seed)
    worlds.close()
    return int(info["scenario_key"][0])


WALKERS = {
    "nobody": [],
    "crosses": [{"x_m": 0.6, "y_m": 0.9, "vx_mps": 0.0, "vy_mps": -1.0}],
    "comes head-on": [{"x_m": 1.2, "y_m": 0.05, "vx_mps": -1.0, "vy_mps": 0.0}],
    "stands beside": [{"x_m": 0.1, "y_m": 0.6, "vx_mps": 0.0, "vy_mps": 0.0}],
}


@pytest.mark.parametrize(
    ("who", "measure"), [*((who, "depth") for who in WALKERS), ("comes head-on", "discomfort")]
)
def test_it_is_what_trying_everything_finds(who: str, measure: str, tmp_path: Path) -> None:
    config = problem(tmp_path, people={"walkers": WALKERS[who]}, nearness=measure)
    lattice, key = lattice_of(config), key_of(config, 0)
    every = np.array(list(sequences(lattice, config.max_episode_steps))) / (LEVELS - 1)
    assert len(every) > 500
    found = optimum(config, ScenarioSampler(config).draw(key), key, with_speeds=True)
    assert found.value == pytest.approx(returns_of(config, every, 0).max(), abs=1e-6)


def test_its_speeds_earn_what_it_says() -> None:
    short = {"place_options": {"length_m": 5.0}, "max_episode_steps": 250}
    config = make_config(headroom_config("Crossing-v1", is_scripted=True), **short)
    key = key_of(config, 2)
    found = optimum(config, ScenarioSampler(config).draw(key), key, with_speeds=True)
    shares = found.speeds_mps[None, :] / config.drive.nominal_speed_mps
    assert returns_of(config, shares, 2)[0] == pytest.approx(found.value, abs=1e-5)


@given(st.lists(st.integers(0, LEVELS - 1), min_size=1, max_size=40))
def test_commands_beyond_the_limits_buy_nothing(commands: list[int]) -> None:
    asked = np.array([0, *commands]) / (LEVELS - 1)
    speed, speeds = 0.0, [0.0]
    for command in asked[1:]:  # a tenth up, two tenths down a decision
        speed += float(np.clip(command - speed, -0.2, 0.1))
        speeds.append(speed)
    cost = float((np.diff(asked) ** 2).sum())
    assert float((np.diff(speeds) ** 2).sum()) <= cost + 1e-9


def test_what_it_cannot_solve(tmp_path: Path) -> None:
    reacting = make_config(drive=QUIET_DRIVE)
    with refused("people.model ... 'social_force'"):
        optimum(reacting, ScenarioSampler(reacting).draw(0), 0)
    noisy = make_config(people={"model": "scripted"})
    with refused("wheel_loop ideal"):
        optimum(noisy, ScenarioSampler(noisy).draw(0), 0)
    for changes in ({"latency_steps": 1}, {"line_sensor": {"pitch_m": 0.015}}):
        late = problem(tmp_path, drive={**QUIET_DRIVE, **changes})
        with refused("latency_steps 0, and no line_sensor"):
            optimum(late, ScenarioSampler(late).draw(0), 0)
    sluggish = problem(tmp_path, drive={**QUIET_DRIVE, "acceleration_mps2": 0.3})
    with refused("slew limits"):
        optimum(sluggish, ScenarioSampler(sluggish).draw(0), 0)


@given(
    st.sampled_from(NEARNESS), st.integers(0, LEVELS - 1), st.integers(-1, 1), st.floats(0.0, 2.0)
)
def test_a_decision_without_contact_earns_the_terms_of_the_reward(
    measure: Any, level: int, change: int, clearance_m: float
) -> None:
    config = Config(nearness=measure)
    lattice, rules, weights = lattice_of(config), rules_of(config), np.array(config.reward)
    following = min(max(level + change, 0), LEVELS - 1)
    sure, slope = reward_of(level, following, lattice, weights, rules)
    robot, people = records(ROBOT, 1).view(np.recarray), records(PERSON, 1).view(np.recarray)
    step, terms = records(STEP, 1).view(np.recarray), np.zeros(len(TERMS))
    robot[0].v = lattice.speeds_mps[following]
    people[0].status, people[0].radius = PRESENT, 0.2
    people[0].x = clearance_m + 0.2 + ROBOT_RADIUS_M
    way_m = lattice.ways[level, following] * lattice.unit_m
    step[0].progress = way_m / (rules.nominal_speed_mps * rules.decision_s)
    speeds = lattice.speeds_mps
    step[0].command_change = (speeds[following] - speeds[level]) / rules.nominal_speed_mps
    reward_terms(robot[0], people, step[0], rules, terms)
    earned = sure + slope * nearness(robot[0], people, rules.nearness)
    assert earned == pytest.approx(total(terms, weights), abs=1e-9)
