"""Golden vectors: observations with the answers of the policy in Python."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.export.plan import Plan
from hazbot_gym.policies.guard import Observations
from hazbot_gym.task.observation import SONAR_RANGE_M, Layout, observing_layout
from hazbot_gym.utils.json_object import JsonObject

TOLERANCE = 1e-5  # largest difference of an action, which is in [-1, 1]
COUNT, ROUND = 64, 16  # golden vectors, and how many of them make a round
IMPOSSIBLE = 3.0  # an entry out of bounds, for which every policy stops


class Golden(NamedTuple):
    """Observations one after another; the memory is reset where a round starts."""

    observations: Observations  # (N, width)
    starts: npt.NDArray[np.bool_]  # (N,)
    actions: npt.NDArray[np.float32]  # (N,)


def golden_of(plan: Plan, count: int = COUNT, seed: int = 0) -> Golden:
    """Return seeded observations, one of each round out of bounds, and the policy's actions."""
    observations = observations_for(plan, count, seed)
    observations[ROUND // 2 :: ROUND, 0] = IMPOSSIBLE
    starts = np.arange(count) % ROUND == 0
    return Golden(observations, starts, actions_of(plan, observations, starts))


def observations_for(plan: Plan, count: int, seed: int) -> Observations:
    """Return random observations; their ranges change as in a drive if the policy listens to them.

    Each range moves at a constant velocity, which is drawn again from time to time, as is the range
    itself: another source.
    """
    observations = draw(plan.layout, count, seed)
    if not plan.listens:
        return observations
    rng, sensors = np.random.default_rng(seed), len(plan.layout.sensors)
    range_m, velocity_mps = rng.uniform(0.3, 4.0, sensors), rng.uniform(-1.5, 1.5, sensors)
    for row in observations:
        is_new = rng.uniform(size=(2, sensors)) < 0.04
        range_m = np.where(is_new[0], rng.uniform(0.3, 4.0, sensors), range_m)
        velocity_mps = np.where(is_new[1], rng.uniform(-1.5, 1.5, sensors), velocity_mps)
        range_m = np.clip(range_m + velocity_mps * plan.period_s, 0.2, SONAR_RANGE_M)
        noise_m = rng.uniform(-0.03, 0.03, sensors)
        row[:sensors] = np.clip(range_m + noise_m, 0.0, SONAR_RANGE_M) / SONAR_RANGE_M
    return observations


def draw(layout: Layout, count: int, seed: int) -> Observations:
    """Return random observations within their bounds, with flags that are 0 or 1.

    People are in order, in a unit direction, and have at most one walking pattern.
    """
    rng = np.random.default_rng(seed)
    shape = count, layout.width
    observations = rng.uniform(layout.low, layout.high, shape).astype(np.float32)
    if not layout.has_people:
        return observations
    at = {name: i for i, name in enumerate(layout.names)}
    people = rng.integers(0, layout.person_slots + 1, count)
    distances = [at[f"person{k}_distance_m"] for k in range(layout.person_slots)]
    observations[:, distances] = np.sort(observations[:, distances], axis=1)
    for k in range(layout.person_slots):
        angles, patterns = rng.uniform(-np.pi, np.pi, count), rng.integers(-1, 4, count)
        observations[:, at[f"person{k}_present"]] = people > k
        observations[:, at[f"person{k}_bearing_sin"]] = np.sin(angles)
        observations[:, at[f"person{k}_bearing_cos"]] = np.cos(angles)
        for code, name in enumerate(PATTERN_NAMES):
            observations[:, at[f"person{k}_{name}"]] = patterns == code
    return observations


def actions_of(
    plan: Plan, observations: Observations, starts: npt.NDArray[np.bool_]
) -> npt.NDArray[np.float32]:
    """Return the policy's actions on observations one after another."""
    with observing_layout(plan.layout):
        if not plan.has_memory:
            return plan.policy.predict(observations)[0][:, 0]
        state, actions = None, []
        for observation, begins in zip(observations, starts, strict=True):
            action, state = plan.policy.predict(observation, None if begins else state)
            actions.append(action[0])
    return np.array(actions, np.float32)


def as_json(plan: Plan, golden: Golden) -> JsonObject:
    """Return the vectors with what a reader needs to build and read an observation."""
    return {
        "policy": plan.spec,
        "fields": [
            {name: getattr(field, name) for name in ("name", "unit", "low", "high", "scale")}
            for field in plan.layout.fields
        ],
        "nominal_speed_mps": plan.nominal_mps,
        "decision_period_s": plan.period_s,
        "tolerance": TOLERANCE,
        "observations": golden.observations.tolist(),
        "starts": golden.starts.tolist(),
        "actions": golden.actions.tolist(),
    }
