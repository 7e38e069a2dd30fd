"""PPO-Lagrangian: PPO under a constraint on the cost of an episode, with an adaptive multiplier.

    maximise   J_r - lambda (J_c - d)                    over the policy, by PPO
    I      <-  [I + eta (J_c - d)]+
    lambda <-  [I + K_P (J_c - d) + K_D [J_c - J_c']+]+

J_c is the mean cost of an episode, J_c' the one before, d the limit. With K_P = K_D = 0 this is the
gradient step on the multiplier of PPO-Lagrangian (Ray, Achiam and Amodei 2019); the other two terms
make it a PID controller, which overshoots less (Stooke, Achiam and Abbeel, ICML 2020, algorithm 2).
Cost and reward share one critic: every reward becomes r - lambda c.

A decision's cost is its intrusion, plus 1 for a contact that the robot causes. The reward penalizes
the same intrusion by a fixed weight (``config.reward``), so lambda is an *additional* penalty, and
the fixed one remains however low the cost. To let the constraint alone decide, remove
the fixed weight, ``overrides: {reward: {intrusion: 0}}``; lambda is then the intrusion weight that
gives a cost of d.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, cast

import numpy as np
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.envs.arguments import Info
from hazbot_gym.policies.guard import Flags
from hazbot_gym.training.array_ppo import ArrayPPO
from hazbot_gym.training.combined_envs import CombinedEnvs
from hazbot_gym.training.config import Lagrangian


class MultiplierState(NamedTuple):
    """Multiplier lambda and the state of its PID controller."""

    multiplier: float  # lambda, in units of the unscaled reward
    integral: float
    cost: float = math.inf  # J_c of the last update; None before the first


def updated(state: MultiplierState, cost: float, lagrangian: Lagrangian) -> MultiplierState:
    """Return the multiplier after episodes of some mean cost."""
    excess, growth = cost - lagrangian.limit, max(cost - state.cost, 0.0)
    integral = max(state.integral + lagrangian.rate * excess, 0.0)
    total = integral + lagrangian.proportional * excess + lagrangian.derivative * growth
    return MultiplierState(max(total, 0.0), integral, cost)


class PenalizedEnvs(VecEnvWrapper):
    """Environment wrapper with penalized rewards r - lambda c, scaled like rewards."""

    def __init__(self, envs: VecEnv, multiplier: float, reward_scale: float) -> None:
        super().__init__(envs)
        self.multiplier, self.reward_scale = multiplier, reward_scale

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        costs = cast(CombinedEnvs, self.unwrapped).costs.astype(np.float32)
        return observations, rewards - self.reward_scale * self.multiplier * costs, dones, infos


class PPOLagrangian(ArrayPPO):
    """PPO-Lagrangian: the multiplier is updated between policy updates.

    The multiplier is updated after as many episodes have ended as there are worlds. Of episodes
    that begin together, the short ones end first, so that the costs of fewer episodes would be a
    biased sample.
    """

    remembered = ("multiplier", "ended")

    def __init__(
        self,
        policy: str | type[ActorCriticPolicy],
        env: VecEnv,
        *,
        lagrangian: Lagrangian,
        reward_scale: float,
        **options: Any,
    ) -> None:
        self.lagrangian = lagrangian
        self.multiplier = list(MultiplierState(lagrangian.start, lagrangian.start))  # checkpointed
        self.ended: list[float] = []  # costs of the episodes that ended since the last update
        super().__init__(policy, PenalizedEnvs(env, lagrangian.start, reward_scale), **options)

    def collect_rollouts(
        self,
        env: VecEnv,
        callback: BaseCallback,
        rollout_buffer: RolloutBuffer,
        n_rollout_steps: int,
    ) -> bool:
        """Collect rollouts with the current multiplier."""
        cast(PenalizedEnvs, env).multiplier = self.multiplier[0]
        return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)

    def train(self) -> None:
        """Update the multiplier if enough episodes have ended, then the policy."""
        if len(self.ended) >= self.n_envs:
            cost = float(np.mean(self.ended))
            self.multiplier, self.ended = (
                list(updated(MultiplierState(*self.multiplier), cost, self.lagrangian)),
                [],
            )
            self.logger.record("lagrangian/cost", cost)
        self.logger.record("lagrangian/multiplier", self.multiplier[0])
        super().train()

    def _update_info_buffer(self, infos: list[Info], dones: Flags | None = None) -> None:
        super()._update_info_buffer(infos, dones)
        ended = [infos[i] for i in np.flatnonzero(cast(Flags, dones))]
        self.ended += [info["episode"]["cost"] for info in ended if "episode" in info]
