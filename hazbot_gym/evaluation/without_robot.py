"""Counterfactual without the robot: the same people on the same routes with the same noise."""

from __future__ import annotations

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.own_walking import address_of_model
from hazbot_gym.core.state import PRESENT, Floats, Ints
from hazbot_gym.sim.unattended import walk_unattended
from hazbot_gym.task.scenario import ScenarioSampler


def walked_alone(
    config: Config, source: ScenarioSampler, key: int, persons: Ints, instants: int
) -> Floats:
    """Return counterfactual positions of people without the robot, (instants, K, 2) [m].

    Args:
        config: of the environment.
        source: of its scenarios.
        key: of the scenario.
        persons: (K,) numbers of the people.
        instants: from the start, a decision period apart.

    Returns: Positions, NaN where absent, and NaN for all people of a recording, which is replayed
        unchanged with or without the robot.
    """
    if config.people.model == "replay":
        return np.full((instants, len(persons), 2), np.nan)
    scenario, clock = source.draw(key), config.clock
    every = clock.social_per_decision
    steps = every * (instants - 1) + 1
    seen = walk_unattended(
        scenario.people, scenario.place, config.people.force, key=key, steps=steps,
        dt_s=clock.social_s, own_model=address_of_model(config.people.model),
    )[::every, persons]  # fmt: skip
    where = np.stack([seen["x"], seen["y"]], axis=-1)
    return np.where((seen["status"] == PRESENT)[..., None], where, np.nan)
