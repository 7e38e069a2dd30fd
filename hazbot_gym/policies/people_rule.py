"""Rules about people, on every tier: tracked ones, or those that four ultrasonic sensors betray.

A rule is written once, for observations with people. On the sonar tier the people are put there by
``sonar_estimate``, and what it remembers of the echoes is the policy's state.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import Actions, Observations, Rule, speed_action
from hazbot_gym.policies.sonar_estimate import Echoes, listen, people
from hazbot_gym.task.observation import LAYOUTS, NOBODY, PERSON_SLOTS, layout_of

SONAR, TRACKS = LAYOUTS["sonar"], LAYOUTS["tracks"]


class PeopleRule(Rule):
    """A rule whose ``speed_share`` reads the fields of people."""

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the action; the state is None, or the echoes known so far on the sonar tier.

        See ``base.Policy.predict``.
        """
        if layout_of(observation).tier == SONAR.tier:
            observation, state = with_estimates(observation, state, episode_start)
        return speed_action(self.speed_share(observation)), state


def with_estimates(
    observation: Observations, echoes: Echoes | None, starts: npt.ArrayLike | None = None
) -> tuple[Observations, Echoes]:
    """Return sonar observations (..., n) with the people that they betray, as on tier tracks.

    Args:
        observation: Of the sonar tier.
        echoes: What was known of the echoes before, or None.
        starts: (...) whose episode has just begun.

    Returns:
        Observations (..., 48), and what is known of the echoes now.
    """
    seen = SONAR.decode(observation)
    echoes = listen(seen, echoes, starts)
    return with_people(observation, people(echoes, seen["speed_mps"])), echoes


def with_people(observation: Observations, found: dict[str, Floats]) -> Observations:
    """Return sonar observations (..., n) with the nearest people in their slots, as on tier tracks.

    Args:
        observation: Of the sonar tier.
        found: Person fields in their units, arrays (..., any number of people).
    """
    full = np.zeros((*np.shape(observation)[:-1], TRACKS.width), np.float32)
    full[..., : SONAR.width] = observation
    full[..., SONAR.width :] = np.tile(NOBODY, PERSON_SLOTS)
    is_there = found["present"] > 0.5
    nearest = np.argsort(np.where(is_there, found["distance_m"], np.inf), axis=-1)
    nearest = nearest[..., :PERSON_SLOTS]
    is_filled = np.take_along_axis(is_there, nearest, axis=-1)
    for name, values in found.items():
        chosen = np.take_along_axis(values, nearest, axis=-1)
        for slot in range(PERSON_SLOTS):
            column = TRACKS.names.index(f"person{slot}_{name}")
            share = chosen[..., slot] / TRACKS.fields[column].scale
            full[..., column] = np.where(is_filled[..., slot], share, full[..., column])
    return full
