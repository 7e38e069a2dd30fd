"""Arrays of a batch: state, episode bookkeeping and outputs of N worlds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.sensor_ring import sensors_of
from hazbot_gym.envs.batch_step import Episodes, Outputs
from hazbot_gym.sim.batched_worlds import Worlds, allocate
from hazbot_gym.sim.perception import tracker_of
from hazbot_gym.task.observation import layout_in
from hazbot_gym.task.reward import terms_of
from hazbot_gym.task.step_record import STEP

KEYS_AHEAD = 8  # scenario keys drawn in advance for each world


class Arrays(NamedTuple):
    """Arrays of N worlds, of which none has begun an episode."""

    worlds: Worlds
    episodes: Episodes
    outputs: Outputs


def arrays_of(config: Config, worlds: int, people: int) -> Arrays:
    """Return the arrays of N worlds of a config, with room for P people each."""
    state = allocate(
        worlds,
        people,
        len(sensors_of(config.sensors.ring)),
        tracker_latency=tracker_of(config).latency_steps,
        drive_latency=config.drive.latency_steps,
        has_gas=config.gas is not None,
    )
    episodes = Episodes(
        keys=np.zeros((worlds, KEYS_AHEAD), np.uint64),
        used=np.full(worlds, KEYS_AHEAD, np.int64),
        is_over=np.ones(worlds, np.bool_),
        was_over=np.ones(worlds, np.bool_),
    )
    width = layout_in(config).width
    outputs = Outputs(
        observations=np.zeros((worlds, width), np.float32),
        final_observations=np.zeros((worlds, width), np.float32),
        records=np.zeros(worlds, STEP),
        terms=np.zeros((worlds, len(terms_of(config)))),
        rewards=np.zeros(worlds),
        costs=np.zeros(worlds),
        steps=np.zeros(worlds, np.int64),
        final_gas=np.zeros_like(state.gas),
    )
    return Arrays(state, episodes, outputs)
