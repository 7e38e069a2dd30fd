"""Vectorized training environments for Stable-Baselines3.

Rewards are scaled and shaped for the networks. As in Monitor, the last info of every episode holds
under ``episode`` its return, reward terms, cost and time ratio, neither scaled nor shaped.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, cast

import gymnasium
import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.guard import Observations
from hazbot_gym.task.reward import TERMS
from hazbot_gym.training.config import TrainConfig, shares
from hazbot_gym.training.shaping import FreeDrive

SUMS = (*TERMS, "cost", "r", "l")  # of an episode; r and l are Monitor's return and length
PROGRESS = TERMS.index("progress")


class TrainingEnvs(VecEnv):
    """Several ``VecEnv`` as one, with scaled and shaped rewards; sums in infos are raw."""

    def __init__(
        self, parts: Sequence[VecEnv], configs: Sequence[Config], training: TrainConfig
    ) -> None:
        """Combine environments.

        Args:
            parts: Each a ``CorridorVecEnv`` or a ``DummyVecEnv`` of corridor environments.
            configs: The config of each part.
            training: Scaling and shaping of rewards, and whether observations end with the time
                left.
        """
        self.parts, self.scale = list(parts), training.reward_scale
        self.is_timed = training.timed_critic
        sizes = [part.num_envs for part in parts]
        self.slices = [slice(sum(sizes[:i]), sum(sizes[: i + 1])) for i in range(len(sizes))]
        self._sums = np.zeros((sum(sizes), len(SUMS)))
        self._free_s = np.zeros(sum(sizes))
        self._decision_s = np.repeat([config.clock.decision_s for config in configs], sizes)
        self._nominal_mps = np.repeat([config.drive.nominal_speed_mps for config in configs], sizes)
        self._free_drive = FreeDrive(configs, sizes)
        self._is_shaped = training.shaping == "free_drive"
        space = parts[0].observation_space
        assert space.shape is not None
        self.width = space.shape[0]  # of policies' observations, without the time left
        super().__init__(
            sum(sizes), _with_time(space) if self.is_timed else space, parts[0].action_space
        )

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed all worlds at the next reset: world i with ``seed + i``."""
        for part, own in zip(self.parts, self.slices, strict=True):
            part.seed(None if seed is None else seed + own.start)
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def reset(self) -> npt.NDArray[np.float32]:
        """Start new episodes everywhere."""
        parts = [cast(Observations, part.reset()) for part in self.parts]
        self._sums[:] = 0.0
        self.reset_infos = [info for part in self.parts for info in part.reset_infos]
        self._free_s[:] = [info["time_free_s"] for info in self.reset_infos]
        return self._observed(parts)

    def step_async(self, actions: npt.NDArray[np.generic]) -> None:
        """Send the actions."""
        for part, own in zip(self.parts, self.slices, strict=True):
            part.step_async(actions[own])

    def step_wait(
        self,
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.bool_], list[Info]]:
        """Take one decision in every world."""
        potential = self._potential()
        steps = [part.step_wait() for part in self.parts]
        rewards, dones = (np.concatenate([step[k] for step in steps]) for k in (1, 2))
        infos = [info for step in steps for info in step[3]]
        self._add_up(rewards, [step[3] for step in steps])
        for part, own in zip(self.parts, self.slices, strict=True):
            for i in np.flatnonzero(dones[own]):
                self.reset_infos[own.start + i] = part.reset_infos[i]
        for i in np.flatnonzero(dones):
            infos[i]["episode"] = self._close(int(i))
            if self._is_shaped:
                infos[i]["TimeLimit.truncated"] = False  # already part of the potential
            if self.is_timed:
                last = infos[i]["terminal_observation"]
                infos[i]["terminal_observation"] = np.append(last, np.float32(0.0))
        shaped = rewards + np.where(dones, 0.0, self._potential()) - potential
        observations = self._observed([cast(Observations, step[0]) for step in steps])
        return observations, (self.scale * shaped).astype(np.float32), dones, infos

    def _observed(self, parts: list[npt.NDArray[np.float32]]) -> npt.NDArray[np.float32]:
        """Return the observations of all worlds, with the time left if configured."""
        width = parts[0].shape[1]
        observed = _aligned(self.num_envs, width + self.is_timed)
        np.concatenate(parts, out=observed[:, :width])
        if self.is_timed:
            observed[:, width] = self._free_drive.time_left(self._sums[:, -1])
        return observed

    def _potential(self) -> Floats:
        """Return the potential of all worlds (N,), 0 without shaping."""
        if not self._is_shaped:
            return np.zeros(self.num_envs)
        path = self._free_s / self._decision_s
        return self._free_drive.potential(path, self._sums[:, PROGRESS], self._sums[:, -1])

    def _add_up(self, rewards: Floats, infos: list[list[Info]]) -> None:
        """Add a decision to the sums of the running episodes."""
        for part, own, told in zip(self.parts, self.slices, infos, strict=True):
            terms, costs = _decision_of(part, told)
            self._sums[own, : len(TERMS)] += terms
            self._sums[own, len(TERMS)] += costs
        self._sums[:, -2] += rewards
        self._sums[:, -1] += 1.0

    def _close(self, i: int) -> dict[str, float]:
        """Return the sums of the ended episode in world i, and reset them."""
        sums, length = dict(zip(SUMS, self._sums[i].tolist(), strict=True)), self._sums[i, -1]
        sums["time_ratio"] = float(length * self._decision_s[i] / self._free_s[i])
        sums["speed_mps"] = float(self._sums[i, PROGRESS] / length * self._nominal_mps[i])
        self._sums[i] = 0.0
        self._free_s[i] = self.reset_infos[i]["time_free_s"]
        return sums

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


def make_envs(config: TrainConfig) -> TrainingEnvs:
    """Make the environments of a run, with the worlds split among them.

    Raises:
        InvalidInput: An environment cannot be made, or they do not fit each other.
    """
    if config.worlds < len(config.env):
        raise InvalidInput(
            f"worlds: given {config.worlds}, allowed is {len(config.env)} or more, one for each env"
        )
    make = _batched if config.engine == "batched" else _pymunk
    sizes, configs = shares(config.worlds, len(config.env)), config.environments()
    parts = [make(*each, config.threads) for each in zip(configs, sizes, strict=True)]
    return TrainingEnvs(parts, configs, config)


def require_speeds(envs: VecEnv, key: str) -> None:
    """Reject a config key that requires continuous actions."""
    if hasattr(envs.action_space, "n"):
        raise InvalidInput(f"{key}: given action_type 'discrete', allowed is 'continuous'")


def _with_time(space: gymnasium.Space[object]) -> gymnasium.spaces.Box:
    """Return the observation space with the share of time left as last entry."""
    assert isinstance(space, gymnasium.spaces.Box)
    low, high = np.append(space.low, np.float32(0.0)), np.append(space.high, np.float32(1.0))
    return gymnasium.spaces.Box(low, high)


def _batched(config: Config, worlds: int, threads: int) -> VecEnv:
    return CorridorVecEnv(worlds, config=config, threads=threads)


def _pymunk(config: Config, worlds: int, threads: int) -> VecEnv:
    return DummyVecEnv([partial(CorridorEnv, config)] * worlds)


def _decision_of(part: VecEnv, infos: list[Info]) -> tuple[Floats, Floats]:
    """Return the reward terms (N, 7) and costs (N,) of the decision just taken."""
    if isinstance(part, CorridorVecEnv):
        return part.terms, part.costs
    terms = np.array([[info["reward_terms"][name] for name in TERMS] for info in infos])
    return terms, np.array([info["cost"] for info in infos], float)


def _aligned(rows: int, columns: int) -> npt.NDArray[np.float32]:
    """Return an aligned array for observations.

    Torch's matrix products depend on alignment in the last bit; numpy's alignment varies, and equal
    seeds would not give equal weights.
    """
    return torch.empty(rows, columns).numpy()
