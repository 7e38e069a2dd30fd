"""Imitation pretraining: supervised learning from a teacher before reinforcement learning.

The teacher drives under action noise, so that the demonstrations include recoveries (DART, Laskey
et al., CoRL 2017). In further rounds the student drives and the teacher says what it would do, so
that the student learns where its own mistakes lead; it is fitted to all rounds (DAgger, Ross et
al., AISTATS 2011). The actor is fitted to the teacher's noise-free actions by least squares, the
critic to the returns of the last round, so that PPO's first updates do not destroy the actor.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecEnv

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation import rollout
from hazbot_gym.policies.base import NO_CODE, Permissions, Policy, make
from hazbot_gym.policies.guard import Actions, Flags, Observations
from hazbot_gym.training.combined_envs import CombinedEnvs, driver_in, policy_width
from hazbot_gym.training.config import Imitation, TrainConfig
from hazbot_gym.training.vec_envs import require_speeds


class Demonstrations(NamedTuple):
    """Demonstrations: observations, expert actions, and returns for a critic."""

    observations: torch.Tensor  # (M, width)
    actions: torch.Tensor  # (M, 1) expert actions
    returns: torch.Tensor | None = None  # (M,) discounted returns, NaN where a critic has no use

    def take(self, rows: torch.Tensor) -> Demonstrations:
        """Return a subset."""
        returns = None if self.returns is None else self.returns[rows]
        return Demonstrations(self.observations[rows], self.actions[rows], returns)


class Teachers:
    """A teacher for the worlds of each environment, as one policy for all worlds."""

    def __init__(self, teachers: Sequence[Policy], worlds: Sequence[slice]) -> None:
        """Combine teachers.

        Args:
            teachers: One for each environment.
            worlds: The worlds of each environment, from the first to the last.
        """
        self._teachers, self._worlds = teachers, worlds

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: Flags | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the actions of all worlds, and the teachers' states."""
        states = [None] * len(self._teachers) if state is None else cast(list[object], state)
        answers = [
            teacher.predict(
                observation[own], last, None if episode_start is None else episode_start[own],
                deterministic,
            )
            for teacher, own, last in zip(self._teachers, self._worlds, states, strict=True)
        ]  # fmt: skip
        return np.concatenate([actions for actions, _ in answers]), [each for _, each in answers]


def teacher_of(config: TrainConfig, envs: VecEnv, allowed: Permissions = NO_CODE) -> Policy:
    """Return the teacher of a run in all its environments, with the given permissions.

    Raises:
        InvalidInput: The policy is unknown, cannot act on these observations, or actions are
            discrete, which teachers do not support.
    """
    require_speeds(envs, "imitation")
    specs = config.teachers()
    made = {spec: make(spec, **allowed._asdict()) for spec in dict.fromkeys(specs)}
    made = {spec: driver_in(envs, teacher, spec) for spec, teacher in made.items()}
    for teacher in made.values():
        teacher.predict(np.zeros((1, policy_width(envs)), np.float32))
    if len(made) == 1:
        return made[specs[0]]
    worlds = cast(CombinedEnvs, envs.unwrapped).slices
    return Teachers([made[spec] for spec in specs], worlds)


def imitate(model: PPO, envs: VecEnv, teacher: Policy, config: TrainConfig) -> None:
    """Pretrain a new model on the teacher of its run; deterministic for a seed."""
    assert config.imitation is not None
    rounds = list[Demonstrations]()
    for each in range(config.imitation.rounds):
        seed = rollout.episode_seed(config.seed, "imitation", each)
        envs.seed(seed)
        rng, student = np.random.default_rng(seed), model.policy if rounds else None
        rounds.append(watch(envs, teacher, config.imitation, float(model.gamma), rng, student))
        generator = torch.Generator().manual_seed(seed)
        learn(model.policy, _joined(rounds), config.imitation, generator)


def watch(
    envs: VecEnv,
    teacher: Policy,
    imitation: Imitation,
    gamma: float,
    rng: np.random.Generator,
    student: ActorCriticPolicy | None = None,
) -> Demonstrations:
    """Collect demonstrations in all worlds in parallel; return those of complete episodes.

    The student drives, if there is one, else the teacher.
    """
    observation, state = cast(Observations, envs.reset()), None
    width, starts = policy_width(envs), np.ones(envs.num_envs, np.bool_)
    seen, done, expert = [], [], []
    for _ in range(-(-imitation.decisions // envs.num_envs)):
        action, state = teacher.predict(observation[:, :width], state, starts)
        seen.append(observation)
        expert.append(action)
        driven = student.predict(observation, deterministic=True)[0] if student else action
        noise = imitation.noise * rng.standard_normal(action.shape, np.float32)
        seen_next, rewards, starts, _ = envs.step(np.clip(driven + noise, -1.0, 1.0))
        observation = cast(Observations, seen_next)
        done.append((rewards, starts))
    rewards, ends = (np.stack(each) for each in zip(*done, strict=True))
    returns, is_known = returns_of(rewards, ends, gamma)
    demonstrations = (np.stack(seen), np.stack(expert), returns.astype(np.float32))
    return Demonstrations(*(torch.as_tensor(each[is_known]) for each in demonstrations))


def _joined(rounds: Sequence[Demonstrations]) -> Demonstrations:
    """Return the demonstrations of all rounds, with the returns of the last one."""
    observations, actions, returns = zip(*rounds, strict=True)
    unknown = [torch.full_like(each, torch.nan) for each in returns[:-1]]
    return Demonstrations(
        torch.cat(observations), torch.cat(actions), torch.cat([*unknown, returns[-1]])
    )


def returns_of(rewards: Floats, ends: Flags, gamma: float) -> tuple[Floats, Flags]:
    """Return discounted returns (T, N), and a mask of the decisions of complete episodes."""
    returns, is_known = np.zeros_like(rewards, np.float64), np.zeros_like(ends, np.bool_)
    later, has_end = np.zeros(rewards.shape[1]), np.zeros(rewards.shape[1], np.bool_)
    for t in reversed(range(len(rewards))):
        later = rewards[t] + gamma * np.where(ends[t], 0.0, later)
        has_end = has_end | ends[t]
        returns[t], is_known[t] = later, has_end
    return returns, is_known


def learn(
    policy: ActorCriticPolicy,
    demonstrations: Demonstrations,
    imitation: Imitation,
    generator: torch.Generator,
) -> None:
    """Fit an actor, and a critic if returns are given, with a learning rate that decays to 0."""
    count = len(demonstrations.actions)
    batches = imitation.epochs * (count // imitation.batch_size)
    optimizer = torch.optim.Adam(policy.parameters(), imitation.learning_rate)
    falling = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, total_iters=max(batches, 1))
    for _ in range(imitation.epochs):
        order = torch.randperm(count, generator=generator)
        lots = order.split(imitation.batch_size)  # type: ignore[no-untyped-call]  # torch's own
        for batch in lots[: batches // imitation.epochs]:
            loss = _loss(policy, demonstrations.take(batch))
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]  # torch's own
            optimizer.step()
            falling.step()


def _loss(policy: ActorCriticPolicy, demonstrations: Demonstrations) -> torch.Tensor:
    loss = miss(mean_actions(policy, demonstrations.observations), demonstrations.actions)
    if demonstrations.returns is not None:
        values = policy.predict_values(demonstrations.observations).flatten()
        errors = (values - demonstrations.returns)[~demonstrations.returns.isnan()]
        loss = loss + errors.square().sum() / max(len(errors), 1)
    return loss


def mean_actions(policy: ActorCriticPolicy, observations: torch.Tensor) -> torch.Tensor:
    """Return the mean of the actions' distribution, squashed if the policy squashes it."""
    drawn = cast(
        torch.distributions.Distribution, policy.get_distribution(observations).distribution
    )
    return torch.tanh(drawn.mean) if policy.squash_output else drawn.mean


def miss(means: torch.Tensor, actions: torch.Tensor) -> torch.Tensor:
    """Return the mean squared error; outputs that clip to the teacher's action have error 0."""
    is_beyond = (means * actions > 0.0) & (actions.abs() >= 1.0) & (means.abs() >= 1.0)
    return torch.where(is_beyond, 0.0, (means - actions) ** 2).mean()
