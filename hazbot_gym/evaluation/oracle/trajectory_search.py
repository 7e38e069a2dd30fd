"""The best that was found in a scenario whose people react: a search in the simulator itself.

Where people answer to the robot the future depends on what it does, and no exact optimum is known.
But a scenario can be driven through as often as one likes: it is the same every time. The search
keeps the best plan so far, changes it a little in every world of a batch at once, and keeps the
best of these (an evolution strategy, (1 + lambda) with elitism; Rechenberg 1973). Its changes are
those that matter to a drive: another speed for a while, a wait that is put in, or taken out.

It begins with what some policies did and so ends no lower than any of them. What it finds is a
lower bound of the optimum and knows the future; a part of its lead is nobody's to have.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.envs.vector import CorridorVectorEnv

SPEEDS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # actions that a stretch of a plan may be set to
MEAN_STRETCH = 12  # decisions that a change lasts, geometrically distributed
LONGEST_STRETCH = 80


class Effort(NamedTuple):
    """How hard is searched."""

    worlds: int = 96  # lambda, plans that are tried at once
    rounds: int = 80


class Found(NamedTuple):
    """The best plan and what it earns."""

    actions: Floats  # (T,) in [-1, 1]
    value: float  # its return


def search(
    config: Config,
    seed: int,
    starts: Floats,
    rng: np.random.Generator,
    effort: Effort,
) -> Found:
    """Return the best plan that is found for the scenario of a seed.

    Args:
        config: of the environment, with continuous actions.
        seed: of the reset.
        starts: (S, T) actions in [-1, 1] that the search begins with, at most as many as worlds.
        rng: source of the changes.
        effort: how hard is searched.
    """
    worlds = CorridorVectorEnv(effort.worlds, config, threads=1, autoreset_mode="Disabled")
    plans = np.resize(starts, (effort.worlds, starts.shape[1]))
    returns, lengths = _play(worlds, seed, plans)
    best = int(returns.argmax())
    plan, value, length = plans[best].copy(), returns[best], lengths[best]
    for _ in range(effort.rounds):
        plans = _changed(plan, effort.worlds, int(length), rng)
        returns, lengths = _play(worlds, seed, plans)
        best = int(returns.argmax())
        if returns[best] > value:
            plan, value, length = plans[best].copy(), returns[best], lengths[best]
    worlds.close()
    return Found(plan[:length], float(value))


def _play(worlds: CorridorVectorEnv, seed: int, plans: Floats) -> tuple[Floats, Ints]:
    """Return what each world's plan earns in the same scenario, and how many decisions it takes."""
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
    """Return plans that differ from one in a stretch or two within its first decisions."""
    plans = np.repeat(plan[None], count, axis=0)
    for row in plans:
        for _ in range(1 + rng.integers(2)):
            _change(row, length, rng)
    return plans


def _change(row: npt.NDArray[np.float64], length: int, rng: np.random.Generator) -> None:
    """Set a stretch of a plan to another speed, take it out, or put a wait in before it."""
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
