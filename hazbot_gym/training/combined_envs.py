"""Several ``VecEnv`` of Stable-Baselines3 as one, so that a run can train on several environments.

Wrappers access this environment as ``envs.unwrapped``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.driver import driver_of
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Flags, Observations
from hazbot_gym.task.reward import TERMS, terms_of
from hazbot_gym.training.staggered_starts import stagger

PROGRESS = TERMS.index("progress")


class CombinedEnvs(VecEnv):
    """The worlds of several ``VecEnv``, in their order.

    Attributes:
        term_names: Names of the reward terms.
        terms: (N, terms) unweighted reward terms of the last decision.
        costs: (N,) its safety costs.
        steps: (N,) decisions taken in each running episode.
        advance: (N,) its progress, in decisions at nominal speed.
        times_free_s: (N,) time of a free drive along its path [s].
    """

    def __init__(
        self, parts: Sequence[VecEnv], configs: Sequence[Config], *, staggered: bool = False
    ) -> None:
        """Combine environments.

        Args:
            parts: Each a ``CorridorVecEnv`` or a ``DummyVecEnv`` of corridor environments.
            configs: The config of each part.
            staggered: Whether worlds start in different phases, see ``staggered_starts``.
        """
        self.parts, self.configs = list(parts), list(configs)
        self.sizes = [part.num_envs for part in parts]
        ends = np.cumsum(self.sizes).tolist()
        self.slices = [slice(end - size, end) for end, size in zip(ends, self.sizes, strict=True)]
        self.term_names = terms_of(configs[0])  # parts with equal observations have equal terms
        self.terms, self.costs = np.zeros((ends[-1], len(self.term_names))), np.zeros(ends[-1])
        self.steps, self.advance = np.zeros(ends[-1]), np.zeros(ends[-1])
        self.times_free_s = np.zeros(ends[-1])
        self._staggered, self._seed = staggered, 0
        super().__init__(ends[-1], parts[0].observation_space, parts[0].action_space)

    def of_each_world(self, value: Callable[[Config], float]) -> Floats:
        """Return a value of the config of each world (N,)."""
        return np.repeat(np.array([value(config) for config in self.configs]), self.sizes)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed all worlds at the next reset: world i with ``seed + i``."""
        self._seed = seed or 0
        for part, own in zip(self.parts, self.slices, strict=True):
            part.seed(None if seed is None else seed + own.start)
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def set_options(self, options: list[Info] | Info | None = None) -> None:
        """Set the options of the next reset of all worlds."""
        for part in self.parts:
            part.set_options(options)

    def reset(self) -> Observations:
        """Start new episodes everywhere."""
        observations = [cast(Observations, part.reset()) for part in self.parts]
        self.steps[:], self.advance[:] = 0.0, 0.0
        self._note_times(np.arange(self.num_envs))
        if self._staggered:
            observations = self._stagger()
        return joined(observations)

    def step_async(self, actions: npt.NDArray[np.generic]) -> None:
        """Send the actions."""
        for part, own in zip(self.parts, self.slices, strict=True):
            part.step_async(actions[own])

    def step_wait(self) -> tuple[Observations, npt.NDArray[np.float32], Flags, list[Info]]:
        """Take one decision in every world."""
        steps = [part.step_wait() for part in self.parts]
        rewards, dones = (np.concatenate([step[k] for step in steps]) for k in (1, 2))
        for part, own, step in zip(self.parts, self.slices, steps, strict=True):
            self.terms[own], self.costs[own] = _decision_of(part, step[3])
        self.steps += 1.0
        self.advance += self.terms[:, PROGRESS]
        self.steps[dones], self.advance[dones] = 0.0, 0.0
        self._note_times(np.flatnonzero(dones))
        observations = [cast(Observations, step[0]) for step in steps]
        return joined(observations), rewards, dones, [info for step in steps for info in step[3]]

    def close(self) -> None:
        """Close all parts."""
        for part in self.parts:
            part.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of some worlds."""
        found = [value for part in self.parts for value in part.get_attr(attr_name)]
        return [found[i] for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: object, indices: object = None) -> None:
        """Not supported: environments of a run are immutable."""
        raise InvalidInput(f"set_attr: given {attr_name!r}, a run's environments are not changed")

    def env_method(
        self, method_name: str, *args: object, indices: object = None, **kwargs: object
    ) -> Any:
        """Not supported: batched worlds have no individual methods."""
        raise InvalidInput(f"env_method: given {method_name!r}, worlds are not called one by one")

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        """Return False for every world."""
        return [False for _ in self._get_indices(indices)]

    def _note_times(self, worlds: npt.NDArray[np.int64]) -> None:
        """Note the free times of episodes that have just begun."""
        for part, own in zip(self.parts, self.slices, strict=True):
            for i in worlds[(worlds >= own.start) & (worlds < own.stop)].tolist():
                self.times_free_s[i] = part.reset_infos[i - own.start]["time_free_s"]

    def _stagger(self) -> list[Observations]:
        """Drive each world along a random part of its path."""
        decision_s = self.of_each_world(lambda config: config.clock.decision_s)
        shares = np.random.default_rng(self._seed).random(self.num_envs)
        decisions = (shares * self.times_free_s / decision_s).astype(np.int64)
        observations = []
        for part, own in zip(self.parts, self.slices, strict=True):
            started = stagger(cast(CorridorVecEnv, part), decisions[own])
            self.steps[own], self.advance[own] = started.steps, started.advance
            observations.append(started.observations)
        self._note_times(np.arange(self.num_envs))
        return observations


def joined(parts: Sequence[Observations]) -> Observations:
    """Return the rows of several arrays as one aligned array.

    Torch's matrix products depend on alignment in the last bit; numpy's alignment varies, and equal
    seeds would not give equal weights.
    """
    rows, columns = sum(map(len, parts)), parts[0].shape[1]
    return np.concatenate(parts, out=aligned(rows, columns))


def aligned(rows: int, columns: int) -> Observations:
    """Return an aligned array."""
    return torch.empty(rows, columns).numpy()


def driver_in(envs: VecEnv, policy: Policy, name: str) -> Policy:
    """Return a policy that can be asked in all the environments.

    Args:
        envs: The environments, perhaps under wrappers; their observations have the same fields.
        policy: The policy.
        name: Its name, for messages.

    Raises:
        InvalidInput: It is made for another robot than that of one of them.
    """
    *_, driver = (
        driver_of(policy, config, name) for config in cast(CombinedEnvs, envs.unwrapped).configs
    )
    return driver


def policy_width(envs: VecEnv) -> int:
    """Return the width of the observations of policies, which do not include the time left."""
    shape = envs.unwrapped.observation_space.shape
    assert shape is not None
    return shape[0]


def _decision_of(part: VecEnv, infos: list[Info]) -> tuple[Floats, Floats]:
    """Return the reward terms (N, terms) and costs (N,) of the decision just taken."""
    if isinstance(part, CorridorVecEnv):
        return part.terms, part.costs
    terms = np.array([list(info["reward_terms"].values()) for info in infos])
    return terms, np.array([info["cost"] for info in infos], float)
