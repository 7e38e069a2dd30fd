"""Policies around policies, with which the episodes of a replay are run again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.task.observation import Layout, readings

Heard = tuple[Episode, Row, Floats]  # an episode, its labels, and the readings of its sonar


class Listener:
    """Policy that notes the range readings it is given, and lets another policy act."""

    def __init__(self, policy: Policy, layout: Layout) -> None:
        self._policy, self._layout = policy, layout
        # of episodes side by side; (worlds, sensors) per decision
        self._rounds: list[list[Floats]] = []

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Note the readings and return the policy's answer."""
        if episode_start is None or episode_start.all():
            self._rounds.append([])
        decoded = self._layout.decode(np.atleast_2d(observation))
        self._rounds[-1].append(readings(decoded, self._layout.sensors))
        return self._policy.predict(
            observation, state=state, episode_start=episode_start, deterministic=deterministic
        )

    def heard(self, runs: Iterable[tuple[Episode, Row]]) -> Iterator[Heard]:
        """Yield episodes and labels, each with its readings (T, sensors) [m]."""
        for i, (episode, labels) in enumerate(runs):
            number, world = divmod(i, len(self._rounds[0][0]))
            decisions = self._rounds[number][: len(episode.rewards)]
            yield episode, labels, np.stack([ranges_m[world] for ranges_m in decisions])


class SideBySide:
    """Composite policy: each policy drives its share of one batch, faster than in sequence."""

    def __init__(self, policies: Sequence[Policy]) -> None:
        self._policies = policies

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, list[object]]:
        """Return the actions of all worlds, and each policy's inner state."""
        actions, states, each = [], [], len(observation) // len(self._policies)
        for i, policy in enumerate(self._policies):
            mine = slice(i * each, (i + 1) * each)
            action, inner = policy.predict(
                observation[mine],
                state=None if state is None else state[i],
                episode_start=None if episode_start is None else episode_start[mine],
                deterministic=deterministic,
            )
            actions.append(np.reshape(action, (each, 1)))
            states.append(inner)
        return np.concatenate(actions), states
