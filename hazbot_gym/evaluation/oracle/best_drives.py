"""Best drives known: the exact optimum of scenarios, or the result of an offline search.

If people do not react and the drive is ideal, the best drive is the exact optimum
(``dynamic_programming.py``), an upper bound for policies with commands on its speeds. Otherwise it
is the result of an offline trajectory search (``trajectory_search.py``) that starts from the drives
of policies. Both know the future.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.open_loop import Plan
from hazbot_gym.evaluation.oracle.dynamic_programming import optimum
from hazbot_gym.evaluation.oracle.trajectory_search import Effort, Found, search
from hazbot_gym.task.action import action_of_speed
from hazbot_gym.task.scenario import ScenarioSampler


class Pace(NamedTuple):
    """Threads that work on scenarios side by side, and what to call after each scenario."""

    threads: int = 1
    on_progress: Callable[[], None] = lambda: None


ALONE = Pace()


def optima(config: Config, keys: Sequence[int], pace: Pace = ALONE) -> list[Found]:
    """Return the exact optimum of the scenario of each key."""
    source = ScenarioSampler(config)

    def best(i: int) -> Found:
        found = optimum(config, source.draw(keys[i]), keys[i], with_speeds=True)
        actions = action_of_speed(found.speeds_mps, config.drive.nominal_speed_mps)
        return Found(actions, found.value, found.value)

    return _each(best, len(keys), pace)


def searched(
    config: Config,
    seeds: Sequence[int],
    drives: Iterable[Sequence[Episode]],
    effort: Effort,
    pace: Pace = ALONE,
) -> list[Found]:
    """Return the best drive found for the scenario of each seed.

    Args:
        config: of the environment.
        seeds: of the resets.
        drives: episodes that initialize the search, one policy each, in the order of the seeds.
        effort: search budget.
        pace: threads, and what to call after each scenario.
    """
    limit, nominal_mps = config.max_episode_steps, config.drive.nominal_speed_mps
    starts = np.array(
        [
            [_lengthened(action_of_speed(e.command_mps[1:], nominal_mps), limit) for e in episodes]
            for episodes in drives
        ]
    )

    def best(i: int) -> Found:
        rng = np.random.default_rng(seeds[i])
        return search(config, seeds[i], starts[:, i], rng, effort)

    return _each(best, len(seeds), pace)


def plan_of(found: Sequence[Found]) -> Plan:
    """Return the policy that drives the best drives, one per world."""
    longest = max(len(each.actions) for each in found)
    return Plan(np.stack([_lengthened(each.actions, longest) for each in found]))


def _each(best: Callable[[int], Found], count: int, pace: Pace) -> list[Found]:
    def one(i: int) -> Found:
        found = best(i)
        pace.on_progress()
        return found

    found = [one(0)]  # here, where an interrupt ends what has to be compiled
    with ThreadPoolExecutor(pace.threads) as pool:
        return found + list(pool.map(one, range(1, count)))


def _lengthened(actions: Floats, length: int) -> Floats:
    """Return a plan extended at full speed."""
    return np.concatenate([actions, np.ones(length - len(actions))])
