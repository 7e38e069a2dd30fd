"""Staggered starts: worlds that start in different phases of an episode.

Worlds that are reset together are in the same phase of an episode for a long time, and an update of
PPO then sees this phase alone. Trainings with thousands of worlds therefore spread the phases
(Rudin et al., CoRL 2021, reset at random times). Here each world drives at nominal speed for a
random part of its path before the first decision that counts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.policies.guard import Observations
from hazbot_gym.task.action import nearest_level


class Started(NamedTuple):
    """Worlds after a staggered start, one row each."""

    observations: Observations  # (N, width)
    steps: Floats  # (N,) decisions taken so far
    advance: Floats  # (N,) progress so far, in decisions at nominal speed


def stagger(part: CorridorVecEnv, decisions: npt.NDArray[np.int64]) -> Started:
    """Let world i take a number of decisions at nominal speed.

    A world whose episode ends on the way, by a contact, stays at the start of its next one.

    Args:
        part: Worlds that have just been reset.
        decisions: (N,) number of decisions of each.
    """
    worlds, left = part.worlds, decisions.copy()
    steps, advance = np.zeros(len(left)), np.zeros(len(left))
    full_speed: npt.NDArray[np.generic] = np.ones((len(left), 1))
    if worlds.config.action_type == "discrete":
        full_speed = nearest_level(full_speed[:, 0])
    observations = np.zeros(0, np.float32)
    for _ in range(max(int(left.max()), 1)):
        moving = left > 0
        observations, _, terminated, truncated, info = worlds.step(full_speed, mask=moving)
        steps[moving] += 1.0
        advance[moving] += info["reward_terms"]["progress"][moving]
        left[moving] -= 1
        ended = np.flatnonzero((terminated | truncated) & moving)
        steps[ended], advance[ended], left[ended] = 0.0, 0.0, 0
        part.note_resets(info, ended)
    return Started(observations, steps, advance)
