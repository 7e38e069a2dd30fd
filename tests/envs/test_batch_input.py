"""A mistake of the user's gets one line, and changes nothing."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.vector import CorridorVectorEnv
from tests.refusals import refused

GOOD = np.zeros((3, 1))


@pytest.mark.parametrize(
    "bad",
    [
        np.zeros(3),
        np.zeros((2, 1)),
        np.zeros((3, 2)),
        np.array([[0.0], [np.nan], [0.0]]),
        np.array([[0.0], [1.001], [0.0]]),
        np.array([[0.0], [-np.inf], [0.0]]),
        [["fast"], ["slow"], ["fast"]],
        None,
    ],
    ids=str,
)
def test_bad_actions_are_refused_and_change_nothing(bad: Any) -> None:
    refused_unchanged(lambda envs: envs.step(bad), "actions")


@pytest.mark.parametrize(
    ("given", "commanded"),
    [(np.float32(1.0000001), 1.0), (-1.0000005, -1.0), (1.0 + 9e-7, 1.0), (1, 1.0)],
)
def test_an_action_beyond_the_bounds_by_rounding_is_clipped(given: Any, commanded: float) -> None:
    envs, exact, env = CorridorVectorEnv(3), CorridorVectorEnv(3), CorridorEnv()
    envs.reset(seed=0), exact.reset(seed=0), env.reset(seed=0)
    observations = envs.step(np.full((3, 1), given))[0]
    assert np.array_equal(observations, exact.step(np.full((3, 1), commanded))[0])
    assert env.step(np.array([given]))[0] == pytest.approx(observations[0], abs=1e-6)
    assert env.snapshot().command_mps == envs.state().robots["command"][0]


@pytest.mark.parametrize("bad", [1.0 + 2e-6, -1.0 - 2e-6, np.nan, np.inf, 1e9])
def test_an_action_further_beyond_the_bounds_is_refused(bad: float) -> None:
    env = CorridorEnv()
    env.reset(seed=0)
    with refused("action"):
        env.step(np.array([bad]))
    refused_unchanged(lambda envs: envs.step(np.full((3, 1), bad)), "actions")


@pytest.mark.parametrize(
    "bad", [[0, 1, 5], [-1, 0, 0], [0, 1], [0.0, 1.0, 2.0], [True, False, True]]
)
def test_bad_discrete_actions_are_refused_and_change_nothing(bad: Any) -> None:
    refused_unchanged(lambda envs: envs.step(np.array(bad)), "actions", action_type="discrete")


@pytest.mark.parametrize("bad", [[[0.0], [0.0, 1.0], [0.0]], [0.0, [1.0], 0.0]])
def test_ragged_actions_are_refused_and_change_nothing(bad: Any) -> None:
    refused_unchanged(lambda envs: envs.step(bad), "actions")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"seed": [1, 2]}, "seed ... 2 seeds for 3 worlds"),
        ({"seed": [1, 2, -3]}, "seed ... -3, allowed"),
        ({"seed": -1}, "seed ... -1, allowed"),
        ({"seed": 1.5}, "seed: given"),
        ({"seed": [1, 2, "x"]}, "seed ... 'x', allowed"),
        ({"options": {"kye": 3}}, "reset options ... kye ... key, config and reset_mask"),
        ({"options": {7: 3}}, "reset options ... 7 ... key, config and reset_mask"),
        ({"options": {"key": -1}}, "reset options: key ... -1, allowed"),
        ({"options": {"key": 2**63}}, "reset options: key ... 9223372036854775808, allowed"),
        ({"seed": True}, "seed ... True, allowed"),
        ({"seed": "12"}, "seed ... '12', allowed"),
        ({"options": 5}, "reset options ... 5 ... dict with key, config and reset_mask"),
        ({"options": {"key": True}}, "reset options: key ... True, allowed"),
        ({"options": {"key": 1.0}}, "reset options: key ... 1.0, allowed"),
        ({"options": {"key": "one"}}, "reset options: key ... 'one', allowed"),
        ({"options": {"key": [1, 2]}}, "reset options ... 2 keys for 3 worlds"),
        ({"options": {"key": [1, 2, 0.5]}}, "reset options: key ... 0.5, allowed"),
        ({"options": {"reset_mask": [True, True, True]}}, "reset_mask: given"),
        ({"options": {"reset_mask": np.ones(2, np.bool_)}}, "reset_mask: given"),
        ({"options": {"reset_mask": np.ones(3)}}, "reset_mask: given"),
        ({"options": {"reset_mask": np.zeros(3, np.bool_)}}, "reset_mask ... no world"),
    ],
    ids=str,
)
def test_bad_resets_are_refused_and_change_nothing(arguments: Any, complaint: str) -> None:
    refused_unchanged(lambda envs: envs.reset(**arguments), complaint)


def test_a_bad_mask_of_a_step_is_refused_and_changes_nothing() -> None:
    refused_unchanged(lambda envs: envs.step(GOOD, mask=np.ones(4, np.bool_)), "mask ... (4,)")


def refused_unchanged(
    ask: Callable[[CorridorVectorEnv], Any], complaint: str, **arguments: Any
) -> None:
    envs = CorridorVectorEnv(3, **arguments)
    envs.reset(seed=0)
    before = pickle.dumps(envs)
    with refused(complaint):
        ask(envs)
    assert pickle.dumps(envs) == before


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"num_envs": 0}, "num_envs ... 0"),
        ({"num_envs": True}, "num_envs ... True"),
        ({"num_envs": 10**9}, "num_envs ... 1000000000 ... integers from 1 to 100,000"),
        ({"threads": 10**9}, "threads ... 1000000000 ... integers from 1 to 1,024"),
        ({"num_envs": 2.0}, "num_envs ... 2.0"),
        ({"threads": 0}, "threads ... 0"),
        ({"autoreset_mode": "Never"}, "autoreset_mode ... 'Never'"),
        ({"render_mode": "human"}, "render_mode ... 'human'"),
        ({"max_episode_steps": 0}, "max_episode_steps ... 0"),
        ({"tier": "sight"}, "tier ... 'sight'"),
        ({"colour": "red"}, "colour: unknown"),
    ],
    ids=str,
)
def test_bad_arguments_are_refused_in_one_line(arguments: Any, complaint: str) -> None:
    with refused(complaint):
        CorridorVectorEnv(**{"num_envs": 2, **arguments})


def test_what_a_wrong_argument_leaves_can_be_closed() -> None:
    CorridorVectorEnv.__new__(CorridorVectorEnv).close()  # as Gymnasium 1.1 does by itself


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_stepping_before_the_first_reset_is_refused(mode: AutoresetMode) -> None:
    with refused("step ... reset"):
        CorridorVectorEnv(3, autoreset_mode=mode).step(GOOD)


def test_without_autoreset_a_world_that_is_over_must_be_reset() -> None:
    envs = CorridorVectorEnv(3, max_episode_steps=1, autoreset_mode=AutoresetMode.DISABLED)
    envs.reset(seed=0)
    envs.step(GOOD)
    envs.reset(options={"reset_mask": np.array([True, False, True])})
    with refused("step ... 1 worlds ... first is 1"):
        envs.step(GOOD)
