"""Properties of the reward under its default weights."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from typing import Any

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hazbot_gym.config import make_config
from hazbot_gym.core.proxemics import INTIMATE_M
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.task.outcome import BY_ROBOT
from hazbot_gym.task.reward import contact_severity

EMPTY = {"count": [0, 0]}


def make(**options: Any) -> CorridorEnv:
    env = gymnasium.make("hazbot_gym/Corridor-v1", **options).unwrapped
    assert isinstance(env, CorridorEnv)
    return env


def drive(env: CorridorEnv, shares: Iterable[float]) -> tuple[float, float, str]:
    """Drive at shares of the nominal speed; return the return, the distance [m] and the outcome."""
    env.reset(seed=0)
    total = 0.0
    for share in shares:
        _, reward, terminated, truncated, info = env.step(np.array([2.0 * share - 1.0]))
        total += float(reward)
        if terminated or truncated:
            return total, env.snapshot().s_m, str(info["outcome"])
    return total, env.snapshot().s_m, "running"


def with_walker(x: float, y: float, vx: float, vy: float) -> CorridorEnv:
    walker = {"x_m": x, "y_m": y, "vx_mps": vx, "vy_mps": vy}
    return make(place="open", people={"model": "scripted", "walkers": [walker]})


# --- in an empty corridor full speed is optimal --------------------------------------------------

CORRIDOR = make(people=EMPTY)
FULL_RETURN, _, FULL_OUTCOME = drive(CORRIDOR, itertools.repeat(1.0))


def test_full_speed_arrives() -> None:
    assert FULL_OUTCOME == "arrived"


def test_alone_the_return_grows_with_a_constant_speed() -> None:
    returns = [drive(CORRIDOR, itertools.repeat(share))[0] for share in np.linspace(0.0, 1.0, 11)]
    assert np.all(np.diff(returns) > 0.0)
    assert returns[-1] == FULL_RETURN


@settings(max_examples=25, deadline=None)
@given(
    levels=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8),
    hold=st.integers(1, 60),
)
def test_alone_no_speed_profile_beats_full_speed(levels: list[float], hold: int) -> None:
    profile = itertools.cycle(level for level in levels for _ in range(hold))
    assert drive(CORRIDOR, profile)[0] <= FULL_RETURN + 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_alone_no_random_walk_of_the_speed_beats_full_speed(seed: int) -> None:
    steps = np.random.default_rng(seed).normal(0.0, 0.1, 600)
    profile = np.clip(0.8 + np.cumsum(steps), 0.0, 1.0)
    assert drive(CORRIDOR, profile)[0] < FULL_RETURN


# --- standing for ever is worse than arriving slowly ---------------------------------------------


@pytest.mark.parametrize("share", [0.45, 0.5, 0.75])
def test_standing_for_ever_is_worse_than_arriving_slowly(share: float) -> None:
    slow, _, outcome = drive(CORRIDOR, itertools.repeat(share))
    standing, _, waited = drive(CORRIDOR, itertools.repeat(0.0))
    assert (outcome, waited) == ("arrived", "timeout")
    assert standing < slow - 100.0


# --- through somebody's intimate zone it is better to wait ---------------------------------------


def nearest_m(env: CorridorEnv, shares: Callable[[float], float]) -> tuple[float, float, str]:
    """Drive by a rule of the time [s]; return the return, the least clearance [m], the outcome."""
    env.reset(seed=0)
    total, nearest, time_s = 0.0, np.inf, 0.0
    while True:
        action = np.array([2.0 * shares(time_s) - 1.0])
        _, reward, terminated, truncated, info = env.step(action)
        total += float(reward)
        state, time_s = env.snapshot(), float(info["time_s"])
        distances = np.hypot(state.people["x"] - state.x, state.people["y"] - state.y)
        nearest = min(nearest, float(distances.min()) - 0.5)
        if terminated or truncated:
            return total, nearest, str(info["outcome"])


@pytest.mark.parametrize("late_s", [-1.2, -1.0, -0.8, 0.8, 1.0])
@pytest.mark.parametrize("speed_mps", [0.5, 0.8])
def test_at_full_speed_through_an_intimate_zone_is_worse_than_waiting(
    late_s: float, speed_mps: float
) -> None:
    """A person crosses the path at 4 m, a little before or after a robot at full speed does."""
    there_s = 4.0 / 0.5 + 0.6
    env = with_walker(4.0, speed_mps * (there_s + late_s), 0.0, -speed_mps)
    rushed, clearance, _ = nearest_m(env, lambda time_s: 1.0)
    assert clearance < INTIMATE_M
    gone_s = there_s + late_s + 1.5 / speed_mps
    waited, free, outcome = nearest_m(env, lambda time_s: 0.0 if 3.0 < time_s < gone_s else 1.0)
    assert outcome == "arrived"
    assert free > INTIMATE_M
    assert rushed < waited


@pytest.mark.parametrize("offset_m", [0.52, 0.7, 0.9])
def test_slowing_beside_somebody_who_passes_is_better_than_driving_on_and_than_stopping(
    offset_m: float,
) -> None:
    def passed(share: float) -> tuple[float, float, str]:
        env = with_walker(7.0, offset_m, -0.7, 0.0)
        return nearest_m(env, lambda time_s: share if 4.0 < time_s < 8.0 else 1.0)

    rushed, clearance, _ = passed(1.0)
    assert clearance < INTIMATE_M
    slowed, _, outcome = passed(0.5)
    stopped, _, _ = passed(0.0)
    assert outcome == "arrived"
    assert slowed > rushed
    assert slowed > stopped


def test_somebody_who_passes_at_a_distance_is_no_reason_to_slow_down() -> None:
    def passed(share: float) -> float:
        env = with_walker(7.0, 1.4, -0.7, 0.0)
        return nearest_m(env, lambda time_s: share if 4.0 < time_s < 8.0 else 1.0)[0]

    assert passed(1.0) > passed(0.75) > passed(0.5) > passed(0.0)


@pytest.mark.parametrize("speed_mps", [0.0, -0.5])
def test_running_into_somebody_is_worse_than_standing_for_ever(speed_mps: float) -> None:
    env = with_walker(3.0, 0.0, speed_mps, 0.0)
    struck, _, outcome = drive(env, itertools.repeat(1.0))
    assert outcome == "contact_person"
    standing, *_ = drive(with_walker(3.0, 2.0, 0.0, 0.0), itertools.repeat(0.0))
    assert struck < standing


# --- smooth is better than on and off ------------------------------------------------------------


@pytest.mark.parametrize("period", [2, 4, 6, 10, 20])
def test_on_and_off_is_worse_than_smooth_over_the_same_distance(period: int) -> None:
    """Both drive 20 s; the smooth one at the constant speed that covers the same distance."""
    steps = 200
    on_off = [1.0 if k % period < period / 2 else 0.0 for k in range(steps)]
    rapid, distance_m, _ = drive(CORRIDOR, on_off)
    share = distance_m / (0.5 * 0.1 * steps)
    for _ in range(3):  # the slew limit costs some distance at the start
        smooth, covered_m, _ = drive(CORRIDOR, [share] * steps)
        share *= distance_m / covered_m
    assert covered_m == pytest.approx(distance_m, rel=0.01)
    assert rapid < smooth


@pytest.mark.parametrize("period", [2, 6, 20])
def test_on_and_off_is_worse_than_smooth_with_the_same_average_command(period: int) -> None:
    on_off = [1.0 if k % period < period / 2 else 0.0 for k in range(200)]
    assert drive(CORRIDOR, on_off)[0] < drive(CORRIDOR, [0.5] * 200)[0]


@pytest.mark.parametrize("env_id", sorted(ENVIRONMENTS))
def test_a_whole_episode_of_blocking_costs_less_than_a_contact(env_id: str) -> None:
    config = make_config(preset=ENVIRONMENTS[env_id][1])
    contact = config.reward.contact * contact_severity(BY_ROBOT, config.drive.nominal_speed_mps)

    assert config.max_episode_steps * config.reward.burden > contact
