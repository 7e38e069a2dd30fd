"""Imitation alone: behaviour cloning, and DAgger, in which the pupil drives and the teacher tells.

In round i = 0, 1, ... the teacher is at the wheel with probability beta^i for each decision, the
pupil otherwise; the teacher says what it would do about everything that is seen; the pupil is
fitted to all that was ever said (Ross, Gordon and Bagnell, AISTATS 2011, algorithm 3.1). So it
learns where its own mistakes lead to. With beta = 0 only the first round is the teacher's, their
parameter-free schedule; with beta = 1 all are, which is behaviour cloning (Pomerleau 1989). The
best pupil on validation is kept, as the paper has it.

A round takes ``imitation.decisions``, a run ``steps`` of them in all. The data set is part of each
checkpoint: 4 bytes for an entry of an observation, 20 MB for 100,000 decisions on the tracks tier.
"""

from __future__ import annotations

from typing import Any, ClassVar, cast

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import ActorCriticPolicy

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import rollout
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Observations
from hazbot_gym.training.config import Imitation
from hazbot_gym.training.imitation import Lessons, learn, miss
from hazbot_gym.training.vec_envs import TrainingEnvs


class DAgger(BaseAlgorithm):
    """Supervised learning of a teacher's answers in rounds; in most, the pupil drives."""

    policy_aliases: ClassVar[Any] = {"MlpPolicy": ActorCriticPolicy}
    remembered = ("observations", "actions")
    policy: ActorCriticPolicy

    def __init__(
        self,
        policy: Any,
        env: TrainingEnvs,
        *,
        teacher: Policy,
        imitation: Imitation,
        beta: float = 0.5,
        **options: Any,
    ) -> None:
        """Make a pupil that knows nothing yet.

        Args:
            policy: ``MlpPolicy``; its critic is not taught.
            env: Where it learns.
            teacher: Who tells what to do.
            imitation: How long a round is and how the pupil is fitted.
            beta: Of the probability beta^i that the teacher drives in round i.
            options: What all algorithms of Stable-Baselines3 take.
        """
        if not 0.0 <= beta <= 1.0:
            raise InvalidInput(f"beta: given {beta!r}, allowed is 0 to 1")
        super().__init__(
            policy, env, support_multi_env=True, supported_action_spaces=(spaces.Box,), **options
        )
        self.teacher, self.imitation, self.beta = teacher, imitation, beta
        assert env.observation_space.shape is not None
        self.observations = torch.empty(0, *env.observation_space.shape)
        self.actions = torch.empty(0, 1)
        self._setup_model()

    def _setup_model(self) -> None:
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        policy = self.policy_class(
            self.observation_space, self.action_space, self.lr_schedule, **self.policy_kwargs
        )
        self.policy = cast(ActorCriticPolicy, policy)

    def learn(
        self,
        total_timesteps: int,
        callback: Any = None,
        log_interval: int | None = None,
        tb_log_name: str = "DAgger",
        reset_num_timesteps: bool = True,
        progress_bar: bool = False,
    ) -> DAgger:
        """Go through rounds until there were so many decisions; see ``BaseAlgorithm.learn``."""
        total, callback = self._setup_learn(
            total_timesteps, callback, reset_num_timesteps, tb_log_name, progress_bar
        )
        callback.on_training_start(locals(), globals())
        while self.num_timesteps < total:
            callback.on_rollout_start()
            seed = rollout.episode_seed(self.seed or 0, "round", self._n_updates)
            told = self._drive(callback, np.random.default_rng(seed))
            callback.on_rollout_end()
            self._fit(told, torch.Generator().manual_seed(seed))
        callback.on_training_end()
        return self

    def _drive(self, callback: BaseCallback, rng: np.random.Generator) -> Lessons:
        """Drive a round; return what was seen and what the teacher said about it."""
        assert self.env is not None
        share, state, seen, told = self.beta**self._n_updates, None, [], []
        for _ in range(-(-self.imitation.decisions // self.n_envs)):
            observation = cast(Observations, self._last_obs)
            wanted, state = self.teacher.predict(observation, state, self._last_episode_starts)
            seen.append(torch.from_numpy(observation))
            told.append(torch.from_numpy(wanted))
            is_taught = rng.random((self.n_envs, 1)) < share
            action = np.where(is_taught, wanted, self.predict(observation, deterministic=True)[0])
            noise = self.imitation.noise * rng.standard_normal(action.shape, np.float32)
            observed, _, dones, infos = self.env.step(np.clip(action + noise, -1.0, 1.0))
            self._last_obs = cast(Observations, observed)
            self._last_episode_starts = dones
            self.num_timesteps += self.n_envs
            callback.update_locals({"infos": infos, "dones": dones})
            callback.on_step()
        return Lessons(torch.cat(seen), torch.cat(told))

    def _fit(self, told: Lessons, generator: torch.Generator) -> None:
        """Add a round to the data set and fit the pupil to all of it."""
        self.logger.record("imitation/miss", self.miss_of(told))
        self.observations = torch.cat([self.observations, told.observations])
        self.actions = torch.cat([self.actions, told.actions])
        learn(self.policy, Lessons(self.observations, self.actions), self.imitation, generator)
        self.logger.record("imitation/miss_after", self.miss_of(told))
        self._n_updates += 1

    def miss_of(self, lessons: Lessons) -> float:
        """Return the pupil's mean squared miss of what it was told."""
        with torch.no_grad():
            drawn = self.policy.get_distribution(lessons.observations).distribution
            means = cast(torch.distributions.Distribution, drawn).mean
            return float(miss(means, lessons.actions))

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy"], []


class BC(DAgger):
    """Behaviour cloning: the teacher drives in every round."""

    def __init__(self, policy: Any, env: TrainingEnvs, **options: Any) -> None:
        super().__init__(policy, env, beta=1.0, **options)
