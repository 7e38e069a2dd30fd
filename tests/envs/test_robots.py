"""Several robots in one place: conformance with PettingZoo, and what they do to each other."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.state import PRESENT, ROBOT_RADIUS_M
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import MissingExtra
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.sim.walking import BLOCKING_RANGE_M
from hazbot_gym.task.observation import layout_in
from hazbot_gym.task.places import load_place
from hazbot_gym.task.robot_paths import Lanes, lanes_in, robot_paths
from tests.refusals import refused

CROSSING: dict[str, Any] = {"place": "intersection", "people": {"count": [2, 5]}}
EMPTY: dict[str, Any] = {"place": "open", "people": {"count": [0, 0]}}
# Its tests import its games by their old names.
pytestmark = pytest.mark.filterwarnings(
    "ignore:The old environment creation API:DeprecationWarning"
)
Actions = Callable[[dict[str, Any]], dict[str, Any]]


@pytest.fixture
def parallel_env() -> Any:
    pytest.importorskip("pettingzoo", reason="needs the extra robots")
    return import_module("hazbot_gym.envs.robots").parallel_env


def at(action: float) -> Actions:
    return lambda observations: {name: np.full(1, action, np.float32) for name in observations}


def at_random(seed: int) -> Actions:
    rng = np.random.default_rng(seed)
    return lambda observations: {
        name: rng.uniform(-0.5, 1.0, 1).astype(np.float32) for name in observations
    }


def play(env: Any, act: Actions, seed: int, steps: int = 2000) -> list[Any]:
    """Return the results of reset and steps, until no robot is left."""
    told = [env.reset(seed=seed)]
    while env.agents and len(told) <= steps:
        seen = {name: told[-1][0][name] for name in env.agents}
        told.append(env.step(act(seen)))
    return told


def ends(told: list[Any]) -> dict[str, dict[str, Any]]:
    """Return the last info of each robot."""
    return {name: info for step in told for name, info in step[-1].items()}


# --- PettingZoo ----------------------------------------------------------------------------------


@pytest.mark.parametrize("robots", [2, 6])
def test_passes_the_api_test_of_pettingzoo(parallel_env: Any, robots: int) -> None:
    from pettingzoo.test import parallel_api_test

    parallel_api_test(parallel_env(robots, max_episode_steps=60, **CROSSING), num_cycles=200)


def test_passes_the_seed_test_of_pettingzoo(parallel_env: Any) -> None:
    from pettingzoo.test import parallel_seed_test

    parallel_seed_test(lambda: parallel_env(3, max_episode_steps=60, **CROSSING), num_cycles=200)


def test_equal_seeds_give_equal_episodes_and_others_do_not(parallel_env: Any) -> None:
    used, fresh = parallel_env(4, **CROSSING), parallel_env(4, **CROSSING)
    first = play(used, at_random(1), seed=7, steps=100)
    other = play(used, at_random(1), seed=8, steps=100)
    again = play(used, at_random(1), seed=7, steps=100)

    assert repr(first) == repr(again) == repr(play(fresh, at_random(1), seed=7, steps=100))
    assert repr(first) != repr(other)


def test_a_key_chooses_the_scenario(parallel_env: Any) -> None:
    env = parallel_env(2, **CROSSING)

    _, infos = env.reset(seed=0, options={"key": 5})

    assert {info["scenario_key"] for info in infos.values()} == {5}


# --- one robot -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "config",
    [
        {},
        {"place": "circle", "tier": "sonar", "drive": {"latency_steps": 3, "reflex_stop_m": 0.5}},
        {"people": {"count": [8, 8]}, "sensors": {"tracker": {"latency_steps": 2}}},
        {"people": {"model": "scripted", "count": [4, 4]}, "place": "doorway"},
    ],
)
def test_one_robot_alone_is_the_single_environment_to_the_bit(
    parallel_env: Any, config: dict[str, Any]
) -> None:
    env = parallel_env(1, keep_right_m=0.0, start_spread_m=0.0, **config)
    single = CorridorVectorEnv(1, config, autoreset_mode="Disabled")
    for seed in range(3):
        observations, _ = env.reset(seed=seed)
        expected, _ = single.reset(seed=[seed])
        act, told = at_random(seed), [{}]
        while env.agents:
            np.testing.assert_array_equal(observations["robot_0"], expected[0])
            actions = act(observations)
            observations, *told = env.step(actions)
            expected, *single_told, info = single.step(actions["robot_0"][None])
            assert [each["robot_0"] for each in told[:3]] == [each[0] for each in single_told]
        np.testing.assert_array_equal(observations["robot_0"], expected[0])
        for key, value in told[3]["robot_0"].items():
            terms = info[key]
            is_terms = key == "reward_terms"
            assert value == ({n: terms[n][0] for n in value} if is_terms else terms[0])


# --- robots among each other ---------------------------------------------------------------------


def test_a_robot_observes_another_like_a_person_but_its_reward_does_not(parallel_env: Any) -> None:
    env = parallel_env(2, **EMPTY)
    layout, seen = layout_in(env.config), []
    for told in play(env, at(1.0), seed=0)[1:]:
        for name, observation in told[0].items():
            seen.append(layout.decode(observation))
            assert told[4][name]["reward_terms"]["intrusion"] == 0.0

    assert max(float(each["person0_present"]) for each in seen) == 1.0
    assert min(float(each["range_front_left_m"]) for each in seen) < 2.0


def test_robots_on_one_line_run_into_each_other_both_at_fault(parallel_env: Any) -> None:
    env = parallel_env(2, keep_right_m=0.0, start_spread_m=0.0, **EMPTY)

    told = play(env, at(1.0), seed=0)

    first, second = ends(told).values()
    for info in (first, second):
        assert info["outcome"] == "contact_robot"
        assert info["contact_caused_by"] == "robot"
        assert info["contact_speed_mps"] == pytest.approx(1.0, abs=0.05)
        assert info["reward_terms"]["contact"] > 0.5
    assert first["time_s"] == second["time_s"]
    gap_m = np.hypot(*(np.diff(env.robots[axis])[0] for axis in ("x", "y"))) - 2 * ROBOT_RADIUS_M
    assert -0.04 < gap_m < 0.0


def test_a_standing_robot_is_not_at_fault(parallel_env: Any) -> None:
    env = parallel_env(2, keep_right_m=0.0, start_spread_m=0.0, **EMPTY)

    told = play(
        env, lambda seen: {n: np.float32([1.0 if n == "robot_0" else -1.0]) for n in seen}, 0
    )

    causes = {name: info["contact_caused_by"] for name, info in ends(told).items()}
    assert causes == {"robot_0": "robot", "robot_1": "other_robot"}


def test_a_robot_that_arrived_is_gone_and_the_others_go_on(parallel_env: Any) -> None:
    env = parallel_env(2, **EMPTY)

    def one_waits(observations: dict[str, Any]) -> dict[str, Any]:
        slow = -1.0 if len(observations) == 2 else 1.0
        return {n: np.float32([1.0 if n == "robot_0" else slow]) for n in observations}

    told = play(env, one_waits, seed=0)

    assert {info["outcome"] for info in ends(told).values()} == {"arrived"}
    times_s = [info["time_s"] for info in ends(told).values()]
    assert times_s[1] > times_s[0] + 20.0
    layout = layout_in(env.config)
    last = layout.decode(told[-1][0]["robot_1"])
    assert last["person0_present"] == 0.0


def test_people_are_those_of_now_also_after_the_last_decision(parallel_env: Any) -> None:
    env = parallel_env(2, place="open", people={"count": [4, 4]}, max_episode_steps=400)
    env.reset(seed=0)
    while env.agents:
        before = env.people
        env.step({name: np.float32([1.0 if name == "robot_0" else -1.0]) for name in env.agents})

    moved_m = np.hypot(env.people["x"] - before["x"], env.people["y"] - before["y"])
    assert moved_m.max() < 0.3


def test_most_people_get_past_robots_that_stand_in_their_lanes(parallel_env: Any) -> None:
    env = parallel_env(2, place="intersection", people={"count": [6, 6]}, max_episode_steps=600)
    stuck = 0
    for seed in range(6):
        env.reset(seed=seed)
        for step in range(600):
            if env.agents:  # drive for 8 s, then stand
                env.step(at(1.0 if step < 80 else -1.0)(dict.fromkeys(env.agents)))
        people, robots = env.people, env.robots
        there = people[people["status"] == PRESENT]
        away_m = np.hypot(there["x"][:, None] - robots["x"], there["y"][:, None] - robots["y"])
        stuck += np.count_nonzero(away_m < 1.0)

    assert stuck <= 3  # of 36, after 52 s


def test_people_walk_into_no_robot_and_each_robot_burdens_its_own(parallel_env: Any) -> None:
    env = parallel_env(6, place="intersection", people={"count": [8, 8]}, max_episode_steps=300)
    burdens = []
    for seed in range(3):
        env.reset(seed=seed)
        while env.agents:
            _, _, _, _, infos = env.step(at(-1.0)(dict.fromkeys(env.agents)))
            people, robots = env.people, env.robots
            there = people[people["status"] == PRESENT]
            away_m = np.hypot(there["x"][:, None] - robots["x"], there["y"][:, None] - robots["y"])
            assert (away_m > ROBOT_RADIUS_M + there["radius"][:, None]).all()
            burdens.append([info["reward_terms"]["burden"] for info in infos.values()])
            is_far = away_m.min(axis=0, initial=np.inf) > BLOCKING_RANGE_M + 1.0
            assert not np.any(np.array(burdens[-1])[is_far])
        assert {info["outcome"] for info in infos.values()} == {"timeout"}
    assert np.max(burdens) > 0.0


@pytest.mark.parametrize("policy", ["fuzzy_expert", "ppo"])
def test_policies_of_one_robot_drive_several(parallel_env: Any, policy: str) -> None:
    env, driver = parallel_env(4, **CROSSING), make_policy(policy)

    def act(observations: dict[str, Any]) -> dict[str, Any]:
        actions, _ = driver.predict(np.stack(list(observations.values())), deterministic=True)
        return dict(zip(observations, actions, strict=True))

    told = play(env, act, seed=0, steps=100)

    assert all(np.isfinite(list(step[1].values())).all() for step in told[1:])
    assert max(env.robots["s"]) > 1.0


# --- paths ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", ["open", "corridor", "intersection", "circle", "aisle"])
def test_opposite_robots_pass_on_the_right(place: str) -> None:
    there, back = robot_paths(load_place(place), 2, Lanes(0.45, 0.0), key=0)
    points = [
        sample_path(path, np.arange(0.0, path_length(path.view(np.recarray)), 0.01))
        for path in (there, back)
    ]

    for mine, other in (points, points[::-1]):
        for x, y, heading, _ in mine[200:-200:50]:
            dx, dy = other[:, 0] - x, other[:, 1] - y
            near = int(np.argmin(np.hypot(dx, dy)))
            assert np.hypot(dx, dy)[near] == pytest.approx(0.9, abs=0.01)
            assert np.cos(heading) * dy[near] - np.sin(heading) * dx[near] > 0.8  # on its left


def test_lanes_are_as_far_right_as_there_is_room() -> None:
    usual = [
        lanes_in(place, load_place(place), robots, right_m=None, spread_m=0.0).right_m
        for place, robots in (("intersection", 6), ("corridor", 2), ("corridor", 4), ("aisle", 2))
    ]

    assert usual == [0.6, 0.6, 0.45, 0.45]


def test_crossing_paths_meet_after_equal_ways() -> None:
    paths = robot_paths(load_place("intersection"), 4, Lanes(0.0, 0.0), key=0)

    middles = [sample_path(path, np.array([6.0]))[0, :2] for path in paths]

    np.testing.assert_allclose(middles, np.full((4, 2), [6.0, 0.0]), atol=0.1)


def test_robots_on_one_way_start_apart() -> None:
    for key in range(20):
        paths = robot_paths(load_place("open"), 6, Lanes(0.6, 2.0), key)
        starts = np.array([[path["x"][0], path["y"][0]] for path in paths])
        away_m = np.hypot(*(starts[:, None] - starts).T)[~np.eye(6, dtype=bool)]
        assert away_m.min() > 2 * ROBOT_RADIUS_M


# --- refusals ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"robots": 7}, "robots: given 7, allowed ... 1 to 6"),
        ({"place": "doorway"}, "place doorway ... keep_right_m = 0.45 ... 0.30 m"),
        ({"gas": {}}, "robots: given gas"),
        ({"people": {"model": "replay"}}, "robots: given recordings"),
        ({"drive": {"acceleration_mps2": {"uniform": [0.3, 0.6]}}}, "robots: given randomised"),
        ({"place": "aisle", "keep_right_m": -0.6}, "place aisle ... keep_right_m = -0.6 ... wall"),
        ({"place": "aisle", "keep_right_m": 1.2}, "keep_right_m: given 1.2 ... bend"),
        ({"keep_right_m": float("nan")}, "keep_right_m: given nan"),
        ({"keep_right_m": "half"}, "keep_right_m: given 'half' ... numbers"),
        ({"start_spread_m": -1.0}, "start_spread_m: given -1"),
        ({"start_spread_m": None}, "start_spread_m: given None"),
    ],
)
def test_refuses(parallel_env: Any, arguments: dict[str, Any], said: str) -> None:
    with refused(said):
        parallel_env(**arguments)


def test_refuses_actions_of_other_robots(parallel_env: Any) -> None:
    env = parallel_env(2, **EMPTY)
    with refused("step: ... call reset"):
        env.step({})
    with refused("robots: ... call reset"):
        env.people  # noqa: B018
    with refused("reset options: given config"):
        env.reset(options={"config": {"people": {"count": [1, 1]}}})
    with refused("reset options: given 'key', allowed is a dict"):
        env.reset(options="key")
    env.reset(seed=0)
    with refused("actions: given those of robot_0, allowed ... robot_0, robot_1"):
        env.step({"robot_0": np.zeros(1, np.float32)})
    with refused("actions: given list ... mapping"):
        env.step([0.0, 0.0])
    with refused("actions: given ... no array"):
        env.step({"robot_0": np.zeros(1), "robot_1": np.zeros(2)})
    with refused("actions: ... -1 <= action <= 1"):
        env.step(at(2.0)(dict.fromkeys(env.agents)))


def test_missing_pettingzoo_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pettingzoo", None)
    monkeypatch.delitem(sys.modules, "hazbot_gym.envs.robots", raising=False)

    with refused("pettingzoo ... pip install 'hazbot-gym[robots]'", error=MissingExtra):
        import_module("hazbot_gym.envs.robots")
