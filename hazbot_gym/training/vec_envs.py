"""The environments of a training run, side by side, as Stable-Baselines3 wants them.

Adds what a run needs besides: rewards scaled and shaped for the networks; and under ``episode`` in
the info of every episode that ends, as Monitor does it, its return, reward terms, cost and time
ratio, neither scaled nor shaped.
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

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
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
    """Several ``VecEnv`` as one; rewards are scaled and shaped, the sums in infos are not."""

    def __init__(
        self, parts: Sequence[VecEnv], configs: Sequence[Config], training: TrainConfig
    ) -> None:
        """Put environments side by side.

        Args:
            parts: Each a ``CorridorVecEnv`` or a ``DummyVecEnv`` of corridor environments.
            configs: The config of each.
            training: How their rewards are scaled and shaped, and whether observations end with
                the time left.
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
        self.width = space.shape[0]  # of what policies see, the time left not among it
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

    def step_async(self, actions: npt.NDArray[Any]) -> None:
        """Hand out the actions."""
        for part, own in zip(self.parts, self.slices, strict=True):
            part.step_async(actions[own])

    def step_wait(self) -> tuple[npt.NDArray[np.float32], Any, Any, list[dict[str, Any]]]:
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
                infos[i]["TimeLimit.truncated"] = False  # the potential has charged it
            if self.is_timed:
                last = infos[i]["terminal_observation"]
                infos[i]["terminal_observation"] = np.append(last, np.float32(0.0))
        shaped = rewards + np.where(dones, 0.0, self._potential()) - potential
        observations = self._observed([cast(Observations, step[0]) for step in steps])
        return observations, (self.scale * shaped).astype(np.float32), dones, infos

    def _observed(self, parts: list[npt.NDArray[np.float32]]) -> npt.NDArray[np.float32]:
        """Return the observations of all worlds, with the time left if that is wanted."""
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

    def _add_up(self, rewards: Floats, infos: list[list[dict[str, Any]]]) -> None:
        """Add a decision to the sums of the episodes that are going on."""
        for part, own, told in zip(self.parts, self.slices, infos, strict=True):
            terms, costs = _decision_of(part, told)
            self._sums[own, : len(TERMS)] += terms
            self._sums[own, len(TERMS)] += costs
        self._sums[:, -2] += rewards
        self._sums[:, -1] += 1.0

    def _close(self, i: int) -> dict[str, float]:
        """Return what the episode that has ended in world i came to, and begin the next one's."""
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

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of some worlds."""
        found = [value for part in self.parts for value in part.get_attr(attr_name)]
        return [found[i] for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: nothing of a run's environments is changed."""
        raise InvalidInput(f"set_attr: given {attr_name!r}, a run's environments are not changed")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Refuse: batched worlds have no methods of their own."""
        raise InvalidInput(f"env_method: given {method_name!r}, worlds are not called one by one")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Tell that no world is wrapped."""
        return [False for _ in self._get_indices(indices)]


def make_envs(config: TrainConfig) -> TrainingEnvs:
    """Make the environments of a run, the worlds shared out among them.

    Raises:
        InvalidInput: One of them cannot be made, or they do not fit each other.
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
    """Refuse what a key of a run asks for where actions are levels instead of speeds."""
    if hasattr(envs.action_space, "n"):
        raise InvalidInput(f"{key}: given action_type 'discrete', allowed is 'continuous'")


def _with_time(space: gymnasium.Space[Any]) -> gymnasium.spaces.Box:
    """Return the space of observations with the time left, a share, as their last entry."""
    assert isinstance(space, gymnasium.spaces.Box)
    low, high = np.append(space.low, np.float32(0.0)), np.append(space.high, np.float32(1.0))
    return gymnasium.spaces.Box(low, high)


def _batched(config: Config, worlds: int, threads: int) -> VecEnv:
    return CorridorVecEnv(worlds, config=config, threads=threads)


def _pymunk(config: Config, worlds: int, threads: int) -> VecEnv:
    return DummyVecEnv([partial(CorridorEnv, config)] * worlds)


def _decision_of(part: VecEnv, infos: list[dict[str, Any]]) -> tuple[Floats, Floats]:
    """Return the reward terms (N, 7) and costs (N,) of the decision just taken."""
    if isinstance(part, CorridorVecEnv):
        return part.terms, part.costs
    terms = np.array([[info["reward_terms"][name] for name in TERMS] for info in infos])
    return terms, np.array([info["cost"] for info in infos], float)


def _aligned(rows: int, columns: int) -> npt.NDArray[np.float32]:
    """Return an array for observations that begins where torch reads it best.

    Its matrix products depend in the last bit on where an array begins; numpy's begin anywhere,
    and then equal seeds would not give equal weights.
    """
    return torch.empty(rows, columns).numpy()
