"""Gas in whole episodes: what it adds, what it leaves alone, and how a survey ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.gas import Plume, concentration
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.task.survey import FALSE_ALARM
from tests.gas_columns import without_gas

ALONE: dict[str, Any] = {"count": [0, 0]}
STRONG: dict[str, Any] = {"leak_share": 1.0, "strength_ppm": [500.0, 500.0]}
WEAK: dict[str, Any] = {"leak_share": 1.0, "strength_ppm": [1e-6, 1e-6]}
SENSOR = {"rise_s": 0.5, "decay_s": 4.0, "half_ppm": 5.0, "exponent": 0.5}

Speed = Callable[[int], float]  # action of a decision


def steadily(_: int) -> float:
    return 1.0


def hesitantly(decision: int) -> float:
    return -1.0 if decision % 50 < 20 else 0.2


def a_gas(**gas: Any) -> CorridorEnv:
    return CorridorEnv(gas=gas, people=ALONE)


def drive(env: CorridorEnv, seed: int, speed: Speed = steadily) -> list[Any]:
    """Return reset and steps of an episode: observation, reward, info and true state."""
    observation, info = env.reset(seed=seed)
    told: list[Any] = [(observation, 0.0, info, env.snapshot())]
    while told[-1][2]["outcome"] == "running":
        observation, reward, *_, info = env.step(np.array([speed(len(told))]))
        told.append((observation, reward, info, env.snapshot()))
    return told


def terms(told: list[Any]) -> Floats:
    """Return the survey term of each decision."""
    return np.array([info["reward_terms"]["survey"] for *_, info, _ in told])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_gas_adds_its_entries_and_its_reward_and_changes_nothing_else(seed: int) -> None:
    gas, plain = (gymnasium.make(f"hazbot_gym/{name}-v1") for name in ("Inspection", "Corridor"))
    for each in (gas, plain):
        assert isinstance(each.unwrapped, CorridorEnv)
    weight = gas.unwrapped.config.reward.survey
    with_gas, without = (drive(each.unwrapped, seed, hesitantly) for each in (gas, plain))
    assert len(with_gas) == len(without)
    for (seen, reward, info, _), (other, others, told, _) in zip(with_gas, without, strict=True):
        assert without_gas(seen).tobytes() == other.tobytes()
        assert reward == pytest.approx(others + weight * info["reward_terms"]["survey"], abs=1e-9)
        assert {name: info[name] for name in told if name != "reward_terms"} == {
            name: value for name, value in told.items() if name != "reward_terms"
        }


def test_inspection_without_people_has_none() -> None:
    env = gymnasium.make("hazbot_gym/InspectionEmpty-v1").unwrapped
    assert isinstance(env, CorridorEnv)
    for seed in range(3):
        assert all(len(state.people) == 0 for *_, state in drive(env, seed))


def test_leak_and_field_are_the_same_however_the_robot_drives() -> None:
    """So that policies are compared in the same gas: at an equal place and time it is equal."""
    records, env = [], a_gas(**STRONG)
    for speed in (steadily, hesitantly):
        told = drive(env, 4, speed)
        key = np.uint64(told[0][2]["scenario_key"])
        assert len({state.gas["leak"].tobytes() for *_, state in told}) == 1
        records.append(told[0][3].gas["leak"].copy())
        leak = records[0].view(np.recarray)[0]
        for *_, info, state in told:
            s = state.gas["smell"]["s_m"][0]
            field = concentration(leak, Plume(), s, state.y_e, state.time_s, key)
            assert info["gas"]["concentration_ppm"] == pytest.approx(field, rel=1e-9)
    assert records[0].tobytes() == records[1].tobytes()


def test_noise_of_the_sensor_is_the_same_however_the_robot_drives() -> None:
    env = a_gas(leak_share=0.0)
    one, other = (
        [info["gas"]["reading"] for *_, info, _ in drive(env, 4, speed)][:200]
        for speed in (steadily, hesitantly)
    )
    assert one == other
    assert np.std(one) > 0.0


def test_other_episodes_have_other_leaks() -> None:
    env = a_gas(**STRONG)
    leaks = {env.reset(seed=seed)[1]["gas"]["leak_s_m"] for seed in range(5)}
    assert len(leaks) == 5


# --- how a survey ends ---------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_strong_leak_is_reported_once(seed: int) -> None:
    told = drive(a_gas(**STRONG), seed, hesitantly)
    survey = terms(told)
    (at,) = np.flatnonzero(survey == 1.0)
    assert -1.0 not in survey
    assert [info["gas"]["reported"] for *_, info, _ in told] == [0] * at + [1] * (len(told) - at)
    assert told[at][2]["gas"]["alarm"] == 1
    assert told[at][2]["gas"]["reading"] >= 1.0
    assert told[at][2]["gas"]["concentration_ppm"] > 0.0
    assert told[at][0][15] == 1.0  # gas_alarmed


def test_a_leak_too_weak_to_smell_is_missed_at_the_end() -> None:
    told = drive(a_gas(**WEAK), 1)
    assert terms(told).tolist() == [0.0] * (len(told) - 1) + [-1.0]
    assert told[-1][2]["outcome"] == "arrived"
    assert told[-1][2]["gas"]["leak"] == 1


def test_without_a_leak_nothing_is_missed() -> None:
    told = drive(a_gas(leak_share=0.0), 1)
    assert not terms(told).any()
    assert {name: told[-1][2]["gas"][name] for name in ("leak", "leak_s_m", "leak_distance_m")} == {
        "leak": 0, "leak_s_m": 0.0, "leak_distance_m": 0.0
    }  # fmt: skip


def test_a_nervous_sensor_raises_false_alarms() -> None:
    told = drive(a_gas(leak_share=0.0, sensor={**SENSOR, "false_alarms_per_h": 3600.0}), 1)
    survey = terms(told)
    assert set(survey) == {0.0, FALSE_ALARM}
    counts = [info["gas"]["false_alarms"] for *_, info, _ in told]
    assert counts == np.cumsum(survey != 0.0).tolist()
    assert counts[-1] > 5


def test_a_leak_around_the_start_is_reported_by_a_sensor_without_lag() -> None:
    """The alarm must not be lost to the reset, where no decision is judged."""
    sudden = {**SENSOR, "rise_s": 1e-3}
    gas = {"leak_share": 1.0, "strength_ppm": [1e6, 1e6], "sensor": sudden}
    env = CorridorEnv(gas=gas, people=ALONE)
    early = 0
    for seed in range(12):
        told = drive(env, seed)
        assert told[0][2]["gas"]["alarm"] == 0
        assert told[-1][2]["gas"]["reported"] == 1
        early += told[0][2]["gas"]["reading"] > 1.0
    assert early > 1


def test_leak_lies_ahead_and_then_behind() -> None:
    told = drive(a_gas(**STRONG), 2)
    ahead = [info["gas"]["leak_distance_m"] for *_, info, _ in told]
    assert ahead[0] == pytest.approx(told[0][2]["gas"]["leak_s_m"], abs=0.1)
    assert ahead[0] > 0.0 > ahead[-1]


# --- a sensor given as data ----------------------------------------------------------------------


def test_a_sensor_given_in_full_is_the_one_that_smells() -> None:
    """A sensor that rises six times as fast reports the same leak earlier."""
    firsts = []
    for sensor in (SENSOR, {**SENSOR, "rise_s": 3.0}):
        told = drive(a_gas(**STRONG, sensor=sensor), 3)
        firsts.append(int(terms(told).argmax()))
        last, before = told[firsts[-1]][3].gas["smell"], told[firsts[-1] - 1][3].gas["smell"]
        steady = (1.0 + last["concentration_ppm"] / 5.0) ** 0.5 - 1.0
        share = 1.0 - np.exp(-0.1 / sensor["rise_s"])
        assert last["response"] - before["response"] == pytest.approx(
            share * (steady - before["response"])
        )
    assert 0 < firsts[0] < firsts[1]
