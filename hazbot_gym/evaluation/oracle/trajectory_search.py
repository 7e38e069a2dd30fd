"""Offline trajectory search: the best plan found for a scenario with reactive people.

If people react to the robot, the future depends on its actions, and no exact optimum is known. But
a scenario is deterministic and can be simulated any number of times. The search keeps the best plan
so far, mutates it in every world of a batch, and keeps the best result (a (1 + lambda) evolution
strategy with elitism; Rechenberg 1973). Mutations set a segment to another speed, or insert or
remove a wait.

It starts from the action sequences of given policies and so ends no lower than any of them. The
result is a lower bound of the optimum and knows the future, so part of its lead is unattainable.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.envs.vector import CorridorVectorEnv

SPEEDS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # actions available to a mutation
MEAN_STRETCH = 12  # mean length of a mutation in decisions, geometrically distributed
LONGEST_STRETCH = 80


class Effort(NamedTuple):
    """Search budget."""

    worlds: int = 64  # lambda, plans evaluated in parallel
    rounds: int = 40


class Found(NamedTuple):
    """The best plan and its return."""

    actions: Floats  # (T,) in [-1, 1]
    value: float  # its return
    halfway: float  # the best return after half of the rounds


def search(
    config: Config,
    seed: int,
    starts: Floats,
    rng: np.random.Generator,
    effort: Effort,
) -> Found:
    """Return the best plan found for the scenario of a seed.

    Args:
        config: of the environment, with continuous actions.
        seed: of the reset.
        starts: (S, T) actions in [-1, 1] of the initial plans, at most as many as worlds.
        rng: random generator of the mutations.
        effort: search budget.
    """
    worlds = CorridorVectorEnv(effort.worlds, config, threads=1, autoreset_mode="Disabled")
    plans = np.resize(starts, (effort.worlds, starts.shape[1]))
    returns, lengths = _play(worlds, seed, plans)
    best = int(returns.argmax())
    plan, value, length = plans[best].copy(), returns[best], lengths[best]
    halfway = value
    for each in range(effort.rounds):
        plans = _changed(plan, effort.worlds, int(length), rng)
        returns, lengths = _play(worlds, seed, plans)
        best = int(returns.argmax())
        if returns[best] > value:
            plan, value, length = plans[best].copy(), returns[best], lengths[best]
        if each + 1 == effort.rounds // 2:
            halfway = value
    worlds.close()
    return Found(plan[:length], float(value), float(halfway))


def _play(worlds: CorridorVectorEnv, seed: int, plans: Floats) -> tuple[Floats, Ints]:
    """Return each plan's return in the same scenario, and its number of decisions."""
    count, live = len(plans), np.ones(len(plans), np.bool_)
    returns, lengths = np.zeros(count), np.zeros(count, np.int64)
    worlds.reset(seed=[seed] * count)
    for t in range(worlds.config.max_episode_steps):
        action = plans[:, min(t, plans.shape[1] - 1), None].astype(np.float32)
        _, rewards, terminated, truncated, _ = worlds.step(action, mask=live)
        returns[live] += rewards[live]
        lengths[live] += 1
        live &= ~(terminated | truncated)
        if not live.any():
            break
    return returns, lengths


def _changed(plan: Floats, count: int, length: int, rng: np.random.Generator) -> Floats:
    """Return mutations of a plan, with one or two changed segments in its first decisions."""
    plans = np.repeat(plan[None], count, axis=0)
    for row in plans:
        for _ in range(1 + rng.integers(2)):
            _change(row, length, rng)
    return plans


def _change(row: npt.NDArray[np.float64], length: int, rng: np.random.Generator) -> None:
    """Set a segment of a plan to another speed, remove it, or insert a wait before it."""
    first = int(rng.integers(length))
    stretch = min(int(rng.geometric(1.0 / MEAN_STRETCH)), LONGEST_STRETCH, len(row) - first - 1)
    if stretch < 1:
        return
    kind = rng.integers(3)
    if kind == 0:
        row[first : first + stretch] = rng.choice(SPEEDS)
    elif kind == 1:
        row[first:-stretch] = row[first + stretch :].copy()
    else:
        wait = rng.choice((-1.0, row[first]))
        row[first + stretch :] = row[first:-stretch].copy()
        row[first : first + stretch] = wait
