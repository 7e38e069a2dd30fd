"""PPO of Stable-Baselines3, with rollouts and updates on whole arrays.

The algorithm is unchanged (Schulman et al. 2017): actions, advantages and loss are those of
``stable_baselines3.PPO``, up to rounding. Torch's generator also draws the minibatches, NumPy's
there. Otherwise only the work is arranged in another way:

- A rollout computes the actor's mean alone at every step. Log probabilities and values follow at
  the end, for all steps at once.
- The gradient of a minibatch is the sum over chunks that fit into the processor's cache. Threads
  share the chunks; the order of the sum is fixed, so that results do not depend on their number.

With ``desired_kl`` the learning rate follows the KL divergence between the policies before an
update and in its last epoch: above twice the desired divergence it is divided by 1.5, below half of
it multiplied by 1.5 (after Rudin et al., CoRL 2021). The desired divergence falls linearly to 0
over the training, so that the policy comes to rest.

With ``final_log_std`` the standard deviation of the actions is not learned: its logarithm goes
linearly from ``log_std_init`` to this value over the training.

With ``normalize_by_env`` the advantages of a rollout are normalized within each environment of the
training before those of a minibatch are. Otherwise environments in which much is at stake, such as
a door that can be blocked, decide on the direction of an update alone (compare per-task
normalization, Hessel et al., AAAI 2019).

Discrete actions, state-dependent exploration and separate features of the actor use the methods of
Stable-Baselines3, which have none of these three; so do updates with clipped value losses, without
``desired_kl``.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypeVar, cast

import gymnasium
import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.utils import explained_variance
from stable_baselines3.common.vec_env import VecEnv

from hazbot_gym.envs.arguments import Info
from hazbot_gym.policies.guard import Flags, Observations
from hazbot_gym.training.combined_envs import CombinedEnvs

CHUNK = 2048  # decisions whose gradient is computed at once: their activations fit into the cache
LR_STEP, LR_LEAST, LR_MOST = 1.5, 1e-5, 1e-2  # of the learning rate that follows the KL divergence
# Options that Stable-Baselines3 does not have, and what leaves each of them out.
OWN = {"desired_kl": None, "final_log_std": None, "normalize_by_env": False}
Advantages = TypeVar("Advantages", torch.Tensor, npt.NDArray[np.float32])
HALF_LOG_2_PI = 0.5 * float(np.log(2.0 * np.pi))


class Chunk(NamedTuple):
    """Some decisions of a minibatch; tensors of n rows."""

    observations: torch.Tensor
    actions: torch.Tensor
    old_log_prob: torch.Tensor
    advantages: torch.Tensor  # normalized over the minibatch
    returns: torch.Tensor


class Losses(NamedTuple):
    """Sums over a chunk, or over a minibatch, of what Stable-Baselines3 logs."""

    policy: float
    value: float
    clipped: float  # decisions with a clipped ratio
    kl: float


class ArrayPPO(PPO):
    """Stable-Baselines3's PPO on whole arrays.

    Attributes:
        threads: Number of threads of an update.
        desired_kl: Desired KL divergence of an update at the start of the training, or None.
        final_log_std: Logarithm of the standard deviation at the end of the training, or None.
        normalize_by_env: Whether advantages are normalized within each environment first.
    """

    threads = 1

    def __init__(
        self,
        *args: Any,
        desired_kl: float | None = None,
        final_log_std: float | None = None,
        normalize_by_env: bool = False,
        **kwargs: Any,
    ) -> None:
        """Make a model; see ``stable_baselines3.PPO``.

        Args:
            *args: Arguments of ``stable_baselines3.PPO``.
            desired_kl: Desired KL divergence of an update. The learning rate given is then the
                first one. None: the learning rate is as given.
            final_log_std: Logarithm of the standard deviation at the end of the training. None: the
                standard deviation is learned.
            normalize_by_env: Whether to normalize the advantages within each environment of a
                ``CombinedEnvs`` first; not with discrete actions.
            **kwargs: Arguments of ``stable_baselines3.PPO``.

        Raises:
            ValueError: One of these three is given where Stable-Baselines3 trains, which has none.
        """
        self.desired_kl, self.final_log_std = desired_kl, final_log_std
        self.normalize_by_env = normalize_by_env
        super().__init__(*args, **kwargs)
        given = [name for name, without in OWN.items() if getattr(self, name) is not without]
        if given and not self._is_gaussian():
            raise ValueError(
                f"{given[0]} is given, allowed only with continuous actions and features shared by "
                "actor and critic, without use_sde and squash_output"
            )
        if desired_kl is not None and self.clip_range_vf is not None:
            raise ValueError("desired_kl is given, allowed without clip_range_vf only")
        if final_log_std is not None:
            self.policy.log_std.requires_grad_(False)

    def collect_rollouts(
        self,
        env: VecEnv,
        callback: BaseCallback,
        rollout_buffer: RolloutBuffer,
        n_rollout_steps: int,
    ) -> bool:
        """Collect a rollout of every world; see ``stable_baselines3.PPO``."""
        if not self._is_gaussian():
            return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)
        policy = self.policy
        policy.set_training_mode(False)
        self._set_std()
        rollout_buffer.reset()
        callback.on_rollout_start()
        seen, starts = cast(Observations, self._last_obs), cast(Flags, self._last_episode_starts)
        std = policy.log_std.detach().exp()
        cut_off: list[tuple[int, int, Observations]] = []
        for step in range(n_rollout_steps):
            with torch.no_grad():
                mean = mean_action(policy, features_of(policy, torch.as_tensor(seen)))
                actions = torch.normal(mean, std.expand_as(mean)).numpy()
            rollout_buffer.observations[step] = seen
            rollout_buffer.actions[step] = actions
            rollout_buffer.episode_starts[step] = starts
            new, rewards, dones, infos = env.step(np.clip(actions, -1.0, 1.0))
            self.num_timesteps += env.num_envs
            rollout_buffer.rewards[step] = rewards
            cut_off += [
                (step, i, infos[i]["terminal_observation"])
                for i in np.flatnonzero(dones).tolist()
                if infos[i].get("TimeLimit.truncated", False)
            ]
            callback.update_locals(locals())
            if not callback.on_step():
                return False
            self._note_ends(infos, dones)
            seen, starts = cast(Observations, new), dones
        self._last_obs, self._last_episode_starts = seen, starts
        rollout_buffer.pos, rollout_buffer.full = n_rollout_steps, True
        self._evaluate(rollout_buffer, cut_off)
        callback.update_locals(locals())
        callback.on_rollout_end()
        return True

    def train(self) -> None:
        """Update the policy with the rollout; see ``stable_baselines3.PPO``."""
        if not self._is_gaussian() or self.clip_range_vf is not None:
            super().train()
            return
        self.policy.set_training_mode(True)
        if self.desired_kl is None:
            self._update_learning_rate(self.policy.optimizer)
        clip_range = cast(Any, self.clip_range)(self._current_progress_remaining)
        buffer, noted = self.rollout_buffer, list[Losses]()
        whole = _flattened(buffer)
        with ThreadPoolExecutor(
            self.threads, initializer=torch.set_num_threads, initargs=(1,)
        ) as pool:
            for _ in range(self.n_epochs):
                losses, goes_on = self._epoch(whole, clip_range, pool)
                noted += losses
                self._n_updates += 1
                if not goes_on:
                    break
        self._follow(float(np.mean([each.kl for each in losses])))
        self._log(noted, losses, clip_range)

    # --- inside ----------------------------------------------------------------------------------

    def _is_gaussian(self) -> bool:
        """Return True for continuous actions with a plain Gaussian and shared features."""
        policy = self.policy
        return (
            isinstance(self.action_space, gymnasium.spaces.Box)
            and not self.use_sde
            and not policy.squash_output
            and policy.share_features_extractor
        )

    def _set_std(self) -> None:
        """Set the standard deviation of the actions, where it is not learned."""
        if self.final_log_std is not None:
            first, done = self.policy.log_std_init, 1.0 - self._current_progress_remaining
            self.policy.log_std.data.fill_(first + (self.final_log_std - first) * done)

    def _trained(self) -> list[torch.nn.Parameter]:
        return [each for each in self.policy.parameters() if each.requires_grad]

    def _follow(self, kl: float) -> None:
        """Adapt the learning rate to the KL divergence of an update."""
        if self.desired_kl is None:
            return
        desired, (group,) = self.desired_kl * self._current_progress_remaining, self._groups()
        if kl > 2.0 * desired:
            group["lr"] = max(group["lr"] / LR_STEP, LR_LEAST)
        elif kl < 0.5 * desired:
            group["lr"] = min(group["lr"] * LR_STEP, LR_MOST)

    def _groups(self) -> list[dict[str, Any]]:
        return self.policy.optimizer.param_groups

    def _note_ends(self, infos: list[Info], dones: Flags) -> None:
        ends = np.flatnonzero(dones)
        if len(ends):
            self._update_info_buffer([infos[i] for i in ends], np.ones(len(ends), np.bool_))

    def _evaluate(
        self, buffer: RolloutBuffer, cut_off: list[tuple[int, int, Observations]]
    ) -> None:
        """Write values, log probabilities, returns and advantages of a rollout.

        The value of an episode that the horizon cut off is bootstrapped.
        """
        policy = self.policy
        with torch.no_grad():
            for step in range(buffer.buffer_size):
                seen = torch.as_tensor(buffer.observations[step])
                features = features_of(policy, seen)
                mean = mean_action(policy, features)
                value = policy.value_net(policy.mlp_extractor.forward_critic(features))
                actions = torch.as_tensor(buffer.actions[step])
                buffer.log_probs[step] = log_prob(actions, mean, policy.log_std).numpy()
                buffer.values[step] = value.numpy().flatten()
            for step, i, last in cut_off:
                value = policy.predict_values(torch.as_tensor(last[None]))
                buffer.rewards[step, i] += self.gamma * value.item()
            final = policy.predict_values(torch.as_tensor(cast(Observations, self._last_obs)))
        buffer.compute_returns_and_advantage(final, cast(Flags, self._last_episode_starts))
        if self.normalize_by_env:
            assert self.env is not None
            for worlds in cast(CombinedEnvs, self.env.unwrapped).slices:
                buffer.advantages[:, worlds] = normalized(buffer.advantages[:, worlds])

    def _epoch(
        self, whole: Chunk, clip_range: float, pool: ThreadPoolExecutor
    ) -> tuple[list[Losses], bool]:
        """Update once with every minibatch; return its losses, and False beyond ``target_kl``."""
        noted = []
        for rows in _minibatches(len(whole.returns), self.batch_size):
            found = self._gradient(whole, rows, clip_range, pool)
            noted.append(Losses(*(each / len(rows) for each in found)))
            if self.target_kl is not None and noted[-1].kl > 1.5 * self.target_kl:
                return noted, False
            torch.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
            self.policy.optimizer.step()
        return noted, True

    def _gradient(
        self, whole: Chunk, rows: torch.Tensor, clip_range: float, pool: ThreadPoolExecutor
    ) -> Losses:
        """Set the gradient of the loss of a minibatch; return the sums of its losses."""
        advantages = whole.advantages[rows]
        if self.normalize_advantage and len(rows) > 1:
            advantages = normalized(advantages)

        def part(first: int) -> tuple[tuple[torch.Tensor | None, ...], Losses]:
            chunk = Chunk(*(each[rows[first : first + CHUNK]] for each in whole))
            chunk = chunk._replace(advantages=advantages[first : first + CHUNK])
            return self._chunk_gradient(chunk, len(rows), clip_range)

        parts = list(pool.map(part, range(0, len(rows), CHUNK)))
        for parameter, *each in zip(
            self._trained(), *(gradients for gradients, _ in parts), strict=True
        ):
            parameter.grad = None if each[0] is None else sum(each[1:], start=each[0])
        return Losses(*(sum(each) for each in zip(*(losses for _, losses in parts), strict=True)))

    def _chunk_gradient(
        self, chunk: Chunk, total: int, clip_range: float
    ) -> tuple[tuple[torch.Tensor | None, ...], Losses]:
        """Return a chunk's part of the gradient, None for unused parameters, and its losses."""
        policy = self.policy
        features = features_of(policy, chunk.observations)
        mean = mean_action(policy, features)
        values = policy.value_net(policy.mlp_extractor.forward_critic(features)).flatten()
        log_ratio = log_prob(chunk.actions, mean, policy.log_std) - chunk.old_log_prob
        ratio = log_ratio.exp()
        clipped = ratio.clamp(1.0 - clip_range, 1.0 + clip_range)
        policy_loss = -torch.min(chunk.advantages * ratio, chunk.advantages * clipped).sum()
        value_loss = (chunk.returns - values).square().sum()
        entropy = (policy.log_std + 0.5 + HALF_LOG_2_PI).sum() * len(values)
        loss = policy_loss + self.vf_coef * value_loss - self.ent_coef * entropy
        gradients = torch.autograd.grad(loss / total, self._trained(), allow_unused=True)
        with torch.no_grad():
            beyond = ((ratio - 1.0).abs() > clip_range).sum()
            kl = (ratio - 1.0 - log_ratio).sum()
        return gradients, Losses(*(each.item() for each in (policy_loss, value_loss, beyond, kl)))

    def _log(self, noted: list[Losses], last: list[Losses], clip_range: float) -> None:
        buffer, policy = self.rollout_buffer, self.policy
        means = Losses(*np.mean(noted, axis=0))
        entropy = (policy.log_std + 0.5 + HALF_LOG_2_PI).sum().item()
        loss = last[-1].policy + self.vf_coef * last[-1].value - self.ent_coef * entropy
        explained = explained_variance(buffer.values.flatten(), buffer.returns.flatten())
        if self.desired_kl is not None:
            self.logger.record("train/learning_rate", self._groups()[0]["lr"])
        self.logger.record("train/entropy_loss", -entropy)
        self.logger.record("train/policy_gradient_loss", means.policy)
        self.logger.record("train/value_loss", means.value)
        self.logger.record("train/approx_kl", float(np.mean([each.kl for each in last])))
        self.logger.record("train/clip_fraction", means.clipped)
        self.logger.record("train/loss", loss)
        self.logger.record("train/explained_variance", explained)
        self.logger.record("train/std", policy.log_std.exp().mean().item())
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        self.logger.record("train/clip_range", clip_range)


def normalized(advantages: Advantages) -> Advantages:
    """Return advantages with mean 0 and standard deviation 1."""
    result: Advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
    return result


def features_of(policy: ActorCriticPolicy, observations: torch.Tensor) -> torch.Tensor:
    """Return the features that actor and critic share."""
    return cast(torch.Tensor, policy.features_extractor(observations))


def mean_action(policy: ActorCriticPolicy, features: torch.Tensor) -> torch.Tensor:
    """Return the mean of the actor's Gaussian (n, 1)."""
    return cast(torch.Tensor, policy.action_net(policy.mlp_extractor.forward_actor(features)))


def log_prob(actions: torch.Tensor, mean: torch.Tensor, log_std: torch.Tensor) -> torch.Tensor:
    """Return the log density (n,) of actions (n, k) of a diagonal Gaussian."""
    z = (actions - mean) * (-log_std).exp()
    return (-0.5 * z.square() - log_std - HALF_LOG_2_PI).sum(dim=1)


def _flattened(buffer: RolloutBuffer) -> Chunk:
    """Return a rollout world by world, in the order of Stable-Baselines3."""

    def flat(name: str) -> torch.Tensor:
        return torch.from_numpy(buffer.swap_and_flatten(getattr(buffer, name)))

    return Chunk(
        observations=flat("observations"),
        actions=flat("actions"),
        old_log_prob=flat("log_probs").flatten(),
        advantages=flat("advantages").flatten(),
        returns=flat("returns").flatten(),
    )


def _minibatches(count: int, size: int) -> Iterator[torch.Tensor]:
    """Yield the rows of each minibatch of an epoch."""
    order = torch.randperm(count)
    for first in range(0, count, size):
        yield order[first : first + size]
