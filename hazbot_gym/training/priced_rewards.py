"""Rewards at a price of nearness that is drawn for each episode, and observed.

A policy that observes the price learns the whole trade-off between delay and discomfort at once
(compare Abels et al., ICML 2019). The price is drawn log-uniformly from the run's range; with w the
weight of the intrusion term i in the environment's config,

    r' = r + (w(price) - w) i,    w(price) = -price dt
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import gymnasium
import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.config import Config
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Flags, Observations
from hazbot_gym.policies.price_input import PriceInput
from hazbot_gym.task.reward import INTRUSION, price_of
from hazbot_gym.training.combined_envs import CombinedEnvs, aligned
from hazbot_gym.training.config import TrainConfig

STREAM = 1  # of the random numbers of a seed; staggered starts use those without a stream


class PricedRewards(VecEnvWrapper):
    """Environment wrapper: draws a price for each episode, which is the last observation entry.

    Attributes:
        prices: (N,) prices of the running episodes.
    """

    def __init__(self, envs: VecEnv, inputs: PriceInput) -> None:
        """Wrap environments above a ``CombinedEnvs``, with rewards as they come."""
        space = envs.observation_space
        assert isinstance(space, gymnasium.spaces.Box)
        low, high = np.append(space.low, np.float32(-1.0)), np.append(space.high, np.float32(1.0))
        super().__init__(envs, gymnasium.spaces.Box(low, high))
        self._inputs, self._envs = inputs, cast(CombinedEnvs, envs.unwrapped)
        self._own = self._envs.of_each_world(price_of)
        self._decision_s = self._envs.of_each_world(lambda config: config.clock.decision_s)
        self._rng = np.random.default_rng([0, STREAM])
        self._entries = np.zeros(self.num_envs)
        self.prices = self._own.copy()

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed all worlds, and the prices."""
        self._rng = np.random.default_rng(None if seed is None else [seed, STREAM])
        return self.venv.seed(seed)

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        self._draw(np.ones(self.num_envs, np.bool_))
        return self._with_price(cast(Observations, self.venv.reset()))

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        weights = (self._own - self.prices) * self._decision_s
        rewards = rewards + weights * self._envs.terms[:, INTRUSION]
        for i in np.flatnonzero(dones):
            last, entry = infos[i]["terminal_observation"], np.float32(self._entries[i])
            infos[i]["terminal_observation"] = np.append(last, entry)
        self._draw(dones)
        return self._with_price(cast(Observations, observations)), rewards, dones, infos

    def _draw(self, which: Flags) -> None:
        self._entries[which] = self._rng.uniform(-1.0, 1.0, which.sum())
        self.prices[which] = self._inputs.price(self._entries[which])

    def _with_price(self, observations: Observations) -> Observations:
        width = observations.shape[1]
        priced = aligned(self.num_envs, width + 1)
        priced[:, :width] = observations
        priced[:, width] = self._entries
        return priced


class AtPrice:
    """A model in training as a policy at one price."""

    def __init__(self, model: Policy, entry: float) -> None:
        self._model, self._entry = model, np.float32(entry)

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: Flags | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the model's action; see ``Policy.predict``."""
        entry = np.full((*observation.shape[:-1], 1), self._entry)
        seen = np.concatenate([observation, entry], axis=-1)
        return self._model.predict(seen, state, episode_start, deterministic)


def price_input_of(config: TrainConfig) -> PriceInput | None:
    """Return the price input of a run's policy, if it has one.

    Raises:
        InvalidInput: The environments have no single price, or one outside the range.
    """
    if config.prices is None:
        return None
    low, high = config.prices
    own = sorted({fixed_price(each) for each in config.environments()})
    if len(own) > 1 or not low <= own[0] <= high:
        given = ", ".join(f"{price:g}" for price in own)
        raise InvalidInput(
            f"prices: given {low:g} to {high:g} for environments with {given}, allowed is a range "
            "with their one price in it"
        )
    return PriceInput(low, high, own[0])


def fixed_price(config: Config) -> float:
    """Return the price of an environment.

    Raises:
        InvalidInput: It changes from episode to episode.
    """
    if "reward.intrusion" in config.randomised:
        raise InvalidInput("prices: given with a randomised reward.intrusion, allowed is one value")
    return round(price_of(config), 9)
