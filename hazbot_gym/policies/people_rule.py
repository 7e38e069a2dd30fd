"""Base class of rules about people, on every tier: tracked people, or sonar estimates.

A rule reads observations with people. On the sonar tier ``sonar_estimate`` fills the person fields,
and its memory of echoes is the policy's state.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import Rule
from hazbot_gym.policies.guard import Actions, Flags, Observations
from hazbot_gym.policies.sonar_estimate import listen, people
from hazbot_gym.task.action import speed_action
from hazbot_gym.task.observation import Layout, layout_for, layout_of


class PeopleRule(Rule):
    """Rule whose ``speed_share`` reads person fields."""

    def act(
        self, observation: Observations, state: Any, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the action; the state is None, or the echo memory on the sonar tier.

        See ``Guarded.act``.
        """
        observation, state = self.with_estimates(observation, state, starts)
        return speed_action(self.speed_share(observation)), state

    def with_estimates(
        self, observation: Observations, state: Any, starts: Flags | None
    ) -> tuple[Observations, object]:
        """Return observations with people, and the next state; arguments as of ``act``."""
        layout = layout_of(observation)
        if layout.has_people:
            return observation, state
        seen, ring = layout.decode(observation), layout.sensors
        state = listen(seen, state, starts, ring)
        return with_people(observation, people(state, seen["speed_mps"], ring)), state


def with_slots(layout: Layout) -> Layout:
    """Return a layout with person slots, the layout itself if it has some."""
    if layout.has_people:
        return layout
    return layout_for("tracks", layout.sensors, has_gas=layout.has_gas)


def with_people(observation: Observations, found: dict[str, Floats]) -> Observations:
    """Return sonar observations (..., n) with person fields filled, as on the tracks tier.

    Args:
        observation: Sonar-tier observation.
        found: Person fields in their units, arrays (..., any number of people).
    """
    sonar = layout_of(observation)
    tracks = with_slots(sonar)
    full = np.zeros((*np.shape(observation)[:-1], tracks.width), np.float32)
    full[..., : sonar.width] = observation
    is_there = found["present"] > 0.5
    nearest = np.argsort(np.where(is_there, found["distance_m"], np.inf), axis=-1)
    nearest = nearest[..., : tracks.person_slots]
    for name, values in found.items():
        chosen = np.take_along_axis(values * is_there, nearest, axis=-1)
        for slot in range(tracks.person_slots):
            column = tracks.names.index(f"person{slot}_{name}")
            full[..., column] = chosen[..., slot] / tracks.fields[column].scale
    return full
