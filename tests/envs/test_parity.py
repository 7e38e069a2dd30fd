"""The two engines agree: the same seeds and actions lead to the same episodes.

By default a few scenarios for each environment, people model, tier and driver; HAZBOT_PARITY=200
asks for 200 of each, which takes half an hour.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.core.state import PRESENT, Floats, Records
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.policies.fuzzy_expert import FuzzyExpert
from hazbot_gym.sim import world as world_module

SCENARIOS = int(os.environ.get("HAZBOT_PARITY", "4"))  # for each combination
EPISODES = 5 if SCENARIOS >= 10 else 2  # one after the other in a world
WORLDS = math.ceil(SCENARIOS / EPISODES)
TOLERANCE = 1e-6
MODELS = ("scripted", "social_force", "replay", "seeded")
RUNS = [
    ("tracks", "random"),
    ("tracks", "expert"),
    ("privileged", "random"),
    ("privileged", "expert"),
    ("sonar", "random"),  # the expert needs to see people
]


class Passed(NamedTuple):
    """What passed, decision by decision, resets included; a batch has a second axis of worlds."""

    observations: npt.NDArray[np.float32]  # (T, width)
    numbers: Floats  # (T, 10): reward, cost, the seven terms, speed of a contact
    bodies: Floats  # (T, 3 + 2 P): the robot's pose and people's positions, NaN where absent
    ends: npt.NDArray[np.str_]  # (T,): how an episode ended and who caused it, else empty


class Driver:
    """Chooses the actions (N, 1) of a batch."""

    def __init__(self, name: str, worlds: int, seed: int) -> None:
        self._is_expert, self._rng = name == "expert", np.random.default_rng(seed)
        # Slow ones run out of time, fast ones touch people, and some arrive.
        self._bias = self._rng.uniform(-0.2, 1.0, (worlds, 1))

    def actions(self, observations: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        if self._is_expert:
            return FuzzyExpert().predict(observations)[0]
        drawn = self._bias + self._rng.uniform(-1.0, 1.0, self._bias.shape)
        return np.clip(drawn, -1.0, 1.0).astype(np.float32)


# --- running both --------------------------------------------------------------------------------


def in_batch(envs: CorridorVectorEnv, seed: int, driver: str, episodes: int) -> tuple[Passed, Any]:
    """Run until every world has ended its episodes; return what passed and the actions taken."""
    choose = Driver(driver, envs.num_envs, seed)
    observations, info = envs.reset(seed=seed)
    rewards, over = np.zeros(envs.num_envs), np.zeros(envs.num_envs, np.int64)
    rows, taken = [batch_row(envs, observations, rewards, info)], []
    while over.min() < episodes:
        taken.append(choose.actions(observations))
        observations, rewards, terminated, truncated, info = envs.step(taken[-1])
        over += terminated | truncated
        rows.append(batch_row(envs, observations, rewards, info))
    return Passed(*map(np.array, zip(*rows, strict=True))), np.array(taken)


def batch_row(envs: CorridorVectorEnv, observations: Any, rewards: Floats, info: Any) -> Any:
    nobody = np.full(envs.num_envs, None)
    speeds = info.get("contact_speed_mps", np.zeros(envs.num_envs))
    numbers = [rewards, info["cost"], *info["reward_terms"].values(), speeds]
    outcomes, causes = info.get("outcome", nobody), info.get("contact_caused_by", nobody)
    ends = [f"{how} {by}" if how else "" for how, by in zip(outcomes, causes, strict=True)]
    bodies = positions(envs._worlds.robots, envs._worlds.people)
    return observations, np.stack(numbers, axis=-1), bodies, ends


def alone(env: CorridorEnv, seed: int, taken: Any, episodes: int) -> Passed:
    """Take the actions (T, 1) in the reference engine, resetting where the batch does."""
    rows = list(rows_alone(env, seed, taken, episodes))
    return Passed(*map(np.array, zip(*rows, strict=True)))


def rows_alone(env: CorridorEnv, seed: int, taken: Any, episodes: int) -> Iterator[Any]:
    observation, info = env.reset(seed=seed)
    yield row_alone(env, observation, 0.0, info)
    is_over = False
    for action in taken:
        if is_over:
            reward: Any = 0.0
            is_over = False
            observation, info = env.reset()
        else:
            observation, reward, terminated, truncated, info = env.step(action)
            is_over = terminated or truncated
        yield row_alone(env, observation, reward, info)
        episodes -= is_over
        if episodes == 0:
            return


def row_alone(env: CorridorEnv, observation: Any, reward: Any, info: dict[str, Any]) -> Any:
    terms = info["reward_terms"].values()
    numbers = [reward, info["cost"], *terms, info.get("contact_speed_mps", 0.0)]
    end = f"{info['outcome']} {info.get('contact_caused_by')}" if "outcome" in info else ""
    return observation, numbers, positions(env._world.robots, env._world.people[None])[0], end


def positions(robots: Records, people: Records) -> Floats:
    """Return (N, 3 + 2 P) for robots (N,) and people (N, P)."""
    is_absent = people["status"] != PRESENT
    xy = [np.where(is_absent, np.nan, people[axis]) for axis in ("x", "y")]
    pose = np.stack([robots["x"], robots["y"], robots["theta"]], axis=-1)
    return np.concatenate([pose, *xy], axis=-1)


# --- comparing -----------------------------------------------------------------------------------


def gap(batch: Passed, i: int, reference: Passed) -> float:
    """Return the largest difference in world i, inf if episodes end or people enter otherwise."""
    steps = len(reference.ends)
    if len(batch.ends) < steps or (batch.ends[:steps, i] != reference.ends).any():
        return math.inf
    worst = 0.0
    for mine, others in zip(batch[:3], reference[:3], strict=True):
        one, other = mine[:steps, i].astype(np.float64), others.astype(np.float64)
        if one.shape != other.shape or (np.isnan(one) != np.isnan(other)).any():
            return math.inf
        worst = max(worst, float(np.nanmax(np.abs(one - other), initial=0.0)))
    return worst


def compare(
    envs: CorridorVectorEnv, env: CorridorEnv, *, seed: int, driver: str, episodes: int = EPISODES
) -> tuple[list[float], list[str]]:
    """Return the largest difference in each world, and how the reference's episodes ended."""
    batch, taken = in_batch(envs, seed, driver, episodes)
    gaps, ends = [], []
    for i in range(envs.num_envs):
        reference = alone(env, seed + i, taken[:, i], episodes)
        gaps.append(gap(batch, i, reference))
        ends += [end for end in reference.ends if end]
    return gaps, ends
