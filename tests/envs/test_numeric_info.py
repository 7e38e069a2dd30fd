"""Clients that read nothing but numbers get them all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.numeric_info import NumericInfo
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.task.reward import TERMS

NUMBERS = {
    "scenario_key",
    "time_free_s",
    "time_s",
    "cost",
    "contact_speed_mps",
    *(f"reward_terms/{name}" for name in TERMS),
}
MODE = AutoresetMode.SAME_STEP


def batches(**options: Any) -> list[VectorEnv[Any, Any, Any]]:
    options["max_episode_steps"] = 20
    return [
        CorridorVectorEnv(2, autoreset_mode=MODE, **options),
        SyncVectorEnv(2 * [lambda: CorridorEnv(**options)], autoreset_mode=MODE),
    ]


@pytest.mark.parametrize("kind", [0, 1], ids=["native", "sync"])
def test_infos_hold_every_number_and_nothing_else(kind: int) -> None:
    envs, plain = NumericInfo(batches()[kind]), batches()[kind]
    assert set(envs.reset(seed=1)[1]) == NUMBERS
    plain.reset(seed=1)
    for _ in range(25):
        (*one, info), (*other, told) = (each.step(np.zeros((2, 1))) for each in (envs, plain))
        assert all(np.array_equal(mine, others) for mine, others in zip(one, other, strict=True))
        assert info["reward_terms/progress"].tolist() == told["reward_terms"]["progress"].tolist()
        if "final_info" in told:
            assert set(info["final_info"]) == NUMBERS
            assert info["final_info"]["time_s"].tolist() == [2.0, 2.0]
            assert info["final_obs"][0].shape == (51,)


@pytest.mark.parametrize("kind", [0, 1], ids=["native", "sync"])
def test_numbers_of_gas_are_flat_as_well(kind: int) -> None:
    envs, plain = NumericInfo(batches(gas={})[kind]), batches(gas={})[kind]
    for each in (envs, plain):
        each.reset(seed=1)
    for _ in range(25):
        info, told = (each.step(np.zeros((2, 1)))[-1] for each in (envs, plain))
        assert NUMBERS | {"reward_terms/survey"} < set(info)
        for name, values in told["gas"].items():
            if not name.startswith("_"):
                assert info[f"gas/{name}"].tolist() == values.tolist()
