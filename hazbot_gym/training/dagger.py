"""Imitation learning: behaviour cloning and DAgger.

In round i = 0, 1, ... the teacher acts with probability beta^i in each decision, the student
otherwise; the teacher labels every observation with its own action; the student is fitted to the
aggregated data set (Ross, Gordon and Bagnell, AISTATS 2011, algorithm 3.1). So it learns in the
states that its own mistakes lead to. With beta = 0 the teacher drives in the first round only (the
parameter-free schedule of Ross et al.); with beta = 1 the teacher drives in all rounds, which is
behavior cloning (Pomerleau 1989). The best student on validation is kept, as in the algorithm of
Ross et al.

A round takes ``imitation.decisions``, a run ``steps`` decisions in total. The data set is part of
each checkpoint: 4 bytes per observation entry, 20 MB for 100,000 decisions on the tracks tier.
"""

from __future__ import annotations

from typing import Any, ClassVar, cast

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.type_aliases import MaybeCallback
from stable_baselines3.common.vec_env import VecEnv

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import rollout
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Observations
from hazbot_gym.training.config import Imitation
from hazbot_gym.training.imitation import Demonstrations, learn, mean_actions, miss


class DAgger(BaseAlgorithm):
    """DAgger: supervised learning of the teacher's actions on the student's own states."""

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {"MlpPolicy": ActorCriticPolicy}
    remembered = ("observations", "actions")
    policy: ActorCriticPolicy

    def __init__(
        self,
        policy: str | type[ActorCriticPolicy],
        env: VecEnv,
        *,
        teacher: Policy,
        imitation: Imitation,
        beta: float = 0.5,
        **options: Any,
    ) -> None:
        """Make an untrained student.

        Args:
            policy: ``MlpPolicy``; its critic is not trained.
            env: Training environments.
            teacher: Policy that labels observations with actions.
            imitation: Length of a round and options of the fit.
            beta: Base of the probability beta^i that the teacher drives in round i.
            options: Options of ``BaseAlgorithm``.
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
        callback: MaybeCallback = None,
        log_interval: int | None = None,
        tb_log_name: str = "DAgger",
        reset_num_timesteps: bool = True,
        progress_bar: bool = False,
    ) -> DAgger:
        """Run rounds up to a number of decisions; see ``BaseAlgorithm.learn``."""
        total, callback = self._setup_learn(
            total_timesteps, callback, reset_num_timesteps, tb_log_name, progress_bar
        )
        callback.on_training_start(locals(), globals())
        while self.num_timesteps < total:
            callback.on_rollout_start()
            seed = rollout.episode_seed(self.seed or 0, "round", self._n_updates)
            demonstrations = self._drive(callback, np.random.default_rng(seed))
            callback.on_rollout_end()
            self._fit(demonstrations, torch.Generator().manual_seed(seed))
        callback.on_training_end()
        return self

    def _drive(self, callback: BaseCallback, rng: np.random.Generator) -> Demonstrations:
        """Drive a round; return the observations and the teacher's actions."""
        assert self.env is not None
        share, state, seen, expert = self.beta**self._n_updates, None, [], []
        for _ in range(-(-self.imitation.decisions // self.n_envs)):
            observation = cast(Observations, self._last_obs)
            wanted, state = self.teacher.predict(observation, state, self._last_episode_starts)
            seen.append(torch.from_numpy(observation))
            expert.append(torch.from_numpy(wanted))
            is_taught = rng.random((self.n_envs, 1)) < share
            action = np.where(is_taught, wanted, self.predict(observation, deterministic=True)[0])
            noise = self.imitation.noise * rng.standard_normal(action.shape, np.float32)
            observed, _, dones, infos = self.env.step(np.clip(action + noise, -1.0, 1.0))
            self._last_obs = cast(Observations, observed)
            self._last_episode_starts = dones
            self.num_timesteps += self.n_envs
            callback.update_locals({"infos": infos, "dones": dones})
            callback.on_step()
        return Demonstrations(torch.cat(seen), torch.cat(expert))

    def _fit(self, demonstrations: Demonstrations, generator: torch.Generator) -> None:
        """Add a round to the data set and fit the student to the whole set."""
        self.logger.record("imitation/miss", self.miss_of(demonstrations))
        self.observations = torch.cat([self.observations, demonstrations.observations])
        self.actions = torch.cat([self.actions, demonstrations.actions])
        learn(
            self.policy, Demonstrations(self.observations, self.actions), self.imitation, generator
        )
        self.logger.record("imitation/miss_after", self.miss_of(demonstrations))
        self._n_updates += 1

    def miss_of(self, demonstrations: Demonstrations) -> float:
        """Return the student's mean squared error of the teacher's actions."""
        with torch.no_grad():
            means = mean_actions(self.policy, demonstrations.observations)
            return float(miss(means, demonstrations.actions))

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy"], []


class BC(DAgger):
    """Behaviour cloning: the teacher drives in every round."""

    def __init__(self, policy: str | type[ActorCriticPolicy], env: VecEnv, **options: Any) -> None:
        super().__init__(policy, env, beta=1.0, **options)
