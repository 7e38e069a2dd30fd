"""PPO under a limit on the cost of an episode, by a price on cost that finds itself.

    maximise   J_r - lambda (J_c - d)                    over the policy, by PPO
    I      <-  [I + eta (J_c - d)]+
    lambda <-  [I + K_P (J_c - d) + K_D [J_c - J_c']+]+

J_c is the mean cost of an episode, J_c' the one before, d the limit. With K_P = K_D = 0 this is the
gradient step on the multiplier of PPO-Lagrangian (Ray, Achiam and Amodei 2019); the other two terms
make it a PID controller, which overshoots less (Stooke, Achiam and Abbeel, ICML 2020, algorithm 2).
Price and reward go into one critic: every reward becomes r - lambda c.

A decision's cost is its intrusion, plus 1 for a contact that the robot causes. The reward charges
the same intrusion by a fixed price, its weight of -4 (``config.reward``), so with that weight
lambda is what the limit asks *on top*, and 4 stays charged however low the cost. To let the limit
alone decide, take the fixed price away, ``overrides: {reward: {intrusion: 0}}``; lambda is then
what the intrusion weight would have to be for a cost of d.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnvWrapper

from hazbot_gym.training.config import Lagrangian
from hazbot_gym.training.vec_envs import TrainingEnvs


class Price(NamedTuple):
    """The state of the controller."""

    multiplier: float  # lambda, in units of the bare reward
    integral: float
    cost: float = math.inf  # J_c of the last change; before the first nothing grows


def moved(price: Price, cost: float, lagrangian: Lagrangian) -> Price:
    """Return the price after episodes of some mean cost."""
    excess, growth = cost - lagrangian.limit, max(cost - price.cost, 0.0)
    integral = max(price.integral + lagrangian.rate * excess, 0.0)
    total = integral + lagrangian.proportional * excess + lagrangian.derivative * growth
    return Price(max(total, 0.0), integral, cost)


class PricedEnvs(VecEnvWrapper):
    """Environments in which cost is paid for: r - lambda c, scaled as rewards are."""

    def __init__(self, envs: TrainingEnvs, multiplier: float) -> None:
        super().__init__(envs)
        self.reward_scale, self.multiplier = envs.scale, multiplier

    def reset(self) -> Any:
        """Start new episodes everywhere."""
        return self.venv.reset()

    def step_wait(self) -> tuple[Any, npt.NDArray[np.float32], Any, list[dict[str, Any]]]:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        costs = np.array([info["cost"] for info in infos], np.float32)
        return observations, rewards - self.reward_scale * self.multiplier * costs, dones, infos


class PPOLagrangian(PPO):
    """PPO whose rewards are charged for cost, at a price that moves between updates.

    It moves when as many episodes have ended as there are worlds: of episodes that begin together
    the short ones end first, and what they cost is not what episodes cost.
    """

    remembered = ("price", "ended")

    def __init__(
        self, policy: Any, env: TrainingEnvs, *, lagrangian: Lagrangian, **options: Any
    ) -> None:
        self.lagrangian = lagrangian
        self.price = list(Price(lagrangian.start, lagrangian.start))  # as checkpoints keep it
        self.ended: list[float] = []  # costs of the episodes that have ended since it moved
        super().__init__(policy, PricedEnvs(env, lagrangian.start), **options)

    def collect_rollouts(self, env: Any, *arguments: Any, **options: Any) -> bool:
        """Let the policy drive where cost has its present price."""
        env.multiplier = self.price[0]
        return super().collect_rollouts(env, *arguments, **options)

    def train(self) -> None:
        """Move the price if enough is known, then update the policy."""
        if len(self.ended) >= self.n_envs:
            cost = float(np.mean(self.ended))
            self.price, self.ended = list(moved(Price(*self.price), cost, self.lagrangian)), []
            self.logger.record("lagrangian/cost", cost)
        self.logger.record("lagrangian/multiplier", self.price[0])
        super().train()

    def _update_info_buffer(self, infos: list[dict[str, Any]], dones: Any = None) -> None:
        super()._update_info_buffer(infos, dones)
        self.ended += [infos[i]["episode"]["cost"] for i in np.flatnonzero(dones)]
