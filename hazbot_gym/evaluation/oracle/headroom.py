"""Benchmark headroom: the span from the best constant speed to the exact optimum.

A benchmark in which a one-line rule is optimal cannot tell policies apart. The span runs from the
best constant speed (0) to the optimum (1); the position of the best one-parameter rule, its
parameter chosen in hindsight on the same scenarios, bounds the room left for other policies from
below.

For the optimum to be exact, people must not react to the robot and the drive must be ideal
(``dynamic_programming.py``): the scenarios are those of the environments, with scripted people and
ideal wheels. All commands are rounded to the speed lattice of the optimum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.oracle.dynamic_programming import optimum
from hazbot_gym.evaluation.oracle.lattice import LEVELS
from hazbot_gym.evaluation.statistics.normalised_score import normalised_score
from hazbot_gym.policies import make
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.policies.sweeps import sweep
from hazbot_gym.task.action import nearest_level
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.utils import processors
from hazbot_gym.utils.json_object import JsonObject

QUIET_DRIVE = {"wheel_loop": "ideal", "wheel_noise_radps": 0.0, "heading_noise_rad": 0.0}
CONSTANT, EXPERT = "constant", "fuzzy_expert"
RULES = ("stop_on_sight", "stop_when_near", "ssm:mode=strict", "ssm:mode=directional", "ttc")
ENOUGH = 0.15  # least share of the span that the best rule should leave


class OnLattice:
    """Policy wrapper that rounds commands to the speeds of the lattice."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the rounded action; see ``policies.base.Policy``."""
        actions, state = self._policy.predict(observation, state, episode_start, deterministic)
        return (2.0 * nearest_level(actions, LEVELS) / (LEVELS - 1) - 1.0).astype(np.float32), state


class Played(NamedTuple):
    """Results of a policy in the scenarios."""

    spec: str
    returns: Floats  # (episodes,)
    arrived: float


def environments() -> list[str]:
    """Return the environments that support scripted people."""
    return [name for name, (_, preset) in ENVIRONMENTS.items() if "model" not in _people(preset)]


def headroom_config(name: str) -> Config:
    """Return an environment's config with non-reactive people and an ideal drive."""
    preset = ENVIRONMENTS[name][1]
    return make_config(preset=preset, people={"model": "scripted"}, drive=QUIET_DRIVE)


def headroom(
    names: Iterable[str], episodes: int, *, on_progress: Callable[[], None] = lambda: None
) -> dict[str, object]:
    """Return the span of each environment and the position of every family within it.

    Args:
        names: of environments, without the namespace.
        episodes: of each; seeds 0, 1, ...
        on_progress: called after each scenario's optimum.
    """
    return {
        "episodes": episodes,
        "enough": ENOUGH,
        "environments": {name: _place(name, episodes, on_progress) for name in names},
    }


def best_returns(
    config: Config, keys: Iterable[int], on_progress: Callable[[], None] = lambda: None
) -> Floats:
    """Return the optimum of every scenario."""
    source = ScenarioSampler(config)

    def best(key: int) -> float:
        value = optimum(config, source.draw(key), key).value
        on_progress()
        return value

    first, *others = keys
    found = [best(first)]  # here, where an interrupt ends what has to be compiled
    with ThreadPoolExecutor(processors.usable()) as pool:
        return np.array(found + list(pool.map(best, others)))


def play(config: Config, spec: str, episodes: int) -> tuple[Played, list[int]]:
    """Return a policy's results in the scenarios of seeds 0, 1, ..., and their keys."""
    seeds, limit = list(range(episodes)), config.max_episode_steps
    threads = processors.usable()
    runs = list(
        batch_rollout.run_episodes(
            config, OnLattice(make(spec)), seeds, limit=limit, threads=threads
        )
    )
    returns = np.array([episode.rewards.sum() for episode, _ in runs])
    arrived = float(np.mean([episode.outcome == "arrived" for episode, _ in runs]))
    return Played(spec, returns, arrived), [int(labels["scenario_key"]) for _, labels in runs]


def _people(preset: JsonObject) -> JsonObject:
    people: dict[str, object] = preset.get("people", {})
    return people


def _place(name: str, episodes: int, on_progress: Callable[[], None]) -> dict[str, object]:
    config = headroom_config(name)
    best = {family: _best(config, specs, episodes) for family, specs in _families()}
    _, keys = play(config, best[CONSTANT].spec, episodes)
    top = float(best_returns(config, keys, on_progress).mean())
    low = float(best[CONSTANT].returns.mean())
    rows: dict[str, JsonObject] = {
        family: {
            "policy": played.spec,
            "return": float(played.returns.mean()),
            "arrived": played.arrived,
            "share": float(normalised_score(played.returns.mean(), low, top)),
        }
        for family, played in best.items()
    }
    rules = max(rows[family]["share"] for family in (CONSTANT, *RULES))
    return {"optimum": top, "constant": low, "room": 1.0 - rules, "families": rows}


def _families() -> Iterator[tuple[str, list[str]]]:
    for family in (CONSTANT, *RULES):
        yield family, sweep(family)
    yield EXPERT, [EXPERT]


def _best(config: Config, specs: list[str], episodes: int) -> Played:
    """Return a family's best member on these scenarios, its parameter chosen in hindsight."""
    return max(
        (play(config, spec, episodes)[0] for spec in specs),
        key=lambda played: played.returns.mean(),
    )
